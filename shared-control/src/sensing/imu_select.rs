//! Two IMUs: which of them is flown with, and the attitude from it.
//!
//! Both are conditioned, judged and calibrated at rest all the time, each for itself. On the ground the first is used
//! if it is good, else the second if that is. While motors turn there is one way only: from the first, when it is bad,
//! to the second, if that is good and calibrated; never back, since a sensor that failed once has nothing to say for
//! itself.
//!
//! A fault takes a few samples to be found, and the attitude has followed the bad ones meanwhile. So from the first
//! sign of it on a second attitude is kept beside, which goes on from the last good one by the standby's gyro; at the
//! switch it becomes the attitude.

use nalgebra::{UnitQuaternion, Vector3};

use crate::elementary::magnitude;
use crate::record::state_words::StateWords;
use crate::sensing::estimator::{self, EstimatorConfig, EstimatorState, measured_down};
use crate::sensing::gyro_bias::GyroBias;
use crate::sensing::imu::{self, Flown, ImuConfig, ImuState, ImuStep};
use crate::sensing::imu_health::{ImuHealth, ImuHealthState};
use crate::sensing::levelling::Support;
use crate::signals::{AttitudeEstimate, RawImuSample, StepInput};

/// One of the IMUs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImuUnit {
    /// [`StepInput::imu`].
    #[default]
    First,
    /// [`StepInput::imu_second`].
    Second,
}

impl ImuUnit {
    /// Its number in a trace and in the words of a state.
    pub fn number(&self) -> u32 {
        match self {
            ImuUnit::First => 0,
            ImuUnit::Second => 1,
        }
    }
}

/// Conditioning of both, and the attitude from them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensingConfig {
    /// The first IMU.
    pub imu: ImuConfig,
    /// The second.
    pub imu_second: ImuConfig,
    /// Attitude from the one in use.
    pub estimator: EstimatorConfig,
}

/// What is remembered of one IMU.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct UnitState {
    conditioning: ImuState,
    health: ImuHealthState,
    gyro: GyroBias,
}

/// Share of a gyro's limit from which on a spin may be beyond it.
const NEAR_LIMIT: f32 = 0.85;

/// What is known of a step before its samples.
struct Now {
    time_us: u64,
    motors_turned: bool,
    spin_rad_s: Option<f32>,
}

/// One IMU's news of a step.
struct News {
    step: ImuStep,
    health: ImuHealth,
    /// Might it turn out that they were not to be believed?
    suspect: bool,
}

/// What is remembered of both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuPairState {
    first: UnitState,
    second: UnitState,
    in_use: ImuUnit,
    /// Attitude by the standby's gyro since the unit in use was last above suspicion.
    q_by_standby: UnitQuaternion<f32>,
}

impl ImuPairState {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { first, second, in_use, q_by_standby } = self;
        for UnitState { conditioning, health, gyro } in [first, second] {
            conditioning.record(words);
            health.record(words);
            gyro.record(words);
        }
        words.word(in_use.number());
        words.rotation(q_by_standby);
    }
}

/// What a step found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuFindings {
    /// The unit in use.
    pub unit: ImuUnit,
    /// Its health.
    pub health: ImuHealth,
    /// The other's health.
    pub standby_health: ImuHealth,
    /// Attitude from the unit in use.
    pub estimate: AttitudeEstimate,
    /// Mean specific force of the unit in use, body, m/s^2; none where no sample came.
    pub force_m_s2: Option<Vector3<f32>>,
    /// Time at rest over which its gyro has been calibrated, s.
    pub gyro_rest_s: f32,
    /// Root mean square of what shakes each of its axes, body, m/s^2.
    pub vibration_m_s2: Vector3<f32>,
    /// Of the first and the second: mean specific force at rest in its own axes, m/s^2; none where it is not known.
    pub rest_force_m_s2: [Option<Vector3<f32>>; 2],
}

