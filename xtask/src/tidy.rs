//! Rules of the project that neither the compiler nor clippy knows: sizes, names, leftovers, references, long lines,
//! Rust files that nobody compiles.

mod modules;
mod prose;
mod references;
mod rust_source;

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::process;
use crate::workspace::Workspace;
use references::Tree;

const FILE_SIZE_MAX: usize = 1_000_000;
/// Names that say nothing about what is inside.
const EMPTY_NAMES: [&str; 6] = ["common", "helper", "helpers", "misc", "util", "utils"];

/// One breach of a rule.
struct Finding {
    path: String,
    /// From 1; none if the file as a whole is meant.
    line: Option<usize>,
    message: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.path, self.message),
            None => write!(f, "{}: {}", self.path, self.message),
        }
    }
}

/// Checks every file that git tracks or would add.
pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    let paths = process::output(
        Command::new("git")
            .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
            .current_dir(&workspace.root),
    )?;
    // what is deleted, but not yet from git's index, is not there
    let is_there = |path: &&str| workspace.root.join(path).is_file();
    let paths: Vec<&str> = paths.split_terminator('\0').filter(is_there).collect();
    let tree = Tree::new(paths.iter().copied());
    let mut findings = Vec::new();
    let mut sources = BTreeMap::new();
    for path in &paths {
        let bytes = fs::read(workspace.root.join(path)).with_context(|| format!("cannot read {path}"))?;
        findings.extend(check(path, &bytes, &tree));
        if path.ends_with(".rs") {
            sources.insert(*path, String::from_utf8_lossy(&bytes).into_owned());
        }
    }
    let sources = sources.iter().map(|(path, text)| (*path, text.as_str())).collect();
    for path in modules::orphans(&sources, &workspace.target_roots()?) {
        let message = "nobody compiles it: no `mod` names it, and it is no target of its crate".into();
        findings.push(Finding { path: path.to_owned(), line: None, message });
    }
    for finding in &findings {
        println!("{finding}");
    }
    if !findings.is_empty() {
        bail!("{} breaches of the project's rules", findings.len());
    }
    println!("{} files are tidy", paths.len());
    Ok(())
}

fn check(path: &str, bytes: &[u8], tree: &Tree) -> Vec<Finding> {
    let mut breaches = Vec::new();
    if bytes.len() > FILE_SIZE_MAX {
        breaches.push((None, format!("{} bytes; at most {FILE_SIZE_MAX}", bytes.len())));
    }
    if let Some(name) = empty_name(path) {
        breaches.push((None, format!("the name '{name}' does not say what is inside")));
    }
    if let Ok(text) = str::from_utf8(bytes) {
        breaches.extend(check_text(path, text, tree).into_iter().map(|(line, message)| (Some(line), message)));
    }
    let finding = |(line, message)| Finding { path: path.to_owned(), line, message };
    breaches.into_iter().map(finding).collect()
}

/// Line, from 1, and what is wrong there.
fn check_text(path: &str, text: &str, tree: &Tree) -> Vec<(usize, String)> {
    let leftovers = (1..).zip(text.lines()).filter_map(|(number, line)| Some((number, leftover(line)?)));
    let mut breaches: Vec<_> = leftovers.collect();
    breaches.extend(references::check(path, text, tree));
    breaches.extend(prose::riddles(path, text));
    breaches.extend(prose::long_lines(path, text));
    if path.ends_with(".rs") {
        breaches.extend(rust_source::check(path, text));
    }
    breaches
}

/// The folder or file, extension aside, with a name of no content.
fn empty_name(path: &str) -> Option<&str> {
    let stems = path.split('/').map(|part| part.split('.').next().unwrap_or(part));
    stems.into_iter().find(|stem| EMPTY_NAMES.contains(stem))
}

/// What must not stay in any text file.
fn leftover(line: &str) -> Option<String> {
    // written in two halves, or this file would break its own rule
    for word in [concat!("TO", "DO"), concat!("FIX", "ME")] {
        if has_word(line, word) && !names_issue(line) {
            return Some(format!("{word} without the number of an issue (#12)"));
        }
    }
    for folder in [concat!("/wo", "rk/"), concat!("/ro", "ot/"), concat!("/ho", "me/")] {
        let foreign = |(at, _): (usize, &str)| !line[..at].ends_with(is_path_character);
        if line.match_indices(folder).any(foreign) {
            return Some(format!("path of one machine: {folder}"));
        }
    }
    None
}

fn has_word(line: &str, word: &str) -> bool {
    let alone = |(at, _): (usize, &str)| {
        let (before, after) = (&line[..at], &line[at + word.len()..]);
        !before.ends_with(char::is_alphanumeric) && !after.starts_with(char::is_alphanumeric)
    };
    line.match_indices(word).any(alone)
}

fn names_issue(line: &str) -> bool {
    line.match_indices('#').any(|(at, _)| line[at + 1..].starts_with(|c: char| c.is_ascii_digit()))
}

/// Whether a slash after this character goes on with a path, as in `tests/home/`.
fn is_path_character(c: char) -> bool {
    c.is_alphanumeric() || "._-~}".contains(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leftovers_need_an_issue() {
        let word = concat!("TO", "DO");
        assert!(leftover(&format!("// {word}: later")).is_some());
        assert!(leftover(&format!("// {word}(#12): later")).is_none());
        assert!(leftover(&format!("# Section #12 {word}")).is_none());
        assert!(leftover(&format!("MAS{word}N")).is_none());
    }

    #[test]
    fn absolute_machine_paths_are_found_relative_ones_are_not() {
        let folder = concat!("/ho", "me/");
        assert!(leftover(&format!("path = \"{folder}me\"")).is_some());
        assert!(leftover(&format!("{folder}me")).is_some());
        assert!(leftover(&format!("see tests{folder}me")).is_none());
        assert!(leftover(&format!("https://example.org{folder}")).is_none());
    }

    #[test]
    fn names_without_content_are_found_anywhere_in_a_path() {
        assert_eq!(empty_name("sil-host/src/utils.rs"), Some("utils"));
        assert_eq!(empty_name("tests/common/mod.rs"), Some("common"));
        assert_eq!(empty_name("sil-host/src/commonality.rs"), None);
    }

    #[test]
    fn large_files_are_found_even_if_binary() {
        let bytes = vec![0xff; FILE_SIZE_MAX + 1];
        let tree = Tree::new([]);
        assert_eq!(check("data.bin", &bytes, &tree).len(), 1);
        assert_eq!(check("data.bin", &bytes[1..], &tree).len(), 0);
    }
}
