//! Which motor lifts less than its command says.
//!
//! Where motor i lacks a lift x, three readings say the same number: the angular accelerations about roll and pitch,
//! each by the lever with the signs of the motor's place, and the specific force along z. A gust's torque is felt
//! without the force, and only by chance along one motor's arm. So each motor's hypothesis is as good as its worst
//! witness:
//!
//! ```text
//!   missing_i = min( -s_roll,i a_roll J_roll / h,  -s_pitch,i a_pitch J_pitch / h,  m a_z )
//! ```
//! with a the accelerations that the motors' lifts don't explain, by low-passes of [`FAST_S`] for the suspicion (which
//! asks the first two alone) and [`SLOW_S`] for the verdict, less what was there all along (a low-pass of
//! [`KNOWN_S`]: an offset of the centre of gravity, a steady wind, a weaker propeller). It is compared with the lift
//! that the motor should make, and with how far the four differ: what is wrong in the model shows in proportion; and
//! with how far off the model has been of late (a mean of the unexplained over [`DOUBT_S`]): on other people's vehicles
//! that is most of what looks like a lost motor (docs/motor-loss.md, "On real logs"). What all three agree on while a
//! motor is suspected is learnt as its own ([`super::weak_motors`]).

use nalgebra::Vector3;

use super::Stage;
use super::allocation::opposite;
use super::unexplained::Unexplained;
use super::weak_motors::WeakMotors;
use crate::airframe::TORQUE_SIGNS;
use crate::elementary::{larger, limit, smaller};
use crate::lagged_axis::LagStep;
use crate::record::state_words::StateWords;
use crate::signals::AttitudeEstimate;
use crate::vehicle::VehicleParameters;

/// Low-pass of what raises a suspicion, s.
pub const FAST_S: f32 = 0.008;
/// Low-pass of what a verdict is made of, s.
pub const SLOW_S: f32 = 0.02;
/// Low-pass of what is taken for known, s.
pub const KNOWN_S: f32 = 0.3;
/// While a motor is suspected what is learnt takes so many times as long.
const SUSPECTED_TIMES: f32 = 4.0;
/// Low-pass of the mass as the accelerometer shows it, s.
const MASS_S: f32 = 2.0;
/// How wrong the model has been is a mean over so long, s.
pub const DOUBT_S: f32 = 2.0;
/// So many times that mean is added to what a motor must lack.
const DOUBTS: f32 = 1.0;
/// So many times that of yaw must speak against a loss: a rotor's own inertia turns the vehicle, and no model has it.
const DOUBTS_YAW: f32 = 3.0;
/// Share of its lift that a suspected motor lacks.
pub const SUSPECTED_SHARE: f32 = 0.12;
/// Or that it lacks, where it will lack the other when its lag is over.
const SUSPECTED_EARLY_SHARES: [f32; 2] = [0.05, 0.4];
/// Of a motor that was found to lift less, a suspicion lasts until it lacks no more than this share.
const SUSPECTED_UNTIL_SHARE: f32 = 0.03;
/// Share of its lift that a lost motor lacks.
pub const LOST_SHARE: f32 = 0.42;
/// Share that it will lack when its lag is over.
pub const LOST_AHEAD_SHARE: f32 = 0.6;
/// The same for the specific force along z, the noisiest witness.
const LOST_FORCE_SHARE: f32 = 0.3;
/// Of the difference between the largest and the smallest of the four lifts, what a model's error may make.
const DIFFERENCE_SHARE: f32 = 0.15;
/// Steps in a row that a verdict takes: 5 ms at 400 Hz.
const VERDICT_S: f32 = 0.005;
/// A motor's lift is judged where it should be this share of the largest.
const JUDGED_SHARE: f32 = 0.08;
/// Time in flight after which it judges, s.
const SETTLES_S: f32 = 0.5;

/// Commands that are kept, the last and those that are under way: 30 ms of delay at 400 Hz, the most that the board's
/// parameters take.
const COMMANDS_KEPT: usize = 13;

