//! Every Rust file is compiled: it is the root of a target, or a `mod` names it. Where a crate lists its test programs
//! itself (`autotests = false`), cargo says nothing of a file that no program has.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Delimiter, Literal, TokenStream, TokenTree};

/// A `mod name;`: the inline modules around it, and its own name, or the path that an attribute gives.
#[derive(Debug, PartialEq)]
struct Declared {
    inside: Vec<String>,
    name: String,
    path: Option<String>,
}

/// Files that nobody compiles: `files` are all Rust files with their text, `roots` those of the targets.
pub(super) fn orphans<'a>(files: &BTreeMap<&'a str, &str>, roots: &BTreeSet<String>) -> Vec<&'a str> {
    let mut compiled = BTreeSet::new();
    let mut next: Vec<String> = roots.iter().cloned().collect();
    while let Some(path) = next.pop() {
        let Some(text) = files.get(path.as_str()) else { continue };
        if compiled.insert(path.clone()) {
            let declared = text.parse().map_or_else(|_| Vec::new(), |tokens| declared(tokens, &[]));
            next.extend(declared.iter().flat_map(|module| candidates(&path, roots.contains(&path), module)));
        }
    }
    files.keys().copied().filter(|path| !compiled.contains(*path)).collect()
}

/// Where a module's file may be.
fn candidates(from: &str, is_root: bool, module: &Declared) -> Vec<String> {
    let (folder, file) = from.rsplit_once('/').unwrap_or(("", from));
    if let Some(path) = &module.path {
        return super::references::beside(from, path).into_iter().collect();
    }
    let own = file.trim_end_matches(".rs");
    let parts = [folder].into_iter().chain((!is_root && own != "mod").then_some(own));
    let parts = parts.chain(module.inside.iter().map(String::as_str)).filter(|part| !part.is_empty());
    let stem = parts.chain([module.name.as_str()]).collect::<Vec<_>>().join("/");
    vec![format!("{stem}.rs"), format!("{stem}/mod.rs")]
}

/// All `mod name;` of a file, in macros and inline modules too.
fn declared(tokens: TokenStream, inside: &[String]) -> Vec<Declared> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut found = Vec::new();
    let mut path = None;
    for (at, token) in tokens.iter().enumerate() {
        match (token, tokens.get(at + 1), tokens.get(at + 2)) {
            (TokenTree::Ident(keyword), Some(TokenTree::Ident(name)), Some(TokenTree::Punct(end)))
                if keyword == "mod" && end.as_char() == ';' =>
            {
                found.push(Declared { inside: inside.to_vec(), name: name.to_string(), path: path.take() });
            }
            (TokenTree::Group(group), ..) if group.delimiter() == Delimiter::Bracket => {
                path = path_attribute(group.stream()).or(path);
            }
            (TokenTree::Group(group), ..) => {
                let mut inside = inside.to_vec();
                if let Some([TokenTree::Ident(keyword), TokenTree::Ident(name)]) = tokens[..at].last_chunk()
                    && keyword == "mod"
                {
                    inside.push(name.to_string());
                }
                found.extend(declared(group.stream(), &inside));
            }
            _ => {}
        }
    }
    found
}

/// The text of `path = "text"`.
fn path_attribute(attribute: TokenStream) -> Option<String> {
    let tokens: Vec<TokenTree> = attribute.into_iter().collect();
    match tokens.as_slice() {
        [TokenTree::Ident(name), TokenTree::Punct(_), TokenTree::Literal(text)] if name == "path" => unquoted(text),
        _ => None,
    }
}

fn unquoted(text: &Literal) -> Option<String> {
    Some(text.to_string().strip_prefix('"')?.strip_suffix('"')?.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&'static str, &str)], roots: &[&str]) -> Vec<&'static str> {
        let roots = roots.iter().map(|root| (*root).to_owned()).collect();
        orphans(&files.iter().copied().collect(), &roots)
    }

    #[test]
    fn a_test_file_that_no_mod_names_is_found() {
        let files = [
            ("tests/tests/main.rs", "mod flown;"),
            ("tests/tests/flown.rs", "// mod lost;"),
            ("tests/tests/lost.rs", "#[test]\nfn never_runs() {}"),
        ];
        assert_eq!(found(&files, &["tests/tests/main.rs"]), ["tests/tests/lost.rs"]);
        assert_eq!(found(&files, &["tests/tests/main.rs", "tests/tests/lost.rs"]), [""; 0]);
    }

    #[test]
    fn what_only_an_orphan_names_is_an_orphan_too() {
        let files = [("src/lib.rs", ""), ("src/a.rs", "mod b;"), ("src/a/b.rs", "mod c;"), ("src/a/b/c.rs", "")];
        assert_eq!(found(&files, &["src/lib.rs"]), ["src/a.rs", "src/a/b.rs", "src/a/b/c.rs"]);
    }

    #[test]
    fn modules_are_followed_as_the_compiler_does() {
        let files = [
            ("src/lib.rs", "pub mod a; mod b;\n#[cfg(test)]\nmod inline { mod d; }\nlisted! { mod e; }"),
            ("src/a.rs", "mod c;"),
            ("src/a/c.rs", ""),
            ("src/b/mod.rs", "mod c;"),
            ("src/b/c.rs", ""),
            ("src/c.rs", ""),
            ("src/inline/d.rs", "#[path = \"../../other/f.rs\"]\nmod named;"),
            ("src/e.rs", ""),
            ("other/f.rs", ""),
            ("other/named.rs", ""),
        ];
        assert_eq!(found(&files, &["src/lib.rs"]), ["other/named.rs", "src/c.rs"]);
    }
}
