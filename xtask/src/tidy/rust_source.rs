//! Rules for Rust source, checked on its tokens: comments and strings do not count, and no layout fools it.

use std::ops::RangeInclusive;

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

const FILE_LINES_MAX: usize = 400;
const FUNCTION_LINES_MAX: usize = 70;

/// Line, from 1, and what is wrong there.
type Breach = (usize, String);

/// Checks one file; `path` decides which rules hold for it.
pub(super) fn check(path: &str, text: &str) -> Vec<Breach> {
    let tokens = match text.parse::<TokenStream>() {
        Ok(tokens) => tokens,
        Err(error) => return vec![(error.span().start().line, format!("not Rust: {error}"))],
    };
    let is_test = path.split('/').any(|part| part == "tests") || path.ends_with("tests.rs");
    let in_core = path.starts_with("shared-control/src/");
    let mut scan = Scan {
        no_f64: in_core,
        no_unwrap: in_core || path.starts_with("firmware/src/"),
        test_lines: 0,
        breaches: Vec::new(),
    };
    scan.stream(tokens, is_test);
    if !is_test && !text.starts_with("//!") {
        scan.breaches.push((1, "expected a first line that says what the file is for (//!)".into()));
    }
    let lines = text.lines().count() - scan.test_lines;
    if !is_test && lines > FILE_LINES_MAX {
        scan.breaches.push((FILE_LINES_MAX, format!("{lines} lines without tests; at most {FILE_LINES_MAX}")));
    }
    scan.breaches
}

struct Scan {
    no_f64: bool,
    no_unwrap: bool,
    test_lines: usize,
    breaches: Vec<Breach>,
}

impl Scan {
    fn stream(&mut self, stream: TokenStream, in_test: bool) {
        let tokens = stream.into_iter().collect::<Vec<_>>();
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            let rest = &tokens[at..];
            if !in_test && is_test_attribute(rest) {
                let item = &rest[..item_length(rest)];
                self.test_lines += lines(item).count();
                self.stream(item.iter().cloned().collect(), true);
                at += item.len();
                continue;
            }
            self.function_length(rest);
            if !in_test {
                self.forbidden(rest);
            }
            if let TokenTree::Group(group) = token {
                self.stream(group.stream(), in_test);
            }
            at += 1;
        }
    }

    /// `fn name ... { body }`; a pointer `fn(...)` has no name, a declaration no body.
    fn function_length(&mut self, tokens: &[TokenTree]) {
        let [TokenTree::Ident(keyword), TokenTree::Ident(name), ..] = tokens else {
            return;
        };
        if keyword != "fn" {
            return;
        }
        let lines = lines(&tokens[..item_length(tokens)]);
        let count = lines.clone().count();
        if count > FUNCTION_LINES_MAX {
            let message = format!("fn {name} has {count} lines; at most {FUNCTION_LINES_MAX}");
            self.breaches.push((*lines.start(), message));
        }
    }

    fn forbidden(&mut self, tokens: &[TokenTree]) {
        let line = tokens[0].span().start().line;
        let is_f64 = match &tokens[0] {
            TokenTree::Ident(name) => name == "f64",
            TokenTree::Literal(number) => number.to_string().ends_with("f64"),
            _ => false,
        };
        if self.no_f64 && is_f64 {
            self.breaches.push((line, "f64: the control core computes in f32 alone".into()));
        }
        if let [TokenTree::Punct(dot), TokenTree::Ident(method), ..] = tokens
            && self.no_unwrap
            && dot.as_char() == '.'
            && method == "unwrap"
        {
            self.breaches.push((line, "unwrap(): what flies does not panic".into()));
        }
    }
}

/// `#[cfg(test)]` or `#[test]`.
fn is_test_attribute(tokens: &[TokenTree]) -> bool {
    let [TokenTree::Punct(hash), TokenTree::Group(attribute), ..] = tokens else {
        return false;
    };
    let text = attribute.stream().to_string().replace(' ', "");
    hash.as_char() == '#' && (text == "cfg(test)" || text == "test")
}

