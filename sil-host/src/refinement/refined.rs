//! Benches in, refined model out.

use super::bench::Bench;
use super::choice::Comparison;
use super::component::Component;
use super::constant::{Constant, Constants};
use super::form::{Fitted, Form};
use super::plausibility::{Check, Given, checks};
use crate::model::VehicleModel;
use crate::vehicle::propulsion::{DevicePropulsion, Esc, LookUpTable, POINTS_MAX, Propulsion};

/// What benches made of a model.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The base model with what was measured in it.
    pub model: VehicleModel,
    /// What the base model is called, for remarks.
    pub base: String,
    /// What was measured.
    pub constants: Vec<Constant>,
    /// The forms of each component that was measured.
    pub comparisons: Vec<Comparison>,
    /// Whether the result can be.
    pub checks: Vec<Check>,
    /// What was left out or assumed.
    pub notes: Vec<String>,
}

/// Why there is nothing to refine.
#[derive(Debug, thiserror::Error)]
pub enum NotRefined {
    /// The base model has no such constants.
    #[error("the base model is of level {0}: expected level device, which has the constants that benches measure")]
    Level(&'static str),
    /// A form that does not exist.
    #[error("--form {given}: expected {expected}")]
    Form {
        /// What was given.
        given: String,
        /// What there is.
        expected: String,
    },
    /// The columns do not go together.
    #[error(
        "the benches show no component: expected columns that go together, such as command and motor_v, speed_rad_s \
         and lift_n (docs/refine.md)"
    )]
    Nothing,
}

/// Refines the model by all benches. `forms` are requests such as `lift=table`.
///
/// # Errors
/// The model is of another level, a request is not understood, or no component is shown.
pub fn refine(
    benches: &[Bench],
    base: &VehicleModel,
    given: &Given,
    forms: &[String],
) -> Result<Refined, NotRefined> {
    let Propulsion::Device(device) = base.propulsion else {
        return Err(NotRefined::Level(base.propulsion.level().name()));
    };
    let requests = forms.iter().map(|form| request(form)).collect::<Result<Vec<_>, _>>()?;
    let mut notes = Vec::new();
    let mut steady = Vec::new();
    for bench in benches {
        let reduced = bench.steady();
        notes.extend(bench.notes.iter().chain(&reduced.notes).map(|note| format!("{}: {note}", bench.name)));
        steady.push(reduced);
    }
    let mut constants = Constants::new(&steady, &device);
    let mut comparisons = Vec::new();
    for component in Component::ALL {
        let points = constants.points(component);
        if points.x.is_empty() {
            continue;
        }
        let requested = requests.iter().rev().find(|(of, _)| *of == component).map(|(_, form)| *form);
        let Some(comparison) = Comparison::of(component, points, requested) else {
            notes.push(format!("{}: too few readings to fit any form", component.name()));
            continue;
        };
        for assumed in constants.assumed(component) {
            notes.push(format!("{}: no bench shows {assumed}, the base model's is used", component.name()));
        }
        constants.add(&comparison);
        comparisons.push(comparison);
    }
    if comparisons.is_empty() {
        return Err(NotRefined::Nothing);
    }
    let constants = constants.all;
    let device = with_measured(device, &constants, &comparisons);
    let model = VehicleModel { propulsion: Propulsion::Device(device), ..base.clone() };
    let checks = checks(&device, given, base.gravity_m_s2);
    Ok(Refined { model, base: base.name.clone(), constants, comparisons, checks, notes })
}

/// `lift=table`.
fn request(text: &str) -> Result<(Component, &'static str), NotRefined> {
    let component = text.split_once('=').and_then(|(name, _)| Component::ALL.into_iter().find(|of| of.name() == name));
    let Some(component) = component else {
        let names: Vec<&str> = Component::ALL.iter().map(|of| of.name()).collect();
        let expected = format!("COMPONENT=FORM, the component one of {}", names.join(", "));
        return Err(NotRefined::Form { given: text.to_owned(), expected });
    };
    let wanted = text.split_once('=').map_or("", |(_, form)| form);
    let forms: Vec<&'static str> = component.forms().into_iter().map(Form::name).collect();
    match forms.iter().find(|form| **form == wanted) {
        Some(form) => Ok((component, form)),
        None => {
            let expected = format!("for {} one of {}", component.name(), forms.join(", "));
            Err(NotRefined::Form { given: text.to_owned(), expected })
        }
    }
}

/// The base's constants, replaced where they were measured.
fn with_measured(base: DevicePropulsion, constants: &[Constant], comparisons: &[Comparison]) -> DevicePropulsion {
    let mut device = base;
    for constant in constants {
        let place = match constant.key {
            "resistance_ohm" => &mut device.resistance_ohm,
            "inductance_h" => &mut device.inductance_h,
            "speed_constant_rad_s_v" => &mut device.speed_constant_rad_s_v,
            "speed_offset_rad_s" => &mut device.speed_offset_rad_s,
            "loss_nm_s" => &mut device.loss_nm_s,
            "lift_n_s2" => &mut device.lift_n_s2,
            "reaction_torque_nm_s2" => &mut device.reaction_torque_nm_s2,
            "drag_nm_s2" => &mut device.drag_nm_s2,
            _ => continue,
        };
        *place = constant.value;
    }
    // a line through the origin has no offset
    if constants.iter().any(|constant| constant.key == "speed_constant_rad_s_v" && constant.form == "proportional") {
        device.speed_offset_rad_s = 0.0;
    }
    for comparison in comparisons {
        match (comparison.component, &comparison.taken().fitted) {
            (Component::SpeedController, Fitted::Table(table)) => device.esc = Esc::Table(*table),
            (Component::SpeedController, _) => {
                device.esc = comparison.of_model().and_then(|of| esc_of(&of.fitted)).unwrap_or(device.esc);
            }
            (Component::Lift, Fitted::Table(table)) => device.lift_table = Some(from_rest(table)),
            (Component::Lift, _) => device.lift_table = None,
            _ => {}
        }
    }
    device
}

/// A speed controller of a fitted formula.
fn esc_of(fitted: &Fitted) -> Option<Esc> {
    let Fitted::Formula(formula, fit) = fitted else { return None };
    match (formula.name, fit.parameters.as_slice()) {
        ("exponential", &[gain1_v, rate1, gain2_v, rate2]) => Some(Esc::Exponential { gain1_v, rate1, gain2_v, rate2 }),
        ("saturating", &[gain1_v, gain2_v, rate2]) => Some(Esc::Exponential { gain1_v, rate1: 0.0, gain2_v, rate2 }),
        ("proportional", &[battery_v]) => Some(Esc::Duty { battery_v }),
        _ => None,
    }
}

/// A rotor at rest lifts nothing, whatever its lowest reading was.
fn from_rest(table: &LookUpTable) -> LookUpTable {
    let mut points = vec![(0.0, 0.0)];
    points.extend(table.points().iter().filter(|(speed, _)| *speed > 0.0));
    // two neighbours in the middle become one where there is no room
    if points.len() > POINTS_MAX {
        points.remove(points.len() / 2);
    }
    LookUpTable::new(&points).unwrap_or(*table)
}
