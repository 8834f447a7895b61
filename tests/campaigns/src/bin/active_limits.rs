//! The MPC while the motors are at their limits, as the tables of docs/mpc-against-cascade.md: `cargo run --release -p
//! campaigns --bin active_limits`, with `-- --json FILE` also as rows in a file; `tenth` flies a tenth of it.

use std::process::ExitCode;

use campaigns::active_limits::{find, tables};
use campaigns::arguments::Arguments;

/// Samples on each kind of body: that many without a loss leave less than 1 of 10,000, but for a chance of 1 in 1,000.
const SAMPLES: u64 = 69_080;
/// Throws: less than 3 of 1,000.
const THROWS: u64 = 2_300;

fn main() -> ExitCode {
    let arguments = match Arguments::of_process("active_limits") {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    let findings = find(SAMPLES / arguments.parts, THROWS / arguments.parts);
    print!("{}", tables(&findings));
    arguments.write(&findings)
}