/// Tokens up to the end of the item: its first block in braces, or the semicolon before any.
fn item_length(tokens: &[TokenTree]) -> usize {
    let ends = |token: &TokenTree| match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        TokenTree::Punct(punct) => punct.as_char() == ';',
        _ => false,
    };
    tokens.iter().position(ends).map_or(tokens.len(), |last| last + 1)
}

/// First to last line that the tokens are on.
fn lines(tokens: &[TokenTree]) -> RangeInclusive<usize> {
    let first = tokens.first().map_or(1, |token| token.span().start().line);
    let last = tokens.last().map_or(0, |token| match token {
        TokenTree::Group(group) => Group::span_close(group).end().line,
        other => other.span().end().line,
    });
    first..=last
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Breaches of a file that says what it is for, lines counted from the one after that.
    fn breaches(path: &str, text: &str) -> Vec<Breach> {
        let found = check(path, &format!("//! For tests.\n{text}"));
        found.into_iter().map(|(line, message)| (line - 1, message)).collect()
    }

    fn function_of(lines: usize) -> String {
        format!("fn long() {{\n{}}}\n", "    step();\n".repeat(lines - 2))
    }

    #[test]
    fn a_function_may_fill_a_screen_and_no_more() {
        assert_eq!(breaches("a.rs", &function_of(FUNCTION_LINES_MAX)), []);
        let breaches = breaches("a.rs", &format!("\n{}", function_of(FUNCTION_LINES_MAX + 1)));
        assert_eq!(breaches.len(), 1);
        assert_eq!(breaches[0].0, 2);
        assert!(breaches[0].1.contains("fn long has 71 lines"), "{breaches:?}");
    }

    #[test]
    fn functions_inside_modules_and_tests_are_measured_too() {
        let text = format!("#[cfg(test)]\nmod tests {{\n{}}}\n", function_of(FUNCTION_LINES_MAX + 1));
        assert_eq!(breaches("a.rs", &text).len(), 1);
    }

    #[test]
    fn tests_do_not_count_towards_the_length_of_a_file() {
        let code = format!("//! For tests.\n{}", "const A: f32 = 1.0;\n".repeat(FILE_LINES_MAX - 1));
        let tests = "#[cfg(test)]\nmod tests {\n    const B: f32 = 1.0;\n}\n";
        assert_eq!(check("a.rs", &format!("{code}{tests}")), []);
        assert_eq!(check("a.rs", &format!("{code}\n{tests}")).len(), 1);
        assert_eq!(check("a/tests.rs", &format!("{code}\n{tests}")), []);
    }

    #[test]
    fn the_core_holds_no_f64_outside_comments_strings_and_tests() {
        let text = "// f64\nconst TEXT: &str = \"f64\";\n#[cfg(test)]\nmod tests {\n    type A = f64;\n}\n";
        assert_eq!(breaches("shared-control/src/a.rs", text), []);
        for text in ["type A = f64;", "const A: f32 = 1.0_f64 as f32;", "m!(x as f64);", "fn a() { f64::from(1) }"] {
            assert_eq!(breaches("shared-control/src/a.rs", text).len(), 1, "{text}");
            assert_eq!(breaches("sil-host/src/a.rs", text), [], "{text}");
        }
    }

    #[test]
    fn what_flies_does_not_unwrap() {
        for path in ["shared-control/src/a.rs", "firmware/src/a.rs"] {
            assert_eq!(breaches(path, "fn a() {\n    b().unwrap()\n}").len(), 1);
            assert_eq!(breaches(path, "fn a() {\n    b().unwrap_or(1)\n}"), []);
            assert_eq!(breaches(path, "#[test]\nfn a() {\n    b().unwrap()\n}"), []);
        }
    }

    #[test]
    fn a_file_says_what_it_is_for() {
        assert_eq!(check("a.rs", "//! Waits.\nfn wait() {}\n"), []);
        assert_eq!(check("a.rs", "fn wait() {}\n").len(), 1);
        assert_eq!(check("a/tests.rs", "fn wait() {}\n"), []);
    }

    #[test]
    fn what_cannot_be_read_is_a_breach() {
        assert_eq!(breaches("a.rs", "fn a() {\n}}\n").len(), 1);
    }
}
