//! Rules for lines: their width, and words that docs/style.md wants said in the field's words.

/// Columns, of code and of comments.
const WIDTH_MAX: usize = 120;

/// Phrases of earlier pages that readers stumbled over.
const RIDDLES: [&str; 5] = ["at home", "left over", "speaks about", "speak about", "told apart"];

/// Line, from 1, and what is wrong there.
type Breach = (usize, String);

/// Lines that are too long. A row of a Markdown table can't be wrapped, nor can an address.
pub(super) fn long_lines(path: &str, text: &str) -> Vec<Breach> {
    if !(path.ends_with(".rs") || path.ends_with(".md") || path.ends_with(".toml")) {
        return Vec::new();
    }
    let is_table_row = |line: &str| path.ends_with(".md") && line.starts_with('|');
    let lines = (1..).zip(text.lines()).filter(|(_, line)| !is_table_row(line) && !line.contains("://"));
    let widths = lines.map(|(number, line)| (number, line.chars().count()));
    let long = widths.filter(|(_, width)| *width > WIDTH_MAX);
    long.map(|(number, width)| (number, format!("{width} columns; at most {WIDTH_MAX}"))).collect()
}

/// Phrases on pages that do not say what they mean.
pub(super) fn riddles(path: &str, text: &str) -> Vec<Breach> {
    let names_them = path == "docs/style.md";
    if !path.ends_with(".md") || names_them {
        return Vec::new();
    }
    let lines = (1..).zip(text.lines());
    let found = lines.flat_map(|(number, line)| {
        let in_line = RIDDLES.into_iter().filter(move |phrase| line.contains(phrase));
        in_line.map(move |phrase| (number, format!("\"{phrase}\": say it in the field's words (docs/style.md)")))
    });
    found.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_may_fill_the_width_and_no_more() {
        let full = "é".repeat(WIDTH_MAX);
        for path in ["a.rs", "a.md", "a.toml"] {
            assert_eq!(long_lines(path, &format!("{full}\n")), []);
            assert_eq!(long_lines(path, &format!("\n{full}é\n")), [(2, "121 columns; at most 120".to_owned())]);
        }
        assert_eq!(long_lines("a.csv", &format!("{full}é\n")), []);
    }

    #[test]
    fn what_cannot_be_wrapped_may_be_longer() {
        let row = format!("| {} |", "a ".repeat(WIDTH_MAX));
        assert_eq!(long_lines("a.md", &row), []);
        assert_eq!(long_lines("a.rs", &row).len(), 1);
        assert_eq!(long_lines("a.rs", &format!("// https://a.org/{}", "a".repeat(WIDTH_MAX))), []);
    }

    #[test]
    fn riddles_are_found_on_pages() {
        assert_eq!(riddles("docs/a.md", "what is left over").len(), 1);
        assert_eq!(riddles("docs/a.md", "what remains"), []);
        assert_eq!(riddles("a.rs", "// what is left over"), []);
    }
}
