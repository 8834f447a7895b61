//! What of a fit becomes a number of the model itself, and what stays beside it as an effect.

use super::start::YAW_SHARE;
use crate::axis::Axis;
use crate::diagnosis::fitted::Fitted;
use crate::diagnosis::fitting::fit::Term;
use crate::model::{Mounting, VehicleModel};
use crate::vehicle::propulsion::Propulsion;

/// Is an effect nothing but another value of one of the model's numbers?
pub(super) fn is_own(effect: &Fitted) -> bool {
    matches!(effect.name(), "inertia_error" | "mass_error" | "reaction_torque")
}

fn value_of(terms: &[Term<'_>], name: &str, axis: Option<Axis>) -> Option<f64> {
    let term = terms.iter().find(|term| term.effect.name() == name && term.effect.axis() == axis);
    term.and_then(|term| term.values.first().copied())
}

/// True mass over the model's: with the mass held, forces and moments are that much smaller.
pub(super) fn model_mass(terms: &[Term<'_>]) -> f64 {
    value_of(terms, "mass_error", None).unwrap_or(1.0)
}

/// Mean lift of the motors over the model's.
pub(super) fn mean_lift(terms: &[Term<'_>]) -> f64 {
    let motors: Vec<f64> =
        terms.iter().filter(|term| term.effect.name() == "weak_motor").map(|t| t.values[0]).collect();
    if motors.is_empty() { 1.0 } else { motors.iter().sum::<f64>() / motors.len() as f64 }
}

/// A term as it is once the motors' mean lift is the model's.
pub(super) fn even<'e>(term: &Term<'e>, all: &[Term<'e>]) -> Term<'e> {
    let mut even = term.clone();
    if term.effect.name() == "weak_motor" {
        even.values[0] /= mean_lift(all);
    }
    even
}

/// Moments beside a mass that is held where it was.
pub(super) fn in_unit_of<'e>(mass: f64, mut terms: Vec<Term<'e>>) -> Vec<Term<'e>> {
    let is_moment = |term: &&mut Term<'e>| matches!(term.effect.name(), "torque_bias" | "speed_stability");
    for term in terms.iter_mut().filter(is_moment) {
        term.values[0] /= mass;
    }
    terms
}

/// The model with inertias, lift and reaction torque as fitted: it then moves as the fitted one does, its mass as
/// before.
pub(super) fn folded(model: &VehicleModel, terms: &[Term<'_>]) -> VehicleModel {
    let inertia = |axis: Axis| value_of(terms, "inertia_error", Some(axis)).unwrap_or(1.0);
    let (mass, lift) = (model_mass(terms), mean_lift(terms));
    let [ixx, iyy, izz] = model.inertia_kg_m2;
    let (new_ixx, new_iyy) = (ixx * inertia(Axis::Roll) / mass, iyy * inertia(Axis::Pitch) / mass);
    // a flat plate has the most inertia about yaw, a rod along one axis the least
    let fitted_izz = izz * inertia(Axis::Yaw) / mass;
    let new_izz = fitted_izz.clamp((new_ixx - new_iyy).abs(), new_ixx + new_iyy);
    let mut folded = VehicleModel { inertia_kg_m2: [new_ixx, new_iyy, new_izz], ..model.clone() };
    if let (Propulsion::Box(motor), Mounting::Free { .. }) = (&mut folded.propulsion, model.mounting) {
        *motor = motor.with_offset(value_of(terms, "lift_offset", None).unwrap_or_default(), model.base_command);
        motor.lift_offset_n *= lift / mass;
        motor.lift_slope_n *= lift / mass;
        motor.reaction_torque_per_lift_m *=
            value_of(terms, "reaction_torque", None).unwrap_or(1.0) * new_izz / fitted_izz;
    }
    folded
}

/// The same with the assumed inertia about yaw, and as quick about it.
pub(super) fn with_assumed_yaw(mut model: VehicleModel) -> VehicleModel {
    let [ixx, iyy, izz] = model.inertia_kg_m2;
    let assumed = YAW_SHARE * (ixx + iyy);
    model.inertia_kg_m2[2] = assumed;
    if let Propulsion::Box(motor) = &mut model.propulsion {
        motor.reaction_torque_per_lift_m *= assumed / izz;
    }
    model
}
