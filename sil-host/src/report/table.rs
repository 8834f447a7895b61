//! Tables: a caption, a header, and rows whose first cell names the row.

use super::axis::with_minus_sign;
use maud::{Markup, html};

/// A table cell.
#[derive(Clone, Debug)]
pub struct Cell {
    text: String,
    is_number: bool,
    is_better: bool,
    section: Option<usize>,
}

impl Cell {
    /// A text that leads to a section of the page, counted from 1.
    pub fn to_section(text: impl Into<String>, number: usize) -> Self {
        Self { section: Some(number), ..Self::from(text) }
    }

    /// A number with this many decimals; a NaN or infinite one stands for "no value".
    pub fn number(value: f64, decimals: usize) -> Self {
        let text = if value.is_finite() { with_minus_sign(&format!("{value:.decimals$}")) } else { String::new() };
        Self { text, is_number: true, is_better: false, section: None }
    }

    /// Highlights the cell as the better one of its row.
    pub fn better(self) -> Self {
        Self { is_better: true, ..self }
    }

    fn content(&self) -> Markup {
        html! {
            @if self.is_number && self.text.is_empty() {
                span aria-hidden="true" { "–" } span.spoken { "no value" }
            } @else if self.is_better {
                strong { (self.text) } span.spoken { " (better)" }
            } @else if let Some(number) = self.section {
                a href=(format!("#section-{number}")) { (self.text) }
            } @else {
                (self.text)
            }
        }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), is_number: false, is_better: false, section: None }
    }
}

/// Which of several numbers is the better one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// Errors, times, effort.
    Lower,
    /// Margins, speed.
    Higher,
}

/// A table with a caption. Columns whose cells are all numbers are aligned at the right.
#[derive(Clone, Debug)]
pub struct Table {
    caption: String,
    header: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows; `header` names the columns, units included ("RMS error, deg").
    pub fn new(caption: impl Into<String>, header: &[&str]) -> Self {
        Self { caption: caption.into(), header: header.iter().map(|&name| name.to_owned()).collect(), rows: Vec::new() }
    }

    /// Adds a row; its first cell names it. Cells missing at the end stay empty.
    pub fn row(mut self, cells: impl IntoIterator<Item = Cell>) -> Self {
        self.rows.push(cells.into_iter().collect());
        self
    }

    /// Adds a row of numbers with this many decimals and highlights the best; NaN stands for "no value". Numbers that
    /// look alike when printed cannot be separated.
    pub fn comparison(self, name: impl Into<String>, values: &[f64], decimals: usize, better: Better) -> Self {
        let mut cells: Vec<Cell> = values.iter().map(|&value| Cell::number(value, decimals)).collect();
        if let Some(best) = best_index(values, better) {
            let is_tied = cells.iter().filter(|cell| cell.text == cells[best].text).count() > 1;
            let is_alone = values.iter().filter(|value| value.is_finite()).count() == 1;
            cells[best].is_better = !is_tied && !is_alone;
        }
        self.row(std::iter::once(Cell::from(name)).chain(cells))
    }

    pub(super) fn render(&self) -> Markup {
        let columns = self.rows.iter().map(Vec::len).chain([self.header.len()]).max().unwrap_or(0);
        let is_numeric = |column: usize| {
            let mut cells = self.rows.iter().filter_map(|row| row.get(column)).peekable();
            cells.peek().is_some() && cells.all(|cell| cell.is_number)
        };
        let alignment: Vec<&str> =
            (0..columns).map(|column| if is_numeric(column) { "number" } else { "text" }).collect();
        html! {
            figure.group {
                // Outside of the table, so that it keeps the page's width when a wide table is scrolled.
                figcaption { strong { (self.caption) } }
                // Focusable, so that it can be scrolled with the keyboard.
                div.scroll role="region" tabindex="0" aria-label=(self.caption) {
                    table.stacked[columns > COLUMNS_ON_A_PHONE] aria-label=(self.caption) {
                        thead { tr {
                            @for (column, &class) in alignment.iter().enumerate() {
                                th scope="col" class=(class) { (self.header.get(column).map_or("", String::as_str)) }
                            }
                        } }
                        tbody {
                            @for row in &self.rows { tr {
                                @for (column, &class) in alignment.iter().enumerate() {
                                    (render_cell(row.get(column), self.header.get(column), column == 0, class))
                                }
                            } }
                        }
                    }
                }
            }
        }
    }
}

/// A table of more columns becomes a block per row on a narrow screen, each cell beside the name of its column.
const COLUMNS_ON_A_PHONE: usize = 3;

fn render_cell(cell: Option<&Cell>, column: Option<&String>, names_row: bool, alignment: &str) -> Markup {
    let content = cell.map(Cell::content).unwrap_or_default();
    let class =
        if cell.is_some_and(|cell| cell.is_better) { format!("{alignment} better") } else { alignment.to_owned() };
    html! {
        @if names_row {
            th scope="row" class=(class) { (content) }
        } @else {
            td class=(class) data-column=(column.map_or("", String::as_str)) { (content) }
        }
    }
}

fn best_index(values: &[f64], better: Better) -> Option<usize> {
    let finite = values.iter().enumerate().filter(|(_, value)| value.is_finite());
    let best = match better {
        Better::Lower => finite.min_by(|a, b| a.1.total_cmp(b.1)),
        Better::Higher => finite.max_by(|a, b| a.1.total_cmp(b.1)),
    };
    best.map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The indices of the highlighted cells of a row.
    fn highlighted(values: &[f64], better: Better) -> Vec<usize> {
        let table = Table::new("", &[]).comparison("row", values, 2, better);
        (0..values.len()).filter(|&index| table.rows[0][index + 1].is_better).collect()
    }

    #[test]
    fn the_better_value_is_highlighted() {
        assert_eq!(highlighted(&[2.26, 1.84], Better::Lower), [1]);
        assert_eq!(highlighted(&[2.26, 1.84, 0.5], Better::Higher), [0]);
        assert_eq!(highlighted(&[f64::NAN, 2.0, 1.0], Better::Lower), [2]);
    }

    #[test]
    fn nothing_is_highlighted_where_no_difference_shows() {
        assert_eq!(highlighted(&[1.001, 1.002], Better::Lower), [] as [usize; 0], "equal as printed");
        assert_eq!(highlighted(&[1.0, f64::NAN], Better::Lower), [] as [usize; 0], "nothing to compare with");
        assert_eq!(highlighted(&[f64::NAN, f64::INFINITY], Better::Lower), [] as [usize; 0]);
        assert_eq!(highlighted(&[], Better::Higher), [] as [usize; 0]);
    }

    #[test]
    fn numbers_are_aligned_and_rows_are_named() {
        let html = Table::new("T", &["axis", "error", "note"])
            .row([Cell::from("roll"), Cell::number(-0.001, 2), "fair".into()])
            .row(["pitch".into(), Cell::number(-8.08, 2).better()])
            .render()
            .into_string();
        assert!(html.contains(r#"<th scope="col" class="number">error</th>"#), "{html}");
        assert!(html.contains(r#"<th scope="row" class="text">pitch</th>"#), "{html}");
        assert!(html.contains(r#"<td class="number" data-column="error">0.00</td>"#), "{html}");
        assert!(html.contains(r#"<td class="number better" data-column="error"><strong>−8.08</strong>"#), "{html}");
        assert!(html.contains(r#"<td class="text" data-column="note"></td>"#), "a missing cell stays empty: {html}");
    }
}
