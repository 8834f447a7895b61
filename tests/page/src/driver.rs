//! One browser with its driver: commands as HTTP requests with JSON.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

/// How long a script in the page may take, ms.
const SCRIPT_MS: u32 = 60_000;

/// Of the times in `/proc`, on every Linux that Debian builds.
pub const TICKS_PER_S: f64 = 100.0;

/// What a hand does with a mouse.
#[derive(Clone, Copy, Debug)]
pub enum Mouse {
    /// Moves it to a place in the window, px from its upper left corner.
    To([f64; 2]),
    /// Presses its button.
    Down,
    /// Lets it go.
    Up,
}

/// A browser; it ends with the value.
pub struct Browser {
    driver: Child,
    port: u16,
    session: String,
}

impl Browser {
    /// Starts one with a window of this size, px.
    ///
    /// # Errors
    /// There is no Chromium with its driver.
    pub fn start(width_px: u32, height_px: u32, is_dark: bool) -> Result<Browser> {
        let mut driver = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .context("chromedriver can't be started (apt-get install chromium chromium-driver)")?;
        let said = driver.stdout.take().context("chromedriver says nothing")?;
        let port = BufReader::new(said).lines().map_while(Result::ok).find_map(|line| {
            let (_, port) = line.rsplit_once("successfully on port ")?;
            port.trim_end_matches('.').parse().ok()
        });
        let port = port.context("chromedriver names no port")?;
        let mut browser = Browser { driver, port, session: String::new() };
        let window = format!("--window-size={width_px},{height_px}");
        // CI's user is root in a container, whose Chromium has no sandbox
        let mut arguments = vec!["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", &window];
        if is_dark {
            arguments.push("--blink-settings=preferredColorScheme=0");
        }
        let wanted = json!({ "alwaysMatch": {
            "goog:chromeOptions": { "args": arguments },
            "goog:loggingPrefs": { "browser": "ALL", "performance": "ALL" },
        } });
        let session = browser.post("/session", &json!({ "capabilities": wanted }))?;
        let id = session["sessionId"].as_str().context("no session")?;
        browser.session = format!("/session/{id}");
        browser.command("timeouts", &json!({ "script": SCRIPT_MS }))?;
        Ok(browser)
    }

    /// Opens an address.
    ///
    /// # Errors
    /// As any command's: what the driver says.
    pub fn open(&self, address: &str) -> Result<()> {
        self.command("url", &json!({ "url": address })).map(drop)
    }

    /// What a script in the page returns.
    ///
    /// # Errors
    /// What the driver says.
    pub fn script(&self, script: &str, arguments: &[Value]) -> Result<Value> {
        self.command("execute/sync", &json!({ "script": script, "args": arguments }))
    }

    /// Gives a file to an input of the page.
    ///
    /// # Errors
    /// What the driver says.
    pub fn give_file(&self, selector: &str, path: &str) -> Result<()> {
        let found = self.command("element", &json!({ "using": "css selector", "value": selector }))?;
        let element = found.as_object().and_then(|of| of.values().next()).and_then(Value::as_str);
        let element = element.with_context(|| format!("no element {selector}"))?;
        self.command(&format!("element/{element}/value"), &json!({ "text": path })).map(drop)
    }

