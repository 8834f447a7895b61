//! Loss of a motor: noticed from the gyro, the accelerometer and what the commands should lift, then flown with the
//! three motors that are left.
//!
//! ```text
//!   commands -> lag -> lifts ---.
//!   rates, specific force ------+-> detector -> suspected (reversible): the opposite motor relaxed
//!                                           '-> lost (latched, names the motor): reduced attitude -> three motors
//! ```
//! Where a motor is lost only the thrust's axis is controlled, and the vehicle spins about it (Mueller and D'Andrea,
//! ICRA 2014: relaxed hover). `docs/motor-loss.md` has the equations, the assumptions and what was measured.

pub mod allocation;
pub mod complex;
pub mod detector;
pub mod reduced_attitude;
pub mod spin_gains;

use nalgebra::Vector3;

use crate::elementary::larger;
use crate::lift_curve::LiftCurve;
use crate::mixer::MixResult;
use crate::record::state_words::StateWords;
use crate::signals::{AttitudeEstimate, MotorCommands};
use crate::vehicle::VehicleParameters;
use detector::{DetectorConfig, DetectorState, Suspicion};
use reduced_attitude::ReducedAttitude;

/// What flies with three motors, made once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLossConfig {
    /// Finds which motor it is.
    pub detector: DetectorConfig,
    /// The thrust's axis, yaw left free.
    pub control: ReducedAttitude,
    lift_curve: LiftCurve,
}

impl MotorLossConfig {
    /// For a vehicle in free flight and a loop; none on a rig, which holds the vehicle, and none without motors' lag
    /// that the design could be made for.
    pub fn new(vehicle: &VehicleParameters, loop_rate_hz: f32) -> Option<Self> {
        if vehicle.yaw_locked {
            return None;
        }
        Some(Self {
            detector: DetectorConfig::new(vehicle, loop_rate_hz),
            control: ReducedAttitude::new(vehicle),
            lift_curve: vehicle.lift_curve,
        })
    }
}

/// How far a loss is beyond doubt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Stage {
    /// All four lift what they should.
    #[default]
    Whole,
    /// One seems to lift less; it may be a gust, and what is done about it ends with it.
    Suspected(Suspicion),
    /// This one is lost (0 to 3), for good.
    Lost(usize),
}

impl Stage {
    /// Motor that is lost, 1 to 4.
    pub fn lost_motor(&self) -> Option<u8> {
        match self {
            Stage::Lost(motor) => Some(*motor as u8 + 1),
            Stage::Whole | Stage::Suspected(_) => None,
        }
    }
}

/// What is remembered of the motors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorLoss {
    detector: DetectorState,
    stage: Stage,
}

/// What a step knows.
#[derive(Clone, Copy, Debug)]
pub struct Felt<'a> {
    /// Attitude and rates.
    pub estimate: &'a AttitudeEstimate,
    /// Mean specific force, body, m/s^2; none where no sample came.
    pub force_m_s2: Option<Vector3<f32>>,
    /// In the air, armed, and seen by an IMU that works.
    pub flies: bool,
    /// Lift of each of four motors that is wanted, N.
    pub lift_per_motor_n: f32,
}

impl MotorLoss {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { detector, stage } = self;
        detector.record(words);
        let (number, motor, missing_n) = match stage {
            Stage::Whole => (0, 0, 0.0),
            Stage::Suspected(Suspicion { motor, missing_n }) => (1, *motor, *missing_n),
            Stage::Lost(motor) => (2, *motor, 0.0),
        };
        words.word(number);
        words.word(motor as u32);
        words.number(missing_n);
    }

    /// How it stands.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// One step: judges what the last commands did, and changes what the mixer made for four motors where one of them
    /// fails. On the ground and disarmed everything begins anew.
    pub fn fly(&mut self, config: &MotorLossConfig, felt: &Felt, mix: &mut MixResult) {
        if !felt.flies {
            *self = Self::default();
            return;
        }
        if let Stage::Whole | Stage::Suspected(_) = self.stage {
            self.stage = self.detector.judge(&config.detector, felt.estimate, felt.force_m_s2);
        }
        match self.stage {
            Stage::Whole => {}
            Stage::Suspected(suspicion) => relax_opposite(config, &suspicion, mix),
            Stage::Lost(motor) => {
                let lifts_n = self.detector.lifts_n();
                let commands = config.control.commands(felt, motor, &lifts_n, &config.lift_curve);
                *mix =
                    MixResult { commands: MotorCommands(commands), saturated: mix.saturated, ..MixResult::default() };
            }
        }
        let turning = mix.commands.0.map(|command| config.lift_curve.lift(command));
        self.detector.command(&config.detector, turning, self.stage.lost_motor());
    }
}

/// The motor opposite to the suspected one lifts as much less as that seems to, so that the two are balanced again;
/// the two of a diagonal turn alike, and so it takes part of the yaw torque as well.
fn relax_opposite(config: &MotorLossConfig, suspicion: &Suspicion, mix: &mut MixResult) {
    let opposite = allocation::opposite(suspicion.motor);
    if let Some(command) = mix.commands.0.get_mut(opposite) {
        let lift_n = config.lift_curve.lift(*command) - suspicion.missing_n;
        *command = config.lift_curve.command(larger(lift_n, config.lift_curve.lift_min_n));
    }
}

#[cfg(test)]
mod tests;
