//! Rows in a run: what holds from each to the next.

use std::ops::Range;

/// All rows in runs, each as long as every row but its first goes on from the row before it.
pub(super) fn runs(rows: usize, goes_on: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut from = 0;
    for row in 1..=rows {
        if row == rows || !goes_on(row) {
            runs.push(from..row);
            from = row;
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_in_one_run() {
        let kinds = [1, 1, 2, 1, 1, 1];
        assert_eq!(runs(kinds.len(), |row| kinds[row] == kinds[row - 1]), [0..2, 2..3, 3..6]);
        assert_eq!(runs(2, |_| false), [0..1, 1..2]);
        assert_eq!(runs(0, |_| true), []);
    }
}
