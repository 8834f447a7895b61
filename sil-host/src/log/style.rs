//! How a table is written: what separates its fields, what marks a fraction.

use super::error::LogErrorKind;

/// How numbers and fields are written in a file.
pub(crate) struct Style {
    pub(crate) separator: char,
    /// The first mark of a fraction that was found.
    decimal: Option<char>,
}

impl Style {
    /// The separator is whichever of three the header has most of.
    pub(crate) fn of(header: &str) -> Style {
        let separators = [',', ';', '\t'];
        // the first of equals
        let most = separators.into_iter().rev().max_by_key(|separator| header.matches(*separator).count());
        Style { separator: most.unwrap_or(','), decimal: None }
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
