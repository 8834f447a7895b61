//! The views that fly and ask.

use anyhow::Result;
use page_test::Page;

/// A slider of the form, by its key.
fn slider(key: &str) -> String {
    format!("#controls input[type=range][data-key={key}]")
}

#[test]
fn a_slider_changes_the_curve() -> Result<()> {
    let page = Page::open()?;
    page.fly()?;
    let before = page.curves()?;
    page.flown_after(|page| page.set(&slider("angle_gain_1_s"), "0.3"))?;
    assert_ne!(before, page.curves()?);
    page.wait("document.getElementById('flight').dataset.margins === 'measured'")?;
    assert!(page.text("#flight .card")?.contains("Stable"));
    Ok(())
}

#[test]
fn a_link_holds_the_whole_flight() -> Result<()> {
    let page = Page::open()?;
    page.fly()?;
    page.flown_after(|page| page.set("#controls [name=rig]", "free"))?;
    page.flown_after(|page| page.set("[name=add-effect]", "weak_motor"))?;
    page.flown_after(|page| page.set(&slider("scale"), "0.4"))?;
    page.flown_after(|page| page.set("[name=manoeuvre]", "drawn"))?;
    page.flown_after(|page| page.set(&slider("mpc_horizon"), "0.5"))?;
    let state = page.value("location.hash")?;
    let linked = Page::open_on(1280, 900, false, state.as_str().unwrap())?;
    linked.wait("document.getElementById('flight').dataset.ms")?;
    assert_eq!(linked.curves()?, page.curves()?);
    assert_eq!(linked.text("#flight .about")?, page.text("#flight .about")?);
    Ok(())
}

#[test]
fn what_is_drawn_by_hand_is_flown() -> Result<()> {
    let page = Page::open()?;
    page.fly()?;
    page.flown_after(|page| page.set("[name=manoeuvre]", "drawn"))?;
    page.flown_after(|page| {
        let up = "for (const key of ['ArrowRight', 'ArrowUp'])
            document.querySelector('.drawing').dispatchEvent(new KeyboardEvent('keydown', { key }));";
        page.browser.script(up, &[]).map(drop)
    })?;
    assert!(page.saved("script.toml")?.contains("at_s = 1.5\nroll_deg = 25"), "{}", page.saved("script.toml")?);
    Ok(())
}

#[test]
fn the_quiz_hides_an_effect_and_lets_the_diagnosis_answer() -> Result<()> {
    let page = Page::open()?;
    page.click("#tab-quiz")?;
    page.click("#quiz [data-hide]")?;
    page.wait("document.querySelector('#quiz form')")?;
    assert_eq!(page.value("document.querySelectorAll('#quiz [type=radio]').length")?, 5);
    page.click("#quiz [type=submit]")?;
    page.wait("document.querySelector('#quiz [role=status] strong')")?;
    let said = page.text("#quiz [role=status]")?;
    assert!(said.contains("Hidden was:") && said.contains("guess") && said.contains("diagnosis"), "{said}");
    page.set("#quiz [name=quiz-rig]", "free")?;
    page.click("#quiz [data-hide]")?;
    page.wait("document.querySelector('#quiz form') && document.querySelector('#quiz article svg')")?;
    assert_eq!(page.value("document.querySelector('#quiz [name=quiz-rig]').value")?, "free");
    Ok(())
}
