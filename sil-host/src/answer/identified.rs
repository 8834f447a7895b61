//! What was identified, on the terminal.

use super::text_table::TextTable;
use crate::diagnosis::{Identification, Identified, manoeuvres_for};

/// The numbers of a vehicle, but for the twelve of single motors about single axes, which stand in the file.
pub fn table(identified: &Identification) -> String {
    let is_single =
        |name: &str| name.starts_with("motor") && ["roll", "pitch", "yaw"].iter().any(|a| name.ends_with(a));
    let shown: Vec<Identified> = identified.numbers.iter().filter(|one| !is_single(&one.name)).cloned().collect();
    table_of(&shown)
}

/// Numbers, and what to fly for those that the logs do not show.
pub fn table_of(numbers: &[Identified]) -> String {
    let mut table = TextTable::new(["identified", "value", "95 % interval"]);
    for number in numbers {
        let digits = number.own.decimals().unwrap_or(6);
        let [low, high] = number.interval();
        let unit = if number.unit.is_empty() { String::new() } else { format!(", {}", number.unit) };
        let mark = if number.to_fly.is_some() { "   not excited" } else { "" };
        table.row([
            format!("{}{unit}", number.name),
            format!("{:.digits$}", number.own.value),
            format!("{low:.digits$} to {high:.digits$}{mark}"),
        ]);
    }
    let to_fly = manoeuvres_for(numbers).into_iter();
    let more: String = to_fly.map(|to_fly| format!("to know what is not excited: {to_fly}\n")).collect();
    table.to_string() + &more
}
