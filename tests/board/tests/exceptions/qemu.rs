//! QEMU's `mps2-an386`: a Cortex-M4F with memory at 0 and at 0x2000_0000.

use std::io::ErrorKind;
use std::process::{Command, Stdio};

/// Where its program lies.
pub const BASE: u32 = 0;

/// What a program writes to standard output; none where QEMU is not installed.
pub fn trace(program: &[u8]) -> Option<Vec<u8>> {
    let path = std::env::temp_dir().join(format!("exceptions-{}.bin", std::process::id()));
    std::fs::write(&path, program).unwrap();
    let mut command = Command::new("qemu-system-arm");
    command.args(["-M", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "none"]);
    command.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(&path);
    let output = command.stdin(Stdio::null()).output();
    std::fs::remove_file(&path).unwrap();
    match output {
        Ok(output) => {
            let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "qemu-system-arm: {}: {complaint}", output.status);
            Some(output.stdout)
        }
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => panic!("qemu-system-arm: {error}"),
    }
}
