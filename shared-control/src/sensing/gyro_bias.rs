//! A gyro's bias: its mean at rest, and whatever the estimator finds to be left of it in flight. Each IMU has its own.

use nalgebra::Vector3;

use crate::elementary::{limit, sqrt};
use crate::record::state_words::StateWords;
use crate::sensing::imu::ImuStep;
use crate::sensing::level_trim::REST_MIN_S;

/// What counts as rest, and how far the mean is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroBiasConfig {
    /// How far the rate may stray from its mean while the vehicle counts as at rest, rad/s.
    pub rest_spread_max_rad_s: f32,
    /// How far the direction of the specific force may stray from where it was, rad.
    pub rest_tilt_max_rad: f32,
    /// Time at rest after which the mean rate is believed to be the bias, s.
    pub rest_settle_s: f32,
    /// Longest time over which the bias is averaged at rest, s.
    pub rest_average_max_s: f32,
    /// Largest bias that is believed, rad/s.
    pub bias_max_rad_s: f32,
}

impl GyroBiasConfig {
    /// The bias to 1e-4 rad/s within 10 s.
    pub const NOMINAL: GyroBiasConfig = GyroBiasConfig {
        rest_spread_max_rad_s: 0.1,
        rest_tilt_max_rad: 0.05,
        rest_settle_s: 1.0,
        rest_average_max_s: 10.0,
        // MPU-6000 product specification 3.4, section 6.1: zero-rate output +-20 deg/s, as much again over temperature
        bias_max_rad_s: 0.7,
    };
}

/// What is known of a gyro's bias.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GyroBias {
    bias_rad_s: Vector3<f32>,
    /// It has been averaged at rest for long enough, and its sensor was never bad on the ground since.
    calibrated: bool,
    rest: RestWindow,
}

/// The gyro since the vehicle last came to rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct RestWindow {
    rotation_rad: Vector3<f32>,
    /// The specific force, integrated likewise, m/s.
    velocity_m_s: Vector3<f32>,
    duration_s: f32,
    down_body: Option<Vector3<f32>>,
}

impl GyroBias {
    /// The bias, body frame, rad/s.
    pub fn bias_rad_s(&self) -> Vector3<f32> {
        self.bias_rad_s
    }

    /// Time at rest over which it has been averaged, s; zero in flight and once moved.
    pub fn rest_s(&self) -> f32 {
        self.rest.duration_s
    }

    /// Mean specific force of the same time, body, m/s^2; none before [`REST_MIN_S`].
    pub fn rest_force_m_s2(&self) -> Option<Vector3<f32>> {
        let RestWindow { velocity_m_s, duration_s, .. } = self.rest;
        (duration_s >= REST_MIN_S).then(|| velocity_m_s * (1.0 / duration_s))
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { bias_rad_s, calibrated, rest: RestWindow { rotation_rad, velocity_m_s, duration_s, down_body } } =
            self;
        words.vector(bias_rad_s);
        words.word(u32::from(*calibrated));
        words.vector(rotation_rad);
        words.vector(velocity_m_s);
        words.number(*duration_s);
        words.word(u32::from(down_body.is_some()));
        words.vector(&down_body.unwrap_or_default());
    }

    /// Can the gyro be flown with? Stays true in flight.
    pub fn is_calibrated(&self) -> bool {
        self.calibrated
    }

    /// The vehicle is not at rest: averaging begins anew.
    pub fn moved(&mut self) {
        self.rest = RestWindow::default();
    }

    /// The sensor is not to be believed: it must be calibrated anew before it is flown with.
    pub fn distrust(&mut self) {
        *self = Self { bias_rad_s: self.bias_rad_s, ..Self::default() };
    }

    /// Adds what the estimator finds in flight, rad/s.
    pub fn correct(&mut self, config: &GyroBiasConfig, change_rad_s: Vector3<f32>) {
        self.set(config, &(self.bias_rad_s + change_rad_s));
    }

