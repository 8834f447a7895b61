//! What the vehicle's sensors make of its motion: bias, white noise, counts.

pub mod imu;
mod lever;
pub mod random;

use shared_control::signals::RawImuSample;

use crate::effects::{self, Effect};
use crate::model::SensorNoise;
use crate::plant::{Plant, Truth};
use crate::vehicle::{Changes, SensorChain, Turning};
use lever::Lever;
use random::RandomStream;

/// The sensors of one vehicle. Each has a random stream of its own, so that none disturbs another.
#[derive(Clone, Debug)]
pub struct Sensors {
    noise: SensorNoise,
    /// None for nominal sensors.
    chain: Option<SensorChain>,
    gyro_bias_rad_s: [f64; 3],
    accel_bias_m_s2: [f64; 3],
    /// None at the centre of gravity.
    lever: Option<Lever>,
    gyro_stream: RandomStream,
    accel_stream: RandomStream,
    attitude_stream: RandomStream,
    navigation_stream: RandomStream,
}

impl Sensors {
    /// Sensors with this noise and no bias.
    pub fn new(noise: &SensorNoise, seed: u64) -> Self {
        Self {
            noise: *noise,
            chain: None,
            gyro_bias_rad_s: [0.0; 3],
            accel_bias_m_s2: [0.0; 3],
            lever: None,
            gyro_stream: RandomStream::new(seed, "gyro"),
            accel_stream: RandomStream::new(seed, "accelerometer"),
            attitude_stream: RandomStream::new(seed, "attitude"),
            navigation_stream: RandomStream::new(seed, "navigation"),
        }
    }

    /// Sensors that only round to whole counts.
    pub fn ideal() -> Self {
        Self::new(&SensorNoise::NONE, 0)
    }

    /// Adds a constant to every reading, body axes: gyro in rad/s, accelerometer in m/s².
    pub fn with_bias(mut self, gyro_rad_s: [f64; 3], accel_m_s2: [f64; 3]) -> Self {
        self.gyro_bias_rad_s = gyro_rad_s;
        self.accel_bias_m_s2 = accel_m_s2;
        self
    }

    /// Puts the IMU this far from the centre of gravity, body axes, m: it feels the rotation about that.
    pub fn with_imu_at(mut self, position_body_m: [f64; 3]) -> Self {
        self.lever = (position_body_m != [0.0; 3]).then(|| Lever::new(position_body_m));
        self
    }

    /// Adds what the sensors' effects among these do; the others are the plant's.
    pub fn with_effects(mut self, effects: &[Effect]) -> Self {
        let chain = effects::changes(Changes::default(), effects).sensors;
        self.chain = (chain != SensorChain::default()).then_some(chain);
        self
    }

    /// By how much reported attitude lags the true one, s: its reader hands [`Sensors::attitude`] older angles.
    pub fn attitude_delay_s(&self) -> f64 {
        self.chain.as_ref().map_or(0.0, |chain| chain.attitude_delay_s)
    }

    /// One reading of the IMU, stamped `time_us`. It sits at the centre of gravity (on the gimbal: at the pivot), or
    /// where [`Sensors::with_imu_at`] has put it.
    pub fn imu(&mut self, plant: &Plant, time_us: u64) -> RawImuSample {
        let rotors = turning(plant.motor_speed_rad_s(), plant.rotor_phase_rad());
        self.imu_sample(time_us, plant.rate_body_rad_s(), plant.specific_force_body_m_s2(), rotors)
    }

    /// The same of a vehicle that stands level and still, under that gravity (m/s²).
    pub fn imu_at_rest(&mut self, gravity_m_s2: f64, time_us: u64) -> RawImuSample {
        self.imu_sample(time_us, [0.0; 3], [0.0, 0.0, -gravity_m_s2], None)
    }

    /// The same of a motion that was seen.
    pub fn imu_of(&mut self, truth: &Truth) -> RawImuSample {
        let (rate_rad_s, force_m_s2) = (truth.rate_body_rad_s, truth.specific_force_body_m_s2);
        let rotors = turning(truth.motor_speed_rad_s, truth.rotor_phase_rad);
        self.imu_sample((truth.time_s * 1e6).round() as u64, rate_rad_s, force_m_s2, rotors)
    }

    #[inline]
    fn imu_sample(
        &mut self,
        time_us: u64,
        mut rate_rad_s: [f64; 3],
        mut force_m_s2: [f64; 3],
        rotors: Option<Turning>,
    ) -> RawImuSample {
        if let Some(lever) = &mut self.lever {
            force_m_s2 = sum(force_m_s2, lever.felt_m_s2(time_us, rate_rad_s));
        }
        if let Some(chain) = &self.chain {
            if let Some(rotors) = rotors {
                let (rate, force) = chain.vibration.felt(&rotors, imu::gyro_passes, imu::accel_passes);
                (rate_rad_s, force_m_s2) = (sum(rate_rad_s, rate), sum(force_m_s2, force));
            }
            (rate_rad_s, force_m_s2) = (chain.gyro_rad_s(rate_rad_s), chain.turned(force_m_s2));
        }
        let rate = disturbed(rate_rad_s, &self.gyro_bias_rad_s, self.noise.gyro_rad_s, &mut self.gyro_stream);
        let force = disturbed(force_m_s2, &self.accel_bias_m_s2, self.noise.accel_m_s2, &mut self.accel_stream);
        imu::quantise(time_us, rate, force)
    }

    /// Roll, pitch and yaw as a log reports them, rad.
    pub fn attitude(&mut self, roll_pitch_yaw_rad: [f64; 3]) -> [f64; 3] {
        let reported = self.chain.as_ref().map_or(roll_pitch_yaw_rad, |chain| chain.attitude_rad(roll_pitch_yaw_rad));
        disturbed(reported, &[0.0; 3], self.noise.attitude_rad, &mut self.attitude_stream)
    }

    /// Velocity (north, east, down, m/s) and height above ground (m) as a log of free flight reports them.
    pub fn navigation(&mut self, truth: &Truth) -> [f64; 4] {
        let [north, east, down] =
            disturbed(truth.velocity_ned_m_s, &[0.0; 3], self.noise.velocity_m_s, &mut self.navigation_stream);
        let mut height_m = truth.height_m;
        if self.noise.height_m > 0.0 {
            height_m += self.noise.height_m * self.navigation_stream.normal();
        }
        [north, east, down, height_m]
    }
}

fn turning(speed_rad_s: [f64; 4], phase_rad: Option<[f64; 4]>) -> Option<Turning> {
    phase_rad.map(|phase_rad| Turning { speed_rad_s, phase_rad })
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|axis| a[axis] + b[axis])
}

/// Truth, bias and noise; a sensor without noise draws nothing.
#[inline]
fn disturbed(truth: [f64; 3], bias: &[f64; 3], deviation: f64, stream: &mut RandomStream) -> [f64; 3] {
    let mut reading = truth;
    for (value, bias) in reading.iter_mut().zip(bias) {
        *value += bias;
        if deviation > 0.0 {
            *value += deviation * stream.normal();
        }
    }
    reading
}

#[cfg(test)]
mod tests;
