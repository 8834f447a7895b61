//! A CSV whose columns mean nothing yet, for whoever drafts a map of it.

use super::super::error::{LogError, LogErrorKind};
use super::super::messages::Table;
use super::super::style::Style;
use super::error_in;
use super::lines::{Lines, are_names, unquoted};

/// Every column of numbers under its own name, a field that is no number as NaN; and the names of the columns that have
/// fields which are neither numbers nor blank.
///
/// # Errors
/// There is no line.
pub(in crate::log) fn table(file: &str, text: &str) -> Result<(Table, Vec<String>), LogError> {
    let mut lines = Lines::of(text).into_iter().flat_map(Lines::numbered).map(|(_, line)| line);
    let header = lines.find(|line| !line.starts_with('#') && !line.is_empty());
    let header = header.ok_or_else(|| error_in(file, None, None, LogErrorKind::Empty))?;
    let mut style = Style::of(header);
    let names: Vec<String> = style.fields(header).into_iter().map(|name| unquoted(name).to_owned()).collect();
    if !are_names(names.iter().map(String::as_str)) {
        return Err(error_in(file, None, None, LogErrorKind::NoNames));
    }
    let mut has_words = vec![false; names.len()];
    let mut table = Table::with_fields(names.iter().cloned());
    for line in lines.filter(|line| !line.is_empty()) {
        let fields = style.fields(line).into_iter().map(unquoted).enumerate();
        let numbers: Vec<f64> = fields
            .map(|(place, field)| {
                let number = style.number(field);
                let is_there = number.as_ref().is_ok_and(|number| number.is_finite());
                if let (false, false, Some(has_words)) = (is_there, field.is_empty(), has_words.get_mut(place)) {
                    *has_words = true;
                }
                number.unwrap_or(f64::NAN)
            })
            .collect();
        table.push(numbers);
    }
    let with_words = names.into_iter().zip(has_words).filter(|(_, has_words)| *has_words).map(|(name, _)| name);
    Ok((table, with_words.collect()))
}
