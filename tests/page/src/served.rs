//! A vehicle of `sil serve` at a TCP port of its own, for as long as the value lives.

use std::env;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result};

/// Longer than any test, s: a vehicle that nobody ends ends by itself.
const LIFE_S: &str = "120";

/// The vehicle; it ends with the value.
pub struct Served {
    process: Child,
    address: String,
}

impl Served {
    /// Starts it in a folder; `arguments` go to `sil serve` beside the port.
    ///
    /// # Errors
    /// Nobody said where `sil` is, or it does not start.
    pub fn start(folder: &Path, arguments: &[&str]) -> Result<Served> {
        let sil = env::var_os("SIL_BINARY").context("SIL_BINARY is not set: run `cargo xtask page-test`")?;
        let mut command = Command::new(sil);
        command.args(["serve", "--tcp", "0", "--udp", "off", "--for", LIFE_S]).args(arguments).current_dir(folder);
        let mut process = command.stdout(Stdio::piped()).spawn()?;
        let mut lines =
            BufReader::new(process.stdout.take().context("sil says nothing")?).lines().map_while(Result::ok);
        let address = lines.find_map(|line| line.strip_prefix("TCP  waits for clients at ").map(str::to_owned));
        // nobody reads on: what else it prints must not fill the pipe
        std::thread::spawn(move || lines.for_each(drop));
        let served = Served { process, address: address.unwrap_or_default() };
        anyhow::ensure!(!served.address.is_empty(), "sil serve ended without a port");
        Ok(served)
    }

    /// Where it waits for clients.
    pub fn address(&self) -> &str {
        &self.address
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // it may have ended by itself
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
