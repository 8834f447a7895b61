//! Benches in, refined model out.

use super::bench::Bench;
use super::choice::Comparison;
use super::component::{Component, Measured};
use super::constant::{Constant, Constants, ROTOR_INERTIA};
use super::form::{Fitted, Form};
use super::plausibility::{Check, Given, checks};
use crate::model::{Mounting, VehicleModel};
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

/// What is to be made of benches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Order<'a> {
    /// What is known of the vehicle, for the checks.
    pub given: Given,
    /// Forms to take whatever predicts best, such as `lift=table`.
    pub forms: &'a [String],
    /// Benches that no fit uses: the error of each form is reported on them.
    pub held_out: &'a [Bench],
}

/// Refines the model by all benches.
///
/// # Errors
/// The model is of another level, a request is not understood, or no component is shown.
pub fn refine(benches: &[Bench], base: &VehicleModel, order: &Order<'_>) -> Result<Refined, NotRefined> {
    let Propulsion::Device(before) = base.propulsion else {
        return Err(NotRefined::Level(base.propulsion.level().name()));
    };
    let requests = order.forms.iter().map(|form| request(form)).collect::<Result<Vec<_>, _>>()?;
    let mut notes = Vec::new();
    let measured: Vec<Measured> = benches.iter().map(|bench| measure(bench, &mut notes)).collect();
    let unseen: Vec<Measured> = order.held_out.iter().map(|bench| measure(bench, &mut notes)).collect();
    let mut constants = Constants::new(&measured, &before);
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
        comparisons.push(comparison.with_unseen(&constants.points_of(component, &unseen)));
    }
    if comparisons.is_empty() {
        return Err(NotRefined::Nothing);
    }
    let mut device = with_measured(before, &constants.all, &comparisons);
    if let Some(inertia) = rotor_inertia(&device, &constants.all, &comparisons) {
        device.rotor_inertia_kg_m2 = inertia.value;
        constants.all.push(inertia);
    }
    let mut model = VehicleModel { propulsion: Propulsion::Device(device), ..base.clone() };
    notes.extend(hover_anew(&mut model));
    for key in model.drop_impossible_tolerances() {
        notes.push(format!("the tolerance of {key} is left out: the refined model can't have it"));
    }
    let checks = checks(&device, &order.given, base.gravity_m_s2);
    Ok(Refined { model, base: base.name.clone(), constants: constants.all, comparisons, checks, notes })
}

/// A file's steady readings and steps; what should be known of it goes to the notes.
fn measure(bench: &Bench, notes: &mut Vec<String>) -> Measured {
    let (steady, (steps, remarks)) = (bench.steady(), bench.steps());
    let all = bench.notes.iter().chain(&steady.notes).chain(&remarks);
    notes.extend(all.map(|note| format!("{}: {note}", bench.name)));
    Measured { steady, steps }
}

/// A vehicle in free flight needs the command that carries it.
fn hover_anew(model: &mut VehicleModel) -> Option<String> {
    let Mounting::Free { mass_kg } = model.mounting else { return None };
    let wanted_n = 0.25 * mass_kg * model.gravity_m_s2;
    if model.propulsion.lift_n(1.0) <= wanted_n {
        return Some("full command does not carry the vehicle: base_command is left as it was".to_owned());
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if model.propulsion.lift_n(middle) < wanted_n { low = middle } else { high = middle }
    }
    model.base_command = high;
    Some(format!("base_command is now {high:.4}: there four lifts equal the weight of {mass_kg} kg"))
}

/// The rotor's inertia by the lag with which the motor speeds up: the inverse of [`DevicePropulsion::lag_s`]. Its
/// interval is that of the lag and of the constants together, their half widths added as squares.
fn rotor_inertia(device: &DevicePropulsion, constants: &[Constant], comparisons: &[Comparison]) -> Option<Constant> {
    let lag = comparisons.iter().find(|of| of.component == Component::LagRising)?;
    let speeds = &lag.points.x;
    let speed_rad_s = speeds.iter().sum::<f64>() / speeds.len() as f64;
    let of_lag = constants.iter().find(|constant| constant.component == Component::LagRising)?;
    let lag_s = lag.of_model()?.fitted.value(speed_rad_s);
    let inertia = |device: &DevicePropulsion| {
        let total = device.motor_inertia_kg_m2 + device.rotor_inertia_kg_m2;
        lag_s * total / device.lag_s(speed_rad_s) - device.motor_inertia_kg_m2
    };
    let value = inertia(device);
    let half = |constant: &Constant| 0.5 * (constant.interval[1] - constant.interval[0]);
    let mut square = ((value + device.motor_inertia_kg_m2) * half(of_lag) / of_lag.value).powi(2);
    for constant in constants {
        let mut moved = *device;
        if let Some(place) = place(&mut moved, constant.key) {
            *place += half(constant);
            square += (inertia(&moved) - value).powi(2);
        }
    }
    (value > 0.0).then(|| Constant {
        component: Component::LagRising,
        key: ROTOR_INERTIA,
        form: of_lag.form,
        unit: "kg m^2",
        value,
        interval: [value - square.sqrt(), value + square.sqrt()],
        runs: Vec::new(),
        ..of_lag.clone()
    })
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

/// Where a constant stands in a model.
fn place<'a>(device: &'a mut DevicePropulsion, key: &str) -> Option<&'a mut f64> {
    match key {
        "resistance_ohm" => Some(&mut device.resistance_ohm),
        "inductance_h" => Some(&mut device.inductance_h),
        "speed_constant_rad_s_v" => Some(&mut device.speed_constant_rad_s_v),
        "speed_offset_rad_s" => Some(&mut device.speed_offset_rad_s),
        "loss_nm_s" => Some(&mut device.loss_nm_s),
        "lift_n_s2" => Some(&mut device.lift_n_s2),
        "reaction_torque_nm_s2" => Some(&mut device.reaction_torque_nm_s2),
        "drag_nm_s2" => Some(&mut device.drag_nm_s2),
        _ => None,
    }
}

/// The base's constants, replaced where they were measured.
fn with_measured(base: DevicePropulsion, constants: &[Constant], comparisons: &[Comparison]) -> DevicePropulsion {
    let mut device = base;
    for constant in constants {
        if let Some(place) = place(&mut device, constant.key) {
            *place = constant.value;
        }
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
