//! CrazyPAD's flights, each compared with normal flights of its airframe (`sil diagnose --baseline`): all that there
//! are, and those of its day. A normal flight is compared with the others.

use std::fmt;
use std::path::Path;

use rayon::prelude::*;
use sil_host::diagnosis::{
    BaselineDiagnosis, BetweenFlights, Difference, FlightNumbers, Given, Known, Subject, compare_flights,
};

use super::crazypad::NORMAL;
use super::{files, load, name_of};

/// A log with its numbers.
pub struct Numbered {
    /// `controller` or `motor`.
    pub kind: String,
    /// What was done to the vehicle, by its authors.
    pub label: String,
    /// `E8` or `E9`.
    pub airframe: String,
    /// Number of the log.
    pub log: String,
    numbers: FlightNumbers,
}

/// Which normal flights are a baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// All of the airframe.
    All,
    /// Those of the same day.
    SameDay,
    /// The same, and nothing was touched but what the label says, which nobody has written down. Not for propellers:
    /// one that was cut was off the vehicle.
    SameDayUntouched,
}

/// One flight against normal ones.
pub struct Compared {
    /// Name of the flight.
    pub name: String,
    /// What was done to the vehicle.
    pub label: String,
    /// `E8` or `E9`.
    pub airframe: String,
    /// Of `kind`.
    pub kind: String,
    /// Which normal flights are its baseline.
    pub against: Against,
    /// The answer.
    pub answer: BaselineDiagnosis,
}

/// The numbers of all logs of a kind (`controller`, `motor`), or of both (an empty name); none where they are absent.
///
/// # Panics
/// The logs are there and not CrazyPAD's.
pub fn numbered(kind: &str) -> Vec<Numbered> {
    files("flight_crazypad", kind).par_iter().map(|path| one(path)).collect()
}

fn one(path: &Path) -> Numbered {
    let name = name_of(path);
    let parts = || {
        let (kind, rest) = name.split_once("_data_")?;
        let (label, vehicle) = rest.split_once("__")?;
        let (airframe, log) = vehicle.split_once('_')?;
        Some([kind, label, airframe, log].map(str::to_owned))
    };
    let [kind, label, airframe, log] = parts().expect("KIND_data_LABEL__AIRFRAME_LOG");
    let whole = load(path, if kind == "motor" { "crazypad_motor" } else { "crazypad_controller" });
    let numbers = FlightNumbers::of(&whole, &Subject::Axes).expect("a log with windows");
    Numbered { kind, label, airframe, log, numbers }
}

impl Numbered {
    fn is_normal(&self) -> bool {
        self.label == NORMAL
    }

    /// Day of April 2022 by the history of the authors' repository.
    fn day(&self) -> u32 {
        let is_late_normal = [("motor", "log05"), ("controller", "log03")].contains(&(&self.kind, &self.log));
        match (self.airframe.as_str(), self.label.as_str()) {
            ("E8", NORMAL) if is_late_normal => 9,
            (_, "cut_propeller_M3_1mm_46mm") | ("E9", "cut_propeller_M3_2mm_2mm_43mm") => 9,
            (_, label) if label.starts_with("cut_propeller") => 16,
            _ => 3,
        }
    }

    /// Normal flights of this airframe, of the same kind of log, without itself.
    fn baseline(&self, all: &[Numbered], against: Against) -> Vec<FlightNumbers> {
        let is_of = |other: &&Numbered| {
            let is_alike = (&other.kind, &other.airframe) == (&self.kind, &self.airframe);
            let is_itself = self.is_normal() && other.log == self.log;
            is_alike && other.is_normal() && !is_itself && (against == Against::All || other.day() == self.day())
        };
        all.iter().filter(is_of).map(|other| other.numbers.clone()).collect()
    }
}

/// Every flight against all other normal flights of its airframe, and against those of its day where there are some.
///
/// # Panics
/// Flights can't be compared.
pub fn compared(all: &[Numbered]) -> Vec<Compared> {
    let all_ways = [Against::All, Against::SameDay, Against::SameDayUntouched];
    all.iter().flat_map(|flight| all_ways.into_iter().filter_map(|against| flight.compared(all, against))).collect()
}

impl Numbered {
    fn compared(&self, all: &[Numbered], against: Against) -> Option<Compared> {
        let normal = self.baseline(all, against);
        let untouched = against == Against::SameDayUntouched;
        if normal.is_empty() || untouched && self.label.starts_with("cut_propeller") {
            return None;
        }
        let between = if untouched { BetweenFlights::Untouched } else { BetweenFlights::Serviced };
        let given = Given { known: &Known::default(), between };
        let answer = compare_flights(&self.numbers, &normal, &Subject::Axes, given).expect("numbers in common");
        let Numbered { kind, label, airframe, log, .. } = self;
        Some(Compared {
            name: format!("{airframe} {label}, {kind} {log}"),
            label: label.clone(),
            airframe: airframe.clone(),
            kind: kind.clone(),
            against,
            answer,
        })
    }
}

/// "weak_motor 2: 0.760 +- 0.019".
fn short(difference: &Difference) -> String {
    let place = difference.parameters.get("motor").map(|motor| format!(" {}", motor.value));
    let place = place.or(difference.axis.map(|axis| format!(" {axis}"))).unwrap_or_default();
    let size = ["scale", "mass_scale"].iter().find_map(|name| difference.parameters.get(name));
    let size = size.map(|size| format!(" {size}")).unwrap_or_default();
    format!("{}{place}{size}", difference.effect)
}

fn whole(difference: &Difference) -> String {
    let mut text = short(difference);
    for other in &difference.one_of {
        text += &format!(" or {}", short(other));
    }
    text
}

/// A row of the table.
impl fmt::Display for Compared {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let baseline = &self.answer.baseline;
        let day = match self.against {
            Against::All => "",
            Against::SameDay => ", same day",
            Against::SameDayUntouched => ", untouched",
        };
        let z: Vec<String> = baseline.numbers.iter().map(|number| format!("{:+.1}", number.z)).collect();
        let found: Vec<String> = self.answer.findings.iter().map(whole).collect();
        let nearest = self.answer.nearest.as_ref().map_or_else(String::new, |nearest| {
            format!("({}, chance {:.2})", short(nearest), nearest.chance.unwrap_or(1.0))
        });
        let (flights, name) = (baseline.logs.len(), &self.name);
        let answer = if found.is_empty() { format!("nothing {nearest}") } else { found.join("; and ") };
        writeln!(out, "| {name} | {flights}{day} | {} | {:.0e} | {answer} |", z.join(" "), baseline.chance)
    }
}
