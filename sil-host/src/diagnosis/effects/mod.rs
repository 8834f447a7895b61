//! The hypotheses: every effect of docs/effects.md as a small extension of the model, one file each, and the table of all.
//!
//! These are the diagnosis' own equations, apart from those of the simulated plant (`crate::effects`), so that a mistake
//! in one of them shows.

use crate::axis::Axis;
use crate::prediction::model::Model;

mod actuation_delay;
mod attitude_delay;
mod battery_sag;
mod cg_offset;
mod command_clipping;
mod coulomb_friction;
mod ground_effect;
mod gyro;
mod imu_misalignment;
mod inertia_coupling;
mod inertia_error;
pub(super) mod input_gain;
mod mass_error;
mod motor_lag;
mod periodic_disturbance;
mod rotor_drag;
mod spring;
mod step_disturbance;
mod thrust_scale;
mod torque_bias;
mod viscous_friction;
mod weak_motor;
mod wind;

pub(crate) use coulomb_friction::SOFTENING_RAD_S;

/// Where an effect is at home (docs/commands.md).
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// Rig and body.
    Plant,
    /// From command to force.
    Actuator,
    /// What the log shows of the truth.
    Sensor,
    /// What was commanded.
    Controller,
    /// From outside.
    Environment,
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name in docs/effects.md.
    pub name: &'static str,
    /// Value that changes nothing.
    pub nominal: f64,
    /// Change for a difference quotient: small against any size that matters, large against rounding.
    pub step: f64,
    /// Least admissible value.
    pub min: f64,
    /// Greatest.
    pub max: f64,
}

/// What the log itself says about where to begin: some effects have parameters in which the fit has many local optima.
#[derive(Clone, Debug, Default)]
pub struct Hints {
    /// Per axis, the frequency of the strongest periodic moment, Hz.
    pub frequency_hz: [Option<f64>; 3],
    /// Per axis, when a moment most probably set in, s: where there was none before, and where there was.
    pub step_start_s: [Vec<f64>; 3],
    /// Low and high quantiles of all commands (2 %, 98 %).
    pub command_range: [f64; 2],
    /// Last time of the log, s.
    pub end_s: f64,
}

/// A hypothesis.
pub(super) trait Effect: Sync + Send {
    /// Name in docs/effects.md.
    fn name(&self) -> &'static str;
    /// Where it is at home.
    fn place(&self) -> Place;
    /// The axis, of effects that have one.
    fn axis(&self) -> Option<Axis> {
        None
    }
    /// The motor, 1 to 4, of effects that have one.
    fn motor(&self) -> Option<u8> {
        None
    }
    /// Its parameters.
    fn parameters(&self) -> &'static [Parameter];
    /// Values at which fits begin.
    fn starts(&self, hints: &Hints) -> Vec<Vec<f64>> {
        let _ = hints;
        vec![self.parameters().iter().map(|parameter| parameter.nominal).collect()]
    }
    /// Puts it into a model.
    fn apply(&self, values: &[f64], model: &mut Model);
    /// The values by their names in docs/effects.md, where the fit takes others than those.
    fn told(&self, values: &[f64]) -> Vec<(&'static str, f64)> {
        self.parameters().iter().zip(values).map(|(parameter, value)| (parameter.name, *value)).collect()
    }
    /// The way back: the fit's values of what is told by name; what is not told is nominal.
    fn values_of(&self, told: &dyn Fn(&str) -> Option<f64>) -> Vec<f64> {
        self.parameters().iter().map(|parameter| told(parameter.name).unwrap_or(parameter.nominal)).collect()
    }
    /// The names of what is told, in order.
    fn told_names(&self) -> Vec<&'static str> {
        let any: Vec<f64> = self.parameters().iter().map(|parameter| parameter.nominal).collect();
        self.told(&any).into_iter().map(|(name, _)| name).collect()
    }
    /// What it is, for a person.
    fn in_words(&self) -> &'static str;
}