    /// Moves the mouse and presses its button, as by hand.
    ///
    /// # Errors
    /// What the driver says, such as a place outside of the window.
    pub fn mouse(&self, steps: &[Mouse]) -> Result<()> {
        let step = |step: &Mouse| match step {
            Mouse::To([x, y]) => json!({
                "type": "pointerMove", "origin": "viewport", "duration": 20, "x": x.round(), "y": y.round(),
            }),
            Mouse::Down => json!({ "type": "pointerDown", "button": 0 }),
            Mouse::Up => json!({ "type": "pointerUp", "button": 0 }),
        };
        let steps: Vec<Value> = steps.iter().map(step).collect();
        let mouse = json!({
            "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" }, "actions": steps,
        });
        self.command("actions", &json!({ "actions": [mouse] })).map(drop)
    }

    /// The window as PNG, base64.
    ///
    /// # Errors
    /// What the driver says.
    pub fn picture(&self) -> Result<String> {
        let whole = json!({ "cmd": "Page.captureScreenshot", "params": { "captureBeyondViewport": true } });
        let picture = self.command("goog/cdp/execute", &whole)?;
        picture["data"].as_str().map(str::to_owned).context("no picture")
    }

    /// Processor time that the browser has used so far, s: on a machine that does other things too, a computation in
    /// one thread takes longer than this.
    ///
    /// # Errors
    /// The system does not say (it is Linux's `/proc` that is read).
    pub fn processor_s(&self) -> Result<f64> {
        let mut family = vec![self.driver.id()];
        let mut ticks = 0.0;
        let mut parents = Vec::new();
        for entry in std::fs::read_dir("/proc")? {
            let Some(id) = entry?.file_name().to_str().and_then(|name| name.parse::<u32>().ok()) else { continue };
            // a process may end meanwhile
            let Ok(stat) = std::fs::read_to_string(format!("/proc/{id}/stat")) else { continue };
            // the program's name, in brackets, may hold anything; behind it stand state, parent, ..., and as the 12th
            // and 13th field user's and system's time (proc(5))
            let Some((_, fields)) = stat.rsplit_once(") ") else { continue };
            let fields: Vec<&str> = fields.split(' ').collect();
            let [parent, user, system] = [1, 11, 12].map(|at| fields.get(at).and_then(|of| of.parse::<u32>().ok()));
            parents.push((id, parent.context("no parent")?, f64::from(user.unwrap_or(0) + system.unwrap_or(0))));
        }
        let mut at = 0;
        while let Some(of) = family.get(at).copied() {
            family.extend(parents.iter().filter(|(_, parent, _)| *parent == of).map(|(id, ..)| *id));
            ticks += parents.iter().find(|(id, ..)| *id == of).map_or(0.0, |(.., used)| *used);
            at += 1;
        }
        Ok(ticks / TICKS_PER_S)
    }

    /// A log of the browser's since the last call: `browser` for its console, `performance` for its events.
    ///
    /// # Errors
    /// What the driver says.
    pub fn log(&self, kind: &str) -> Result<Vec<Value>> {
        let log = self.command("se/log", &json!({ "type": kind }))?;
        Ok(log.as_array().cloned().unwrap_or_default())
    }

    fn command(&self, name: &str, body: &Value) -> Result<Value> {
        self.post(&format!("{}/{name}", self.session), body)
    }

    fn post(&self, path: &str, body: &Value) -> Result<Value> {
        let answer = self.request("POST", path, &body.to_string())?;
        let mut answer: Value = serde_json::from_str(&answer)?;
        let value = answer["value"].take();
        if let Some(error) = value.get("error").filter(|error| error.is_string()) {
            bail!("{path}: {error}: {}", value["message"]);
        }
        Ok(value)
    }

    fn request(&self, method: &str, path: &str, body: &str) -> Result<String> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port))?;
        let length = body.len();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n\
             Content-Length: {length}\r\nConnection: close\r\n\r\n{body}"
        )?;
        let mut stream = BufReader::new(stream);
        let mut length = 0;
        loop {
            let mut line = String::new();
            stream.read_line(&mut line)?;
            if line.trim().is_empty() {
                break;
            }
            if let Some((name, value)) = line.split_once(':')
                && name.eq_ignore_ascii_case("content-length")
            {
                length = value.trim().parse()?;
            }
        }
        let mut answer = vec![0; length];
        stream.read_exact(&mut answer)?;
        Ok(String::from_utf8(answer)?)
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // what fails here has nobody to tell, and the driver's end is the browser's
        let _ = self.request("DELETE", &self.session, "");
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}
