//! From raw IMU counts to what the estimator and the rate loop use: scale, axis map, notches at the rotors' lines where
//! they are wanted, low-pass before decimation.
//!
//! The sensor samples faster than the loop runs. Attitude gets the whole rotation since the last step (the sum over
//! all samples, so that nothing is lost between steps); the rate loop gets the low-passed rate, so that noise above
//! half the loop's rate does not fold down.
//!
//! Of the specific force levelling gets the mean, whose sum over the steps is its integral, and what a low-pass of 5 Hz
//! at the sensor's own rate leaves, in which no rotor is seen. What that takes away is the vibration, measured as
//! ArduPilot does (`AP_InertialSensor::calc_vibration_and_clipping`: deviation from 5 Hz, squared, 2 Hz, root), so that
//! its limits hold: below 30 m/s^2 good, beyond 60 bad.

use nalgebra::Vector3;

use crate::elementary::sqrt;
use crate::filter::{LowPass1, LowPass2, LowPass2State};
use crate::record::state_words::StateWords;
use crate::sensing::imu_health::is_full_scale;
use crate::sensing::level_trim::Mounting;
use crate::sensing::rotor_notches::{Notches, NotchesConfig, NotchesState};
use crate::signals::RawImuSample;

/// What data sheets call "g", m/s^2.
pub(crate) const STANDARD_GRAVITY_M_S2: f32 = 9.806_65;
/// Samples per second of an L3GD20 or L3GD20H at its fastest (data sheets: 760 Hz and 757.6 Hz).
pub const L3GD20_RATE_HZ: f32 = 760.0;
/// Longest time between two samples that still counts as continuous, s.
const SAMPLE_GAP_MAX_S: f32 = 0.05;
/// Longest gap that is bridged, at the mean of the rates on both sides, s.
const BRIDGED_GAP_MAX_S: f32 = 0.5;
/// Cut-off of the steady force, Hz, and of the mean square of the vibration.
const STEADY_HZ: f32 = 5.0;
const VIBRATION_MEAN_HZ: f32 = 2.0;
/// By how much the steady force is late, s: a Butterworth low-pass of second order delays slow changes by sqrt(2)/w.
pub const STEADY_LAG_S: f32 = core::f32::consts::SQRT_2 / (2.0 * core::f32::consts::PI * STEADY_HZ);
/// How far ahead of the step a sample may be stamped, us; a stamp beyond is no time.
const STAMP_AHEAD_MAX_US: u64 = 5_000;

/// How the sensor sits on the board: body axis `i` is `sign[i]` times sensor axis `source[i]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMap {
    /// Sensor axis (0, 1, 2) that each body axis comes from.
    pub source: [u8; 3],
    /// +1 or -1 for each body axis.
    pub sign: [f32; 3],
}

impl AxisMap {
    /// MPU6000 on a level Pixhawk 1: body FRD = (sensor y, -sensor x, sensor z); the chip is mounted upside down, so
    /// that its z axis reads about -1 g at rest.
    pub const PIXHAWK1_MPU6000: AxisMap = AxisMap { source: [1, 0, 2], sign: [1.0, -1.0, 1.0] };

    /// L3GD20 on a level Pixhawk 1: body FRD = (sensor y, -sensor x, sensor z), upside down like all three chips.
    ///
    /// Two drivers agree. PX4's `l3gd20` turns an L3GD20 by 270 degrees of yaw: (y, -x, z). ArduPilot's `LSM9DS0` takes
    /// (x, -y, -z) from the chip and turns that by ROLL_180_YAW_270, (x, y, z) -> (-y, -x, -z): again (y, -x, z).
    pub const PIXHAWK1_L3GD20: AxisMap = AxisMap { source: [1, 0, 2], sign: [1.0, -1.0, 1.0] };

    /// L3GD20H, soldered to later boards in the L3GD20's place with its axes a quarter turn further: body FRD =
    /// (-sensor x, -sensor y, sensor z).
    ///
    /// PX4 turns it by 180 degrees of yaw, (-x, -y, z); ArduPilot turns (x, -y, -z) by PITCH_180, (x, y, z) -> (-x, y,
    /// -z): the same.
    pub const PIXHAWK1_L3GD20H: AxisMap = AxisMap { source: [0, 1, 2], sign: [-1.0, -1.0, 1.0] };

