//! The page in a browser, as its user handles it.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

use crate::Browser;

/// Longer than anything in the page takes.
const PATIENCE: Duration = Duration::from_secs(60);
/// From one look to the next.
const LOOK: Duration = Duration::from_millis(20);

/// The page, opened from the disk.
pub struct Page {
    /// What shows it.
    pub browser: Browser,
}

impl Page {
    /// Opens it on a desktop's screen, in light colours.
    ///
    /// # Errors
    /// There is no browser, or no page.
    pub fn open() -> Result<Page> {
        Self::open_on(1280, 900, false, "")
    }

    /// Opens it in a window of this size, px, with what follows `#` in its address.
    ///
    /// # Errors
    /// There is no browser, or no page.
    pub fn open_on(width_px: u32, height_px: u32, is_dark: bool, state: &str) -> Result<Page> {
        let page = Page { browser: Browser::start(width_px, height_px, is_dark)? };
        let place = Self::place()?;
        page.browser.open(&format!("file://{}{state}", place.display()))?;
        page.wait("document.documentElement.dataset.ready")?;
        Ok(page)
    }

    /// Where the built file lies.
    ///
    /// # Errors
    /// Nobody said it.
    pub fn place() -> Result<PathBuf> {
        env::var_os("SIL_PAGE").map(PathBuf::from).context("SIL_PAGE is not set: run `cargo xtask page-test`")
    }

    /// Runs the command line's `sil` in a folder; its standard output, or its complaint.
    ///
    /// # Errors
    /// Nobody said where it is, or it can't be started.
    pub fn sil(folder: &Path, arguments: &[&str]) -> Result<Result<String, String>> {
        let sil = env::var_os("SIL_BINARY").context("SIL_BINARY is not set: run `cargo xtask page-test`")?;
        let output = Command::new(sil).args(arguments).current_dir(folder).output()?;
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        Ok(if output.status.success() { Ok(text(output.stdout)) } else { Err(text(output.stderr)) })
    }

    /// Makes a synthetic log in a folder by `sil synth`; where it lies.
    ///
    /// # Errors
    /// What `sil` says.
    pub fn synthetic(folder: &Path, name: &str, options: &[&str]) -> Result<PathBuf> {
        Self::sil(folder, &[&["synth", name], options].concat())?.map_err(anyhow::Error::msg)?;
        Ok(folder.join(name))
    }

    /// The value of an expression, once it is something.
    ///
    /// # Errors
    /// It is nothing for a minute.
    pub fn wait(&self, expression: &str) -> Result<Value> {
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            let value = self.value(expression)?;
            if !matches!(value, Value::Null | Value::Bool(false)) && value != json!("") {
                return Ok(value);
            }
            std::thread::sleep(LOOK);
        }
        let problems = self.value("[...document.querySelectorAll('[role=alert]')].map((of) => of.innerText).join()")?;
        bail!("for a minute nothing: {expression}; the page says {problems}")
    }

    /// The value of an expression.
    ///
    /// # Errors
    /// The expression has one.
    pub fn value(&self, expression: &str) -> Result<Value> {
        self.browser.script(&format!("return {expression}"), &[])
    }

    /// The text of an element, as it is seen.
    ///
    /// # Errors
    /// There is no such element.
    pub fn text(&self, selector: &str) -> Result<String> {
        let text = self.browser.script("return document.querySelector(arguments[0])?.innerText", &[json!(selector)])?;
        text.as_str().map(str::to_owned).with_context(|| format!("no element {selector}"))
    }

    /// Clicks an element.
    ///
    /// # Errors
    /// There is no such element.
    pub fn click(&self, selector: &str) -> Result<()> {
        self.browser.script("document.querySelector(arguments[0]).click()", &[json!(selector)]).map(drop)
    }

    /// Sets an input or a choice, as by hand.
    ///
    /// # Errors
    /// There is no such element.
    pub fn set(&self, selector: &str, value: &str) -> Result<()> {
        let script = "const element = document.querySelector(arguments[0]);
            element.value = arguments[1];
            for (const kind of ['input', 'change']) element.dispatchEvent(new Event(kind, { bubbles: true }));";
        self.browser.script(script, &[json!(selector), json!(value)]).map(drop)
    }

    /// Gives files to the page as if they were chosen together.
    ///
    /// # Errors
    /// There is no such file.
    pub fn choose(&self, files: &[&Path]) -> Result<()> {
        let files: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        self.browser.give_file("#file", &files.join("\n"))
    }

    /// The headline of the answer to what was dropped.
    ///
    /// # Errors
    /// There is none within a minute.
    pub fn answer(&self) -> Result<String> {
        self.wait("document.querySelector('#answer h1')")?;
        // a number is kept on one line with its unit
        Ok(self.text("#answer h1")?.replace('\u{a0}', " "))
    }

    /// What a button would save as a file.
    ///
    /// # Errors
    /// There is no such button.
    pub fn saved(&self, file: &str) -> Result<String> {
        let script = "const blobs = [];
            const [make, click] = [URL.createObjectURL, HTMLAnchorElement.prototype.click];
            URL.createObjectURL = (blob) => { blobs.push(blob); return make(blob); };
            HTMLAnchorElement.prototype.click = () => {};
            document.querySelector(`[data-file='${arguments[0]}']`).click();
            [URL.createObjectURL, HTMLAnchorElement.prototype.click] = [make, click];
            return blobs[0].text();";
        let text = self.browser.script(script, &[json!(file)])?;
        text.as_str().map(str::to_owned).with_context(|| format!("nothing is saved as {file}"))
    }

    /// The view that flies, with its first flight.
    ///
    /// # Errors
    /// Nothing flies.
    pub fn fly(&self) -> Result<()> {
        self.click("#tab-fly")?;
        self.wait("document.getElementById('flight').dataset.ms").map(drop)
    }

    /// Does something that makes another flight, and waits for it; how long it took until it was drawn, ms.
    ///
    /// # Errors
    /// Nothing flies.
    pub fn flown_after(&self, act: impl FnOnce(&Page) -> Result<()>) -> Result<u32> {
        self.browser.script("delete document.getElementById('flight').dataset.ms", &[])?;
        act(self)?;
        let ms = self.wait("document.getElementById('flight').dataset.ms")?;
        ms.as_str().and_then(|ms| ms.parse().ok()).context("no time")
    }

    /// The drawn curves of the flight.
    ///
    /// # Errors
    /// The driver's.
    pub fn curves(&self) -> Result<Value> {
        self.value("[...document.querySelectorAll('#flight path[data-name]')].map((path) => path.getAttribute('d'))")
    }
}
