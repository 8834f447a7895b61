//! The view that diagnoses logs.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Result;
use page_test::Page;
use serde_json::{Value, json};

/// Where the demonstration log lies.
fn demonstration() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sil-host/demonstration")
}

#[test]
fn the_demonstration_log_has_the_cause_and_the_figures_of_the_command_line() -> Result<()> {
    let page = Page::open()?;
    page.click("#demonstration")?;
    assert_eq!(page.answer()?, "Pitch is out of balance by 0.20 N m, as 204 g would at 10 cm");
    let of_terminal = Page::sil(&demonstration(), &["diagnose", "rig-log.csv", "--json", "-"])?;
    assert_eq!(page.saved("diagnosis.json")?, of_terminal.map_err(anyhow::Error::msg)?);
    let report = page.saved("diagnosis.html")?;
    assert!(report.starts_with("<!DOCTYPE html>") && report.contains("Pitch is out of balance"));
    assert!(page.saved("extended.toml")?.contains("cg_offset"));
    Ok(())
}

#[test]
fn a_bad_file_has_the_terminals_message() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let page = Page::open()?;
    let bad = "time_s,roll_rad,pitch_rad,motor1,motor2,motor3,motor4\n0.00,0,0,0.5,0.5,0.5,0.5\n0.01,0,much,1,1,1,1\n";
    for (name, content) in [("bad.csv", bad), ("empty.ulg", ""), ("picture.png", "\u{89}PNG\r\n")] {
        fs::write(folder.path().join(name), content)?;
        let said = Page::sil(folder.path(), &["diagnose", name])?.unwrap_err();
        page.choose(&[&folder.path().join(name)])?;
        page.wait(&format!(
            "document.querySelector('.log h2')?.innerText === '{name}' && document.querySelector('.log-problem pre')"
        ))?;
        let shown = page.text(".log-problem pre")?;
        assert_eq!(said.trim().trim_start_matches("error: "), shown.trim(), "{name}");
        page.click("#clear")?;
    }
    Ok(())
}

#[test]
fn a_log_that_is_too_large_for_a_page_is_said_and_the_page_goes_on() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let large = folder.path().join("large.csv");
    fs::File::create(&large)?.set_len(3 << 30)?;
    let page = Page::open()?;
    page.choose(&[&large])?;
    page.wait("document.querySelector('.log-problem pre')")?;
    let shown = page.text(".log-problem pre")?;
    assert!(shown.starts_with("The log needs more memory than a browser gives to a page"), "{shown}");
    page.click("#demonstration")?;
    assert!(page.answer()?.starts_with("Pitch is out of balance"));
    Ok(())
}

/// Begins the search again in a worker that has so many pages of 64 kB left of the 4 GB that WebAssembly can address.
fn search_with(page: &Page, pages_left: u32) -> Result<()> {
    page.browser.script(
        "const worker = document.getElementById('worker');
         globalThis.roomy ??= worker.textContent;
         const ready = 'library = instance.exports;';
         const pages = `65536 - ${arguments[0]} - library.memory.buffer.byteLength / 65536`;
         if (!roomy.includes(ready)) throw new Error('the worker has no such line: ' + ready);
         worker.textContent = roomy.replace(ready, `${ready} library.memory.grow(${pages});`);
         document.getElementById('run').click();",
        &[json!(pages_left)],
    )?;
    Ok(())
}

#[test]
fn memory_that_runs_out_while_computing_is_said_and_the_next_log_has_its_answer() -> Result<()> {
    let page = Page::open()?;
    page.click("#demonstration")?;
    let answer = page.answer()?;
    // 10 MB are enough to begin the search, not to end it
    search_with(&page, 160)?;
    page.wait("!document.getElementById('problem').hidden")?;
    let said = page.text("#problem")?;
    assert!(said.starts_with("The log needs more memory than a browser gives to a page (it had 429"), "{said}");
    assert_eq!(page.value("document.getElementById('progress').hidden")?, Value::Bool(true));
    // 100 MB are enough, all of them at addresses that are negative for JavaScript
    search_with(&page, 1600)?;
    assert_eq!(page.answer()?, answer);
    page.browser.script("document.getElementById('worker').textContent = roomy", &[])?;
    page.click("#demonstration")?;
    page.wait("document.querySelector('#answer h1') && document.getElementById('progress').hidden")?;
    assert_eq!(page.answer()?, answer);
    Ok(())
}

