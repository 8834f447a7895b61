//! Level and gyro bias in flight, from what the accelerometer should feel: an extended Kalman filter.
//!
//! An accelerometer feels every force but gravity. So does its integral, and in it rotors that shake the vehicle leave
//! next to nothing: velocity over the ground's air, world axes (NED, the heading as it is estimated),
//!
//! ```text
//!   v' = g z + R f                     f the specific force in body axes, as it is measured
//! ```
//! What that velocity must be, says what carries the vehicle ([`Support`]):
//!
//! ```text
//!   held (rig, hand, ground)           v = 0
//!   in the air                         f_x = -k u_x,  f_y = -k u_y,  u = R^T v        rotor drag over mass, k
//! ```
//! (Martin and Salaun, The true role of accelerometer feedback in quadrotor control, ICRA 2010; Leishman, Macdonald,
//! Beard, McLain, Quadrotors and accelerometers, IEEE CSM 34(1), 2014. That the force is integrated before it is
//! compared is the almost-inertial frame of VQF: Laidig and Seel, Information Fusion 91, 2023.) A wrong tilt sends v
//! the wrong way, and the comparison finds it. A wrong k is found where v is large: it is estimated along. Steady wind
//! is a velocity that the vehicle begins with, as v is against the air. Its error state: tilt phi (rotation vector
//! about north and east, true R = exp(phi) R), velocity, gyro bias (body), k;
//!
//! ```text
//!   phi' = -(R db)_xy      dv' = phi x R f      db' = noise      dk' = noise
//! ```
//! Heading is no state: nothing observes it. Vertical velocity hardly shows either; it is held near zero very weakly.
//! A comparison that misses by more than its expected deviation counts for less, in proportion, and never for nothing.

mod covariance;
mod whole_turn;

use nalgebra::{UnitQuaternion, Vector3};

use crate::elementary::{larger, limit, magnitude, sqrt};
use crate::record::state_words::StateWords;
use crate::sensing::imu::{ImuStep, STEADY_LAG_S, all_finite};
use covariance::{BIAS, Covariance, DRAG, Noises, STATES, TILT, VELOCITY};
use whole_turn::{Mean, WholeTurn};

/// Time over which the force is summed before it is compared, s.
const WINDOW_S: f32 = 0.02;
/// Beyond this nothing is a velocity of such a vehicle against the air, m/s.
const VELOCITY_MAX_M_S: f32 = 100.0;
/// Standard deviation of k at the start, over k.
const DRAG_STD: f32 = 0.4;
/// Range of k, 1/s.
const DRAG_1_S: [f32; 2] = [0.01, 2.0];

/// How far the drag is from being proportional, of itself, and for how long at a time, s.
const DRAG_BENDS: f32 = 0.1;
const DRAG_BENDS_FOR_S: f32 = 0.3;
/// Velocity that a vibration leaves at low frequencies in a vehicle that is held, over its root mean square: sensors at
/// full scale and rotors that speed up once a turn rectify it. m/s per root of Hz, per m/s^2.
const SHAKEN_NOISE: f32 = 0.001;
/// How far from the centre of gravity an IMU sits whose place nobody has measured, m.
const LEVER_M: f32 = 0.03;
/// What the low-pass of the force keeps of it from window to window.
const LEVER_KEPT: f32 = 0.75;
/// What a gyro whose scale is off by 2 % (MPU-6000 product specification 6.1: up to 3 %, 2 % from axis to axis) gets
/// wrong of a turn that lasts so long, over the rate, per root of Hz.
const TURNING_NOISE: f32 = 0.012;
const TURN_LASTS_S: f32 = 0.33;
/// A vehicle climbs and sinks as it likes; but for ever it does not. Variance of one window's comparison.
const CLIMB_VARIANCE_M2_S2: f32 = 1e4;
/// Tilt after numbers that made no sense, rad.
const LOST_TILT_STD_RAD: f32 = 0.1;

