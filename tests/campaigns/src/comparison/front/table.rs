//! The fronts as Markdown.

use super::Row;
use super::measured::{COLUMNS, Measured};
use crate::comparison::table::{row, rule};

/// How many of the points that dominate one are named.
const NAMED: usize = 3;

/// One side's front, the least RMS first; the balanced point is bold. `other` is what the other side is called.
pub fn front(rows: &[Row], other: &str) -> String {
    let mut shown: Vec<(&Row, &Measured)> =
        rows.iter().filter(|row| row.on_front).filter_map(|row| Some((row, row.measured.as_ref()?))).collect();
    shown.sort_by(|(_, a), (_, b)| a.rms_deg.total_cmp(&b.rms_deg));
    let parameters: Vec<&str> =
        rows.first().map_or_else(Vec::new, |row| row.parameters.iter().map(|(field, _)| *field).collect());
    let header = ["point".to_owned()]
        .into_iter()
        .chain(COLUMNS.iter().map(|column| column.name.to_owned()))
        .chain(["peak sensitivity".into(), format!("dominated by the {other}'s")])
        .chain(parameters.iter().map(|field| format!("`{field}`")));
    let mut text = row(header) + &rule(COLUMNS.len() + 2 + parameters.len());
    for (point, measured) in shown {
        let number = point.number;
        let name = if point.is_balanced { format!("**{number}**") } else { number.to_string() };
        let figures = [
            format!("{:.3}", measured.rms_deg),
            format!("{:.2}", measured.overshoot_pct),
            format!("{:.3}", measured.settling_s),
            format!("{:.2}", measured.peak_deg),
            format!("{:.4}", measured.command_deviation),
            format!("{:.1}", measured.delay_margin_ms),
            format!("{:.2}", measured.sensitivity_peak),
        ];
        let values = point.parameters.iter().map(|(_, value)| format!("{value}"));
        text += &row([name].into_iter().chain(figures).chain([beaten(&point.dominated_by)]).chain(values));
    }
    text
}

fn beaten(by: &[usize]) -> String {
    let named: Vec<String> = by.iter().take(NAMED).map(usize::to_string).collect();
    match by.len() {
        0 => "none".into(),
        count if count > NAMED => format!("{} and {} more", named.join(", "), count - NAMED),
        _ => named.join(", "),
    }
}

/// How many points of each front the other dominates.
pub fn summary(rows: &[Vec<Row>; 2]) -> String {
    let header = ["front of", "points measured", "on the front", "of these dominated by the other's"];
    let mut text = row(header.map(Into::into)) + &rule(header.len() - 1);
    for side in rows {
        let on_front: Vec<&Row> = side.iter().filter(|row| row.on_front).collect();
        let beaten = on_front.iter().filter(|row| !row.dominated_by.is_empty()).count();
        let name = side.first().map_or("", |row| row.controller);
        text += &row([name.into(), side.len().to_string(), on_front.len().to_string(), beaten.to_string()]);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row_of(number: usize, rms_deg: f64, on_front: bool) -> Row {
        let measured = Measured {
            rms_deg,
            overshoot_pct: 0.1,
            settling_s: 0.3,
            peak_deg: 0.25,
            command_deviation: 0.012,
            delay_margin_ms: 17.5,
            sensitivity_peak: 1.9,
        };
        Row {
            controller: "MPC",
            number,
            on_front,
            is_balanced: number == 2,
            dominated_by: if number == 1 { vec![3, 4, 5, 6] } else { Vec::new() },
            parameters: vec![("mpc_lead_s", 0.07)],
            measured: Some(measured),
        }
    }

    #[test]
    fn the_front_is_shown_from_the_least_rms_on() {
        let rows = [row_of(0, 8.0, false), row_of(1, 7.9, true), row_of(2, 7.7, true)];
        let text = front(&rows, "cascade");
        let lines: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(lines.len(), 2, "{text}");
        assert!(lines[0].starts_with("| **2** | 7.700 |") && lines[0].contains("| none | 0.07 |"), "{text}");
        assert!(lines[1].contains("| 3, 4, 5 and 1 more |"), "{text}");
        let columns = |line: &str| line.matches('|').count();
        assert!(text.lines().all(|line| columns(line) == columns(lines[0])), "{text}");
    }
}
