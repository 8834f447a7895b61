//! A bench's CSV: columns that name their units, each field checked, each mistake with its line.

use std::collections::BTreeMap;
use std::path::Path;

use super::arrival::sampled;
use super::reading::{CLOCK, NAMES, Reading};
use crate::log::{Style, text_of};

/// Rows that a bench has at least.
const ROWS_MIN: usize = 3;
const SECONDS_A_DAY: f64 = 86_400.0;

/// Readings of a bench, rows in the order of the file; a blank field is NaN.
#[derive(Clone, Debug, Default)]
pub struct Bench {
    /// The file, without its folder.
    pub name: String,
    /// Columns of one length, SI units.
    pub columns: BTreeMap<Reading, Vec<f64>>,
    /// What was left out or assumed.
    pub notes: Vec<String>,
}

/// Why a bench's file can't be used.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// It can't be read as text.
    #[error("{0}")]
    Unreadable(String),
    /// A line is wrong.
    #[error("{file}:{line}: {problem}")]
    Line {
        /// The file as it was given.
        file: String,
        /// Counted from 1.
        line: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// The file as a whole.
    #[error("{file}: {problem}")]
    Whole {
        /// The file as it was given.
        file: String,
        /// What is wrong, and what was expected.
        problem: String,
    },
}

/// What is done with a column.
enum Use {
    Read { reading: Reading, factor: f64 },
    Clock,
    Leave,
}

impl Bench {
    /// Reads a file, compressed by gzip or not.
    ///
    /// # Errors
    /// It can't be read, has no column that a refinement uses, or a field that is no number or lies out of range.
    pub fn load(path: &Path) -> Result<Self, BenchError> {
        let text = text_of(path).map_err(|error| BenchError::Unreadable(error.to_string()))?;
        let bench = Self::parse(&text, &path.display().to_string())?;
        let name = path.file_name().map_or(bench.name, |name| name.to_string_lossy().into_owned());
        Ok(Self { name, ..bench })
    }

    /// Reads text; `file` is for messages.
    ///
    /// # Errors
    /// As [`Bench::load`].
    pub fn parse(text: &str, file: &str) -> Result<Self, BenchError> {
        let at = |line, problem| BenchError::Line { file: file.to_owned(), line, problem };
        let whole = |problem| BenchError::Whole { file: file.to_owned(), problem };
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let lines = (1..).zip(text.lines()).map(|(number, line)| (number, line.trim_matches([' ', '\r'])));
        let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let Some((header_line, header)) = lines.next() else {
            return Err(whole("is empty: expected a header that names the columns, then rows of numbers".to_owned()));
        };
        let mut style = Style::of(header);
        let names: Vec<&str> = style.fields(header).into_iter().map(|name| name.trim_matches([' ', '"'])).collect();
        let uses = uses_of(&names).map_err(|problem| at(header_line, problem))?;
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
        for (line, text) in lines {
            let fields: Vec<&str> =
                style.fields(text).into_iter().map(|field| field.trim_matches([' ', '"'])).collect();
            if fields.len() != names.len() {
                let problem = format!("has {} fields, the header {}: is the line cut off?", fields.len(), names.len());
                return Err(at(line, problem));
            }
            for (index, (field, what)) in fields.iter().zip(&uses).enumerate() {
                let value = value_of(field, what, &mut style)
                    .map_err(|problem| at(line, format!("column `{}`: {problem}", names[index])))?;
                columns[index].push(value);
            }
        }
        let rows = columns.first().map_or(0, Vec::len);
        if rows < ROWS_MIN {
            return Err(whole(format!("has {rows} rows: expected at least {ROWS_MIN}")));
        }
        Self::of_columns(file, &names, uses, columns).map_err(whole)
    }

