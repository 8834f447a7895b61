//! The range of a number in a document, and how a complaint names it.

/// The numbers that a key admits, and how to say so.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Admissible {
    /// Smallest value.
    pub(crate) min: f64,
    /// Largest value.
    pub(crate) max: f64,
    /// What it is, with its unit unless that is given apart: "the arm in metres, motor to centre".
    pub(crate) what: &'static str,
    /// Its unit, given apart; empty for a number without one.
    pub(crate) unit: Option<&'static str>,
}

/// Short for [`Admissible`].
pub(crate) const fn admissible(min: f64, max: f64, what: &'static str) -> Admissible {
    Admissible { min, max, what, unit: None }
}

impl Admissible {
    /// The range in words, with its unit.
    pub(crate) fn describe(&self) -> String {
        let what = match self.unit {
            None => self.what.to_owned(),
            Some("") => format!("the {}", self.what),
            Some(unit) => format!("the {} in {unit}", self.what),
        };
        format!("{what} ({:?} to {:?})", self.min, self.max)
    }
}