    /// LSM303D's accelerometer: body FRD = its own axes; upside down it reads about -1 g on z at rest.
    ///
    /// PX4 starts it unrotated; ArduPilot turns (x, -y, -z) by ROLL_180, which gives (x, y, z).
    pub const PIXHAWK1_LSM303D: AxisMap = AxisMap { source: [0, 1, 2], sign: [1.0; 3] };

    /// A sensor reading turned into the body frame.
    pub fn to_body(&self, sensor: [f32; 3]) -> Vector3<f32> {
        let pick = |axis: usize| {
            let value = match self.source[axis] {
                0 => sensor[0],
                1 => sensor[1],
                _ => sensor[2],
            };
            self.sign[axis] * value
        };
        Vector3::new(pick(0), pick(1), pick(2))
    }

    /// A vector of the body frame as the sensor would read it: the reverse of [`Self::to_body`].
    pub fn from_body(&self, body: [f32; 3]) -> [f32; 3] {
        let mut sensor = [0.0; 3];
        for ((source, sign), value) in self.source.iter().zip(self.sign).zip(body) {
            if let Some(axis) = sensor.get_mut(usize::from(*source)) {
                *axis = sign * value;
            }
        }
        sensor
    }
}

/// Are gyro and accelerometer on one chip? Two can fail one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chips {
    /// One chip.
    One,
    /// A gyro and an accelerometer that know nothing of each other.
    Two,
}

/// Scales, axes and filter of one IMU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuConfig {
    /// What it is made of.
    pub chips: Chips,
    /// rad/s per gyro count.
    pub gyro_rad_s_per_count: f32,
    /// m/s^2 per accelerometer count.
    pub accel_m_s2_per_count: f32,
    /// Gyro axes to body axes.
    pub gyro_axes: AxisMap,
    /// Accelerometer axes to body axes.
    pub accel_axes: AxisMap,
    /// Low-pass on each gyro axis at the sensor's sample rate.
    pub gyro_lowpass: LowPass2,
    /// Notches before it that follow the rotors; none where there are none.
    pub gyro_notches: Option<NotchesConfig>,
    /// On each accelerometer axis, for the steady force.
    pub force_lowpass: LowPass2,
    /// For the mean square of the vibration.
    pub vibration_mean: LowPass1,
    /// How it sits on the vehicle; none where its axes are the vehicle's.
    pub mounting: Option<Mounting>,
}

impl ImuConfig {
    /// MPU6000 on a Pixhawk 1, +-2000 deg/s (16.4 counts per deg/s) and +-8 g (4096 counts per g), as its register map
    /// (sections 4.4, 4.5) gives them.
    pub fn pixhawk1_mpu6000(gyro_cutoff_hz: f32, sample_rate_hz: f32) -> Self {
        Self {
            chips: Chips::One,
            gyro_rad_s_per_count: core::f32::consts::PI / 180.0 / 16.4,
            accel_m_s2_per_count: STANDARD_GRAVITY_M_S2 / 4096.0,
            gyro_axes: AxisMap::PIXHAWK1_MPU6000,
            accel_axes: AxisMap::PIXHAWK1_MPU6000,
            gyro_lowpass: LowPass2::new(gyro_cutoff_hz, sample_rate_hz),
            gyro_notches: None,
            force_lowpass: LowPass2::new(STEADY_HZ, sample_rate_hz),
            vibration_mean: LowPass1::new(VIBRATION_MEAN_HZ, sample_rate_hz),
            mounting: None,
        }
    }

    /// The second IMU of a Pixhawk 1: L3GD20 at +-2000 deg/s, 70 mdeg/s a digit (data sheet rev. 2, table 4; the
    /// L3GD20H's has the same), and LSM303D at +-8 g, 0.244 mg a digit (data sheet rev. 2, table 3). Where the gyro
    /// says that it is an L3GD20H, its axes must be set to [`AxisMap::PIXHAWK1_L3GD20H`].
    pub fn pixhawk1_l3gd20_lsm303d(gyro_cutoff_hz: f32) -> Self {
        Self {
            chips: Chips::Two,
            gyro_rad_s_per_count: core::f32::consts::PI / 180.0 * 0.070,
            accel_m_s2_per_count: STANDARD_GRAVITY_M_S2 * 0.000_244,
            gyro_axes: AxisMap::PIXHAWK1_L3GD20,
            accel_axes: AxisMap::PIXHAWK1_LSM303D,
            gyro_lowpass: LowPass2::new(gyro_cutoff_hz, L3GD20_RATE_HZ),
            gyro_notches: None,
            force_lowpass: LowPass2::new(STEADY_HZ, L3GD20_RATE_HZ),
            vibration_mean: LowPass1::new(VIBRATION_MEAN_HZ, L3GD20_RATE_HZ),
            mounting: None,
        }
    }

