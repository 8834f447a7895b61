//! `sil map`: a draft of the map of somebody else's CSV. Names say what a column may be (`names`), its values in which
//! unit; then the log is read by the draft and held against itself ([`super::sanity`]), and what contradicts is mended
//! and tried again. Each line says why it is there; what nothing in the log can tell is said, too.

mod entry;
mod filling;
mod languages;
mod names;
mod quaternion;
#[cfg(test)]
mod tests;
mod text;
mod units;
mod words;

use std::path::Path;

use self::entry::{Entry, entries_of, entry};
use self::filling::Filling;
use self::names::{Named, is_command_of_some_axis, is_output, named};
use self::quaternion::quaternion;
use self::words::{Families, numbered};
use super::contradiction::Contradiction;
use super::error::{LogError, LogErrorKind};
use super::map::Map;
use super::messages::Table;
use super::more_motors::{is_driven_with, no_quadrotor};
use super::quantity::Quantity;
use super::sanity::examine;
use super::{FORMATS, csv, source};
use crate::axis::Axis;

/// Mended more often than this, something else is wrong.
const ROUNDS_MAX: usize = 8;
/// A column that is not in all rows yields to one that is.
const SPARSE_RANK: usize = 10;

/// A map as a text, to be looked through by its user.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// The map, TOML with a reason for each line.
    pub toml: String,
    /// What the log lacks, or still contradicts; the map can't be used before that is mended.
    pub problems: Vec<String>,
}

/// Drafts the map of a CSV; `None` for a flight controller's own format, which needs none.
///
/// # Errors
/// The file can't be read, or is no table.
pub fn draft(path: &Path) -> Result<Option<Draft>, LogError> {
    draft_of(path, source::load(path)?)
}

/// The same of a stream that is no file; the name tells formats apart and stands in messages.
///
/// # Errors
/// As [`draft`].
pub fn draft_from(name: &Path, from: &mut impl std::io::Read) -> Result<Option<Draft>, LogError> {
    draft_of(name, source::load_from(name, from)?)
}

fn draft_of(path: &Path, bytes: Vec<u8>) -> Result<Option<Draft>, LogError> {
    let is_own_format = FORMATS[..FORMATS.len() - 1].iter().any(|format| (format.recognises)(path, &bytes));
    if is_own_format {
        return Ok(None);
    }
    let file = path.display().to_string();
    let text = source::text(&file, bytes)?;
    Drafting::of(&file, &text).map(|drafting| Some(drafting.finish(&text)))
}

/// A map in the making.
struct Drafting<'a> {
    file: &'a str,
    /// Of the table.
    rows: usize,
    frame: &'static str,
    frame_turn_deg: f64,
    entries: Vec<Entry>,
    unused: Vec<String>,
    /// Columns of another table that stands beside the first, each with the number of its rows.
    of_another_table: Vec<(String, usize)>,
    remarks: Vec<String>,
    /// What a log needs and no column's name says.
    lacking: Vec<String>,
}

