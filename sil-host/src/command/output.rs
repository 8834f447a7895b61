//! Where results go: the terminal, files, or stdout in place of a file.

use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::{Failure, failed};

/// Stands for stdout in place of a file, and for stdin in place of a log.
pub const STANDARD_STREAM: &str = "-";

/// Set once, before a command runs.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// From now on nothing but what was requested of stdout goes there.
pub fn be_quiet() {
    IS_QUIET.store(true, Ordering::Relaxed);
}

/// Prints to stdout, unless the command is to be quiet.
pub fn print(text: impl Display) -> Result<(), Failure> {
    if IS_QUIET.load(Ordering::Relaxed) { Ok(()) } else { to_stdout(text) }
}

/// Prints what was requested of stdout, quiet or not: a draft, a page, JSON for `-`. Who closed stdout
/// (`sil fly | head`) has seen enough; the files are still written.
pub fn to_stdout(text: impl Display) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match write!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(failed(format!("the output: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// A line in bold on a terminal whose user wants colours (no-color.org).
pub fn emphasised(line: &str) -> String {
    let is_wanted = std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty());
    if is_wanted { format!("\u{1b}[1m{line}\u{1b}[0m") } else { line.to_owned() }
}

/// Writes a file, making its folder; a failure names it.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    make_folder(path)?;
    std::fs::write(path, bytes).map_err(|error| failed(format!("{}: cannot be written: {error}", path.display())))
}

/// Makes the folder that a file will lie in.
pub fn make_folder(path: &Path) -> Result<(), Failure> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => std::fs::create_dir_all(folder)
            .map_err(|error| failed(format!("{}: cannot be made: {error}", folder.display()))),
        _ => Ok(()),
    }
}

/// Writes a value as JSON, if a file or stdout was requested.
pub fn write_json(path: Option<&Path>, value: &impl serde::Serialize) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let text = sil_host::answer::json(value).map_err(failed)?;
    if path == Path::new(STANDARD_STREAM) { to_stdout(text) } else { write_file(path, text.as_bytes()) }
}
