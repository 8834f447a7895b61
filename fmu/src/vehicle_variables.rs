//! Which variables a vehicle has, and what each of them is.

use sil_host::model::{Rig, VehicleModel};
use sil_host::plant::{Plant, Truth};

use crate::variable::{AXES, Value, Variable};

/// Samples of the IMU that are handed over, the newest first.
pub(crate) const SAMPLES: usize = 3;

/// Parameters.
#[derive(Clone)]
pub(crate) struct Choices {
    pub(crate) effects: String,
    pub(crate) seed: u64,
    pub(crate) imu_rate_hz: u64,
    pub(crate) released_at_s: f64,
}

/// What a variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Effects,
    Seed,
    ImuRate,
    Release,
    Command(usize),
    Torque(usize),
    Force(usize),
    State(usize),
    Derivative(usize),
    Angle(usize),
    Rate(usize),
    SpecificForce(usize),
    Lift(usize),
    Height,
    Battery,
    Gyro(usize, usize),
    Accelerometer(usize, usize),
}

impl Place {
    /// What it is of a motion; not a number where it is no part of one.
    pub(crate) fn of(self, truth: &Truth) -> f64 {
        match self {
            Self::Angle(axis) => [truth.roll_rad, truth.pitch_rad, truth.yaw_rad][axis],
            Self::Rate(axis) => truth.rate_body_rad_s[axis],
            Self::SpecificForce(axis) => truth.specific_force_body_m_s2[axis],
            Self::Lift(motor) => truth.lift_n[motor],
            Self::Height => truth.height_m,
            _ => f64::NAN,
        }
    }
}

const ANGLES: [&str; 3] = ["roll", "pitch", "yaw"];

type Entry = (Place, Variable);

/// All of a vehicle's variables: parameters, inputs, states, outputs, derivatives.
pub(crate) fn places(plant: &Plant, model: &VehicleModel, has_imu: bool, choices: &Choices) -> Vec<Entry> {
    let mut entries = parameters(has_imu, choices);
    entries.extend(inputs(model));
    let first_state = entries.len();
    let (names, body) = (plant.state_names(), plant.body_state_names().len());
    let starts = plant.states();
    for (place, state) in names.iter().enumerate() {
        entries.push((Place::State(place), Variable::state(state, starts[place], place >= body)));
    }
    entries.extend(outputs(model, |name| names.iter().any(|state| state.name == name)));
    if has_imu {
        entries.extend(samples());
    } else {
        for (place, state) in names.iter().enumerate() {
            entries.push((Place::Derivative(place), Variable::derivative(state, first_state + place)));
        }
    }
    entries
}

fn parameters(has_imu: bool, choices: &Choices) -> Vec<Entry> {
    let effects = Variable::parameter(
        "effects",
        "",
        "effects that the model has not, as in docs/effects.md, several with ; between them",
        Value::Text(choices.effects.clone()),
    );
    let mut entries = vec![(Place::Effects, effects)];
    if has_imu {
        let seed = "seed of the IMU's noise";
        entries.push((Place::Seed, Variable::parameter("seed", "", seed, Value::Count(choices.seed))));
        let rate = "samples of the IMU per second";
        let start = Value::Count(choices.imu_rate_hz);
        entries.push((Place::ImuRate, Variable::parameter("imu_rate_hz", "", rate, start)));
        let release = "until then the vehicle is held where it is, level and still for the IMU";
        let start = Value::Float(choices.released_at_s);
        entries.push((Place::Release, Variable::parameter("released_at_s", "s", release, start)));
    }
    entries
}

fn inputs(model: &VehicleModel) -> Vec<Entry> {
    let command = |motor: usize| {
        let what = format!("command to motor {}, 0 to 1; clamped, and not a number counts as 0", motor + 1);
        let command = Variable::input(format!("motor{}_command", motor + 1), "", &what, model.base_command);
        (Place::Command(motor), command.discrete())
    };
    let torque = |axis: usize| {
        let what = format!("torque from outside about the body's {} axis", AXES[axis]);
        let name = format!("disturbance_torque_body_{}_nm", AXES[axis]);
        (Place::Torque(axis), Variable::input(name, "N.m", &what, 0.0))
    };
    let force = |axis: usize| {
        let what = format!("force from outside along the body's {} axis", AXES[axis]);
        let name = format!("disturbance_force_body_{}_n", AXES[axis]);
        (Place::Force(axis), Variable::input(name, "N", &what, 0.0))
    };
    let mut entries: Vec<Entry> = (0..4).map(command).chain((0..3).map(torque)).collect();
    if model.rig() == Rig::Free {
        entries.extend((0..3).map(force));
    }
    entries
}

/// Those that are no states.
fn outputs(model: &VehicleModel, is_state: impl Fn(&str) -> bool) -> Vec<Entry> {
    let mut entries = Vec::new();
    for (axis, angle) in ANGLES.into_iter().enumerate() {
        let output = Variable::output(format!("{angle}_rad"), "rad", &format!("{angle} (Euler Z-Y-X)"));
        entries.push((Place::Angle(axis), output));
    }
    for (axis, letter) in AXES.into_iter().enumerate() {
        let what = format!("body rate about {letter}, as an ideal gyro reads it");
        entries.push((Place::Rate(axis), Variable::output(format!("rate_body_{letter}_rad_s"), "rad/s", &what)));
    }
    for (axis, letter) in AXES.into_iter().enumerate() {
        let what = format!("specific force along body {letter}, as an ideal accelerometer reads it");
        let output = Variable::output(format!("specific_force_body_{letter}_m_s2"), "m/s2", &what);
        entries.push((Place::SpecificForce(axis), output));
    }
    for motor in 0..4 {
        let what = format!("lift of motor {}", motor + 1);
        entries.push((Place::Lift(motor), Variable::output(format!("motor{}_lift_n", motor + 1), "N", &what)));
    }
    if model.rig() == Rig::Free {
        let what = "height of the rotors above the ground";
        entries.push((Place::Height, Variable::output("height_m".into(), "m", what)));
    }
    entries.push((Place::Battery, Variable::output("battery_v".into(), "V", "voltage of the battery")));
    entries.retain(|(_, variable)| !is_state(&variable.name));
    entries
}

/// The IMU's, the newest first.
fn samples() -> Vec<Entry> {
    let mut entries = Vec::new();
    for sample in 0..SAMPLES {
        for (axis, [gyro, accelerometer]) in sample_names(sample).into_iter().enumerate() {
            let which = which_sample(sample);
            let rate = Variable::output(gyro, "rad/s", &format!("gyro, {which}"));
            let force = Variable::output(accelerometer, "m/s2", &format!("accelerometer, {which}"));
            entries.push((Place::Gyro(sample, axis), rate.discrete()));
            entries.push((Place::Accelerometer(sample, axis), force.discrete()));
        }
    }
    entries
}

/// By axis: gyro and accelerometer of a sample. The controller's inputs have the same.
pub(crate) fn sample_names(sample: usize) -> [[String; 2]; 3] {
    AXES.map(|axis| {
        let of = |what: &str| format!("imu[{}].{what}", sample + 1);
        [of(&format!("rate_body_{axis}_rad_s")), of(&format!("specific_force_body_{axis}_m_s2"))]
    })
}

/// In words.
pub(crate) fn which_sample(sample: usize) -> &'static str {
    ["newest sample", "the sample before", "the one before that"][sample]
}