/// What is expected of vehicle and sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevellingConfig {
    /// Drag of the rotors over the mass k, 1/s; known to 40 % of it.
    pub rotor_drag_1_s: f32,
    /// Standard deviation of the tilt with which a flight begins, rad.
    pub tilt_std_rad: f32,
    /// Of the gyro's bias: running motors shake and warm it, rad/s.
    pub bias_std_rad_s: f32,
    /// Of the wind at take-off, m/s.
    pub wind_std_m_s: f32,
    /// Noise of the gyro, rad/s per root of Hz.
    pub gyro_noise: f32,
    /// Walk of the bias, rad/s^2 per root of Hz.
    pub bias_walk: f32,
    /// What moves the vehicle or its air beside all this, m/s^2 per root of Hz: gusts, and accelerometer errors.
    pub gust_noise: f32,
    /// Noise of the comparison in the air: what drag in proportion to velocity leaves out, m/s^2 per root of Hz.
    pub drag_noise: f32,
    /// Noise of standing still while held: the IMU's lever about the axes, play; m/s per root of Hz.
    pub held_noise: f32,
}

impl LevellingConfig {
    /// A multirotor whose drag nobody measured: 0.45 1/s is the middle of what Faessler, Franchi and Scaramuzza (RA-L
    /// 3(2), 2018) found. Gusts of a calm day. A gyro's bias moves by half a degree a second while the board warms.
    pub const NOMINAL: LevellingConfig = LevellingConfig {
        rotor_drag_1_s: 0.45,
        tilt_std_rad: 0.01,
        bias_std_rad_s: 0.01,
        wind_std_m_s: 3.0,
        gyro_noise: 5e-4,
        bias_walk: 1e-4,
        gust_noise: 0.1,
        drag_noise: 0.05,
        held_noise: 0.01,
    };
}

/// What keeps the vehicle from falling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Support {
    /// A rig, a hand, the ground.
    #[default]
    Held,
    /// Its rotors.
    Air,
}

/// What the filter remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levelling {
    support: Support,
    velocity_m_s: Vector3<f32>,
    drag_1_s: f32,
    covariance: Covariance,
    /// Integral of the specific force over the window so far, world, m/s.
    window_m_s: Vector3<f32>,
    /// Integral of the velocity over it, m.
    window_m: Vector3<f32>,
    /// And of the rate, body, rad.
    window_rad: Vector3<f32>,
    window_s: f32,
    turn: WholeTurn,
    /// Mean rate of the window before, body, rad/s.
    rate_rad_s: Vector3<f32>,
    /// What an IMU beside the centre of gravity feels of rotation, over its distance, 1/s^2.
    turning_1_s2: f32,
}

/// What a comparison found to be wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// Rotation about the world's axes that the attitude lacks, rad.
    pub tilt_rad: Vector3<f32>,
    /// Rate that the gyro's bias lacks, rad/s.
    pub bias_rad_s: Vector3<f32>,
}

impl Levelling {
    /// At the beginning of a flight, with a tilt that is known so well, rad.
    pub fn begin(config: &LevellingConfig, tilt_std_rad: f32) -> Self {
        let square = |std: f32| std * std;
        let (tilt, bias) = (square(tilt_std_rad), square(config.bias_std_rad_s));
        let mut variances = [tilt, tilt, 0.0, 0.0, 0.0, bias, bias, bias, square(DRAG_STD * config.rotor_drag_1_s)];
        variances[VELOCITY..BIAS].fill(square(0.1));
        Self {
            support: Support::Held,
            velocity_m_s: Vector3::zeros(),
            drag_1_s: config.rotor_drag_1_s,
            covariance: Covariance::of(variances),
            window_m_s: Vector3::zeros(),
            window_m: Vector3::zeros(),
            window_rad: Vector3::zeros(),
            window_s: 0.0,
            turn: WholeTurn::default(),
            rate_rad_s: Vector3::zeros(),
            turning_1_s2: 0.0,
        }
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { support, velocity_m_s, drag_1_s, covariance, window_m_s, window_m, window_rad, window_s, .. } = self;
        let Self { turn, rate_rad_s, turning_1_s2, .. } = self;
        words.word(*support as u32);
        words.vector(velocity_m_s);
        words.number(*drag_1_s);
        covariance.record(words);
        words.vector(window_m_s);
        words.vector(window_m);
        words.vector(window_rad);
        words.number(*window_s);
        turn.record(words);
        words.vector(rate_rad_s);
        words.number(*turning_1_s2);
    }

    /// Velocity against the air, world, m/s.
    pub fn velocity_m_s(&self) -> &Vector3<f32> {
        &self.velocity_m_s
    }

    /// Drag of the rotors over the mass, 1/s.
    pub fn drag_1_s(&self) -> f32 {
        self.drag_1_s
    }

