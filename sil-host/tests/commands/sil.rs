//! Runs the binary in an empty folder of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// The bundled rig log.
pub const RIG_LOG: &str = include_str!("../../demonstration/rig-log.csv");
/// The project's model of the testbed.
pub const GIMBAL_MODEL: &str = include_str!("../../../models/f450-gimbal.toml");
/// The same without windings to be followed.
pub const GENERIC_GIMBAL_MODEL: &str = include_str!("../../../models/generic-gimbal.toml");
/// A vehicle in free flight whose motors have no windings to be followed: quicker, where motors are not what matters.
pub const GENERIC_FREE_MODEL: &str = include_str!("../../../models/generic-free.toml");

/// An empty folder in which `sil` runs; gone with the value.
pub struct Folder {
    folder: TempDir,
}

/// What a run left behind.
pub struct Outcome {
    /// The arguments, for messages.
    pub arguments: String,
    /// Exit status; none if a signal ended it.
    pub status: Option<i32>,
    /// All of stdout.
    pub stdout: String,
    /// All of stderr.
    pub stderr: String,
}

impl Folder {
    /// A new one.
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// With `gimbal.toml` and two logs of it, `healthy.csv` and `suspect.csv`, which has a moment that the model lacks.
    pub fn of_healthy_and_suspect() -> Self {
        let folder = Self::new();
        folder.write("gimbal.toml", GENERIC_GIMBAL_MODEL);
        let rates = ["--rate", "100", "--control-rate", "100", "--duration", "6", "--model", "gimbal.toml"];
        folder.sil(&[&["synth", "healthy.csv"], &rates[..]].concat()).assert_done();
        let effect = ["--effect", "torque_bias:axis=roll,torque_nm=0.05"];
        folder.sil(&[&["synth", "suspect.csv"], &effect[..], &rates].concat()).assert_done();
        folder
    }

    /// Where a file of this name lies.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Puts a file there.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// The bytes of a file there.
    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// A file there as JSON.
    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// `sil` with these arguments, no screen to open anything on.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sil"));
        command.args(arguments).current_dir(self.folder.path()).stdin(Stdio::null());
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
        command
    }

    /// Runs `sil` to its end.
    pub fn sil(&self, arguments: &[&str]) -> Outcome {
        Outcome::of(arguments, self.command(arguments))
    }
}

impl Outcome {
    /// Runs a command to its end.
    pub fn of(arguments: &[&str], mut command: Command) -> Self {
        let output = command.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self {
            arguments: arguments.join(" "),
            status: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// It succeeded, and complained of nothing.
    pub fn assert_done(self) -> Self {
        assert_eq!(self.status, Some(0), "{self:?}");
        assert_eq!(self.stderr, "", "{self:?}");
        self
    }

    /// It refused its input: status 2, nothing on stdout, a message on stderr with all of these parts.
    pub fn assert_refused(&self, message_parts: &[&str]) {
        assert_eq!(self.status, Some(2), "{self:?}");
        assert_eq!(self.stdout, "", "{self:?}");
        self.assert_message(message_parts);
    }

    /// It refused its input after it had done what it could: status 2, a message on stderr with all of these parts.
    pub fn assert_message_of_status_2(&self, message_parts: &[&str]) {
        assert_eq!(self.status, Some(2), "{self:?}");
        self.assert_message(message_parts);
    }

    /// It failed on its own: status 1, a message on stderr with all of these parts.
    pub fn assert_failed(&self, message_parts: &[&str]) {
        assert_eq!(self.status, Some(1), "{self:?}");
        self.assert_message(message_parts);
    }

    fn assert_message(&self, parts: &[&str]) {
        assert!(self.stderr.starts_with("error: "), "{self:?}");
        assert!(!self.stderr.contains("panicked"), "{self:?}");
        for part in parts {
            assert!(self.stderr.contains(part), "no \"{part}\" in {self:?}");
        }
    }
}

impl std::fmt::Debug for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { arguments, status, stdout, stderr } = self;
        write!(f, "sil {arguments}\nstatus {status:?}\n--- stdout\n{stdout}\n--- stderr\n{stderr}")
    }
}

/// The instance files of the solver benchmark, in order of their names.
pub fn instance_files() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/instances");
    let mut files: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path().display().to_string()).collect();
    files.sort();
    files
}
