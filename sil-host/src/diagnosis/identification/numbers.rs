//! What a fit says of a vehicle, in numbers that do not hang on the scale: accelerations per command, ratios, times.
//! Each is computed from the model; its deviation follows from those of the fit's own numbers.

use serde::Serialize;

use super::folding::mean_lift;
use crate::axis::Axis;
use crate::diagnosis::base;
use crate::diagnosis::estimate::Estimate;
use crate::diagnosis::fitting::fit::{Fit, Nominal, Term, model_of};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::diagnosis::lateness::held_std_s;
use crate::diagnosis::verdict::model_error;
use crate::model::VehicleModel;
use crate::prediction::model::Model;

/// A number of an identified vehicle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Identified {
    /// What it is: `roll_effectiveness`, `motor1_lift`, `motor_lag_s`, ...
    pub name: String,
    /// Its unit; empty for a ratio.
    pub unit: &'static str,
    /// Value and standard deviation.
    pub own: Estimate,
    /// What to fly to know it, where the logs do not show it; it is then where such vehicles usually are.
    pub to_fly: Option<&'static str>,
}

impl Identified {
    /// The interval that holds the truth in 95 of 100 logs, if the noise is what it was taken for.
    pub fn interval(&self) -> [f64; 2] {
        const QUANTILE: f64 = 1.96;
        [self.own.value - QUANTILE * self.own.std, self.own.value + QUANTILE * self.own.std]
    }

    /// Is it how roll or pitch answers to the motors, or to the commands of separate axes?
    pub fn is_of_tilt(&self) -> bool {
        let names = ["roll_effectiveness", "pitch_effectiveness", "roll_input_gain", "pitch_input_gain"];
        names.contains(&self.name.as_str())
    }
}

/// Manoeuvres for what the logs did not excite, each once.
pub fn manoeuvres_for(numbers: &[Identified]) -> Vec<&'static str> {
    let mut all: Vec<&'static str> = Vec::new();
    for to_fly in numbers.iter().filter_map(|number| number.to_fly) {
        if !all.contains(&to_fly) {
            all.push(to_fly);
        }
    }
    all
}

/// Lag and delay together, by their name.
pub(super) const LATENESS: &str = "lag_and_delay_s";

/// Share of what was known before the log from which on the log has shown nothing.
const UNSEEN: f64 = 0.7;
/// Relative deviation of an effectiveness from which on it is not known.
pub(super) const UNKNOWN_FROM: f64 = 0.2;

pub(super) const STEPS: [&str; 3] = [
    "fly steps of roll to 20 degrees to either side for 15 s",
    "fly steps of pitch to 20 degrees up and down for 15 s",
    "fly turns of the heading to either side, 60 degrees a second, for 15 s",
];
const CLIMBS: &str = "fly quick climbs and descents for 15 s";
const BOTH_AND_YAW: &str = "turn the heading while roll and pitch step to 20 degrees, for 30 s";
const FAST: &str = "fly forth and back, and to either side, at some metres a second, for 30 s";
const BOTH: &str = "fly steps of roll and pitch together, and climbs, for 30 s";

/// Angular accelerations about roll, pitch and yaw per unit of each motor's command around a command of all four,
/// rad/s^2: what one more percent of a motor does, a hundredfold.
pub fn effectiveness_rad_s2(model: &VehicleModel, command: f64) -> [[f64; 3]; 4] {
    Model::of(model).acceleration_per_command(&[command; 4])
}

