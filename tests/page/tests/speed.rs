//! How long a user waits. A slow or busy machine is no fault of the page, so `cargo xtask page-speed` runs these and CI
//! does not; they run one after the other.

use std::path::Path;
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use page_test::{Browser, Page, TICKS_PER_S};
use serde_json::json;

/// The fastest of so many is taken.
const STARTS: usize = 3;

static MACHINE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    MACHINE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[test]
#[ignore = "timed: cargo xtask page-speed"]
fn it_starts_within_a_second() -> Result<()> {
    let _alone = alone();
    // what else the machine does makes a start slower, and none faster
    let starts = (0..STARTS).map(|_| start_s()).collect::<Result<Vec<f64>>>()?;
    let took_s = starts.iter().copied().fold(f64::INFINITY, f64::min);
    println!("started in {starts:.2?} s");
    assert!(took_s < 1.0, "{took_s} s");
    Ok(())
}

/// From the address to a page that can be used, s.
fn start_s() -> Result<f64> {
    let browser = Browser::start(1280, 900, false)?;
    let begun = Instant::now();
    browser.open(&format!("file://{}", Page::place()?.display()))?;
    while browser.script("return document.documentElement.dataset.ready", &[])? != json!("yes") {}
    Ok(begun.elapsed().as_secs_f64())
}

#[test]
#[ignore = "timed: cargo xtask page-speed"]
fn a_log_of_a_minute_is_answered_in_fifteen_seconds() -> Result<()> {
    let _alone = alone();
    let folder = tempfile::tempdir()?;
    let options = ["--duration", "60", "--rate", "200", "--effect", "weak_motor:motor=2,scale=0.9"];
    let log = Page::synthetic(folder.path(), "minute.csv", &options)?;
    let page = Page::open()?;
    let (begun, before_s) = (Instant::now(), page.browser.processor_s()?);
    page.choose(&[&log])?;
    let answer = page.answer()?;
    // one thread computes: on a quiet machine its time is the user's
    let took_s = page.browser.processor_s()? - before_s;
    println!("60 s at 200 Hz: {took_s:.1} s of a core, {:.1} s by the clock, {answer}", begun.elapsed().as_secs_f64());
    let natively_s = natively_s(&log)?;
    println!("the command line on one thread: {natively_s:.1} s; the page takes {:.2} times that", took_s / natively_s);
    assert!(answer.contains("Motor 2"), "{answer}");
    assert!(took_s < 15.0, "{took_s} s");
    Ok(())
}

/// What the command line, built as it is shipped, takes of a core for the same answer on one thread, s.
fn natively_s(log: &Path) -> Result<f64> {
    let sil = std::env::var_os("SIL_BINARY").context("SIL_BINARY is not set: run `cargo xtask page-speed`")?;
    let before_s = ended_children_s()?;
    let mut command = Command::new(sil);
    let status = command.arg("diagnose").arg(log).arg("--quiet").env("RAYON_NUM_THREADS", "1").status()?;
    ensure!(status.success(), "sil diagnose: {status}");
    Ok(ended_children_s()? - before_s)
}

/// Processor time of the processes that this one began and has waited for, s: fields 16 and 17 of `/proc/self/stat`.
fn ended_children_s() -> Result<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    let (_, fields) = stat.rsplit_once(") ").context("no fields")?;
    let ticks = fields.split(' ').skip(13).take(2).map(str::parse::<f64>).sum::<Result<f64, _>>()?;
    Ok(ticks / TICKS_PER_S)
}

#[test]
#[ignore = "timed: cargo xtask page-speed"]
fn a_flight_is_drawn_at_once_after_a_sliders_move() -> Result<()> {
    let _alone = alone();
    let page = Page::open()?;
    page.fly()?;
    let slider = "#controls input[type=range][data-key=angle_gain_1_s]";
    let mut times_ms = Vec::new();
    for track in ["0.30", "0.33", "0.36", "0.40", "0.43", "0.46", "0.55"] {
        times_ms.push(page.flown_after(|page| page.set(slider, track))?);
    }
    println!("flown and drawn after a slider's move: {times_ms:?} ms");
    times_ms.sort_unstable();
    assert!(times_ms[times_ms.len() / 2] < 200, "{times_ms:?} ms");
    Ok(())
}
