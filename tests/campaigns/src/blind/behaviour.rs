//! What a vehicle does, by whatever names its causes are called: effects with their numbers, and what follows from all
//! of them together when level, at rest, in the middle of a log.

use std::collections::BTreeMap;

use sil_host::diagnosis::{Diagnosis, Estimate, Finding};
use sil_host::model::{Mounting, VehicleModel};

use super::hidden::label;

/// Lever of a motor about roll or pitch over the arm.
pub(super) const LEVER_SHARE: f64 = core::f64::consts::FRAC_1_SQRT_2;
/// Signs of the torque of the motors' lifts about (roll, pitch), of docs/rig.md.
const TORQUE_SIGNS: [[f64; 4]; 2] = [[-1.0, 1.0, 1.0, -1.0], [1.0, -1.0, 1.0, -1.0]];

/// An effect with its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Name in the catalogue.
    pub effect: String,
    /// Its axis, of those that have one.
    pub axis: Option<String>,
    /// Its motor, likewise.
    pub motor: Option<u8>,
    /// The rest.
    pub values: BTreeMap<String, Estimate>,
}

impl Named {
    /// Of an effect as `sil synth` takes it.
    ///
    /// # Panics
    /// If it is none.
    pub fn of_short(short: &str) -> Named {
        let (effect, rest) = short.split_once(':').expect("a name before a colon");
        let mut named = Named { effect: effect.to_owned(), axis: None, motor: None, values: BTreeMap::new() };
        for (key, value) in rest.split(',').filter_map(|pair| pair.split_once('=')) {
            match key {
                "axis" => named.axis = Some(value.to_owned()),
                "motor" => named.motor = value.parse().ok(),
                _ => {
                    let value = value.parse().expect("a number");
                    named.values.insert(key.to_owned(), Estimate { value, std: 0.0 });
                }
            }
        }
        named
    }

    /// Of a finding.
    pub fn of_finding(finding: &Finding) -> Named {
        Named::new(finding.effect, finding.axis, &finding.parameters)
    }

    fn new(effect: &str, axis: Option<&str>, parameters: &BTreeMap<&'static str, Estimate>) -> Named {
        Named {
            effect: effect.to_owned(),
            axis: axis.map(str::to_owned),
            motor: parameters.get("motor").map(|motor| motor.value.round() as u8),
            values: parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
        }
    }

    /// Everything that an answer has: the base model, and the findings beside it.
    pub fn of_answer(answer: &Diagnosis) -> Vec<Named> {
        let of_base = answer.base.iter().map(|term| Named::new(term.effect, term.axis, &term.parameters));
        let mut all: Vec<Named> = of_base.collect();
        for found in answer.findings.iter().map(Named::of_finding) {
            if !all.iter().any(|other| other.is_at(&found)) {
                all.push(found);
            }
        }
        all
    }

    /// True for the same effect at the same place.
    pub fn is_at(&self, other: &Named) -> bool {
        self.effect == other.effect && self.axis == other.axis && self.motor == other.motor
    }

    /// Name with axis or motor.
    pub fn label(&self) -> String {
        label(&self.effect, self.axis.as_deref(), self.motor)
    }

    fn value(&self, name: &str) -> f64 {
        self.values.get(name).map_or(0.0, |estimate| estimate.value)
    }
}

/// Figures of what a vehicle does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Figure {
    /// Time by which forces are late: lag and delay together, s.
    Late,
    /// Angular acceleration about roll or pitch per command, rad/s^2.
    Effectiveness(usize),
    /// Angular acceleration about roll or pitch under equal commands, rad/s^2.
    Trim(usize),
}

impl Figure {
    /// All of them.
    pub const ALL: [Figure; 5] =
        [Figure::Late, Figure::Effectiveness(0), Figure::Effectiveness(1), Figure::Trim(0), Figure::Trim(1)];

    /// Which errors matter to nobody: 1 ms; 1 %; what turns the vehicle by 0.4 degrees in half a second.
    pub fn negligible(self, truth: f64) -> f64 {
        match self {
            Figure::Late => 1e-3,
            Figure::Effectiveness(_) => 0.01 * truth.abs(),
            Figure::Trim(_) => 0.05,
        }
    }

    /// Of a vehicle with its effects, `half_s` after the start: half of the log, for what sets in during it.
    pub fn of(self, vehicle: &VehicleModel, effects: &[Named], half_s: f64) -> f64 {
        let sum = |effect: &str, name: &str| -> f64 {
            effects.iter().filter(|named| named.effect == effect).map(|named| named.value(name)).sum()
        };
        match self {
            Figure::Late => sum("motor_lag", "time_constant_s") + sum("actuation_delay", "delay_s"),
            Figure::Effectiveness(axis) => {
                let lift: f64 = lift_factors(effects, half_s).iter().sum();
                LEVER_SHARE * vehicle.arm_m * lift * slope_n(vehicle) / inertia(vehicle, effects, axis)
            }
            Figure::Trim(axis) => moment_nm(vehicle, effects, half_s, axis) / inertia(vehicle, effects, axis),
        }
    }

    /// The same with its uncertainty, as if the numbers' were independent.
    pub fn estimated(self, vehicle: &VehicleModel, effects: &[Named], half_s: f64) -> Estimate {
        let value = self.of(vehicle, effects, half_s);
        let mut variance = 0.0;
        for (place, named) in effects.iter().enumerate() {
            for (name, estimate) in &named.values {
                let mut moved = effects.to_vec();
                let to = Estimate { value: estimate.value + estimate.std, ..*estimate };
                moved[place].values.insert(name.clone(), to);
                variance += (self.of(vehicle, &moved, half_s) - value).powi(2);
            }
        }
        Estimate { value, std: variance.sqrt() }
    }
}