/// All numbers of a fit around a command.
pub(super) fn of(
    fit: &Fit<'_>,
    shooting: &Shooting<'_>,
    nominal: Nominal<'_>,
    command: f64,
    seen: [bool; 3],
) -> Vec<Identified> {
    let values = |terms: &[Term<'_>]| derived(terms, &model_of(nominal, terms), command);
    let here = values(&fit.terms);
    let slopes = fit.slopes_of(|terms| values(terms).iter().map(|one| one.value).collect());
    let model_error = model_error(&shooting.log);
    let half_row_s = held_std_s(&shooting.log.commands);
    let finish = |(at, one): (usize, Derived)| {
        let slope: Vec<f64> = slopes.iter().map(|slopes| slopes[at]).collect();
        let late_s = if one.is_late { half_row_s } else { 0.0 };
        let own = model_error * one.value;
        let variance = fit.variance_along(&slope);
        let std = (variance.max(0.0) + late_s * late_s + own * own).sqrt();
        // a fit without a covariance knows nothing
        let std = if variance.is_finite() { std } else { f64::INFINITY };
        let own = Estimate { value: one.value, std };
        let is_unseen = match (one.of_axis, one.prior_std) {
            (Some(axis), _) => !seen[axis.index()] || std > UNKNOWN_FROM * one.value.abs(),
            (None, Some(prior)) => std > UNSEEN * prior,
            (None, None) => !std.is_finite(),
        };
        Identified { name: one.name, unit: one.unit, own, to_fly: is_unseen.then_some(one.to_fly) }
    };
    here.into_iter().enumerate().map(finish).collect()
}

/// A number without its deviation.
struct Derived {
    name: String,
    unit: &'static str,
    value: f64,
    prior_std: Option<f64>,
    of_axis: Option<Axis>,
    is_late: bool,
    to_fly: &'static str,
}

impl Derived {
    fn new(name: String, unit: &'static str, value: f64, to_fly: &'static str) -> Derived {
        Derived { name, unit, value, prior_std: None, of_axis: None, is_late: false, to_fly }
    }
}

fn derived(terms: &[Term<'_>], model: &Model, command: f64) -> Vec<Derived> {
    let by_motor = model.acceleration_per_command(&[command; 4]);
    let mean = |axis: Axis| 0.25 * by_motor.iter().map(|of| of[axis.index()].abs()).sum::<f64>();
    let mut all = Vec::new();
    for axis in Axis::ALL {
        let name = format!("{}_effectiveness", axis.name());
        let gain = Derived::new(name, "rad/s2 per motor command", mean(axis), STEPS[axis.index()]);
        all.push(Derived { of_axis: Some(axis), ..gain });
    }
    for (motor, of) in by_motor.iter().enumerate() {
        for axis in Axis::ALL {
            let name = format!("motor{}_{}", motor + 1, axis.name());
            all.push(Derived::new(name, "rad/s2 per motor command", of[axis.index()], STEPS[axis.index()]));
        }
    }
    let ratio = mean(Axis::Roll) / mean(Axis::Pitch);
    all.push(Derived::new("pitch_inertia_over_roll".to_owned(), "", ratio, BOTH));
    let lift = lift_per_mass(model, command);
    let slope = (lift_per_mass(model, command + 0.01) - lift_per_mass(model, command - 0.01)) / 0.02;
    all.push(Derived::new("hover_lift".to_owned(), "m/s2", lift, CLIMBS));
    all.push(Derived::new("lift_per_command".to_owned(), "m/s2 per command of all", slope, CLIMBS));
    all.extend(of_terms(terms, model));
    all
}

/// Specific force upward under one command of all motors, m/s^2.
fn lift_per_mass(model: &Model, command: f64) -> f64 {
    let lifts_n = model.settled_lifts(&[command; 4]);
    -model.body.felt_m_s2(&[0.0; crate::prediction::body::FLYING], &lifts_n, &model.changes.air)[2]
}

/// What the terms say themselves.
fn of_terms(terms: &[Term<'_>], model: &Model) -> Vec<Derived> {
    let mean = mean_lift(terms);
    let late: f64 = terms.iter().filter(|term| term.effect.is_late()).map(|term| term.values[0]).sum();
    let moments = model.acceleration_by_moments();
    let mut all = Vec::new();
    for term in terms {
        let (value, prior_std) = (term.values[0], term.effect.prior().map(|prior| prior.std));
        let axis = term.effect.axis();
        let of = |axis: Axis, what: &str| format!("{}_{what}", axis.name());
        let one = match (term.effect.name(), axis) {
            ("thrust_curve", _) => Derived::new("thrust_expo".to_owned(), "", value, CLIMBS),
            ("inertia_error", Some(Axis::Yaw)) => {
                Derived::new("yaw_inertia".to_owned(), "of the assumed", value, BOTH_AND_YAW)
            }
            ("lift_offset", _) => Derived::new("lift_at_no_command".to_owned(), "of hover's", value, CLIMBS),
            ("motor_lag", _) => Derived::new("motor_lag_s".to_owned(), "s", value, STEPS[0]),
            ("actuation_delay", _) => {
                Derived { is_late: true, ..Derived::new("delay_s".to_owned(), "s", value, STEPS[0]) }
            }
            ("weak_motor", _) => {
                let motor = term.effect.motor().unwrap_or_default();
                Derived::new(format!("motor{motor}_lift"), "of the mean", value / mean, BOTH)
            }
            ("torque_bias", Some(axis)) => Derived::new(of(axis, "trim"), "rad/s2", moments[axis.index()], ""),
            ("speed_stability", _) => {
                let name = "speed_stability".to_owned();
                let per_inertia = Derived::new(name, "rad/s2 per m/s", model.acceleration_per_airspeed(), FAST);
                all.push(Derived { prior_std: Some(base::BY_SPEED_STD), ..per_inertia });
                continue;
            }
            ("gyro_bias", Some(axis)) => Derived::new(of(axis, "gyro_bias"), "rad/s", value, ""),
            _ => continue,
        };
        all.push(Derived { prior_std, ..one });
    }
    let together = Derived::new(LATENESS.to_owned(), "s", late, STEPS[0]);
    all.push(Derived { is_late: true, ..together });
    all
}
