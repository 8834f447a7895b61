//! References to files of the project: pages, links and paths that are named must be there.

use std::collections::BTreeSet;

/// Line, from 1, and what is wrong there.
type Breach = (usize, String);

/// Everything that git tracks or would add: files, and the folders that they lie in.
pub(super) struct Tree {
    paths: BTreeSet<String>,
}

impl Tree {
    pub(super) fn new<'a>(files: impl IntoIterator<Item = &'a str>) -> Self {
        let mut paths = BTreeSet::new();
        for file in files {
            let ends = file.match_indices('/').map(|(at, _)| at).chain([file.len()]);
            paths.extend(ends.map(|end| file[..end].to_owned()));
        }
        Self { paths }
    }

    pub(super) fn has(&self, path: &str) -> bool {
        self.paths.contains(path)
    }

    /// Whether a file anywhere has this name.
    fn has_name(&self, name: &str) -> bool {
        self.paths.iter().any(|path| path.rsplit('/').next() == Some(name))
    }

    /// Whether a path of several parts begins in a folder of the project's root.
    fn begins_here(&self, path: &str) -> bool {
        path.split_once('/').is_some_and(|(first, rest)| !rest.is_empty() && self.has(first))
    }
}

/// What a text refers to and the tree does not have. In Rust and TOML, paths count in comments,
/// pages (`*.md`) anywhere.
pub(super) fn check(path: &str, text: &str, tree: &Tree) -> Vec<Breach> {
    let [is_rust, is_markdown, is_toml] = [".rs", ".md", ".toml"].map(|extension| path.ends_with(extension));
    // these rules' own tests name what is not there
    let is_exempt = path.starts_with("xtask/src/tidy");
    if is_exempt || !(is_rust || is_markdown || is_toml) {
        return Vec::new();
    }
    let mut breaches = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        // a feature of another crate is written like a path
        let in_comment = match line.trim_start() {
            code if is_rust => code.starts_with("//"),
            code if is_toml => code.starts_with('#'),
            _ => true,
        };
        let named = named_paths(line).filter(|named| named.ends_with(".md") || in_comment && tree.begins_here(named));
        let linked = links(line).filter(|_| is_markdown);
        let missing = named.filter(|named| !is_there(path, named, tree)).chain(linked.filter(|link| {
            let beside = beside(path, link);
            !beside.is_some_and(|beside| tree.has(&beside))
        }));
        let missing: BTreeSet<&str> = missing.collect();
        breaches.extend(missing.into_iter().map(|named| (number, format!("refers to {named}, which is not there"))));
    }
    breaches
}

/// Words that look like the path of a file or folder; patterns and parts of addresses do not.
fn named_paths(line: &str) -> impl Iterator<Item = &str> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    let words = line.split_whitespace().filter(|word| !word.contains("://") && !word.contains("]("));
    words.flat_map(move |word| {
        // a pattern, or a path that goes on with what is computed, names no one file
        let is_pattern = word.contains(['*', '{', '<', '$', '~', '…']) || word.contains("NAME");
        word.split(move |c| !is_part(c))
            .filter(move |_| !is_pattern)
            .map(|part| part.trim_matches('.'))
            .filter(|part| !part.starts_with('/'))
    })
}

/// Targets of `[text](target)` within the project, without their anchor.
fn links(line: &str) -> impl Iterator<Item = &str> {
    let targets = line.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let targets = targets.filter(|target| !target.contains("://") && !target.starts_with('#'));
    targets.filter_map(|target| target.split('#').next())
}

/// A path holds from the root, from the file's own folder or from its crate; a page's name alone holds anywhere.
fn is_there(from: &str, named: &str, tree: &Tree) -> bool {
    let named = named.trim_end_matches('/');
    let in_crate = from.split_once('/').map(|(first, _)| format!("{first}/{named}"));
    tree.has(named)
        || beside(from, named).is_some_and(|path| tree.has(&path))
        || in_crate.is_some_and(|path| tree.has(&path))
        || !named.contains('/') && tree.has_name(named)
}

/// The path from the root of what a file names from its own folder; none above the root.
pub(super) fn beside(from: &str, named: &str) -> Option<String> {
    let mut parts: Vec<&str> = from.split('/').collect();
    parts.pop();
    for part in named.trim_end_matches('/').split('/') {
        match part {
            "." | "" => {}
            ".." => drop(parts.pop()?),
            name => parts.push(name),
        }
    }
    Some(parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(path: &str, text: &str) -> Vec<String> {
        let tree =
            Tree::new(["README.md", "docs/here.md", "docs/own.md", "sil-host/src/lib.rs", "tests/board/NOTES.md"]);
        check(path, text, &tree).into_iter().map(|(line, message)| format!("{line}: {message}")).collect()
    }

    #[test]
    fn a_page_that_is_not_there_is_found_wherever_it_is_named() {
        for (path, text) in [
            ("sil-host/src/lib.rs", "//! See docs/gone.md."),
            ("sil-host/src/lib.rs", "const TEXT: &str = \"the columns of docs/gone.md\";"),
            ("docs/own.md", "As (docs/gone.md) says"),
            ("models/a.toml", "# docs/gone.md"),
        ] {
            assert_eq!(messages(path, text), ["1: refers to docs/gone.md, which is not there"], "{text}");
        }
        assert_eq!(messages("a.rs", "//! a\n// gone.md says"), ["2: refers to gone.md, which is not there"]);
        assert_eq!(messages("a.toml", "# sil-host/gone.rs").len(), 1);
        assert_eq!(messages("a.toml", "feature = [\"sil-host/gone\"]"), [""; 0]);
    }

    #[test]
    fn what_is_there_may_be_named_from_root_crate_and_folder() {
        for (path, text) in [
            ("sil-host/src/lib.rs", "// docs/here.md, `sil-host/src/lib.rs`, src/lib.rs; NOTES.md and (tests/board/)."),
            ("docs/own.md", "[a](here.md), [b](here.md#part), [c](../README.md), [d](https://a.org/b.md), [e](#own)"),
            (
                "docs/own.md",
                "| `sil-host/src/` | docs/*.md, docs/NAME.md, out/report.html and https://a.org/docs/gone.md |",
            ),
        ] {
            assert_eq!(messages(path, text), [""; 0], "{text}");
        }
    }

    #[test]
    fn a_link_holds_from_its_own_folder_only() {
        assert_eq!(messages("docs/own.md", "[a](docs/here.md)"), ["1: refers to docs/here.md, which is not there"]);
        assert_eq!(messages("docs/own.md", "[a](../../b)"), ["1: refers to ../../b, which is not there"]);
    }

    #[test]
    fn paths_count_in_comments_and_pages_not_in_code() {
        assert_eq!(messages("a.rs", "let path = \"tests/gone.rs\"; // not the whole line"), [""; 0]);
        assert_eq!(messages("a.rs", "/// As in `tests/gone.rs`.").len(), 1);
        assert_eq!(messages("docs/own.md", "`tests/gone.rs`").len(), 1);
    }
}