impl Drafting<'_> {
    fn of<'a>(file: &'a str, text: &str) -> Result<Drafting<'a>, LogError> {
        let (table, with_words) = csv::table(file, text)?;
        let mut drafting = Drafting {
            file,
            rows: table.rows(),
            frame: "FRD",
            frame_turn_deg: 0.0,
            entries: Vec::new(),
            unused: Vec::new(),
            of_another_table: Vec::new(),
            remarks: Vec::new(),
            lacking: Vec::new(),
        };
        let families = Families::of(table.fields());
        let quaternion = quaternion(&table);
        let is_of_it = |name: &&str| quaternion.iter().any(|own| own.columns.iter().any(|column| column == name));
        for name in table.fields().filter(|name| !is_of_it(name)) {
            let filling = Filling::of(&table, name, with_words.iter().any(|other| other == name));
            let said = named(name, families.family(name));
            drafting.take(name, said.as_ref(), filling, &table);
        }
        // angles that the table has itself go before
        quaternion.iter().flat_map(entries_of).for_each(|entry| drafting.enter(entry));
        drafting.drop_signed_outputs(&table);
        let further = drafting.further_motors(&table);
        drafting.take_command_by_elimination();
        units::share(&mut drafting.entries, &table);
        units::weigh(&mut drafting.entries, &table);
        units::size_commands(&mut drafting.entries, &table);
        drafting.lacking = drafting.lacking();
        if !further.is_empty() {
            drafting.lacking.push(no_quadrotor(&further));
        }
        drafting.drop_what_is_not_needed();
        Ok(drafting)
    }

    /// Takes a column for what its name says, if its values may be that.
    fn take(&mut self, name: &str, said: Option<&Named>, filling: Filling, table: &Table) {
        let entry = said.map(|said| entry(name, said));
        let entry = entry.filter(|entry| !is_idle_motor(entry, table));
        match (entry, filling) {
            (_, Filling::EndsEarly(rows)) => self.of_another_table.push((name.to_owned(), rows)),
            (Some(entry), Filling::Whole) => self.enter(entry),
            // the rows need a time each
            (Some(mut entry), Filling::Sparse(rows)) if entry.quantity != Quantity::Time => {
                entry.rank += SPARSE_RANK;
                entry.why.push(format!("in {rows} of {} rows, missing in the others", table.rows()));
                self.enter(entry);
            }
            _ => self.unused.push(name.to_owned()),
        }
    }

    /// Puts an entry in its place; the surer of two has it, and of two equal ones that whose name says less besides.
    fn enter(&mut self, entry: Entry) {
        let order = |entry: &Entry| (entry.rank, entry.besides());
        match self.entries.iter_mut().find(|other| other.quantity == entry.quantity) {
            Some(other) if order(other) <= order(&entry) => self.unused.push(entry.column),
            Some(other) => self.unused.push(std::mem::replace(other, entry).column),
            None => self.entries.push(entry),
        }
    }

    fn has(&self, quantity: Quantity) -> bool {
        self.entries.iter().any(|entry| entry.quantity == quantity)
    }

    fn has_motors(&self) -> bool {
        (0..4).all(|motor| self.has(Quantity::Motor(motor)))
    }

    /// All that a log needs and that no column was taken for.
    fn lacking(&self) -> Vec<String> {
        let has_any = |of: fn(Axis) -> Quantity| Axis::ALL.iter().any(|axis| self.has(of(*axis)));
        let motors = (0..4).filter(|motor| self.has(Quantity::Motor(*motor))).count();
        let mut lacking = Vec::new();
        if !self.has(Quantity::Time) {
            lacking.push("time (time_s) is missing".to_owned());
        }
        if !has_any(Quantity::Angle) && !has_any(Quantity::Rate) {
            lacking.push("angles (roll_rad, pitch_rad) or body rates (p_rad_s, q_rad_s) are missing".to_owned());
        }
        if motors < 4 && !has_any(Quantity::Command) {
            let has_speeds = (0..4).any(|motor| self.has(Quantity::Rpm(motor)));
            let speeds = if has_speeds { "; rotors' speeds, which the log has, are none" } else { "" };
            lacking.push(format!(
                "commands are missing: motor1 to motor4 ({motors} of them recognised{speeds}), or roll_cmd, pitch_cmd"
            ));
        }
        lacking
    }

    /// A command that names no axis is that of the only axis with an angle.
    fn take_command_by_elimination(&mut self) {
        let with_angle: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| self.has(Quantity::Angle(*axis))).collect();
        let commands: Vec<String> = self.unused.iter().filter(|name| is_command_of_some_axis(name)).cloned().collect();
        let has_command = Axis::ALL.iter().any(|axis| self.has(Quantity::Command(*axis))) || self.has_motors();
        if let ([axis], [column], false) = (with_angle.as_slice(), commands.as_slice(), has_command) {
            let said = Named { quantity: Quantity::Command(*axis), unit: None, rank: 3 };
            let mut entry = entry(column, &said);
            entry.why = vec![format!("a command, and {} is the only axis with an angle", axis.name())];
            self.unused.retain(|name| name != column);
            self.entries.push(entry);
        }
    }

    /// Four outputs of which one is ever negative are no motors': `u1` to `u4` may be thrust and three torques.
    fn drop_signed_outputs(&mut self, table: &Table) {
        let is_output = |entry: &Entry| matches!(entry.quantity, Quantity::Motor(_)) && is_output(&entry.column);
        let is_signed = |entry: &Entry| numbers(table, &entry.column).iter().any(|value| *value < 0.0);
        if self.entries.iter().any(|entry| is_output(entry) && is_signed(entry)) {
            let dropped = self.entries.extract_if(.., |entry| is_output(entry));
            self.unused.extend(dropped.map(|entry| entry.column));
        }
    }

    /// Columns that count on behind the fourth motor, and are driven as the four are.
    fn further_motors(&self, table: &Table) -> Vec<String> {
        let of = |motor| self.entries.iter().find(|entry| entry.quantity == Quantity::Motor(motor));
        let [Some(m1), Some(m2), Some(m3), Some(m4)] = [0, 1, 2, 3].map(of).map(|of| of.map(|entry| &entry.column))
        else {
            return Vec::new();
        };
        let motors = [m1, m2, m3, m4].map(|column| table.column(column).unwrap_or_default());
        let stem = |name: &str| numbered(name).map(|(stem, _)| stem);
        let is_further = |name: &&str| ![m1, m2, m3, m4].iter().any(|own| *own == name) && stem(name) == stem(m1);
        let is_driven = |name: &&str| table.column(name).is_some_and(|column| is_driven_with(column, &motors));
        let further = table.fields().filter(|_| stem(m1).is_some()).filter(is_further).filter(is_driven);
        further.map(str::to_owned).collect()
    }

    /// Half a set of motors is none, and beside motors axis commands are not used.
    fn drop_what_is_not_needed(&mut self) {
        let motors = self.has_motors();
        // where no command was recognised its user has yet to name them, of axes that stay
        let has_none = !Axis::ALL.iter().any(|axis| self.has(Quantity::Command(*axis)));
        let driven = Axis::ALL.map(|axis| motors || has_none || self.has(Quantity::Command(axis)));
        let mut dropped = Vec::new();
        self.entries.retain(|entry| {
            let is_kept = match entry.quantity {
                Quantity::Motor(_) => motors,
                Quantity::Command(_) | Quantity::Thrust => !motors,
                // an axis that nothing drives is not compared
                Quantity::Angle(axis) | Quantity::Rate(axis) | Quantity::Reference(axis) => driven[axis.index()],
                _ => true,
            };
            if !is_kept {
                dropped.push(entry.column.clone());
            }
            is_kept
        });
        self.unused.extend(dropped);
    }

    /// Reads the log by the draft and mends what contradicts, as often as something does.
    fn finish(mut self, text: &str) -> Draft {
        let mut problems = std::mem::take(&mut self.lacking);
        if !problems.is_empty() {
            let toml = self.toml(&problems);
            return Draft { toml, problems };
        }
        for round in 0..=ROUNDS_MAX {
            problems.clear();
            let map = match Map::parse("the draft", &self.toml(&[])) {
                Ok(map) => map,
                Err(error) => {
                    problems.push(error.kind.to_string());
                    break;
                }
            };
            let log = match csv::parse(self.file, text, Some(&map)) {
                Ok(log) => log,
                Err(error) if round < ROUNDS_MAX && self.mend_range(&error) => continue,
                Err(error) => {
                    problems.push(error.to_string());
                    break;
                }
            };
            let examination = examine(&log, Some(&map));
            let Some(first) = examination.contradictions.first() else {
                self.remarks.extend(examination.confirmed);
                break;
            };
            problems = examination.contradictions.iter().map(Contradiction::to_string).collect();
            if round == ROUNDS_MAX || !self.mend(first) {
                break;
            }
        }
        let toml = self.toml(&problems);
        Draft { toml, problems }
    }

    /// A value out of its range is of another unit.
    fn mend_range(&mut self, error: &LogError) -> bool {
        let LogErrorKind::OutOfRange { .. } = error.kind else { return false };
        let Some(entry) = self.entries.iter_mut().find(|entry| Some(&entry.column) == error.column.as_ref()) else {
            return false;
        };
        let other = match entry.quantity {
            Quantity::Angle(_) | Quantity::Reference(_) => "_deg",
            Quantity::Rate(_) => "_deg_s",
            _ => return false,
        };
        let key = format!("{}{other}", entry.quantity.stem());
        entry.why.push("too large for radians".to_owned());
        std::mem::replace(&mut entry.key, key.clone()) != key
    }

    /// Does what a contradiction says; false where it says nothing that can be done.
    fn mend(&mut self, contradiction: &Contradiction) -> bool {
        let why = contradiction.seen.clone();
        if self.turns_upright(contradiction) {
            self.frame = "FLU";
            self.remarks.push(format!("frame: {why}, so the body's z points upward"));
            return true;
        }
        if let Some(turn_deg) = contradiction.frame_turn_deg.filter(|_| self.frame_turn_deg == 0.0) {
            self.frame_turn_deg = turn_deg;
            self.remarks.push(format!("frame_turn_deg: {why}; roll and pitch are then about the turned axes"));
            return true;
        }
        let before = self.entries.clone();
        for line in &contradiction.map_lines {
            let (Some((quantity, _)), Some(from)) =
                (Quantity::from_name(&line.key), before.iter().find(|entry| entry.quantity == line.from))
            else {
                return false;
            };
            // the line is about the values after the frame was turned, a map's sign before
            let frame = if self.frame == "FLU" { quantity.sign_from_flu() * line.from.sign_from_flu() } else { 1.0 };
            let sign = frame * line.sign * from.sign;
            let mut entry = Entry { quantity, key: line.key.clone(), sign, ..from.clone() };
            if quantity == line.from && line.sign > 0.0 && line.key == from.key {
                continue;
            }
            // a swap of columns of one unit keeps it
            if quantity != line.from {
                entry.key = line.key.replace(&quantity.name(), &from.key.replace(line.from.stem(), quantity.stem()));
            } else if line.sign < 0.0 {
                entry.key = from.key.clone();
            }
            entry.why.push(why.clone());
            if let Some(other) = contradiction.or_instead.first() {
                entry.why.push(format!("or instead: {other}"));
            }
            match self.entries.iter_mut().find(|entry| entry.quantity == quantity) {
                Some(place) => *place = entry,
                None => self.entries.push(entry),
            }
        }
        let left_out = |entry: &Entry| contradiction.leave_out.contains(&entry.quantity);
        for entry in self.entries.iter().filter(|entry| left_out(entry)) {
            self.remarks.push(format!("left out: {} ({why})", entry.column));
        }
        self.entries.retain(|entry| !left_out(entry));
        self.entries != before
    }

    /// True if the accelerometer says that the whole body frame counts z upward.
    fn turns_upright(&self, contradiction: &Contradiction) -> bool {
        let z = Quantity::Accel(Axis::Yaw);
        let is_of_z = |entry: &Entry| entry.quantity == z && entry.sign > 0.0;
        let turns_z = contradiction.map_lines.iter().any(|line| line.from == z && line.sign < 0.0);
        turns_z && contradiction.map_lines.len() == 1 && self.frame == "FRD" && self.entries.iter().any(is_of_z)
    }
}

/// A motor's column that never changes drives nothing: another may be the motor's.
fn is_idle_motor(entry: &Entry, table: &Table) -> bool {
    let values = numbers(table, &entry.column);
    matches!(entry.quantity, Quantity::Motor(_)) && values.windows(2).all(|pair| pair[0] == pair[1])
}

fn numbers(table: &Table, name: &str) -> Vec<f64> {
    table.column(name).unwrap_or_default().iter().copied().filter(|value| value.is_finite()).collect()
}
