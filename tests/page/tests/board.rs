//! A board on a serial port. The port is a mock: what the page writes goes to a vehicle of `sil serve`, and what that
//! says comes back. No real port and no real board were there.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use page_test::{Page, Served};
use serde_json::{Value, json};

/// In the place of the browser's Web Serial: keeps what is written, reads what the test pushes.
const PORT: &str = "globalThis.port = { written: [] };
    const readable = new ReadableStream({ start(controller) {
        port.push = (bytes) => controller.enqueue(new Uint8Array(bytes));
        port.unplug = () => controller.error(new Error('unplugged'));
    } });
    const writable = new WritableStream({ write(bytes) { port.written.push(...bytes); } });
    const open = async (options) => { port.options = options; };
    const close = async () => { port.isClosed = true; };
    const requestPort = async () => ({ open, close, readable, writable });
    Object.defineProperty(navigator, 'serial', { value: { requestPort }, configurable: true });";

/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(60);

/// Carries bytes between the page's port and the vehicle's socket until an expression has a value.
fn carry_until(page: &Page, vehicle: &mut TcpStream, expression: &str) -> Result<Value> {
    let begun = Instant::now();
    let mut chunk = [0; 4096];
    while begun.elapsed() < PATIENCE {
        let written = page.browser.script("return port.written.splice(0)", &[])?;
        let written: Vec<u8> = serde_json::from_value(written)?;
        vehicle.write_all(&written)?;
        let count = match vehicle.read(&mut chunk) {
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(error) => return Err(error.into()),
        };
        page.browser.script("port.push(arguments[0])", &[json!(chunk[..count])])?;
        let value = page.value(expression)?;
        if !matches!(value, Value::Null | Value::Bool(false)) {
            return Ok(value);
        }
    }
    bail!("for a minute nothing: {expression}; the page says {}", page.text("#board")?)
}

fn connected(folder: &Path, arguments: &[&str]) -> Result<(Page, Served, TcpStream)> {
    let served = Served::start(folder, arguments)?;
    let vehicle = TcpStream::connect(served.address())?;
    vehicle.set_read_timeout(Some(Duration::from_millis(10)))?;
    let page = Page::open_on(1280, 900, false, "?board")?;
    page.browser.script(PORT, &[])?;
    page.click("#tab-board")?;
    page.click("#board-connect")?;
    page.wait("globalThis.port.push")?;
    Ok((page, served, vehicle))
}

#[test]
fn a_vehicle_behind_a_port_shows_how_it_lies_and_leaves_with_the_cable() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let (page, _served, mut vehicle) = connected(folder.path(), &[])?;
    assert_eq!(page.value("port.options")?, json!({ "baudRate": 57600 }));
    let caption = "document.querySelector('#board figcaption').textContent";
    carry_until(&page, &mut vehicle, &format!("/roll -?0°, pitch -?0°/.test({caption})"))?;
    assert_eq!(page.text("#board-state")?, "Vehicle 1, disarmed");
    page.browser.script("port.unplug()", &[])?;
    page.wait("port.isClosed")?;
    page.wait("document.getElementById('board-state').textContent === 'Not connected.'")?;
    Ok(())
}

#[test]
fn nobody_sees_it_who_did_not_ask() -> Result<()> {
    let page = Page::open()?;
    assert_eq!(page.value("document.getElementById('tab-board').hidden")?, Value::Bool(true));
    Ok(())
}

/// The log that the vehicle keeps ends up in the diagnosis, as if it had been dropped.
#[test]
fn a_log_is_fetched_and_diagnosed() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let logs = folder.path().join("logs");
    std::fs::create_dir(&logs)?;
    std::fs::write(logs.join("s.toml"), "duration_s = 4.0\n[[step]]\nat_s = 1.0\nroll_deg = 20\n")?;
    Page::sil(&logs, &["fly", "--script", "s.toml", "--log", "log-0001.ulg", "--controller", "pid"])?
        .map_err(anyhow::Error::msg)?;
    let (page, _served, mut vehicle) = connected(folder.path(), &["--logs", "logs"])?;
    carry_until(&page, &mut vehicle, "!document.querySelector('#board-list').closest('[hidden]')")?;
    page.click("#board-list")?;
    carry_until(&page, &mut vehicle, "document.querySelector('#board-logs button')")?;
    page.click("#board-logs button")?;
    carry_until(&page, &mut vehicle, "document.querySelector('#logs .log dl, #logs .log-problem')")?;
    let recognised = page.text("#logs .log")?;
    assert!(recognised.contains("PX4"), "{recognised}");
    Ok(())
}
