//! Has a board make one of its numbered self-tests by a debug probe, and shows what it says (docs/bring-up.md).

use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::Args;
use object::{Object, ObjectSymbol};

use crate::firmware::Target;
use crate::process;
use crate::workspace::Workspace;

const CHIP: &str = "STM32F427VITx";
/// The word that takes the number (firmware/src/pixhawk/self_test.rs).
const REQUEST: &str = "SELF_TEST_REQUEST";

#[derive(Args)]
pub(crate) struct Arguments {
    /// The test's number, from 1 on (docs/bring-up.md)
    number: u32,
}

/// The image that was built last must be the one that runs: the word lies where its symbol says.
pub(crate) fn run(workspace: &Workspace, Arguments { number }: &Arguments) -> Result<()> {
    let image = Target::find(workspace)?.image();
    let bytes = std::fs::read(&image).with_context(|| format!("{}: build it by `cargo fw`", image.display()))?;
    let address = address_of(&bytes, REQUEST)?;
    let (address, number) = (format!("{address:#x}"), number.to_string());
    process::run(Command::new("probe-rs").args(["write", "--chip", CHIP, "b32", &address, &number]))?;
    process::run(Command::new("probe-rs").args(["attach", "--chip", CHIP]).arg(&image))
}

fn address_of(image: &[u8], name: &str) -> Result<u64> {
    let file = object::File::parse(image)?;
    let Some(symbol) = file.symbols().find(|symbol| symbol.name() == Ok(name)) else {
        bail!("the image has no {name}: build it anew by `cargo fw`");
    };
    Ok(symbol.address())
}
