//! Running an image in the emulator, and the sizes that its symbols give.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSymbol, SymbolKind};

use crate::board;
use crate::process;
use crate::workspace::Workspace;

/// The emulator's program that runs an image and counts.
pub(crate) struct Counter {
    program: PathBuf,
}

/// One solve.
pub(crate) struct Solve {
    pub(crate) instructions: u64,
    pub(crate) stack_bytes: u64,
    pub(crate) is_solved: bool,
    pub(crate) iterations: u64,
    pub(crate) input: [f64; 3],
}

/// All solves of an image, and its sizes.
pub(crate) struct Counts {
    pub(crate) solves: Vec<Solve>,
    /// Functions of the solver, preparation included; the rest of the image is printing.
    pub(crate) flash_bytes: u64,
    /// The prepared problem and the warm start.
    pub(crate) data_bytes: u64,
}

impl Counter {
    pub(crate) fn build(workspace: &Workspace) -> Result<Self> {
        board::check_tools()?;
        let arguments = ["--release", "--package", "emulated-board", "--example", "count_solves"];
        process::run(workspace.cargo("build").args(arguments))?;
        Ok(Self { program: workspace.target_dir.join("release/examples/count_solves") })
    }

    pub(crate) fn count(&self, image: &Path) -> Result<Counts> {
        let text = process::output(Command::new(&self.program).arg(image))?;
        Counts::parse(&text, solver_bytes(image)?).with_context(|| image.display().to_string())
    }

    /// The same of an image that begins every sequence with a line `option NAME`.
    pub(crate) fn count_options(&self, image: &Path) -> Result<Vec<(String, Counts)>> {
        let text = process::output(Command::new(&self.program).arg(image))?;
        let flash_bytes = solver_bytes(image)?;
        let options = text.split("option ").skip(1).map(|option| {
            let (name, lines) = option.split_once('\n').context("an option without a solve")?;
            Ok((name.to_owned(), Counts::parse(lines, flash_bytes)?))
        });
        options.collect::<Result<Vec<_>>>().with_context(|| image.display().to_string())
    }
}

impl Counts {
    fn parse(text: &str, flash_bytes: u64) -> Result<Self> {
        let mut counts = Self { solves: Vec::new(), flash_bytes, data_bytes: 0 };
        let mut counted = None;
        for line in text.lines() {
            let words = line.split_whitespace().collect::<Vec<_>>();
            match words[..] {
                ["prepared", prepared, "bytes,", "state", state, "bytes"] => {
                    counts.data_bytes = prepared.parse::<u64>()? + state.parse::<u64>()?;
                }
                ["counted", instructions, stack] => counted = Some((instructions.parse()?, stack.parse()?)),
                [_, _, status, iterations, u0, u1, u2] => {
                    let (instructions, stack_bytes) = counted.take().context("a solve that was not counted")?;
                    let (is_solved, iterations) = (status == "solved", iterations.parse()?);
                    let input = [u0.parse()?, u1.parse()?, u2.parse()?];
                    counts.solves.push(Solve { instructions, stack_bytes, is_solved, iterations, input });
                }
                _ => bail!("{line}"),
            }
        }
        Ok(counts)
    }

    pub(crate) fn solved(&self) -> usize {
        self.solves.iter().filter(|solve| solve.is_solved).count()
    }

    /// Median and maximum.
    pub(crate) fn iterations(&self) -> (u64, u64) {
        median_and_max(self.solves.iter().map(|solve| solve.iterations).collect())
    }

    /// Median and maximum.
    pub(crate) fn instructions(&self) -> (u64, u64) {
        median_and_max(self.solves.iter().map(|solve| solve.instructions).collect())
    }

    /// Prepared problem, warm start, and the most stack that a solve took.
    pub(crate) fn ram_bytes(&self) -> u64 {
        self.data_bytes + self.solves.iter().map(|solve| solve.stack_bytes).max().unwrap_or(0)
    }
}

fn median_and_max(mut values: Vec<u64>) -> (u64, u64) {
    values.sort_unstable();
    (values.get(values.len() / 2).copied().unwrap_or(0), values.last().copied().unwrap_or(0))
}

/// Bytes of the functions that come from the control core, and of those of the image that it was inlined into.
fn solver_bytes(image: &Path) -> Result<u64> {
    let bytes = std::fs::read(image).with_context(|| format!("cannot read {}", image.display()))?;
    let file = ElfFile32::<LittleEndian>::parse(&*bytes)?;
    let is_entry = |name: &str| name.contains("5bench") && (name.contains("5solve") || name.contains("7prepare"));
    let is_solver = |name: &str| name.contains("shared_control") || is_entry(name);
    let functions = file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text);
    Ok(functions.filter(|symbol| symbol.name().is_ok_and(is_solver)).map(|symbol| symbol.size()).sum())
}