/// The name of a parameter where all is per unit of inertia, on separate axes (docs/log-format.md).
pub(super) fn per_unit_inertia(name: &'static str) -> &'static str {
    match name {
        "torque_nm" => "torque_rad_s2",
        "cos_moment_nm" => "cos_moment_rad_s2",
        "sin_moment_nm" => "sin_moment_rad_s2",
        "amplitude_nm" => "amplitude_rad_s2",
        "stiffness_nm_rad" => "stiffness_1_s2",
        "coefficient_nms" => "coefficient_1_s",
        other => other,
    }
}

/// What a log and a rig can speak about.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scope {
    /// Axes with an angle or a rate in the log.
    pub(super) axes: [bool; 3],
    /// Axes with a measured rate.
    pub(super) rates: [bool; 3],
    /// Axes with a measured angle.
    pub(super) angles: [bool; 3],
    /// Axes that the rig lets turn.
    pub(super) turns: [bool; 3],
    /// True where four motors drive it.
    pub(super) motors: bool,
    /// True where the log has the battery's voltage.
    pub(super) battery: bool,
    /// True where roll and pitch belong to one body.
    pub(super) coupled: bool,
    /// True where a rig holds the vehicle, so that its angles show in the other axes though nobody measures them.
    pub(super) is_held: bool,
    /// True in free flight.
    pub(super) flies_free: bool,
    /// True where the log shows what pushes a free vehicle.
    pub(super) pushed: bool,
    /// True where it has a free vehicle's velocity.
    pub(super) velocity: bool,
    /// A free vehicle's height above ground in the first row, m.
    pub(super) height: Option<f64>,
}

impl Scope {
    /// A log that has everything.
    const WHOLE: Scope = Scope {
        axes: [true; 3],
        rates: [true; 3],
        angles: [true; 3],
        turns: [true; 3],
        motors: true,
        battery: true,
        coupled: true,
        is_held: true,
        flies_free: false,
        pushed: true,
        velocity: true,
        height: Some(0.0),
    };
}

/// Puts an effect that a vehicle model already has into a model of it. Those that turn nothing leave it as it is.
pub(super) fn apply_known(known: &crate::effects::Effect, model: &mut Model) {
    let parameters = known.parameters();
    let told = |name: &str| parameters.iter().find(|(own, _)| *own == name).map(|(_, value)| *value);
    let motor = told("motor").map(|motor| motor as u8);
    let is_it = |effect: &dyn Effect| {
        let has_parameter = effect.told_names().first().is_some_and(|name| told(name).is_some());
        effect.name() == known.entry().name && effect.axis() == known.axis() && effect.motor() == motor && has_parameter
    };
    if let Some(effect) = catalogue(&Scope::WHOLE).iter().find(|effect| is_it(effect.as_ref())) {
        effect.apply(&effect.values_of(&told), model);
    }
}

/// All hypotheses that a log can be asked about.
pub(super) fn catalogue(scope: &Scope) -> Vec<Box<dyn Effect>> {
    let mut table: Vec<Box<dyn Effect>> = Vec::new();
    for axis in Axis::ALL {
        let i = axis.index();
        if scope.turns[i] && scope.axes[i] {
            if axis != Axis::Yaw {
                table.push(Box::new(cg_offset::CgOffset { axis, flies_free: scope.flies_free }));
            }
            table.push(Box::new(torque_bias::TorqueBias(axis)));
            table.push(Box::new(viscous_friction::ViscousFriction(axis)));
            table.push(Box::new(coulomb_friction::CoulombFriction(axis)));
            if axis != Axis::Yaw && (scope.angles[i] || scope.is_held) {
                table.push(Box::new(spring::Spring(axis)));
            }
            if scope.motors {
                table.push(Box::new(inertia_error::InertiaError(axis)));
            }
            table.push(Box::new(periodic_disturbance::PeriodicDisturbance(axis)));
            table.push(Box::new(step_disturbance::StepDisturbance(axis)));
        }
        // with nothing to hold it against a gyro is right: a bias changes nothing, a scale is an inertia's
        if scope.rates[i] && (scope.angles[i] || scope.is_held) {
            table.push(Box::new(gyro::GyroBias(axis)));
            table.push(Box::new(gyro::GyroScale(axis)));
        }
    }
    if scope.coupled {
        table.push(Box::new(inertia_coupling::InertiaCoupling));
        table.push(Box::new(imu_misalignment::ImuMisalignment));
    }
    table.push(Box::new(motor_lag::MotorLag));
    table.push(Box::new(actuation_delay::ActuationDelay));
    table.push(Box::new(command_clipping::CommandClipping));
    if scope.motors {
        table.push(Box::new(thrust_scale::ThrustScale));
        table.extend((1..=4).map(|motor| Box::new(weak_motor::WeakMotor(motor)) as Box<dyn Effect>));
        table.push(Box::new(battery_sag::PerSecond));
        if scope.battery {
            table.push(Box::new(battery_sag::PerVolt));
        }
    }
    if scope.pushed {
        table.push(Box::new(mass_error::MassError));
    }
    if scope.velocity {
        table.push(Box::new(rotor_drag::RotorDrag));
        table.push(Box::new(wind::Wind));
    }
    if let Some(start_height_m) = scope.height {
        table.push(Box::new(ground_effect::GroundEffect { start_height_m }));
    }
    if (0..3).any(|i| scope.angles[i] && scope.rates[i]) {
        table.push(Box::new(attitude_delay::AttitudeDelay));
    }
    table
}
