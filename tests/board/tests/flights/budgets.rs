//! What a step, a task and the image cost: hard limits, and figures that a file keeps so that growth is seen.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::flown::Flown;

/// Set to write `budgets.toml` anew.
const RENEW: &str = "RENEW_BOARD_FIGURES";
/// Growth that is let pass, percent: what another build of the same source brings.
const GROWTH_PERCENT: u64 = 3;
/// And of the cycles, whatever their number: two lines of flash at five wait states, for where a task's code begins in
/// a line is the linker's choice and no cost of its own.
const GROWTH_CYCLES: u64 = 12;

/// Of the cycles of a step at 168 MHz, whatever its rate; a slower loop has more samples in each step.
const PID_LOOP_PERCENT_MAX: u32 = 15;
const CYCLES_PER_S: u32 = 168_000_000;
/// Of a step at 400 Hz: control, IO and link, each task at its worst.
const WORST_STEP_PERMILLE_MAX: u64 = 400;
/// Of the two megabytes that the chip has; what is loaded by a probe or a bootloader in seconds.
const FLASH_BYTES_MAX: usize = 420_000;

const HEAD: &str = "\
# What the image costs, measured on the emulated board: bytes, and instructions of each task's activations without what
# interrupts them, with the worst one's cycles, flash timing included. `cargo xtask board-test` fails if a figure grows
# by more than 3 % (of cycles 12 are let pass); if it is worth it, `RENEW_BOARD_FIGURES=1 cargo xtask board-test` writes
# this file.

";

/// Section, figure, value.
type Figures = BTreeMap<String, BTreeMap<String, u64>>;

pub fn check(flown: &[Flown]) {
    for flight in flown {
        let cascade_alone = flight.name.starts_with("PID");
        let worst = flight.tasks["loop"].worst_cycles;
        let most = CYCLES_PER_S / 100 * PID_LOOP_PERCENT_MAX / u32::from(flight.loop_rate_hz);
        assert!(!cascade_alone || worst < most, "{}: {worst}", flight.name);
        let worst_step = flight.worst_step_permille();
        let is_fast = flight.loop_rate_hz == 400;
        assert!(!is_fast || worst_step < WORST_STEP_PERMILLE_MAX, "{}: {worst_step}", flight.name);
        assert!(flight.flash_bytes < FLASH_BYTES_MAX, "{} bytes of flash", flight.flash_bytes);
        assert!(!flight.computes_in_f64, "f64 arithmetic in the image");
    }
    compare(&figures(flown));
}

fn figures(flown: &[Flown]) -> Figures {
    let mut figures = Figures::new();
    for flight in flown {
        let image = figures.entry("image".to_owned()).or_default();
        image.insert("flash bytes".to_owned(), flight.flash_bytes as u64);
        image.insert("RAM bytes".to_owned(), flight.ram_bytes as u64);
        let section = figures.entry(flight.name.to_owned()).or_default();
        section.insert("CPU permille".to_owned(), flight.cpu_permille);
        section.insert("worst step permille".to_owned(), flight.worst_step_permille());
        section.insert("stack bytes".to_owned(), flight.stack_bytes as u64);
        for (task, instructions) in &flight.tasks {
            section.insert(format!("{task}, median"), instructions.median.into());
            section.insert(format!("{task}, worst"), instructions.worst.into());
            section.insert(format!("{task}, worst cycles"), instructions.worst_cycles.into());
        }
    }
    figures
}

/// The most that a figure may be which was `before`.
fn most(name: &str, before: u64) -> u64 {
    let slack = if name.ends_with("cycles") { GROWTH_CYCLES } else { 0 };
    before + slack.max(GROWTH_PERCENT * before / 100)
}

fn compare(found: &Figures) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("budgets.toml");
    if std::env::var_os(RENEW).is_some() {
        std::fs::write(&path, HEAD.to_owned() + &toml::to_string(found).unwrap()).unwrap();
    }
    let committed: Figures = toml::from_str(&std::fs::read_to_string(&path).unwrap_or_default()).unwrap();
    let mut grown = Vec::new();
    for (section, name, value) in found.iter().flat_map(|(s, all)| all.iter().map(move |(n, v)| (s, n, *v))) {
        match committed.get(section).and_then(|figures| figures.get(name)) {
            Some(before) if value <= most(name, *before) => {}
            before => grown.push(format!("{section}: {name}: {value}, budget {before:?}")),
        }
    }
    let help = format!("if it is worth it: {RENEW}=1 cargo xtask board-test writes tests/board/budgets.toml");
    assert!(grown.is_empty(), "grown by more than {GROWTH_PERCENT} %:\n{}\n{help}", grown.join("\n"));
}
