//! The variables of an FMU: what stands in its description, and what values they take.

use sil_host::plant::StateName;

/// A value as it crosses the interface.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// fmi3Float64.
    Float(f64),
    /// fmi3UInt64.
    Count(u64),
    /// fmi3Boolean.
    Boolean(bool),
    /// fmi3String.
    Text(String),
}

impl Value {
    /// The FMI type, as the description calls it.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Float(_) => "Float64",
            Self::Count(_) => "UInt64",
            Self::Boolean(_) => "Boolean",
            Self::Text(_) => "String",
        }
    }
}

/// Who gives a variable its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// The user, before the start.
    Parameter,
    /// Another FMU or the user, all the time.
    Input,
    /// This FMU, for others.
    Output,
    /// This FMU, for whoever looks.
    Local,
}

/// When it may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Not after initialisation.
    Fixed,
    /// At events and communication points.
    Discrete,
    /// All the time.
    Continuous,
}

/// One variable. Its value reference is its place in the list plus one; 0 is time.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// With unit and frame.
    pub name: String,
    /// What it means.
    pub description: String,
    /// A name out of [`UNITS`]; empty for a number without one.
    pub unit: &'static str,
    /// Who gives its value.
    pub causality: Causality,
    /// When that may change.
    pub variability: Variability,
    /// What it is before the start, and its type.
    pub start: Value,
    /// Is the start this FMU's to compute?
    pub is_calculated: bool,
    /// Place in the list of the state whose derivative this is.
    pub derivative_of: Option<usize>,
}

impl Variable {
    /// A number that another FMU gives, at communication points and events or all the time.
    pub(crate) fn input(name: String, unit: &'static str, description: &str, start: f64) -> Self {
        Self {
            name,
            description: description.into(),
            unit,
            causality: Causality::Input,
            variability: Variability::Continuous,
            start: Value::Float(start),
            is_calculated: false,
            derivative_of: None,
        }
    }

    /// A number that this FMU computes.
    pub(crate) fn output(name: String, unit: &'static str, description: &str) -> Self {
        Self { causality: Causality::Output, is_calculated: true, ..Self::input(name, unit, description, 0.0) }
    }

    /// A choice of the user's.
    pub(crate) fn parameter(name: &str, unit: &'static str, description: &str, start: Value) -> Self {
        Self {
            causality: Causality::Parameter,
            variability: Variability::Fixed,
            start,
            ..Self::input(name.into(), unit, description, 0.0)
        }
    }

    /// A continuous state, which is an output as well.
    pub(crate) fn state(state: &StateName, start: f64, is_calculated: bool) -> Self {
        let output = Self::output(state.name.into(), state.unit, state.meaning);
        Self { start: Value::Float(start), is_calculated, ..output }
    }

    /// The rate of change of a state at a place in the list.
    pub(crate) fn derivative(state: &StateName, place: usize) -> Self {
        let description = format!("rate of change of {}", state.name);
        let unit = unit_per_second(state.unit);
        Self {
            causality: Causality::Local,
            derivative_of: Some(place),
            ..Self::output(format!("der({})", state.name), unit, &description)
        }
    }

    /// The same, changing at events and communication points only.
    pub(crate) fn discrete(self) -> Self {
        Self { variability: Variability::Discrete, ..self }
    }

    /// May it be set before the start?
    pub(crate) fn has_start(&self) -> bool {
        !self.is_calculated
    }
}

/// A unit by SI base units.
#[derive(Clone, Copy, Debug)]
pub struct Unit {
    /// Its name.
    pub name: &'static str,
    /// Base units with their exponents.
    pub base: &'static [(&'static str, i8)],
    /// A unit that people like to read it in, and how many of those it is.
    pub display: Option<(&'static str, f64)>,
}

const DEGREES: f64 = 180.0 / core::f64::consts::PI;

const fn unit(name: &'static str, base: &'static [(&'static str, i8)], display: Option<(&'static str, f64)>) -> Unit {
    Unit { name, base, display }
}

/// All units that occur.
pub const UNITS: [Unit; 14] = [
    unit("s", &[("s", 1)], None),
    unit("Hz", &[("s", -1)], None),
    unit("1/s", &[("s", -1)], None),
    unit("m", &[("m", 1)], None),
    unit("m/s", &[("m", 1), ("s", -1)], None),
    unit("m/s2", &[("m", 1), ("s", -2)], None),
    unit("rad", &[("rad", 1)], Some(("deg", DEGREES))),
    unit("rad/s", &[("rad", 1), ("s", -1)], Some(("deg/s", DEGREES))),
    unit("rad/s2", &[("rad", 1), ("s", -2)], None),
    unit("N", &[("kg", 1), ("m", 1), ("s", -2)], None),
    unit("N.m", &[("kg", 1), ("m", 2), ("s", -2)], None),
    unit("V", &[("kg", 1), ("m", 2), ("s", -3), ("A", -1)], None),
    unit("A", &[("A", 1)], None),
    unit("A/s", &[("A", 1), ("s", -1)], None),
];

/// The unit of a state's rate of change.
fn unit_per_second(of_state: &str) -> &'static str {
    match of_state {
        "rad" => "rad/s",
        "rad/s" => "rad/s2",
        "m" => "m/s",
        "m/s" => "m/s2",
        "A" => "A/s",
        _ => "1/s",
    }
}

/// Of the axes of a vector.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];