    /// The largest rate that the gyro can say, rad/s.
    pub fn gyro_max_rad_s(&self) -> f32 {
        f32::from(i16::MAX) * self.gyro_rad_s_per_count
    }

    /// Which of its words is the rate about the body's z axis, but for how it sits on the vehicle.
    pub fn yaw_word(&self) -> usize {
        let [.., yaw] = self.gyro_axes.source;
        usize::from(yaw)
    }

    /// Rate of a sample whose yaw is beyond the gyro's range, if `beyond_rad_s` says so: that, where it is the larger.
    fn gyro_in_spin_rad_s(&self, sample: &RawImuSample, beyond_rad_s: Option<f32>) -> Vector3<f32> {
        let mut rate_rad_s = self.gyro_rad_s(sample);
        let is_limited = sample.gyro_counts.get(self.yaw_word()).is_some_and(|word| is_full_scale(*word));
        match beyond_rad_s {
            Some(yaw_rad_s) if is_limited && yaw_rad_s * rate_rad_s.z > rate_rad_s.z * rate_rad_s.z => {
                rate_rad_s.z = yaw_rad_s;
            }
            _ => {}
        }
        rate_rad_s
    }

    /// Rotation rate of a sample, body frame, rad/s.
    pub fn gyro_rad_s(&self, sample: &RawImuSample) -> Vector3<f32> {
        let rate_rad_s = self.gyro_axes.to_body(sample.gyro_counts.map(f32::from)) * self.gyro_rad_s_per_count;
        self.mounting.map_or(rate_rad_s, |mounting| mounting.rate(rate_rad_s))
    }

    /// Specific force of a sample, body frame, m/s^2.
    pub fn specific_force_m_s2(&self, sample: &RawImuSample) -> Vector3<f32> {
        let force_m_s2 = self.accel_axes.to_body(sample.accel_counts.map(f32::from)) * self.accel_m_s2_per_count;
        self.mounting.map_or(force_m_s2, |mounting| mounting.force(force_m_s2))
    }
}

/// What the conditioning remembers between steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuState {
    last_time_us: Option<u64>,
    lowpass: [LowPass2State; 3],
    notches: NotchesState,
    rate_body_rad_s: Vector3<f32>,
    force_lowpass: [LowPass2State; 3],
    steady_force_m_s2: Vector3<f32>,
    /// Mean square of the deviation from the steady force, m^2/s^4.
    vibration: Vector3<f32>,
}

impl ImuState {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { last_time_us, lowpass, notches, rate_body_rad_s, force_lowpass, steady_force_m_s2, vibration } =
            self;
        words.optional_time_us(*last_time_us);
        for axis in lowpass.iter().chain(force_lowpass) {
            axis.record(words);
        }
        notches.record(words);
        for vector in [rate_body_rad_s, steady_force_m_s2, vibration] {
            words.vector(vector);
        }
    }

    fn feel(&mut self, config: &ImuConfig, force_m_s2: &Vector3<f32>, anew: bool) {
        for axis in 0..3 {
            if anew {
                self.force_lowpass[axis] = config.force_lowpass.settled(force_m_s2[axis]);
            }
            let steady = config.force_lowpass.update(&mut self.force_lowpass[axis], force_m_s2[axis]);
            let shaken = force_m_s2[axis] - steady;
            config.vibration_mean.update(&mut self.vibration[axis], shaken * shaken);
            self.steady_force_m_s2[axis] = steady;
        }
    }
}

/// The IMU's news since the last step, body frame, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuStep {
    /// Number of samples in it.
    pub samples: u8,
    /// Time it covers, s; zero for the very first sample or after a gap too long to bridge.
    pub duration_s: f32,
    /// True for the very first samples, and where they stayed away too long to be bridged.
    pub after_gap: bool,
    /// Rotation since the last step, rad (integrated gyro, bias still in it).
    pub rotation_rad: Vector3<f32>,
    /// Low-passed rotation rate at the last sample, rad/s, bias still in it; the last known without new samples.
    pub rate_body_rad_s: Vector3<f32>,
    /// Mean specific force, m/s^2; zero without samples.
    pub specific_force_m_s2: Vector3<f32>,
    /// Low-passed specific force at the last sample, m/s^2, late by [`STEADY_LAG_S`]; the last known without new ones.
    pub steady_force_m_s2: Vector3<f32>,
    /// Root mean square of what shakes each axis, m/s^2.
    pub vibration_m_s2: Vector3<f32>,
}