/// What the detector needs to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectorConfig {
    pub(super) step_s: f32,
    delay_steps: usize,
    lag: LagStep,
    lag_s: f32,
    inertia_kg_m2: [f32; 3],
    /// Torque of a lift about roll, pitch and yaw, m.
    lever_m: [f32; 3],
    judged_from_n: f32,
    verdict_steps: u8,
    settle_steps: u16,
}

/// A motor that seems to lift less than it should.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Suspicion {
    /// 0 to 3.
    pub motor: usize,
    /// Lift that it lacks, N.
    pub missing_n: f32,
    /// Lift that it will lack one lag of the motors on, N.
    pub ahead_n: f32,
}

/// What it remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DetectorState {
    /// Commanded lifts, the last first, and where the motors' lag has brought what has arrived of them, N.
    commanded_n: [[f32; 4]; COMMANDS_KEPT],
    lifts_n: [f32; 4],
    /// Of those lifts some motors make a part.
    weak: WeakMotors,
    fast: Unexplained,
    slow: Unexplained,
    known_rad_s2: [f32; 3],
    /// Specific force along z that the lifts don't explain, behind the slow low-pass and the known part, m/s^2.
    force_m_s2: f32,
    known_force_m_s2: f32,
    mass_kg: f32,
    /// How far the angular accelerations were off in the mean, beyond what is known, rad/s^2.
    doubt_rad_s2: [f32; 3],
    steps: u16,
    /// The motor that was suspected last.
    suspected: Option<usize>,
    /// The motor that the verdict is about, and for how many steps.
    accused: usize,
    accused_steps: u8,
}

impl DetectorConfig {
    /// For a vehicle and a loop.
    pub fn new(vehicle: &VehicleParameters, loop_rate_hz: f32) -> Self {
        let step_s = 1.0 / loop_rate_hz;
        Self {
            step_s,
            // to the nearest step: what is left over is at most half of one
            delay_steps: (vehicle.actuation.delay_s * loop_rate_hz + 0.5) as usize,
            lag: LagStep::new(step_s, vehicle.actuation.lag_s),
            lag_s: vehicle.actuation.lag_s,
            inertia_kg_m2: vehicle.inertia_kg_m2,
            lever_m: [vehicle.lever_m(), vehicle.lever_m(), vehicle.torque_per_lift_m],
            judged_from_n: JUDGED_SHARE * vehicle.lift_curve.lift_max_n,
            verdict_steps: (VERDICT_S * loop_rate_hz) as u8,
            settle_steps: (SETTLES_S * loop_rate_hz) as u16,
        }
    }

    /// Lift from which on a motor is judged, N.
    pub(super) fn judged_from_n(&self) -> f32 {
        self.judged_from_n
    }

    /// Angular acceleration of these lifts about yaw, rad/s^2.
    pub(super) fn yaw_rad_s2(&self, lifts_n: &[f32; 4]) -> f32 {
        let [.., sign] = TORQUE_SIGNS;
        let lift_n: f32 = sign.iter().zip(lifts_n).map(|(sign, lift_n)| sign * lift_n).sum();
        self.lever_m[2] * lift_n / self.inertia_kg_m2[2]
    }

    /// A lift one step later, N, on its way to the wanted one.
    pub(super) fn lagged_n(&self, lift_n: f32, wanted_n: f32) -> f32 {
        wanted_n + self.lag.kept * (lift_n - wanted_n)
    }

    /// Angular acceleration of these lifts on a body that turns, rad/s^2.
    fn by_motors_rad_s2(&self, lifts_n: &[f32; 4], rate: &Vector3<f32>) -> [f32; 3] {
        let [ix, iy, iz] = self.inertia_kg_m2;
        let gyroscopic_nm = [(iy - iz) * rate.y * rate.z, (iz - ix) * rate.z * rate.x, (ix - iy) * rate.x * rate.y];
        core::array::from_fn(|axis| {
            let lift_n: f32 = TORQUE_SIGNS[axis].iter().zip(lifts_n).map(|(sign, lift_n)| sign * lift_n).sum();
            (self.lever_m[axis] * lift_n + gyroscopic_nm[axis]) / self.inertia_kg_m2[axis]
        })
    }

