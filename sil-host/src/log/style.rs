//! How a table is written: what separates its fields, what marks a fraction.

use super::error::LogErrorKind;

const BLANK: char = ' ';

/// How numbers and fields are written in a file.
pub(crate) struct Style {
    separator: char,
    /// The first mark of a fraction that was found.
    decimal: Option<char>,
}

impl Style {
    /// The separator is whichever of three the header has most of; in one that has none of them, blanks are.
    pub(crate) fn of(header: &str) -> Style {
        let separators = [',', ';', '\t'];
        if !header.contains(separators) && header.trim().contains(BLANK) {
            return Style { separator: BLANK, decimal: None };
        }
        // the first of equals
        let most = separators.into_iter().rev().max_by_key(|separator| header.matches(*separator).count());
        Style { separator: most.unwrap_or(','), decimal: None }
    }

    /// The fields of a line, as they stand there. Any number of blanks is one separator.
    pub(crate) fn fields<'t>(&self, line: &'t str) -> Vec<&'t str> {
        match self.separator {
            BLANK => line.split_whitespace().collect(),
            separator => line.split(separator).collect(),
        }
    }

    /// A number, written with a point or, where commas do not separate fields, with a comma, the same in all the file.
    pub(crate) fn number(&mut self, text: &str) -> Result<f64, LogErrorKind> {
        let is_comma = self.separator != ',' && text.contains(',');
        let mark = if is_comma { Some(',') } else { text.contains('.').then_some('.') };
        if let (Some(before), Some(mark)) = (self.decimal, mark)
            && before != mark
        {
            return Err(LogErrorKind::OtherDecimalMark { before, field: text.to_owned() });
        }
        self.decimal = self.decimal.or(mark);
        let parsed = if is_comma && !text.contains('.') { text.replacen(',', ".", 1).parse() } else { text.parse() };
        parsed.map_err(|_| LogErrorKind::NotANumber(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_separate_where_nothing_else_does() {
        for (header, line, fields) in [
            ("t  gyro_x m1", "0.1   2 3", vec!["0.1", "2", "3"]),
            ("t, gyro x, m 1", "0.1, 2,,3", vec!["0.1", " 2", "", "3"]),
            ("t\tgyro x", "1\t\t2", vec!["1", "", "2"]),
            ("t", "0 1", vec!["0 1"]),
        ] {
            assert_eq!(Style::of(header).fields(line), fields, "{header}");
        }
    }
}
