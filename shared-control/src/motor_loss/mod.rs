//! Loss of a motor: noticed from the gyro, the accelerometer and what the commands should lift, then flown with the
//! three motors that are left.
//!
//! ```text
//!   commands -> lag -> lifts ---.
//!   rates, specific force ------+-> detector -> suspected (reversible): the opposite motor relaxed, this one raised
//!                                           |-> weak (learnt, forgotten slowly): raised
//!                                           '-> lost (latched, names the motor): reduced attitude -> three motors
//! ```
//! Where a motor is lost only the thrust's axis is controlled, and the vehicle spins about it (Mueller and D'Andrea,
//! ICRA 2014: relaxed hover). `docs/motor-loss.md` has the equations, the assumptions and what was measured.

pub mod allocation;
pub mod complex;
pub mod detector;
pub mod reduced_attitude;
mod report;
pub mod spin_disturbance;
pub mod spin_frame;
pub mod spin_gains;
pub mod spin_rate;
mod unexplained;
pub mod weak_motors;

use nalgebra::Vector3;

use crate::elementary::{larger, limit, smaller};
use crate::lift_curve::LiftCurve;
use crate::mixer::MixResult;
use crate::record::state_words::StateWords;
use crate::signals::{AttitudeEstimate, MotorCommands};
use crate::vehicle::VehicleParameters;
use detector::{DetectorConfig, DetectorState, Suspicion};
pub use report::{MotorReport, Verdict};

use reduced_attitude::ReducedAttitude;
use spin_disturbance::SpinDisturbance;
use spin_rate::SpinRate;
use weak_motors::RAISED_SHARE_MAX;

/// What flies with three motors, made once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLossConfig {
    /// Finds which motor it is.
    pub detector: DetectorConfig,
    /// The thrust's axis, yaw left free.
    pub control: ReducedAttitude,
    lift_curve: LiftCurve,
    rest: Rest,
}

/// How a motor goes on turning where it would better not lift at all: as slowly as on the ground, if it turns there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    command: f32,
    lift_n: f32,
}

impl Rest {
    /// Of motors that are told this much on the ground, by the whole curve of their lift and the part of it that is
    /// flown.
    pub fn new(ground_idle_command: f32, whole: &LiftCurve, flown: &LiftCurve) -> Self {
        let [least, ..] = flown.command_at;
        let command = if ground_idle_command > 0.0 { smaller(ground_idle_command, least) } else { least };
        Self { command, lift_n: whole.lift(command) }
    }
}

impl MotorLossConfig {
    /// For a vehicle in free flight and a loop; none on a rig, which holds the vehicle, and none without motors' lag
    /// that the design could be made for.
    pub fn new(vehicle: &VehicleParameters, rest: Rest, loop_rate_hz: f32) -> Option<Self> {
        if vehicle.yaw_locked {
            return None;
        }
        Some(Self {
            detector: DetectorConfig::new(vehicle, loop_rate_hz),
            control: ReducedAttitude::new(vehicle, loop_rate_hz),
            lift_curve: vehicle.lift_curve,
            rest,
        })
    }

    /// What a motor lifts by a command, N.
    fn lift_n(&self, command: f32) -> f32 {
        let [least, ..] = self.lift_curve.command_at;
        if command >= least {
            self.lift_curve.lift(command)
        } else if command > 0.0 {
            self.rest.lift_n
        } else {
            0.0
        }
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
    /// Share of its lift that the motor lacks which the stage is about, 0 to 1.
    lacks_share: f32,
    /// Lift that the suspected motor makes beyond what the mixer asked of it, N, behind its lag.
    raised_n: f32,
    outside: SpinDisturbance,
    spin: SpinRate,
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
    /// Armed, in the air or not.
    pub armed: bool,
    /// Lift of each of four motors that is wanted, N.
    pub lift_per_motor_n: f32,
}

impl MotorLoss {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { detector, stage, lacks_share, raised_n, outside, spin } = self;
        detector.record(words);
        words.numbers(&[*lacks_share, *raised_n]);
        outside.record(words);
        spin.record(words);
        let (number, motor, lacking_n) = match stage {
            Stage::Whole => (0, 0, [0.0; 2]),
            Stage::Suspected(Suspicion { motor, missing_n, ahead_n }) => (1, *motor, [*missing_n, *ahead_n]),
            Stage::Lost(motor) => (2, *motor, [0.0; 2]),
        };
        words.word(number);
        words.word(motor as u32);
        words.numbers(&lacking_n);
    }

