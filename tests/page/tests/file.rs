//! The file itself: what it may do, and how it looks on every screen.

use std::fs;
use std::path::PathBuf;

use anyhow::Result;
use base64::Engine;
use page_test::Page;
use serde_json::{Value, json};

#[test]
fn nothing_leaves_the_page() -> Result<()> {
    let page = Page::open()?;
    page.click("#demonstration")?;
    page.answer()?;
    page.fly()?;
    let events = page.browser.log("performance")?;
    let requested = events.iter().filter_map(|event| {
        let message: Value = serde_json::from_str(event["message"].as_str()?).ok()?;
        let is_request = message["message"]["method"] == "Network.requestWillBeSent";
        is_request.then(|| message["message"]["params"]["request"]["url"].as_str().unwrap_or_default().to_owned())
    });
    let requested: Vec<String> = requested.collect();
    let is_own = |address: &String| ["file:", "blob:", "data:"].iter().any(|kind| address.starts_with(kind));
    assert!(!requested.is_empty() && requested.iter().all(is_own), "{requested:?}");
    // what would send is forbidden: of three ways none gets past the policy, and no script runs that is not the page's
    let script = "const stopped = [];
        document.addEventListener('securitypolicyviolation', (event) => stopped.push(event.effectiveDirective));
        fetch('https://example.org/').catch(() => {});
        new Image().src = 'https://example.org/a.png';
        const script = document.createElement('script');
        script.src = 'https://example.org/a.js';
        const injected = document.createElement('script');
        injected.textContent = 'globalThis.isInjected = true';
        document.body.append(script, injected);
        return new Promise((resolve) => setTimeout(() => resolve(stopped.sort()), 300));";
    let stopped = page.browser.script(script, &[])?;
    assert_eq!(stopped, json!(["connect-src", "img-src", "script-src-elem", "script-src-elem"]));
    assert!(page.value("globalThis.isInjected")?.is_null());
    Ok(())
}

#[test]
fn it_fits_every_screen_and_every_control_has_a_name() -> Result<()> {
    let mut backgrounds = Vec::new();
    for (name, width_px, height_px, is_dark) in [("desktop", 1280, 900, false), ("phone-dark", 500, 900, true)] {
        let page = Page::open_on(width_px, height_px, is_dark, "")?;
        page.click("#demonstration")?;
        page.answer()?;
        check(&page, &format!("diagnose-{name}"))?;
        page.fly()?;
        page.flown_after(|page| page.set("[name=add-effect]", "cg_offset"))?;
        check(&page, &format!("fly-{name}"))?;
        page.click("#tab-quiz")?;
        check(&page, &format!("quiz-{name}"))?;
        backgrounds.push(page.value("getComputedStyle(document.body).backgroundColor")?);
        let complaints = page.browser.log("browser")?;
        assert!(complaints.is_empty(), "{complaints:?}");
    }
    assert_ne!(backgrounds[0], backgrounds[1], "dark is as light");
    Ok(())
}

/// Nothing is wider than the window, no control is without a name; the picture is kept beside the page.
fn check(page: &Page, name: &str) -> Result<()> {
    let picture = base64::engine::general_purpose::STANDARD.decode(page.browser.picture()?)?;
    let folder: PathBuf = Page::place()?.with_file_name("pictures");
    fs::create_dir_all(&folder)?;
    fs::write(folder.join(format!("{name}.png")), picture)?;
    let wider = page.value("document.documentElement.scrollWidth - innerWidth")?;
    assert!(wider.as_i64().is_some_and(|px| px <= 0), "{name}: {wider} px wider than the window");
    let nameless = page.value(
        "[...document.querySelectorAll('button, input:not([hidden]), select, textarea, [role=img], [role=slider]')]
            .filter((of) => !(of.textContent.trim() && of.matches('button')) && !of.ariaLabel && !of.labels?.length)
            .map((of) => of.outerHTML.slice(0, 200))",
    )?;
    assert_eq!(nameless, json!([]), "{name}");
    Ok(())
}
