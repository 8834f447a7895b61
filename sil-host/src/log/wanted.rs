//! What of a log is wanted: which columns, which rows, and whether its labels are checked. From a file's bytes to the
//! rows that are compared.

use std::io::Read;
use std::path::Path;

use super::flown::{Flown, FlownError};
use super::sanity::gate;
use super::{Log, LogError, Map, read_from};

/// Which rows of a log are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Rows {
    /// Those in which the vehicle flew.
    #[default]
    Flown,
    /// Those of one flight, counted from 1.
    Flight(usize),
    /// All from a time to another, s, on the ground or not.
    Between(f64, f64),
    /// All.
    All,
}

/// What is wanted of a log.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// What its columns mean; none for those of docs/log-format.md and of flight controllers.
    pub map: Option<Map>,
    /// By how much its body axes are turned about yaw ([`Log::turned`]), deg, beyond what map or file say.
    pub frame_turn_deg: f64,
    /// Its rows.
    pub rows: Rows,
    /// True to compare even what contradicts its labels.
    pub unchecked: bool,
}

/// Why there is no such part of a log.
#[derive(Debug, thiserror::Error)]
pub enum NotWanted {
    /// It can't be read, or has too few such rows.
    #[error(transparent)]
    Log(#[from] LogError),
    /// It has no such flight.
    #[error("{file}: {error}")]
    Flight {
        /// The log.
        file: String,
        /// What is wrong.
        error: Box<FlownError>,
    },
    /// It contradicts its labels.
    #[error("{0}\n({1}--unchecked compares nevertheless)")]
    Contradictory(Box<LogError>, String),
}

impl Wanted {
    /// Reads the bytes of a file, compressed or not; the name tells formats apart and stands in messages.
    ///
    /// # Errors
    /// [`NotWanted`], with the place.
    pub fn read(&self, name: &Path, bytes: &mut impl Read) -> Result<Log, NotWanted> {
        self.of(read_from(name, bytes, self.map.as_ref())?)
    }

    /// The wanted rows of a log, where not all of them are wanted cut where its attitude jumps; what was checked of it
    /// stands in its notes.
    ///
    /// # Errors
    /// [`NotWanted`].
    pub fn of(&self, log: Log) -> Result<Log, NotWanted> {
        let mut part = self.part(log.turned(self.frame_turn_deg)?)?;
        if self.rows != Rows::All {
            part = part.cut_at_jumps();
        }
        if self.unchecked {
            part.notes.push("not checked against itself (--unchecked)".to_owned());
            return Ok(part);
        }
        let examination = gate(&part, self.map.as_ref()).map_err(|error| {
            // what a flight controller's fields mean is known
            let draft = part.flight_controller.is_none().then(|| format!("sil map {} drafts a map; ", error.file));
            NotWanted::Contradictory(Box::new(error), draft.unwrap_or_default())
        })?;
        part.notes.push(match examination.confirmed.as_slice() {
            [] => "too short or too quiet to check units, signs and order of its columns".to_owned(),
            confirmed => format!("checked: {}", confirmed.join("; ")),
        });
        Ok(part)
    }

    fn part(&self, log: Log) -> Result<Log, NotWanted> {
        let flight = match self.rows {
            Rows::All => return Ok(log),
            Rows::Between(from_s, to_s) => return Ok(log.between(from_s, to_s)?),
            Rows::Flight(number) => Some(number),
            Rows::Flown => None,
        };
        let flown = Flown::of(&log).part(&log, flight);
        flown.map_err(|error| NotWanted::Flight { file: log.path, error: Box::new(error) })
    }
}