    /// At rest the mean of the gyro is its bias: after a while of it, for a window that begins anew with every motion.
    /// What was learnt before stays until then, so a slow turn or a bump costs nothing. `down_body` is down as the
    /// accelerometer has it.
    pub fn average_at_rest(&mut self, config: &GyroBiasConfig, imu: &ImuStep, down_body: Option<Vector3<f32>>) {
        let rest = &mut self.rest;
        let mean =
            if rest.duration_s > 0.0 { rest.rotation_rad * (1.0 / rest.duration_s) } else { imu.rate_body_rad_s };
        let strayed = imu.rate_body_rad_s - mean;
        let turned = match (rest.down_body, down_body) {
            (Some(before), Some(now)) => sqrt(before.cross(&now).dot(&before.cross(&now))) > config.rest_tilt_max_rad,
            (None, Some(_)) => false,
            (_, None) => true,
        };
        if turned || strayed.dot(&strayed) > config.rest_spread_max_rad_s * config.rest_spread_max_rad_s {
            *rest = RestWindow { down_body, ..RestWindow::default() };
            return;
        }
        rest.down_body = rest.down_body.or(down_body);
        rest.rotation_rad += imu.rotation_rad;
        rest.velocity_m_s += imu.specific_force_m_s2 * imu.duration_s;
        rest.duration_s += imu.duration_s;
        if rest.duration_s > config.rest_average_max_s {
            // forget as much as came, so that a drift is followed
            let kept = config.rest_average_max_s / rest.duration_s;
            rest.rotation_rad *= kept;
            rest.velocity_m_s *= kept;
            rest.duration_s = config.rest_average_max_s;
        }
        if rest.duration_s >= config.rest_settle_s {
            let bias = rest.rotation_rad * (1.0 / rest.duration_s);
            self.set(config, &bias);
            self.calibrated = true;
        }
    }