    /// One step on, at the attitude that it began with; where a window ends, what is wrong. `gravity_m_s2` points down.
    pub fn update(
        &mut self,
        config: &LevellingConfig,
        gravity_m_s2: f32,
        q_world_from_body: &UnitQuaternion<f32>,
        imu: &ImuStep,
        support: Support,
    ) -> Option<Correction> {
        let gained_m_s = q_world_from_body * (imu.specific_force_m_s2 * imu.duration_s);
        self.velocity_m_s += gained_m_s;
        self.velocity_m_s.z += gravity_m_s2 * imu.duration_s;
        self.window_m_s += gained_m_s;
        self.window_m += self.velocity_m_s * imu.duration_s;
        self.window_rad += imu.rotation_rad;
        let turn = self.turn.take(q_world_from_body, &self.velocity_m_s, imu);
        self.window_s += imu.duration_s;
        if support != self.support {
            self.change_support(config, support);
        }
        if let (Support::Air, Some(turn)) = (support, turn) {
            let mut errors = [0.0; STATES];
            self.compare_turn_with_drag(config, &mut errors, &turn);
            return Some(self.take(config, &errors));
        }
        if self.window_s < WINDOW_S {
            return None;
        }
        let body_axes_in_world = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| q_world_from_body * axis);
        let turned_rad_s = tilts_rad_s(&(q_world_from_body * self.window_rad * (1.0 / self.window_s)));
        self.feel_turning();
        let noises = Noises {
            gyro: config.gyro_noise + TURNING_NOISE * turned_rad_s,
            force: config.gust_noise,
            bias: config.bias_walk,
        };
        self.covariance.predict(&noises, &body_axes_in_world, &self.window_m_s, self.window_s);
        // the mean of a window, as what rotors leave in the velocity would fold down to anything at one look a window
        let mean_m_s = self.window_m * (1.0 / self.window_s);
        let mut errors = [0.0; STATES];
        match support {
            Support::Held => {
                let vibration_m_s2 = sqrt(imu.vibration_m_s2.dot(&imu.vibration_m_s2));
                let noise = config.held_noise + SHAKEN_NOISE * vibration_m_s2;
                self.compare_with_rest(&mut errors, &mean_m_s, noise * noise / self.window_s);
            }
            Support::Air if self.turn.goes_on() => self.compare_with_level_flight(&mut errors),
            Support::Air => {
                let [body_x, body_y, _] = &body_axes_in_world;
                let acceleration_m_s2 = self.window_m_s * (1.0 / self.window_s) + Vector3::z() * gravity_m_s2;
                let then_m_s = mean_m_s - acceleration_m_s2 * (STEADY_LAG_S - 0.5 * self.window_s);
                self.compare_with_drag(config, &mut errors, &then_m_s, body_x, imu.steady_force_m_s2.x);
                self.compare_with_drag(config, &mut errors, &then_m_s, body_y, imu.steady_force_m_s2.y);
                self.compare_with_level_flight(&mut errors);
            }
        }
        (self.window_m_s, self.window_m, self.window_rad) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        self.window_s = 0.0;
        Some(self.take(config, &errors))
    }

    /// An IMU that does not sit in the centre of gravity feels rotation, the more the faster it is or changes.
    fn feel_turning(&mut self) {
        let rate_rad_s = self.window_rad * (1.0 / self.window_s);
        let gained_rad_s2 = (rate_rad_s - self.rate_rad_s) * (1.0 / self.window_s);
        let felt_1_s2 = rate_rad_s.dot(&rate_rad_s) + sqrt(gained_rad_s2.dot(&gained_rad_s2));
        self.turning_1_s2 = larger(felt_1_s2, LEVER_KEPT * self.turning_1_s2);
        self.rate_rad_s = rate_rad_s;
    }

    /// Let go, a vehicle may have any wind about it; held again, it has none.
    fn change_support(&mut self, config: &LevellingConfig, support: Support) {
        self.support = support;
        let std_m_s = match support {
            Support::Held => {
                self.velocity_m_s = Vector3::zeros();
                0.1
            }
            Support::Air => config.wind_std_m_s,
        };
        self.covariance.forget(VELOCITY..BIAS, std_m_s * std_m_s);
    }

    fn compare_with_rest(&mut self, errors: &mut [f32; STATES], velocity_m_s: &Vector3<f32>, variance: f32) {
        for axis in 0..3 {
            let mut sees = [0.0; STATES];
            sees[VELOCITY + axis] = 1.0;
            self.covariance.compare(errors, &sees, -velocity_m_s[axis], variance);
        }
    }

    /// Along one of the body's axes, given in the world: with d = true - estimated, f + k u = -k (dv - phi x v) - u dk
    /// along it.
    fn compare_with_drag(
        &mut self,
        config: &LevellingConfig,
        errors: &mut [f32; STATES],
        velocity_m_s: &Vector3<f32>,
        axis: &Vector3<f32>,
        force_m_s2: f32,
    ) {
        let along_m_s = axis.dot(velocity_m_s);
        let drag_m_s2 = self.drag_1_s * along_m_s;
        let turned = velocity_m_s.cross(axis) * self.drag_1_s;
        let mut sees = [0.0; STATES];
        (sees[TILT], sees[TILT + 1]) = (turned.x, turned.y);
        for (i, component) in axis.iter().enumerate() {
            sees[VELOCITY + i] = -self.drag_1_s * component;
        }
        sees[DRAG] = -along_m_s;
        let bent_m_s2 = DRAG_BENDS * config.rotor_drag_1_s * along_m_s;
        let noise = config.drag_noise * config.drag_noise + bent_m_s2 * bent_m_s2 * DRAG_BENDS_FOR_S;
        let lever_m_s2 = LEVER_M * self.turning_1_s2;
        let variance = noise / self.window_s + lever_m_s2 * lever_m_s2;
        self.covariance.compare(errors, &sees, force_m_s2 + drag_m_s2, variance);
    }

    /// The same of a whole turn, along the world's axes: what the tilt does to them is vertical.
    fn compare_turn_with_drag(&mut self, config: &LevellingConfig, errors: &mut [f32; STATES], turn: &Mean) {
        let noise = config.drag_noise * config.drag_noise;
        for axis in 0..2 {
            let mut sees = [0.0; STATES];
            sees[VELOCITY + axis] = -self.drag_1_s;
            sees[DRAG] = -turn.velocity_m_s[axis];
            let bent_m_s2 = DRAG_BENDS * config.rotor_drag_1_s * turn.velocity_m_s[axis];
            let variance = (noise + bent_m_s2 * bent_m_s2 * DRAG_BENDS_FOR_S) / turn.lasted_s;
            let left_m_s2 = turn.force_m_s2[axis] + self.drag_1_s * turn.velocity_m_s[axis];
            self.covariance.compare(errors, &sees, left_m_s2, variance);
        }
    }

    fn compare_with_level_flight(&mut self, errors: &mut [f32; STATES]) {
        let mut sees = [0.0; STATES];
        sees[VELOCITY + 2] = 1.0;
        self.covariance.compare(errors, &sees, -self.velocity_m_s.z, CLIMB_VARIANCE_M2_S2);
    }

    fn take(&mut self, config: &LevellingConfig, errors: &[f32; STATES]) -> Correction {
        let [north, east, vn, ve, vd, bx, by, bz, drag] = *errors;
        let [least, most] = DRAG_1_S;
        self.velocity_m_s += Vector3::new(vn, ve, vd);
        self.drag_1_s = limit(self.drag_1_s + drag, least, most);
        let found = Correction { tilt_rad: Vector3::new(north, east, 0.0), bias_rad_s: Vector3::new(bx, by, bz) };
        let sound = all_finite(&found.tilt_rad)
            && all_finite(&found.bias_rad_s)
            && self.velocity_m_s.iter().all(|speed| magnitude(*speed) <= VELOCITY_MAX_M_S)
            && self.covariance.is_sound();
        if sound {
            return found;
        }
        *self = Self { support: self.support, ..Self::begin(config, LOST_TILT_STD_RAD) };
        self.covariance.forget(VELOCITY..BIAS, config.wind_std_m_s * config.wind_std_m_s);
        Correction { tilt_rad: Vector3::zeros(), bias_rad_s: Vector3::zeros() }
    }
}

/// How much of a rate, world, rad/s, gets the tilt wrong by a gyro's scales. What is about the vertical does so by what
/// another axis shows of it, which turns with the vehicle and in a spin goes round before it adds up.
fn tilts_rad_s(rate_rad_s: &Vector3<f32>) -> f32 {
    let [north, east, down] = [rate_rad_s.x, rate_rad_s.y, rate_rad_s.z].map(|rate| rate * rate);
    sqrt(north + east + down / (1.0 + TURN_LASTS_S * TURN_LASTS_S * down))
}

#[cfg(test)]
mod tests;
