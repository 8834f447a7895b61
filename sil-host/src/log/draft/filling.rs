//! How much of a column is there: logs that were merged from several rates have blank fields, and tables of another
//! length may stand beside the first.

use crate::log::messages::Table;

/// A column of words has fewer numbers than this share of the rows.
const NUMBERS_MIN: f64 = 0.5;
/// A table that ends before this share of the rows is another one.
const ENDS_BEFORE: f64 = 0.95;
/// From fewer numbers nothing follows.
const READINGS_MIN: usize = 2;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Filling {
    /// A number in each row, or in all but a few.
    Whole,
    /// Numbers in so many rows, and none in those between.
    Sparse(usize),
    /// Numbers in so many rows from the first on, and none behind them: rows of another table, whose times are not the
    /// first one's.
    EndsEarly(usize),
    /// Words, or hardly anything.
    Else,
}

impl Filling {
    /// Of a column; `has_words` where a field of it is neither a number nor blank.
    pub(super) fn of(table: &Table, name: &str, has_words: bool) -> Filling {
        let values = table.column(name).unwrap_or_default();
        let (rows, there) = (values.len() as f64, values.iter().filter(|value| value.is_finite()).count());
        if there == values.len() || has_words && there as f64 >= NUMBERS_MIN * rows {
            return Filling::Whole;
        }
        if has_words || there < READINGS_MIN {
            return Filling::Else;
        }
        let is_first_rows = values.iter().take(there).all(|value| value.is_finite());
        if is_first_rows && (there as f64) < ENDS_BEFORE * rows {
            return Filling::EndsEarly(there);
        }
        if is_first_rows { Filling::Whole } else { Filling::Sparse(there) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filling(numbers: &str, has_words: bool) -> Filling {
        let mut table = Table::with_fields(["a".to_owned()]);
        numbers.chars().for_each(|c| table.push([if c == '1' { 1.0 } else { f64::NAN }]));
        Filling::of(&table, "a", has_words)
    }

    #[test]
    fn blanks_between_numbers_are_a_slower_rate_and_blanks_behind_them_another_table() {
        assert_eq!(filling("1111111111", false), Filling::Whole);
        assert_eq!(filling("1 1 1 1 1 ", false), Filling::Sparse(5));
        assert_eq!(filling("  1    1  ", false), Filling::Sparse(2));
        assert_eq!(filling("11111     ", false), Filling::EndsEarly(5));
        assert_eq!(filling(&("1".repeat(99) + " "), false), Filling::Whole);
        assert_eq!(filling("     1    ", false), Filling::Else);
        assert_eq!(filling("1 1 1     ", true), Filling::Else);
    }
}