    fn set(&mut self, config: &GyroBiasConfig, bias_rad_s: &Vector3<f32>) {
        self.bias_rad_s = bias_rad_s.map(|b| limit(b, -config.bias_max_rad_s, config.bias_max_rad_s));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: GyroBiasConfig = GyroBiasConfig::NOMINAL;
    /// Exact in binary, so that durations add up without rounding.
    const STEP_S: f32 = 1.0 / 256.0;
    const DOWN: Vector3<f32> = Vector3::new(0.0, 0.0, 1.0);

    fn news(rate_rad_s: Vector3<f32>) -> ImuStep {
        ImuStep {
            samples: 1,
            duration_s: STEP_S,
            after_gap: false,
            rotation_rad: rate_rad_s * STEP_S,
            rate_body_rad_s: rate_rad_s,
            specific_force_m_s2: DOWN * -9.8,
            steady_force_m_s2: DOWN * -9.8,
            vibration_m_s2: Vector3::zeros(),
        }
    }

    fn rest(gyro: &mut GyroBias, steps: usize, rate_rad_s: Vector3<f32>) {
        for _ in 0..steps {
            gyro.average_at_rest(&CONFIG, &news(rate_rad_s), Some(DOWN));
        }
    }

    #[test]
    fn the_mean_is_believed_once_it_has_settled() {
        let bias = Vector3::new(0.02, -0.03, 0.01);
        let mut gyro = GyroBias::default();
        rest(&mut gyro, 255, bias);
        assert!(!gyro.is_calibrated() && gyro.bias_rad_s() == Vector3::zeros());
        rest(&mut gyro, 1, bias);
        assert!(gyro.is_calibrated() && gyro.rest_s() == CONFIG.rest_settle_s);
        assert!((gyro.bias_rad_s() - bias).norm() < 1e-6, "{}", gyro.bias_rad_s());
    }

    /// Beyond the longest time what was known fades by T / (T + dt) a step.
    #[test]
    fn a_drift_is_followed_within_the_longest_time() {
        let (before, after) = (Vector3::new(0.02, 0.0, 0.0), Vector3::new(0.05, 0.0, 0.0));
        let mut gyro = GyroBias::default();
        rest(&mut gyro, 2560, before);
        assert!((gyro.bias_rad_s() - before).norm() < 1e-5);
        rest(&mut gyro, 1280, after);
        assert_eq!(gyro.rest_s(), CONFIG.rest_average_max_s);
        let kept = (10.0 / (10.0 + f64::from(STEP_S))).powi(1280) as f32;
        let expected = after + (before - after) * kept;
        assert!((gyro.bias_rad_s() - expected).norm() < 2e-5, "{} for {expected}", gyro.bias_rad_s());
    }

    /// What begins anew: a rate that strays from the mean, a direction that turns, no direction at all.
    #[test]
    fn motion_begins_the_window_anew_and_less_than_motion_does_not() {
        let bias = Vector3::new(0.3, 0.0, 0.0);
        let rested = || {
            let mut gyro = GyroBias::default();
            rest(&mut gyro, 512, bias);
            gyro
        };
        let goes_on = |rate_rad_s: Vector3<f32>, down: Option<Vector3<f32>>| {
            let mut gyro = rested();
            gyro.average_at_rest(&CONFIG, &news(rate_rad_s), down);
            assert!((gyro.bias_rad_s() - bias).norm() < 1e-3, "what was learnt stays");
            gyro.rest_s() > 0.0
        };
        // 0.1 rad/s of the mean, in any direction
        assert!(goes_on(bias + Vector3::new(0.0, 0.07, -0.07), Some(DOWN)));
        assert!(!goes_on(bias + Vector3::new(0.0, 0.071, -0.071), Some(DOWN)));
        assert!(!goes_on(bias - Vector3::new(0.101, 0.0, 0.0), Some(DOWN)));
        // 0.05 rad of where down was, either way round
        for sign in [-1.0, 1.0] {
            let tilted = |sine: f32| Some(Vector3::new(sign * sine, 0.0, sqrt(1.0 - sine * sine)));
            assert!(goes_on(bias, tilted(0.0499)) && !goes_on(bias, tilted(0.0501)));
        }
        assert!(!goes_on(bias, None));
    }

    /// After a turn rest begins where down is now: an equal reading goes on, and one as far away again does not.
    #[test]
    fn rest_begins_anew_where_the_vehicle_lies_now() {
        let tilted =
            |rad: f32| Some(Vector3::new(crate::elementary::sin_cos(rad).0, 0.0, crate::elementary::sin_cos(rad).1));
        let mut gyro = GyroBias::default();
        for (tilt_rad, rest_steps) in
            [(0.0, 1.0), (0.2, 0.0), (0.2, 1.0), (0.22, 2.0), (0.26, 0.0), (0.32, 0.0), (0.3, 1.0)]
        {
            gyro.average_at_rest(&CONFIG, &news(Vector3::zeros()), tilted(tilt_rad));
            assert_eq!(gyro.rest_s(), rest_steps * STEP_S, "{tilt_rad}");
        }
    }

    /// A slow turn is found against where down was when the window began, not against the step before.
    #[test]
    fn down_is_compared_with_the_windows_first() {
        let mut gyro = GyroBias::default();
        for step in 0..100u8 {
            let sine = 0.001 * f32::from(step);
            let down = Vector3::new(sine, 0.0, sqrt(1.0 - sine * sine));
            gyro.average_at_rest(&CONFIG, &news(Vector3::zeros()), Some(down));
        }
        // anew at the 51st step, which brings its own direction, and 48 more
        assert_eq!(gyro.rest_s(), 48.0 * STEP_S);
    }

    #[test]
    fn the_bias_is_bounded_on_each_axis() {
        let mut gyro = GyroBias::default();
        rest(&mut gyro, 256, Vector3::new(0.9, -0.8, 0.6));
        assert!((gyro.bias_rad_s() - Vector3::new(0.7, -0.7, 0.6)).norm() < 1e-6);
        gyro.correct(&CONFIG, Vector3::new(-0.1, -0.1, 0.05));
        assert!((gyro.bias_rad_s() - Vector3::new(0.6, -0.7, 0.65)).norm() < 1e-6);
    }

    #[test]
    fn motion_ends_the_rest_and_distrust_the_calibration() {
        let bias = Vector3::new(0.1, 0.2, 0.3);
        let mut gyro = GyroBias::default();
        rest(&mut gyro, 300, bias);
        gyro.moved();
        assert!(gyro.rest_s() == 0.0 && gyro.is_calibrated());
        rest(&mut gyro, 10, bias);
        gyro.distrust();
        assert!(gyro.rest_s() == 0.0 && !gyro.is_calibrated());
        assert!((gyro.bias_rad_s() - bias).norm() < 1e-5, "the last known is better than none");
    }
}
