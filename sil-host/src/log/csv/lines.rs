//! The lines of a CSV's text, whatever ends them, and the fields' quotation marks.

/// A text in lines.
#[derive(Clone, Copy)]
pub(super) struct Lines<'t> {
    whole: &'t str,
    line_end: char,
    /// The number of the last line if it has no end and may be cut off; it is none of the lines.
    pub(super) cut: Option<usize>,
}

impl<'t> Lines<'t> {
    /// Of a text, without its byte order mark; none of a blank one. A single line may lack its end.
    pub(super) fn of(text: &'t str) -> Option<Lines<'t>> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        // without any line feed, carriage returns end lines
        let line_end = if text.contains('\n') { '\n' } else { '\r' };
        let (whole, cut) = match text.rfind(line_end) {
            Some(last) if !text[last + 1..].trim().is_empty() => {
                let whole = &text[..=last];
                (whole, Some(1 + whole.matches(line_end).count()))
            }
            _ => (text, None),
        };
        (!text.trim().is_empty()).then_some(Lines { whole, line_end, cut })
    }

    /// The lines with their numbers, from 1.
    pub(super) fn numbered(self) -> impl Iterator<Item = (usize, &'t str)> + Clone {
        (1..).zip(self.whole.split_terminator(self.line_end).map(|line| line.trim_matches([' ', '\r'])))
    }
}

/// A field without the blanks and quotation marks around it.
pub(super) fn unquoted(field: &str) -> &str {
    let field = field.trim();
    let inner = field.strip_prefix('"').and_then(|f| f.strip_suffix('"'));
    inner.unwrap_or(field)
}

/// Whether a header's fields are names: most of those of a table without a header are numbers.
pub(super) fn are_names<'n>(fields: impl Iterator<Item = &'n str>) -> bool {
    let (numbers, all) =
        fields.fold((0, 0), |(numbers, all), field| (numbers + usize::from(field.parse::<f64>().is_ok()), all + 1));
    2 * numbers <= all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_line_end_is_one_and_a_line_without_it_is_none() {
        for (text, lines, cut) in [
            ("a\nb\n", vec![(1, "a"), (2, "b")], None),
            ("\u{feff}a\r\nb\r\n\r\n", vec![(1, "a"), (2, "b"), (3, "")], None),
            ("a\rb\rc", vec![(1, "a"), (2, "b")], Some(3)),
            ("a\n\nb", vec![(1, "a"), (2, "")], Some(3)),
            ("a", vec![(1, "a")], None),
        ] {
            let of_text = Lines::of(text).unwrap();
            assert_eq!((of_text.numbered().collect::<Vec<_>>(), of_text.cut), (lines, cut), "{text:?}");
        }
        assert!(Lines::of("\u{feff} \n\n").is_none() && Lines::of("").is_none());
    }

    #[test]
    fn quotation_marks_stand_around_a_field_or_not_at_all() {
        assert_eq!([" a ", "\"a b\"", " \"\" ", "\"a"].map(unquoted), ["a", "a b", "", "\"a"]);
    }
}
