//! The findings as a table that is kept.

use std::fmt::Write;
use std::path::PathBuf;

use crate::findings::{Evidence, FINDINGS};

/// Set to write `ELECTRICS.md` anew.
const RENEW: &str = "RENEW_BOARD_FIGURES";

const HEAD: &str = "\
# What the board does at its edges, and what the firmware makes of it

Each row is something that the parts' documents say, or that others measured on this board, and that a program can get
wrong without noticing. `cargo xtask board-test` looks at every one of them on the emulated board, whose parts were
modelled from those documents before anybody looked at the drivers, and fails if a row changes;
`RENEW_BOARD_FIGURES=1 cargo xtask board-test` writes this table. **open**: the firmware does not live up to it yet.

| finding | source | | what was seen |
|---|---|---|---|
";

/// All of them.
pub fn markdown(found: &[Evidence]) -> String {
    let mut text = HEAD.to_owned();
    for (finding, evidence) in FINDINGS.iter().zip(found) {
        let (state, seen) = match evidence {
            Ok(seen) => ("kept", seen),
            Err(seen) => ("**open**", seen),
        };
        writeln!(text, "| {} | {} | {state} | {seen} |", finding.name, finding.source).unwrap();
    }
    text
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("ELECTRICS.md")
}

/// Writes it, if told to.
pub fn renew(text: &str) {
    if std::env::var_os(RENEW).is_some() {
        std::fs::write(path(), text).unwrap();
    }
}

/// Is it what is kept?
pub fn compare(text: &str) {
    let kept = std::fs::read_to_string(path()).unwrap_or_default();
    let other = text.lines().filter(|row| !kept.lines().any(|line| line == *row)).collect::<Vec<_>>().join("\n");
    assert!(kept == text, "ELECTRICS.md is not what was found: {RENEW}=1 cargo xtask board-test writes it\n{other}");
}