#[test]
fn stop_stops_and_another_search_begins_anew() -> Result<()> {
    let page = Page::open()?;
    page.click("#demonstration")?;
    page.answer()?;
    page.set("[name=effort]", "thorough")?;
    page.click("#run")?;
    page.wait("document.getElementById('progress-bar').hasAttribute('value')")?;
    page.click("#stop")?;
    page.wait("!document.getElementById('problem').hidden")?;
    assert!(page.text("#problem")?.starts_with("Stopped"));
    assert_eq!(page.value("document.getElementById('progress').hidden")?, Value::Bool(true));
    std::thread::sleep(std::time::Duration::from_millis(500));
    assert_eq!(page.value("document.querySelector('#answer h1')")?, Value::Null);
    page.set("[name=effort]", "quick")?;
    page.click("#run")?;
    assert!(page.answer()?.starts_with("Pitch is out of balance"));
    Ok(())
}

#[test]
fn a_suspect_flight_is_held_against_normal_ones() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let suspect =
        Page::synthetic(folder.path(), "suspect.csv", &["--effect", "weak_motor:motor=3,scale=0.9", "--seed", "1"])?;
    let normal = Page::synthetic(folder.path(), "normal.csv", &["--seed", "2"])?;
    let page = Page::open()?;
    page.choose(&[&suspect, &normal])?;
    page.wait("document.querySelectorAll('.log dl').length === 2")?;
    assert!(page.value("document.querySelector('#answer h1')")?.is_null(), "nobody said which flight is normal");
    page.click(".log:nth-of-type(2) .check input")?;
    page.click("#run")?;
    page.answer()?;
    let of_terminal =
        Page::sil(folder.path(), &["diagnose", "suspect.csv", "--baseline", "normal.csv", "--json", "-"])?;
    assert_eq!(page.saved("diagnosis.json")?, of_terminal.map_err(anyhow::Error::msg)?);
    Ok(())
}

#[test]
fn other_peoples_columns_get_a_drafted_map_and_flight_controllers_logs_need_none() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let page = Page::open()?;
    let log = fs::read_to_string(demonstration().join("rig-log.csv"))?;
    let rows: Vec<&str> = log.lines().filter(|line| !line.starts_with('#')).collect();
    let head = rows[0]
        .replace("time_s", "t")
        .replace("_rad_s", "_rate")
        .replace("roll_rad", "phi")
        .replace("pitch_rad", "theta");
    let renamed = folder.path().join("renamed.csv");
    fs::write(&renamed, [&[head.as_str()], &rows[1..]].concat().join("\n"))?;
    page.choose(&[&renamed])?;
    page.wait("document.querySelector('.log dl, .log-problem')")?;
    assert!(page.value("document.querySelector('.log').textContent")?.as_str().unwrap().contains("drafted"));
    page.set("#options [name=rig]", "gimbal")?;
    page.set("#options [name=effort]", "quick")?;
    page.click("#run")?;
    assert!(page.answer()?.starts_with("Pitch is out of balance"), "{}", page.answer()?);
    page.click("#clear")?;

    Page::sil(folder.path(), &["fly", "--rig", "free", "--log", "flight.ulg", "--controller", "pid"])?
        .map_err(anyhow::Error::msg)?;
    page.choose(&[&folder.path().join("flight.ulg")])?;
    page.wait("document.querySelector('.log dl')")?;
    let recognised = page.value("document.querySelector('.log').textContent")?;
    assert!(recognised.as_str().unwrap().contains("PX4"), "{recognised}");
    Ok(())
}