    fn of_columns(file: &str, names: &[&str], uses: Vec<Use>, values: Vec<Vec<f64>>) -> Result<Self, String> {
        let mut bench = Self { name: file.to_owned(), ..Self::default() };
        let is_left = |what: &Use| matches!(what, Use::Leave);
        let pairs = names.iter().zip(&uses).filter(|(name, what)| is_left(what) && !name.is_empty());
        let left_out: Vec<&str> = pairs.map(|(name, _)| *name).collect();
        if !left_out.is_empty() {
            bench.notes.push(format!("columns not used: {}", left_out.join(", ")));
        }
        for (what, column) in uses.into_iter().zip(values) {
            match what {
                Use::Read { reading, .. } => {
                    // a column that is there and blank throughout was not measured
                    if column.iter().any(|value| !value.is_nan()) {
                        bench.columns.insert(reading, column);
                    }
                }
                Use::Clock => {
                    let (time_s, note) = sampled(&column)?;
                    bench.notes.extend(note);
                    bench.columns.insert(Reading::Time, time_s);
                }
                Use::Leave => {}
            }
        }
        bench.add_current();
        if bench.columns.is_empty() {
            return Err("no column has a value in any row".to_owned());
        }
        Ok(bench)
    }

    /// A switching speed controller passes power on: what it takes from the supply is in the winding.
    fn add_current(&mut self) {
        if self.has(Reading::Current) {
            return;
        }
        let column = |reading| self.columns.get(&reading);
        let (supply_v, supply_a, motor_v) = (Reading::BatteryVoltage, Reading::BatteryCurrent, Reading::MotorVoltage);
        let (Some(supply_v), Some(supply_a), Some(motor_v)) = (column(supply_v), column(supply_a), column(motor_v))
        else {
            return;
        };
        let through = |((volt, ampere), across): ((&f64, &f64), &f64)| {
            if *across > 0.0 { volt * ampere / across } else { f64::NAN }
        };
        let current = supply_v.iter().zip(supply_a).zip(motor_v).map(through).collect();
        self.columns.insert(Reading::Current, current);
        self.notes.push("current of the winding from that of the supply: equal power on both sides".to_owned());
    }

    /// Whether a quantity was measured.
    pub fn has(&self, reading: Reading) -> bool {
        self.columns.contains_key(&reading)
    }

    /// A column, or NaN throughout.
    pub(super) fn column(&self, reading: Reading) -> Vec<f64> {
        self.columns.get(&reading).cloned().unwrap_or_else(|| vec![f64::NAN; self.rows()])
    }

    /// How many rows it has.
    pub fn rows(&self) -> usize {
        self.columns.values().next().map_or(0, Vec::len)
    }
}

/// What each column of the header is for; a wrong unit in a name is no unknown column but a mistake.
fn uses_of(names: &[&str]) -> Result<Vec<Use>, String> {
    let mut seen: Vec<Reading> = Vec::new();
    let mut uses = Vec::new();
    for name in names {
        let known = NAMES.iter().find(|known| known.text == *name);
        let reading = if *name == CLOCK { Some(Reading::Time) } else { known.map(|known| known.reading) };
        if let Some(reading) = reading {
            if seen.contains(&reading) {
                return Err(format!("column `{name}`: {} is there twice", reading.column()));
            }
            seen.push(reading);
        }
        uses.push(match known {
            Some(known) => Use::Read { reading: known.reading, factor: known.factor },
            None if *name == CLOCK => Use::Clock,
            None => match own_names().find(|own| is_other_unit(own, name)) {
                Some(own) => return Err(format!("column `{name}`: unknown unit; did you mean `{own}`?")),
                None => Use::Leave,
            },
        });
    }
    if seen.is_empty() {
        let own: Vec<&str> = own_names().collect();
        return Err(format!("no column that a refinement uses: expected some of {}", own.join(", ")));
    }
    Ok(uses)
}

fn own_names() -> impl Iterator<Item = &'static str> {
    NAMES.iter().map(|name| name.text).filter(|text| text.chars().all(|c| c.is_ascii_lowercase() || c == '_'))
}

/// `lift_kg` beside `lift_n`: the same first word, another unit.
fn is_other_unit(own: &str, name: &str) -> bool {
    let word = |text: &str| text.split('_').next().unwrap_or_default().to_owned();
    own.contains('_') && name.contains('_') && word(own) == word(name)
}

