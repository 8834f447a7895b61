//! The solver benchmark on an emulated Cortex-M4F: what the solver's two instances take, the one that flies and the
//! thesis' regulation problem. An image per instance file and problem.

mod counting;
mod instances;
mod options;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use crate::firmware::Target;
use crate::workspace::Workspace;
use counting::{Counter, Counts};
use instances::{Instances, Problem};

/// What DAQP takes with the same problem split into its axes, on the same processor, float32, -O3: instructions, median
/// and maximum of the 200 instances at 10 ms, by case.
const DAQP: [(&str, u64, u64); 8] = [
    ("a-i", 765, 1_500),
    ("a-ii", 4_400, 8_000),
    ("b-i", 2_200, 4_800),
    ("b-ii", 6_500, 15_600),
    ("c-i", 4_600, 25_000),
    ("c-ii", 9_900, 46_000),
    ("d-i", 22_600, 415_000),
    ("d-ii", 39_800, 528_000),
];

/// Where to find the instance files and where to leave what comes out.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Folder of instance files (.json, .json.gz); by default the project's own
    folder: Option<PathBuf>,
    /// Write the figures as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
    /// Count what the options of the MPC take at most, instead of the instance files
    #[arg(long, conflicts_with_all = ["folder", "json"])]
    options: bool,
    /// Leave the images here, to be counted again
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
}

/// Builds and counts every file's image; prints the table.
pub(crate) fn run(workspace: &Workspace, arguments: &Arguments) -> Result<()> {
    let target = Target::find(workspace)?;
    let counter = Counter::build(workspace)?;
    let folder = arguments.folder.clone().unwrap_or_else(|| workspace.root.join("tests/instances"));
    let images = arguments.keep.clone().unwrap_or_else(|| workspace.target_dir.join("bench-mcu"));
    fs::create_dir_all(&images).with_context(|| format!("cannot make {}", images.display()))?;
    if arguments.options {
        return options::run(&target, &counter, &images);
    }
    let mut cases = Vec::new();
    for path in instance_files(&folder)? {
        let instances = Instances::read(&path)?;
        for problem in instances.problems() {
            let name = instances.name(problem);
            let image = images.join(format!("{name}.elf"));
            let source = workspace.target_dir.join("bench-mcu-data.rs");
            fs::write(&source, instances.rust_source(problem))
                .with_context(|| format!("cannot write {}", source.display()))?;
            let built = target.build_bench_image(&source, instances.features())?;
            fs::copy(&built, &image).with_context(|| format!("cannot write {}", image.display()))?;
            let counts = counter.count(&image)?;
            print_row(cases.is_empty(), &instances, problem, &counts)?;
            cases.push(figures(&path, &instances, problem, &counts)?);
        }
    }
    println!("images: {}", images.display());
    if let Some(out) = &arguments.json {
        let text = serde_json::to_string_pretty(&json!({ "cases": cases }))?;
        fs::write(out, text).with_context(|| format!("cannot write {}", out.display()))?;
    }
    Ok(())
}

fn instance_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let mut files = entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    files.retain(|path| path.to_string_lossy().ends_with(".json") || path.to_string_lossy().ends_with(".json.gz"));
    files.sort();
    ensure!(!files.is_empty(), "no instance file in {}", folder.display());
    Ok(files)
}

fn print_row(with_head: bool, instances: &Instances, problem: Problem, counts: &Counts) -> Result<()> {
    if with_head {
        println!(
            "problem     case   Ts, ms   solved      error  iterations     instructions   DAQP, split        flash    \
             RAM"
        );
        println!(
            "                                        u_max  median max    median     max   median     max   bytes  \
             bytes"
        );
    }
    let label = instances.label();
    let is_compared = problem == Problem::Regulation && instances.step_s == 0.01;
    let peer = DAQP.iter().find(|(case, _, _)| *case == label && is_compared);
    let peer = peer.map_or_else(|| "      -       -".into(), |(_, median, max)| format!("{median:7} {max:7}"));
    let error = instances.error_max(problem, &counts.solves)?;
    let error = error.map_or_else(|| "-".into(), |error| format!("{error:.1e}"));
    let (iterations, instructions) = (counts.iterations(), counts.instructions());
    println!(
        "{:10}  {label:5} {:7.1}  {:3}/{:3}  {error:>9}  {:6} {:3}  {:8} {:7}  {peer}  {:6} {:6}",
        problem.name(),
        1e3 * instances.step_s,
        counts.solved(),
        counts.solves.len(),
        iterations.0,
        iterations.1,
        instructions.0,
        instructions.1,
        counts.flash_bytes,
        counts.ram_bytes(),
    );
    Ok(())
}

fn figures(path: &Path, instances: &Instances, problem: Problem, counts: &Counts) -> Result<Value> {
    let (iterations, instructions) = (counts.iterations(), counts.instructions());
    Ok(json!({
        "file": path.display().to_string(),
        "problem": problem.name(),
        "case": instances.case,
        "sub": instances.sub,
        "ts_s": instances.step_s,
        "instances": counts.solves.len(),
        "solved": counts.solved(),
        "error_max": instances.error_max(problem, &counts.solves)?,
        "iterations_median": iterations.0,
        "iterations_max": iterations.1,
        "instructions_median": instructions.0,
        "instructions_max": instructions.1,
        "flash_bytes": counts.flash_bytes,
        "ram_bytes": counts.ram_bytes(),
    }))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::counting::Solve;
    use super::*;

    /// The fields of a case in docs/commands.md, each with its types.
    fn described() -> BTreeMap<String, String> {
        let page = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/commands.md")).unwrap();
        let table = page.split("<!-- json: bench-mcu -->").nth(1).unwrap().split("\n\n").next().unwrap();
        let rows = table.lines().filter_map(|line| line.strip_prefix("| `cases[]."));
        let cells = rows.map(|row| row.split('|').map(|cell| cell.trim().trim_end_matches('`').to_owned()));
        cells.map(|mut cells| (cells.next().unwrap(), cells.next().unwrap())).collect()
    }

    /// Whether a value is of one of the types.
    fn fits(value: &Value, types: &str) -> bool {
        types.split(" or ").any(|kind| match kind {
            "string" => value.is_string(),
            "integer" => value.is_u64(),
            "number" => value.is_f64(),
            "null" => value.is_null(),
            _ => false,
        })
    }

    #[test]
    fn the_page_describes_every_field_of_a_case() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/instances/instances_a_i.json.gz");
        let instances = Instances::read(&path).unwrap();
        let solve =
            || Solve { instructions: 700, stack_bytes: 8, is_solved: true, iterations: 3, input: Default::default() };
        let solves = (0..200).map(|_| solve()).collect();
        let counts = Counts { solves, flash_bytes: 4000, data_bytes: 900 };
        let described = described();
        for problem in instances.problems() {
            let case = figures(&path, &instances, problem, &counts).unwrap();
            let case = case.as_object().unwrap();
            assert!(case.keys().eq(described.keys()), "{:?} {:?}", case.keys(), described.keys());
            for (field, value) in case {
                assert!(fits(value, &described[field]), "{field}: {value} is not {}", described[field]);
            }
        }
    }
}
