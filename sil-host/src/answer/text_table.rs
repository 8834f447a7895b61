//! A table on a terminal: first column left, the others right, as wide as their longest cell.

use crate::prediction::ChannelErrors;

/// Rows of cells; the first row is the header.
pub struct TextTable {
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table with its header.
    pub fn new<T: Into<String>>(header: impl IntoIterator<Item = T>) -> Self {
        Self { rows: vec![header.into_iter().map(Into::into).collect()] }
    }

    /// Adds a row.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

impl std::fmt::Display for TextTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns)
            .map(|column| {
                self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
            })
            .collect();
        for row in &self.rows {
            let mut line = String::new();
            for (column, cell) in row.iter().enumerate() {
                match column {
                    0 => line.push_str(&format!("{cell:<width$}", width = widths[0])),
                    _ => line.push_str(&format!("  {cell:>width$}", width = widths[column])),
                }
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// Prediction errors of some models, a row each.
pub fn error_table(title: &str, rows: impl IntoIterator<Item = (&'static str, ChannelErrors)>) -> TextTable {
    let mut table = TextTable::new([title, "roll, deg", "pitch, deg", "p, deg/s", "q, deg/s"]);
    for (name, errors) in rows {
        let cells = [errors.roll_deg, errors.pitch_deg, errors.p_deg_s, errors.q_deg_s];
        table.row(std::iter::once(name.to_owned()).chain(cells.map(|error| number(error, 3))));
    }
    table
}

/// A number with fixed decimals, a dash where there is none.
pub fn number(value: impl Into<Option<f64>>, decimals: usize) -> String {
    match value.into() {
        Some(value) if value.is_finite() => format!("{value:.decimals$}"),
        _ => "-".into(),
    }
}