    /// How it stands.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// How fast a vehicle that has lost a motor turns about yaw by what its motors do, rad/s.
    pub fn spin_rad_s(&self) -> Option<f32> {
        self.stage.lost_motor().map(|_| self.spin.rad_s())
    }

    /// The same for link and log.
    pub fn report(&self) -> MotorReport {
        MotorReport::new(self.stage, self.lacks_share, self.detector.weak().weakest())
    }

    /// One step: judges what the last commands did, and changes what the mixer made for four motors where one of them
    /// fails. On the ground everything begins anew; which motor was lost is known until the next arming.
    pub fn fly(&mut self, config: &MotorLossConfig, felt: &Felt, mix: &mut MixResult) {
        if !felt.flies {
            let lost = self.stage.lost_motor().is_some() && !felt.armed;
            let (stage, lacks_share) = if lost { (self.stage, self.lacks_share) } else { Default::default() };
            *self = Self { stage, lacks_share, ..Self::default() };
            return;
        }
        if let Stage::Whole | Stage::Suspected(_) = self.stage {
            self.stage = self.detector.judge(&config.detector, felt.estimate, felt.force_m_s2);
            self.lacks_share = match self.stage {
                Stage::Whole => 0.0,
                Stage::Suspected(Suspicion { motor, .. }) | Stage::Lost(motor) => {
                    self.detector.lacks_share(&config.detector, motor)
                }
            };
            self.outside = config.control.begin(felt, self.detector.known_rad_s2());
            self.spin = SpinRate::at(felt.estimate.rate_body_rad_s.z);
            mix.commands.0 = self.detector.weak().made_up_for(&config.lift_curve, &mix.commands.0);
        }
        match self.stage {
            Stage::Whole => self.raised_n = 0.0,
            Stage::Suspected(suspicion) => self.balance(config, &suspicion, mix),
            Stage::Lost(motor) => {
                let lifts_n = self.detector.lifts_n();
                let yaw_rad_s2 = config.detector.yaw_rad_s2(&lifts_n);
                self.spin.update(config.detector.step_s, felt.estimate.rate_body_rad_s.z, yaw_rad_s2);
                let motors = (&config.lift_curve, config.rest.command);
                let commands = config.control.commands(felt, &mut self.outside, motor, &lifts_n, motors);
                *mix =
                    MixResult { commands: MotorCommands(commands), saturated: mix.saturated, ..MixResult::default() };
            }
        }
        let turning = mix.commands.0.map(|command| config.lift_n(command));
        self.detector.command(&config.detector, turning, self.stage.lost_motor());
    }

    /// The suspected motor is told to lift so much more that a part of one that is left makes up for the rest. Until
    /// its lag is over, and for good where nothing is left, the motor opposite lifts less instead: the two are
    /// balanced, and as the two of a diagonal turn alike, part of the yaw torque is, too.
    fn balance(&mut self, config: &MotorLossConfig, suspicion: &Suspicion, mix: &mut MixResult) {
        let curve = &config.lift_curve;
        let (own, opposite) = (suspicion.motor & 3, allocation::opposite(suspicion.motor));
        let lifting_n = larger(self.detector.lifts_n()[own], config.detector.judged_from_n());
        let share = limit(suspicion.missing_n / lifting_n, 0.0, RAISED_SHARE_MAX);
        let [own_n, opposite_n] = [own, opposite].map(|motor| curve.lift(mix.commands.0[motor]));
        let wanted_n = smaller(own_n / (1.0 - share), curve.lift_max_n) - own_n;
        let less_n = larger(suspicion.ahead_n - self.raised_n, 0.0);
        mix.commands.0[own] = curve.command(own_n + larger(wanted_n, 0.0));
        let rests = opposite_n - less_n < curve.lift_min_n;
        mix.commands.0[opposite] = if rests { config.rest.command } else { curve.command(opposite_n - less_n) };
        self.raised_n = config.detector.lagged_n(self.raised_n, larger(wanted_n, 0.0));
    }
}

#[cfg(test)]
mod tests;