fn value_of(field: &str, what: &Use, style: &mut Style) -> Result<f64, String> {
    match what {
        Use::Leave => Ok(f64::NAN),
        Use::Clock => clock_s(field).ok_or_else(|| format!("\"{field}\": expected a date and a time of day")),
        Use::Read { .. } if field.is_empty() => Ok(f64::NAN),
        Use::Read { reading, factor } => {
            let number = style.number(field).map_err(|_| format!("\"{field}\" is not a number"))? * factor;
            let [low, high] = reading.range();
            if (low..=high).contains(&number) {
                return Ok(number);
            }
            let (column, factor) = (reading.column(), 1.0 / factor);
            let of_column = if factor == 1.0 { String::new() } else { format!(", {field} in the column's unit") };
            Err(format!("{number:?} as `{column}`{of_column}: expected {low} to {high}"))
        }
    }
}

/// Seconds since midnight.
fn clock_s(field: &str) -> Option<f64> {
    let time = field.rsplit([' ', 'T']).next()?;
    let mut parts = time.splitn(3, ':');
    let hours: f64 = parts.next()?.parse().ok()?;
    let minutes: f64 = parts.next()?.parse().ok()?;
    let seconds: f64 = parts.next()?.replacen(':', ".", 1).parse().ok()?;
    let is_time = (0.0..24.0).contains(&hours) && (0.0..60.0).contains(&minutes) && (0.0..61.0).contains(&seconds);
    is_time.then_some((hours * 3600.0 + minutes * 60.0 + seconds) % SECONDS_A_DAY)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        Bench::parse(text, "bench.csv").map(|bench| format!("{bench:?}")).unwrap_err().to_string()
    }

    #[test]
    fn columns_are_brought_to_si_units() {
        let text = "# a stand\nspeed_rpm,lift_gf,command_pct,remark\n600,100,10,\n1200,,20,x\n1800,900,30,\n";
        let bench = Bench::parse(text, "bench.csv").unwrap();
        let speed = &bench.columns[&Reading::Speed];
        assert!((speed[0] - 62.831_853).abs() < 1e-6 && (speed[2] - 188.495_559).abs() < 1e-6);
        assert!((bench.columns[&Reading::Lift][0] - 0.980_665).abs() < 1e-12);
        assert!(bench.columns[&Reading::Lift][1].is_nan());
        assert_eq!(bench.columns[&Reading::Command], [0.1, 0.2, 0.3]);
        assert_eq!(bench.notes, ["columns not used: remark"]);
    }

    #[test]
    fn mistakes_have_their_line() {
        for (text, expected) in [
            ("", "bench.csv: is empty"),
            ("a,b\n1,2\n", "bench.csv:1: no column that a refinement uses"),
            ("speed_rad_s,lift_kg\n1,2\n", "bench.csv:1: column `lift_kg`: unknown unit; did you mean `lift_n`"),
            ("speed_rad_s,speed_rpm\n1,2\n", "bench.csv:1: column `speed_rpm`: speed_rad_s is there twice"),
            ("speed_rad_s,lift_n\n1,2\n2,x\n", "bench.csv:3: column `lift_n`: \"x\" is not a number"),
            ("speed_rad_s,lift_n\n1,2\n2\n", "bench.csv:3: has 1 fields, the header 2"),
            ("command,motor_v\n0.1,2\n20,3\n", "bench.csv:3: column `command`: 20.0 as `command`: expected 0 to 1"),
            ("speed_rad_s,lift_n\n1,2\n", "bench.csv: has 1 rows"),
            ("Timestamp,RPM\nnoon,1\n", "bench.csv:2: column `Timestamp`: \"noon\""),
            ("lift_n,torque_nm\n,\n,\n,\n", "bench.csv: no column has a value"),
        ] {
            let message = refused(text);
            assert!(message.starts_with(expected), "{message} for {text:?}");
        }
    }

    #[test]
    fn the_windings_current_follows_from_the_supplys_power() {
        let text = "battery_v,battery_a,motor_v\n12,2,6\n12,3,9\n12,0.1,0\n";
        let bench = Bench::parse(text, "bench.csv").unwrap();
        let current = &bench.columns[&Reading::Current];
        assert_eq!(current[..2], [4.0, 4.0]);
        assert!(current[2].is_nan());
    }

    #[test]
    fn clocks_are_read() {
        assert_eq!(clock_s("2019-11-07 18:45:58:868"), Some(67_558.868));
        assert_eq!(clock_s("00:00:01.5"), Some(1.5));
        assert_eq!(clock_s("25:00:00"), None);
        assert_eq!(clock_s("12:30"), None);
    }
}