/// Nominal inertia about roll and pitch, level.
pub(super) fn inertia_kg_m2(vehicle: &VehicleModel) -> [f64; 2] {
    let [ixx, iyy, _] = vehicle.inertia_kg_m2;
    let ring = match vehicle.mounting {
        Mounting::Gimbal { ring_inertia_kg_m2 } => ring_inertia_kg_m2,
        Mounting::Free { .. } => 0.0,
    };
    [ixx, iyy + ring]
}

/// Lift per unit of command at the base command.
pub(super) fn slope_n(vehicle: &VehicleModel) -> f64 {
    const STEP: f64 = 1e-3;
    let lift_n = |command| vehicle.propulsion.lift_n(command);
    (lift_n(vehicle.base_command + STEP) - lift_n(vehicle.base_command - STEP)) / (2.0 * STEP)
}

/// True inertia about roll or pitch.
pub(super) fn inertia(vehicle: &VehicleModel, effects: &[Named], axis: usize) -> f64 {
    let scale =
        on_axis(effects, axis).filter(|named| named.effect == "inertia_error").map(|named| named.value("scale"));
    inertia_kg_m2(vehicle)[axis] * scale.product::<f64>()
}

fn on_axis(effects: &[Named], axis: usize) -> impl Iterator<Item = &Named> {
    effects.iter().filter(move |named| named.axis.as_deref() == Some(["roll", "pitch"][axis]))
}

/// Lift of each motor over the nominal one's.
fn lift_factors(effects: &[Named], half_s: f64) -> [f64; 4] {
    let mut factors = [1.0; 4];
    for named in effects {
        for (motor, factor) in (1..).zip(&mut factors) {
            *factor *= match named.effect.as_str() {
                "thrust_scale" => named.value("scale"),
                "weak_motor" if named.motor == Some(motor) => named.value("scale"),
                "battery_sag" => 1.0 - named.value("per_s") * half_s,
                _ => 1.0,
            };
        }
    }
    factors
}

/// Moment about roll or pitch under the base command, level and at rest; of what sets in during the log its mean.
fn moment_nm(vehicle: &VehicleModel, effects: &[Named], half_s: f64, axis: usize) -> f64 {
    let lift_n = vehicle.propulsion.lift_n(vehicle.base_command);
    let factors = lift_factors(effects, half_s);
    let unequal: f64 = TORQUE_SIGNS[axis].iter().zip(factors).map(|(sign, factor)| sign * factor * lift_n).sum();
    let beside = on_axis(effects, axis).map(|named| match named.effect.as_str() {
        "torque_bias" => named.value("torque_nm"),
        "cg_offset" => [1.0, -1.0][axis] * named.value("cos_moment_nm"),
        "spring" => named.value("stiffness_nm_rad") * named.value("rest_rad"),
        "step_disturbance" => named.value("torque_nm") * (1.0 - named.value("start_s") / (2.0 * half_s)),
        _ => 0.0,
    });
    LEVER_SHARE * vehicle.arm_m * unequal + beside.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sil_host::model::Rig;

    /// docs/rig.md at the command 0.5: lift of a motor, N, and its slope; the model file's inertias and arm.
    const LIFT_N: f64 = 1.317;
    const SLOPE_N: f64 = 1.86;
    const LEVER_M: f64 = 0.226 * core::f64::consts::FRAC_1_SQRT_2;
    const IXX_KG_M2: f64 = 0.0115118;

    fn figure(figure: Figure, shorts: &[&str]) -> f64 {
        let effects: Vec<Named> = shorts.iter().map(|short| Named::of_short(short)).collect();
        figure.of(&VehicleModel::nominal(Rig::Gimbal), &effects, 30.0)
    }

    #[test]
    fn figures_are_those_of_a_calculation_by_hand() {
        let late_s = figure(Figure::Late, &["motor_lag:time_constant_s=0.012", "actuation_delay:delay_s=0.004"]);
        assert!((late_s - 0.016).abs() < 1e-12);
        // motor 2 adds to roll; what it lacks of its lift acts against a moment that does so too
        let trimmed = ["torque_bias:axis=roll,torque_nm=0.05", "weak_motor:motor=2,scale=0.9"];
        let by_hand = (0.05 - 0.1 * LIFT_N * LEVER_M) / IXX_KG_M2;
        assert!((figure(Figure::Trim(0), &trimmed) - by_hand).abs() < 2e-3, "{by_hand}");
        // 3 % of the lift are gone in the middle of the log; roll's inertia is a tenth larger
        let heavy = ["battery_sag:per_s=0.001", "thrust_scale:scale=0.8", "inertia_error:axis=roll,scale=1.1"];
        let by_hand = 4.0 * 0.8 * 0.97 * SLOPE_N * LEVER_M / (1.1 * IXX_KG_M2);
        assert!((figure(Figure::Effectiveness(0), &heavy) / by_hand - 1.0).abs() < 3e-3, "{by_hand}");
    }

    #[test]
    fn a_figures_uncertainty_is_that_of_its_numbers() {
        let vehicle = VehicleModel::nominal(Rig::Gimbal);
        let mut effects =
            vec![Named::of_short("motor_lag:time_constant_s=0.01"), Named::of_short("actuation_delay:delay_s=0.004")];
        for (named, std) in effects.iter_mut().zip([3e-4, 4e-4]) {
            named.values.values_mut().for_each(|value| value.std = std);
        }
        let late = Figure::Late.estimated(&vehicle, &effects, 30.0);
        assert!((late.value - 0.014).abs() < 1e-12 && (late.std - 5e-4).abs() < 1e-12, "{late:?}");
    }
}
