//! What a plan takes at most with each option of the MPC that an owner can choose.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::counting::Counter;
use super::instances::{Instances, Problem};
use crate::firmware::Target;

/// Cycles of an instruction on the board, flash timing included: of the worst plans in `tests/board/budgets.toml` at
/// 400 Hz, 1.37 to 1.39.
const CYCLES_PER_INSTRUCTION: f64 = 1.4;
/// Cycles of a second.
const CYCLES_PER_S: f64 = 168e6;
/// What a step's other tasks take at most: the worst of `tests/board/budgets.toml`.
const OTHER_TASKS_CYCLES: f64 = 74_000.0;

/// Builds the image, counts, and prints a row for each option.
///
/// # Errors
/// Names the options of which a plan, with the step's other tasks, can take longer than a step.
pub(super) fn run(target: &Target<'_>, counter: &Counter, images: &Path) -> Result<()> {
    let source = images.join("options-data.rs");
    fs::write(&source, Instances::none().rust_source(Problem::Options))
        .with_context(|| format!("cannot write {}", source.display()))?;
    let (built, image) = (target.build_bench_image(&source, &[])?, images.join("options.elf"));
    fs::copy(&built, &image).with_context(|| format!("cannot write {}", image.display()))?;
    println!(
        "| option | free inputs | passes, median / max | cut short | instructions, median / max | cycles, of a step |"
    );
    println!("|---|---|---|---|---|---|");
    let mut late = Vec::new();
    for (name, counts) in counter.count_options(&image)? {
        let (option, control_horizon) = name.split_once(' ').context("an option without its free inputs")?;
        let (passes, instructions) = (counts.iterations(), counts.instructions());
        let cycles = CYCLES_PER_INSTRUCTION * instructions.1 as f64;
        let step_cycles = CYCLES_PER_S / if option.ends_with("100-hz") { 100.0 } else { 400.0 };
        if cycles + OTHER_TASKS_CYCLES > step_cycles {
            late.push(name.clone());
        }
        println!(
            "| {option} | {control_horizon} | {} / {} | {} of {} | {} / {} | {:.0}, {:.0} % |",
            passes.0,
            passes.1,
            counts.solves.len() - counts.solved(),
            counts.solves.len(),
            instructions.0,
            instructions.1,
            cycles,
            100.0 * cycles / step_cycles,
        );
    }
    println!("image: {}", image.display());
    ensure!(late.is_empty(), "a plan can be late with: {}", late.join(", "));
    Ok(())
}