impl ImuStep {
    /// Is there something in it, made of finite numbers?
    pub fn is_usable(&self) -> bool {
        self.samples > 0 && all_finite(&self.specific_force_m_s2) && all_finite(&self.rotation_rad)
    }
}

/// Is every part of it a finite number?
pub fn all_finite(v: &Vector3<f32>) -> bool {
    v.x.is_finite() && v.y.is_finite() && v.z.is_finite()
}

/// What the vehicle does that a sensor does not show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flown {
    /// Rotors turn.
    pub rotors_turn: bool,
    /// Yaw rate that may be beyond the gyro's range, by what the motors do, rad/s.
    pub beyond_rad_s: Option<f32>,
}

/// Conditions the samples of one step at `now_us`. Samples whose time does not increase, or lies in the future, are
/// left out; so is a stored time that lies in the future, else one bad stamp would make the vehicle blind until then.
/// The notches stay out while the rotors stand.
pub fn condition(
    config: &ImuConfig,
    state: &mut ImuState,
    samples: &[RawImuSample],
    now_us: u64,
    Flown { rotors_turn, beyond_rad_s }: Flown,
) -> ImuStep {
    let latest_us = now_us.saturating_add(STAMP_AHEAD_MAX_US);
    state.last_time_us = state.last_time_us.filter(|last| *last <= latest_us);
    let mut step = ImuStep {
        samples: 0,
        duration_s: 0.0,
        after_gap: false,
        rotation_rad: Vector3::zeros(),
        rate_body_rad_s: state.rate_body_rad_s,
        specific_force_m_s2: Vector3::zeros(),
        steady_force_m_s2: state.steady_force_m_s2,
        vibration_m_s2: state.vibration.map(sqrt),
    };
    let notches = config.gyro_notches.as_ref().map(|config| Notches::tune(config, &mut state.notches, rotors_turn));
    for sample in samples {
        if sample.time_us > latest_us {
            continue;
        }
        let interval_s = match state.last_time_us {
            Some(last) if sample.time_us <= last => continue,
            Some(last) => seconds_between(last, sample.time_us),
            None => 0.0,
        };
        let first = state.last_time_us.is_none();
        state.last_time_us = Some(sample.time_us);
        let gyro = config.gyro_in_spin_rad_s(sample, beyond_rad_s);
        let force = config.specific_force_m_s2(sample);
        if first || interval_s > BRIDGED_GAP_MAX_S {
            step.after_gap = true;
        } else if interval_s > SAMPLE_GAP_MAX_S {
            step.rotation_rad += (state.rate_body_rad_s + gyro) * (0.5 * interval_s);
            step.duration_s += interval_s;
        } else {
            step.rotation_rad += gyro * interval_s;
            step.duration_s += interval_s;
        }
        let anew = first || interval_s > SAMPLE_GAP_MAX_S;
        if anew {
            state.lowpass = core::array::from_fn(|i| config.gyro_lowpass.settled(gyro[i]));
            state.notches.begin(&gyro);
        }
        state.feel(config, &force, anew);
        let smooth = notches.as_ref().map_or(gyro, |notches| notches.update(&mut state.notches, &gyro));
        for i in 0..3 {
            step.rate_body_rad_s[i] = config.gyro_lowpass.update(&mut state.lowpass[i], smooth[i]);
        }
        step.specific_force_m_s2 += force;
        step.samples = step.samples.saturating_add(1);
    }
    if step.samples > 0 {
        step.specific_force_m_s2 *= 1.0 / f32::from(step.samples);
        state.rate_body_rad_s = step.rate_body_rad_s;
        step.steady_force_m_s2 = state.steady_force_m_s2;
        step.vibration_m_s2 = state.vibration.map(sqrt);
    }
    step
}

/// Time between two stamps in s; exact to the microsecond up to 16 s, more than any gap that matters.
pub fn seconds_between(earlier_us: u64, later_us: u64) -> f32 {
    let span_us = later_us.saturating_sub(earlier_us);
    let span_us = if span_us > u64::from(u32::MAX) { u32::MAX } else { span_us as u32 };
    span_us as f32 * 1e-6
}

#[cfg(test)]
mod tests;