/// Takes the samples of a step, chooses the unit, and brings the attitude up to date. `support` is what has carried the
/// vehicle while motors turned; none where they did not. `spin_rad_s` is how fast one turns about yaw that has lost a
/// motor, by what its motors do; none of any other.
pub fn update(
    config: &SensingConfig,
    pair: &mut ImuPairState,
    attitude: &mut EstimatorState,
    input: &StepInput,
    support: Option<Support>,
    spin_rad_s: Option<f32>,
) -> ImuFindings {
    let motors_turned = support.is_some();
    let now = Now { time_us: input.time_us, motors_turned, spin_rad_s };
    let first = pair.first.take(&config.imu, &input.imu, &now);
    let second = pair.second.take(&config.imu_second, &input.imu_second, &now);
    let unit = choose(pair, motors_turned, first.health, second.health);
    if unit != pair.in_use {
        pair.in_use = unit;
        if motors_turned { attitude.set_attitude(pair.q_by_standby) } else { attitude.level_anew() }
    }
    let (used, used_state, standby, standby_state) = match unit {
        ImuUnit::First => (first, &mut pair.first, second, &mut pair.second),
        ImuUnit::Second => (second, &mut pair.second, first, &mut pair.first),
    };
    let estimator = &config.estimator;
    let estimate = estimator::update(estimator, attitude, &mut used_state.gyro, &used.step, input.time_us, support);
    calibrate_standby(estimator, &mut standby_state.gyro, &standby, motors_turned);
    pair.q_by_standby = if used.suspect {
        let bias_rad = standby_state.gyro.bias_rad_s() * standby.step.duration_s;
        estimator::turned(&pair.q_by_standby, &(standby.step.rotation_rad - bias_rad))
    } else {
        estimate.q_world_from_body
    };
    ImuFindings {
        unit,
        health: used.health,
        standby_health: standby.health,
        estimate,
        force_m_s2: used.step.is_usable().then_some(used.step.specific_force_m_s2),
        gyro_rest_s: used_state.gyro.rest_s(),
        vibration_m_s2: used.step.vibration_m_s2,
        rest_force_m_s2: [pair.first.rest_force_m_s2(&config.imu), pair.second.rest_force_m_s2(&config.imu_second)],
    }
}

impl UnitState {
    fn take(&mut self, config: &ImuConfig, samples: &[RawImuSample], now: &Now) -> News {
        let Now { time_us, motors_turned, spin_rad_s } = *now;
        // only a spin that came near the limit before can be beyond it
        let beyond_rad_s =
            spin_rad_s.filter(|spin_rad_s| magnitude(*spin_rad_s) > NEAR_LIMIT * config.gyro_max_rad_s());
        let flown = Flown { rotors_turn: motors_turned, beyond_rad_s };
        let step = imu::condition(config, &mut self.conditioning, samples, time_us, flown);
        let at_rest = !motors_turned && self.gyro.rest_s() > 0.0;
        let yaw_word = beyond_rad_s.map(|_| config.yaw_word());
        let health = self.health.update(config.chips, samples, at_rest, yaw_word);
        News { step, health, suspect: self.health.is_suspect(config.chips) }
    }

    fn rest_force_m_s2(&self, config: &ImuConfig) -> Option<Vector3<f32>> {
        let force_m_s2 = self.gyro.rest_force_m_s2()?;
        Some(config.mounting.map_or(force_m_s2, |mounting| mounting.force_of_imu(force_m_s2)))
    }
}

fn choose(pair: &ImuPairState, motors_turned: bool, first: ImuHealth, second: ImuHealth) -> ImuUnit {
    match (pair.in_use, motors_turned, first, second) {
        (unit, _, ImuHealth::Bad(_), ImuHealth::Bad(_)) => unit,
        (ImuUnit::Second, true, _, _) => ImuUnit::Second,
        (ImuUnit::First, true, ImuHealth::Bad(_), ImuHealth::Good) if !pair.second.gyro.is_calibrated() => {
            ImuUnit::First
        }
        (_, _, ImuHealth::Good, _) => ImuUnit::First,
        (_, _, ImuHealth::Bad(_), ImuHealth::Good) => ImuUnit::Second,
    }
}

/// At rest the standby's gyro is averaged like the other's, whose bias is the estimator's business.
fn calibrate_standby(config: &EstimatorConfig, gyro: &mut GyroBias, news: &News, motors_turned: bool) {
    if motors_turned || news.step.after_gap {
        gyro.moved();
    } else if news.health != ImuHealth::Good {
        gyro.distrust();
    } else if news.step.is_usable() {
        let down_body = measured_down(config, &news.step.specific_force_m_s2).map(|(down_body, _)| down_body);
        gyro.average_at_rest(&config.gyro_bias, &news.step, down_body);
    }
}

#[cfg(test)]
mod tests;
