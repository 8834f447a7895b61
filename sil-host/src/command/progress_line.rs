//! How far the reading of a log, a diagnosis or a study is, on a terminal; silent where stderr is none.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use sil_host::diagnosis::Progress;

/// What is done sooner shows no line: it would only flicker.
const SILENT: Duration = Duration::from_millis(300);

/// A line on stderr that is gone with the value.
pub struct ProgressLine {
    bar: ProgressBar,
    /// Which of several logs it is; empty for one.
    log: String,
}

impl ProgressLine {
    pub fn new() -> Self {
        let bar = ProgressBar::new(1);
        if let Ok(style) = ProgressStyle::with_template("[{bar:30}] {elapsed}, about {eta} left: {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar, log: String::new() }
    }

    /// For one of several logs, counted from 1.
    pub fn of_several(number: usize, of: usize) -> Self {
        let mut line = Self::new();
        line.log = format!("log {number} of {of}: ");
        line
    }

    /// So many of all, of things that have a name. What there is at the first call is no work done.
    pub fn show_count(&self, done: u64, total: u64, of: &str) {
        if self.bar.length() != Some(total) {
            self.bar.set_length(total);
            self.bar.set_position(done);
            self.bar.reset_eta();
        }
        self.bar.set_position(done);
        self.bar.set_message(format!("{done} of {total} {of}"));
    }

    /// So many bytes of a file.
    pub fn show_read(&self, done: usize, of: usize) {
        self.show_step(done, of, "reading the log");
    }

    pub fn show(&self, progress: Progress) {
        let (done, total, message) = progress.step();
        self.show_step(done, total, &message);
    }

    fn show_step(&self, done: usize, total: usize, message: &str) {
        if self.bar.elapsed() < SILENT {
            return;
        }
        // each step has its own pace
        if self.bar.length() != Some(total as u64) {
            self.bar.set_length(total as u64);
            self.bar.set_position(done as u64);
            self.bar.reset_eta();
        }
        self.bar.set_position(done as u64);
        self.bar.set_message(format!("{}{message}", self.log));
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