    /// Lift that a motor lacks if it alone makes this acceleration about roll or pitch, N.
    fn missing_n(&self, axis: usize, motor: usize, rad_s2: f32) -> f32 {
        -TORQUE_SIGNS[axis & 1][motor & 3] * rad_s2 * self.inertia_kg_m2[axis & 1] / self.lever_m[axis & 1]
    }
}

impl DetectorState {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self {
            commanded_n,
            lifts_n,
            weak,
            fast,
            slow,
            known_rad_s2,
            force_m_s2,
            known_force_m_s2,
            mass_kg,
            doubt_rad_s2,
            steps,
            suspected,
            accused,
            accused_steps,
        } = self;
        words.row(commanded_n.as_flattened());
        words.numbers(lifts_n);
        weak.record(words);
        fast.record(words);
        slow.record(words);
        words.numbers(known_rad_s2);
        words.numbers(&[*force_m_s2, *known_force_m_s2, *mass_kg]);
        words.numbers(doubt_rad_s2);
        words.word(u32::from(*steps));
        words.word(suspected.map_or(4, |motor| motor as u32));
        words.word(*accused as u32);
        words.word(u32::from(*accused_steps));
    }

    /// Lifts of the motors that are left by their commands and their lag, N.
    pub fn lifts_n(&self) -> [f32; 4] {
        self.weak.lifted_n(&self.lifts_n)
    }

    /// Motors that were found to lift a part.
    pub fn weak(&self) -> &WeakMotors {
        &self.weak
    }

    /// Angular acceleration about roll and pitch that was there all along, rad/s^2.
    pub fn known_rad_s2(&self) -> [f32; 2] {
        let [roll, pitch, _] = self.known_rad_s2;
        [roll, pitch]
    }

    /// What the motors are to lift until the next step, N; one that is lost (1 to 4) lifts nothing.
    pub fn command(&mut self, config: &DetectorConfig, mut commanded_n: [f32; 4], lost_motor: Option<u8>) {
        if let Some(lost_n) = lost_motor.and_then(|motor| commanded_n.get_mut(usize::from(motor) - 1)) {
            *lost_n = 0.0;
        }
        // it begins in steady flight: no command is under way and no motor on its way
        let is_first = self.steps <= 1;
        self.commanded_n.rotate_right(1);
        let kept = if is_first { COMMANDS_KEPT } else { 1 };
        self.commanded_n.iter_mut().take(kept).for_each(|under_way_n| *under_way_n = commanded_n);
        let arrived_n = self.commanded_n.get(config.delay_steps).or(self.commanded_n.last()).copied();
        let kept = if is_first { 0.0 } else { config.lag.kept };
        for (lift_n, arrived_n) in self.lifts_n.iter_mut().zip(arrived_n.unwrap_or(commanded_n)) {
            *lift_n = arrived_n + kept * (*lift_n - arrived_n);
        }
    }

    /// Takes what a step measured.
    pub fn judge(
        &mut self,
        config: &DetectorConfig,
        estimate: &AttitudeEstimate,
        force: Option<Vector3<f32>>,
    ) -> Stage {
        let rate = &estimate.rate_body_rad_s;
        if self.steps == 0 {
            *self = Self::default();
            (self.fast.predicted_rad_s, self.slow.predicted_rad_s) = ((*rate).into(), (*rate).into());
        }
        let lifts_n = self.lifts_n();
        let by_motors = config.by_motors_rad_s2(&lifts_n, rate);
        self.fast.update(FAST_S, config.step_s, (rate, &by_motors), &lifts_n);
        self.slow.update(SLOW_S, config.step_s, (rate, &by_motors), &lifts_n);
        if let Some(force_m_s2) = force {
            self.weigh(config, force_m_s2.z, &lifts_n);
        }
        self.steps = self.steps.saturating_add(1);
        let suspicion = self.suspect(config);
        self.suspected = suspicion.map(|suspicion| suspicion.motor);
        self.learn(config);
        if self.steps < config.settle_steps {
            return Stage::Whole;
        }
        self.learn_weak(config, suspicion.as_ref(), &lifts_n);
        let accused = (0..4).find(|&motor| self.lacks_most(config, motor));
        let again = accused == Some(self.accused);
        self.accused_steps = if accused.is_none() || !again { 0 } else { self.accused_steps.saturating_add(1) };
        self.accused = accused.unwrap_or(self.accused);
        match (accused, suspicion) {
            (Some(motor), _) if self.accused_steps >= config.verdict_steps => {
                let missing_n = self.missing_n(config, &self.fast, motor, 0.0);
                self.lifts_n = self.lifts_n();
                self.weak = WeakMotors::default();
                if let Some(lift_n) = self.lifts_n.get_mut(motor) {
                    *lift_n = larger(*lift_n - missing_n, 0.0);
                }
                Stage::Lost(motor)
            }
            (_, Some(suspicion)) => Stage::Suspected(suspicion),
            (_, None) => Stage::Whole,
        }
    }

    /// The specific force along z, and the mass that it shows.
    fn weigh(&mut self, config: &DetectorConfig, force_z_m_s2: f32, lifts_n: &[f32; 4]) {
        let lift_n: f32 = lifts_n.iter().sum();
        if lift_n > 4.0 * config.judged_from_n && force_z_m_s2 < -1.0 {
            let mass_kg = -lift_n / force_z_m_s2;
            // a mean of all until then, so that a first step that is far off weighs no more than others
            let share = larger(1.0 / (1.0 + f32::from(self.steps)), self.known_step_s(config) / MASS_S);
            self.mass_kg += share * (mass_kg - self.mass_kg);
        }
        if self.mass_kg > 0.0 {
            let unexplained_m_s2 = force_z_m_s2 + lift_n / self.mass_kg;
            self.force_m_s2 += config.step_s / SLOW_S * (unexplained_m_s2 - self.force_m_s2);
        }
    }

    /// A step of what is known, s: a short one while a motor is suspected, whose loss would pass for known.
    fn known_step_s(&self, config: &DetectorConfig) -> f32 {
        if self.suspected.is_some() { config.step_s / SUSPECTED_TIMES } else { config.step_s }
    }

    /// What stays is no news, and what comes and goes without a motor's loss is the model's error.
    fn learn(&mut self, config: &DetectorConfig) {
        let step_s = self.known_step_s(config);
        let (known, doubted) = (step_s / KNOWN_S, step_s / DOUBT_S);
        for axis in 0..3 {
            let off_rad_s2 = self.slow.rad_s2[axis] - self.known_rad_s2[axis];
            self.doubt_rad_s2[axis] += doubted * (off_rad_s2.abs() - self.doubt_rad_s2[axis]);
            self.known_rad_s2[axis] += known * off_rad_s2;
        }
        self.known_force_m_s2 += known * (self.force_m_s2 - self.known_force_m_s2);
    }

    /// What gyro and accelerometer agree that a suspected motor lacks is its own: a gust's torque has no force.
    fn learn_weak(&mut self, config: &DetectorConfig, suspicion: Option<&Suspicion>, lifts_n: &[f32; 4]) {
        let lacks = suspicion.map(|suspicion| {
            let lift_n = larger(lifts_n[suspicion.motor & 3], config.judged_from_n);
            let by_gyro_n = self.missing_n(config, &self.slow, suspicion.motor, 0.0);
            let missing_n = smaller(by_gyro_n, self.missing_by_force_n());
            (suspicion.motor, limit(missing_n / lift_n, 0.0, 1.0))
        });
        self.weak.learn(lacks, config.step_s);
    }

    /// Lift that a motor lacks by the gyro alone, N, and will lack so much later, s, at the rate at which that grows.
    fn missing_n(&self, config: &DetectorConfig, of: &Unexplained, motor: usize, later_s: f32) -> f32 {
        let [roll_n, pitch_n] = [0, 1].map(|axis| {
            let rad_s2 = of.rad_s2[axis] + later_s * of.rise_rad_s3[axis] - self.known_rad_s2[axis];
            config.missing_n(axis, motor, rad_s2)
        });
        smaller(roll_n, pitch_n)
    }

    /// Lift that all motors lack by the accelerometer, N.
    fn missing_by_force_n(&self) -> f32 {
        self.mass_kg * (self.force_m_s2 - self.known_force_m_s2)
    }

    /// Share of its lift that a motor lacks by the gyro and by what was learnt of it, 0 to 1.
    pub(super) fn lacks_share(&self, config: &DetectorConfig, motor: usize) -> f32 {
        let lift_n = larger(self.fast.lifts_n[motor & 3], config.judged_from_n);
        let news = limit(self.missing_n(config, &self.fast, motor, 0.0) / lift_n, 0.0, 1.0);
        1.0 - (1.0 - self.weak.lacks_share(motor)) * (1.0 - news)
    }

    /// What the model's errors may make of how far the four differ, and have made of late, N.
    fn allowance_n(&self, config: &DetectorConfig, of: &Unexplained) -> f32 {
        let [first, ..] = of.lifts_n;
        let low = of.lifts_n.iter().fold(first, |low, lift_n| smaller(low, *lift_n));
        let high = of.lifts_n.iter().fold(first, |high, lift_n| larger(high, *lift_n));
        let [roll_n, pitch_n] = [0, 1].map(|axis| config.missing_n(axis, 0, self.doubt_rad_s2[axis]).abs());
        // the lesser of both counts as missing, so the lesser doubt is the one that counts
        DIFFERENCE_SHARE * (high - low) + DOUBTS * smaller(roll_n, pitch_n)
    }

    fn suspect(&self, config: &DetectorConfig) -> Option<Suspicion> {
        let allowed_n = self.allowance_n(config, &self.fast);
        (0..4).find_map(|motor| {
            let missing_n = self.missing_n(config, &self.fast, motor, 0.0);
            let lift_n = larger(self.fast.lifts_n[motor & 3], config.judged_from_n);
            let ahead_n = larger(missing_n, self.missing_n(config, &self.fast, motor, config.lag_s));
            let lacks_share = |lacking_n: f32, share: f32| lacking_n > share * lift_n + allowed_n;
            let [early, then] = SUSPECTED_EARLY_SHARES;
            let still = self.suspected == Some(motor) && self.weak.is_weak(motor);
            let lacks = lacks_share(missing_n, SUSPECTED_SHARE)
                || lacks_share(missing_n, early) && lacks_share(ahead_n, then)
                || still && missing_n > SUSPECTED_UNTIL_SHARE * lift_n;
            let [missing_n, ahead_n] = [missing_n, ahead_n].map(|lacking_n| smaller(lacking_n, lift_n));
            lacks.then_some(Suspicion { motor, missing_n, ahead_n })
        })
    }

    /// All three witnesses say that a motor lacks nearly half of its lift and will lack more, and the yaw torque does
    /// not say otherwise.
    fn lacks_most(&self, config: &DetectorConfig, motor: usize) -> bool {
        // what was learnt to be missing is missing
        let believed_n = self.slow.lifts_n[motor & 3];
        let learnt_n = self.weak.lacks_n(motor, believed_n);
        let lift_n = believed_n + learnt_n;
        let missing_n = learnt_n + self.missing_n(config, &self.slow, motor, 0.0);
        let ahead_n = learnt_n + self.missing_n(config, &self.slow, motor, config.lag_s);
        let force_n = learnt_n + self.missing_by_force_n();
        let yaw_rad_s2 = self.slow.rad_s2[2] - self.known_rad_s2[2];
        let allowed_n = self.allowance_n(config, &self.slow);
        lift_n > config.judged_from_n
            && missing_n > LOST_SHARE * lift_n + allowed_n
            && ahead_n > LOST_AHEAD_SHARE * lift_n + allowed_n
            && force_n > LOST_FORCE_SHARE * lift_n + allowed_n
            && TORQUE_SIGNS[2][motor & 3] * yaw_rad_s2 < DOUBTS_YAW * self.doubt_rad_s2[2]
            && missing_n > self.missing_n(config, &self.slow, opposite(motor), 0.0)
    }
}
