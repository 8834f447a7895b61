//! The levelling against vehicles whose motion is integrated here, in double precision.

#![allow(clippy::disallowed_methods, reason = "the truth is integrated in double precision on the host")]

use nalgebra::{UnitQuaternion as Rotation, Vector3 as Vector};
use proptest::prelude::*;

use super::*;
use crate::frames::{down_in_body, normalized, q_from_rotation_vector};
use crate::sensing::estimator::turned;

const CONFIG: LevellingConfig = LevellingConfig::NOMINAL;
const G: f32 = 9.806_65;
const STEP_S: f32 = 0.0025;

/// A vehicle and what its levelling makes of it.
struct Flight {
    truth: Rotation<f64>,
    velocity_m_s: Vector<f64>,
    /// Along the body's axes, while held and in the air.
    drag_1_s: f64,
    support: Support,
    estimate: UnitQuaternion<f32>,
    bias_rad_s: Vector3<f32>,
    levelling: Levelling,
    /// What the gyro reads at rest.
    drift_rad_s: Vector<f64>,
    /// Peak of a line of 90 Hz on x and y, m/s^2.
    shaken_m_s2: f64,
    /// From the centre of gravity to the IMU, body, m.
    lever_m: Vector<f64>,
    /// Reading of the gyro about yaw over the rate.
    yaw_scale: f64,
    time_s: f64,
}

impl Flight {
    fn new(support: Support) -> Self {
        Self {
            truth: Rotation::identity(),
            velocity_m_s: Vector::zeros(),
            drag_1_s: CONFIG.rotor_drag_1_s.into(),
            support,
            estimate: UnitQuaternion::identity(),
            bias_rad_s: Vector3::zeros(),
            levelling: Levelling::begin(&CONFIG, CONFIG.tilt_std_rad),
            drift_rad_s: Vector::zeros(),
            shaken_m_s2: 0.0,
            lever_m: Vector::zeros(),
            yaw_scale: 1.0,
            time_s: 0.0,
        }
    }

    /// Turning at a rate, body, rad/s, its lift as at hover whatever the tilt.
    fn fly(&mut self, duration_s: f64, rate_rad_s: Vector<f64>) {
        let step_s = f64::from(STEP_S);
        for _ in 0..(duration_s / step_s).round() as usize {
            let down = Vector::new(0.0, 0.0, f64::from(G));
            let felt_m_s2 = match self.support {
                Support::Held => self.truth.inverse() * -down,
                Support::Air => {
                    let u = self.truth.inverse() * self.velocity_m_s;
                    Vector::new(-self.drag_1_s * u.x, -self.drag_1_s * u.y, f64::from(-G))
                }
            };
            if self.support == Support::Air {
                self.velocity_m_s += (self.truth * felt_m_s2 + down) * step_s;
            }
            self.truth *= Rotation::from_scaled_axis(rate_rad_s * step_s);
            self.time_s += step_s;
            // two of its samples a step, as a mean
            let line = |late_s: f64| (core::f64::consts::TAU * 90.0 * (self.time_s + late_s)).sin_cos();
            let ((sin, cos), (sin_2, cos_2)) = (line(0.0), line(0.5 * step_s));
            let shaken = Vector::new(0.5 * (cos + cos_2), 0.5 * (sin + sin_2), 0.0) * self.shaken_m_s2;
            let inward_m_s2 = rate_rad_s.cross(&rate_rad_s.cross(&self.lever_m));
            let felt_m_s2 = felt_m_s2 + inward_m_s2;
            let shown_rad_s = Vector::new(rate_rad_s.x, rate_rad_s.y, self.yaw_scale * rate_rad_s.z);
            let gyro = (shown_rad_s + self.drift_rad_s).cast::<f32>();
            let imu = ImuStep {
                samples: 2,
                duration_s: STEP_S,
                after_gap: false,
                rotation_rad: gyro * STEP_S,
                rate_body_rad_s: gyro,
                specific_force_m_s2: (felt_m_s2 + shaken).cast(),
                // what the low-pass of 5 Hz leaves of the line is a hundredth
                steady_force_m_s2: felt_m_s2.cast(),
                vibration_m_s2: Vector3::repeat(self.shaken_m_s2 as f32 * 0.7),
            };
            self.take(&imu);
        }
    }

    fn take(&mut self, imu: &ImuStep) {
        let found = self.levelling.update(&CONFIG, G, &self.estimate, imu, self.support);
        self.estimate = turned(&self.estimate, &(imu.rotation_rad - self.bias_rad_s * imu.duration_s));
        if let Some(found) = found {
            let correction = q_from_rotation_vector(&found.tilt_rad);
            self.estimate = normalized((correction * self.estimate).into_inner());
            self.bias_rad_s += found.bias_rad_s;
        }
    }

    fn error_deg(&self) -> f64 {
        let truth = self.truth.inverse() * Vector::z();
        truth.cross(&down_in_body(&self.estimate).cast()).norm().asin().to_degrees()
    }

    fn standard_deviation(&self, state: usize) -> f32 {
        self.levelling.covariance.variance(state).sqrt()
    }
}

/// The issue's own: 30 degrees for 3 s in still air, the drag known to 30 %, after a hover that tells nothing of it.
#[test]
fn a_tilt_that_is_held_in_still_air_stays() {
    for factor in [0.7, 1.0, 1.3] {
        for axis in [Vector::x(), -Vector::y()] {
            let mut flight = Flight::new(Support::Air);
            flight.drag_1_s *= factor;
            flight.fly(5.0, Vector::zeros());
            flight.fly(0.5, axis * 60f64.to_radians());
            let mut worst_deg = 0.0;
            for _ in 0..12 {
                flight.fly(0.25, Vector::zeros());
                worst_deg = f64::max(worst_deg, flight.error_deg());
            }
            assert!(worst_deg < 1.0, "{factor}: {worst_deg}");
            // what the flight said of its drag is true
            assert!((f64::from(flight.levelling.drag_1_s()) / flight.drag_1_s - 1.0).abs() < 0.15, "{factor}");
        }
    }
}

/// A vehicle without a motor spins for half a minute, 16 or 40 rad/s either way, its IMU 3 cm from the axis, where it
/// feels up to five times the weight, its gyro 2 % off and drifting, after 5 degrees of wrong tilt: all of it is found,
/// and what the spin makes is taken neither for a tilt nor for a drag.
#[test]
fn a_spin_is_level_wherever_the_imu_sits() {
    for (spin_rad_s, yaw_scale) in [(16.0, 1.02), (16.0, 0.98), (-40.0, 1.0), (40.0, 1.02)] {
        let mut flight = Flight::new(Support::Air);
        (flight.lever_m, flight.yaw_scale) = (Vector::new(0.025, -0.015, -0.02), yaw_scale);
        flight.fly(5.0, Vector::zeros());
        flight.drift_rad_s = Vector::new(0.5, -0.5, 0.0).map(f64::to_radians);
        let wrong = q_from_rotation_vector(&Vector3::new(0.06, -0.06, 0.0));
        flight.estimate = normalized((wrong * flight.estimate).into_inner());
        flight.levelling.covariance.forget(TILT..VELOCITY, 0.1 * 0.1);
        for part in 0..40 {
            flight.fly(0.1, Vector::new(0.0, 0.0, spin_rad_s * f64::from(part) / 40.0));
        }
        for second in 0..30 {
            flight.fly(1.0, Vector::new(0.0, 0.0, spin_rad_s));
            let error_deg = flight.error_deg();
            assert!(second < 4 || error_deg < 0.3, "{spin_rad_s} rad/s, {yaw_scale}, {second} s: {error_deg} degrees");
        }
        let drag = f64::from(flight.levelling.drag_1_s()) / flight.drag_1_s;
        assert!((drag - 1.0).abs() < 0.4, "{spin_rad_s} rad/s: {drag}");
    }
}

/// In the air and held: a drift of half a degree a second is found within seconds, and its error with it.
#[test]
fn a_drifting_gyro_is_found_out() {
    for (support, shaken_m_s2) in
        [(Support::Air, 0.0), (Support::Air, 30.0), (Support::Held, 0.0), (Support::Held, 30.0)]
    {
        let mut flight = Flight::new(support);
        flight.shaken_m_s2 = shaken_m_s2;
        flight.drift_rad_s = Vector::new(0.5, -0.5, 0.0).map(f64::to_radians);
        flight.fly(20.0, Vector::zeros());
        assert!(flight.error_deg() < 0.3, "{support:?} {shaken_m_s2}: {} degrees", flight.error_deg());
        let missed = (flight.bias_rad_s.cast() - flight.drift_rad_s).norm().to_degrees();
        assert!(missed < 0.07, "{support:?} {shaken_m_s2}: {missed} deg/s");
        // and it knows how well it knows
        assert!(missed.to_radians() < 3.0 * f64::from(self::larger_of(&flight)), "{missed}");
    }
}

fn larger_of(flight: &Flight) -> f32 {
    (BIAS..DRAG).map(|state| flight.standard_deviation(state)).fold(0.0, f32::max)
}

/// A wrong tilt is taken out while the vehicle is held, at any attitude.
#[test]
fn held_the_accelerometer_is_level() {
    for tilt in [0.0, 1.0, 2.8] {
        let mut flight = Flight::new(Support::Held);
        flight.truth = Rotation::from_scaled_axis(Vector::new(tilt, 0.3 * tilt, 0.0));
        flight.estimate = Rotation::from_scaled_axis(Vector::new(tilt + 0.02, 0.3 * tilt, 0.0)).cast();
        flight.fly(30.0, Vector::zeros());
        assert!(flight.error_deg() < 0.1, "{tilt}: {}", flight.error_deg());
    }
}

/// Air that moves steadily takes the vehicle along; let go at rest over ground it feels it as a velocity, and tilts for
/// it if it wants to stay. Neither is an error of the attitude.
#[test]
fn a_steady_wind_is_no_tilt() {
    let mut flight = Flight::new(Support::Held);
    flight.fly(1.0, Vector::zeros());
    flight.support = Support::Air;
    flight.velocity_m_s = Vector::new(-4.0, 2.0, 0.0);
    let mut worst_deg = 0.0;
    for _ in 0..40 {
        flight.fly(0.25, Vector::zeros());
        worst_deg = f64::max(worst_deg, flight.error_deg());
    }
    assert!(worst_deg < 1.0, "{worst_deg}");
    assert!((flight.levelling.velocity_m_s().cast() - flight.velocity_m_s).xy().norm() < 0.3);
}

/// No drag at all leaves nothing to see. That is found out, and from then on the gyro is believed: 20 degrees, held
/// again and again, would be a third of that after one of them if the accelerometer were followed.
#[test]
fn without_drag_the_gyro_is_believed() {
    let mut flight = Flight::new(Support::Air);
    flight.drag_1_s = 0.0;
    for round in 0..10u8 {
        let side = if round.is_multiple_of(2) { 1.0 } else { -1.0 };
        flight.fly(0.5, Vector::x() * side * 40f64.to_radians());
        flight.fly(2.0, Vector::zeros());
        flight.fly(0.5, Vector::x() * -side * 40f64.to_radians());
        flight.fly(2.0, Vector::zeros());
    }
    assert!(flight.error_deg() < 4.0 && flight.levelling.drag_1_s() < 0.1, "{} degrees", flight.error_deg());
}

/// The window's own arithmetic against whole matrices in double precision: F P F^T + Q, then Joseph's form.
#[test]
fn the_covariance_is_that_of_whole_matrices() {
    type Matrix = nalgebra::SMatrix<f64, STATES, STATES>;
    let axes = [Vector3::new(0.6f32, 0.8, 0.0), Vector3::new(-0.8, 0.6, 0.0), Vector3::z()];
    let window_m_s = Vector3::new(0.05f32, -0.03, -0.2);
    let mut ours = Covariance::of([1e-3, 2e-3, 0.5, 0.4, 2.0, 1e-4, 2e-4, 3e-4, 0.02]);
    let mut whole = Matrix::zeros();
    for i in 0..STATES {
        whole[(i, i)] = f64::from(ours.variance(i));
    }
    let noises = Noises { gyro: CONFIG.gyro_noise, force: 0.1, bias: CONFIG.bias_walk };
    let sees_first: [f32; STATES] = [0.3, -0.2, -0.4, 0.1, 0.0, 0.0, 0.0, 0.0, -2.0];
    let sees_second: [f32; STATES] = [-0.1, 0.4, 0.2, -0.45, 0.05, 0.0, 0.0, 0.0, 1.0];
    for _ in 0..50 {
        ours.predict(&noises, &axes, &window_m_s, 0.02);
        let mut f = Matrix::identity();
        for (j, axis) in axes.iter().enumerate() {
            f[(TILT, BIAS + j)] = f64::from(-axis.x * 0.02);
            f[(TILT + 1, BIAS + j)] = f64::from(-axis.y * 0.02);
        }
        // v' = phi x a, column by column
        for (j, phi) in [Vector3::x(), Vector3::y()].into_iter().enumerate() {
            let gained = phi.cross(&window_m_s);
            (0..3).for_each(|i| f[(VELOCITY + i, TILT + j)] = f64::from(gained[i]));
        }
        let densities = [CONFIG.gyro_noise, CONFIG.gyro_noise, 0.1, 0.1, 0.1]
            .into_iter()
            .chain([CONFIG.bias_walk; 3])
            .map(|noise| f64::from(noise).powi(2))
            .chain([1e-5]);
        whole = f * whole * f.transpose();
        densities.enumerate().for_each(|(i, density)| whole[(i, i)] += density * 0.02);
        for sees in [sees_first, sees_second] {
            let mut errors = [0.0; STATES];
            ours.compare(&mut errors, &sees, 0.0, 0.5);
            let h = nalgebra::RowSVector::<f64, STATES>::from_iterator(sees.map(f64::from));
            let gain = whole * h.transpose() / ((h * whole * h.transpose())[0] + 0.5);
            let kept = Matrix::identity() - gain * h;
            whole = kept * whole * kept.transpose() + gain * 0.5 * gain.transpose();
        }
    }
    for i in 0..STATES {
        let expected = whole[(i, i)];
        assert!((f64::from(ours.variance(i)) / expected - 1.0).abs() < 1e-3, "{i}: {} {expected}", ours.variance(i));
    }
}

/// One that misses by far more than expected counts for less, in proportion to the miss, and never for nothing.
#[test]
fn a_comparison_counts_by_how_far_it_misses() {
    let found = |residual: f32| {
        let mut errors = [0.0; STATES];
        let mut sees = [0.0; STATES];
        sees[VELOCITY] = 1.0;
        Covariance::of([1e-4; STATES]).compare(&mut errors, &sees, residual, 1.0);
        errors[VELOCITY]
    };
    let gain = 1e-4 / (1.0 + 1e-4);
    for residual in [0.0, 0.5, -3.0] {
        assert!((found(residual) - gain * residual).abs() < 1e-7, "{residual}");
    }
    // beyond three deviations the variance counts (r / 3)^2 times, so that what is found falls as 9 / r
    assert!(
        (found(30.0) / (1e-4 * 9.0 / 30.0) - 1.0).abs() < 1e-3 && (found(-300.0) + 1e-4 * 9.0 / 300.0).abs() < 1e-9
    );
}

/// Ten minutes of manoeuvres: no variance is lost or grows beyond all bounds, and the attitude stays right.
#[test]
fn it_lasts() {
    let mut flight = Flight::new(Support::Air);
    flight.drift_rad_s = Vector::new(0.002, 0.003, -0.004);
    for round in 0..120u32 {
        let axis = [Vector::x(), Vector::y(), Vector::z()][round as usize % 3];
        flight.fly(0.5, axis * 40f64.to_radians());
        flight.fly(1.5, Vector::zeros());
        flight.fly(0.5, axis * -40f64.to_radians());
        flight.fly(2.5, Vector::zeros());
        assert!(round < 2 || flight.error_deg() < 1.0, "{round}: {}", flight.error_deg());
    }
    assert!(flight.levelling.covariance.is_sound());
    assert!(flight.standard_deviation(TILT) > 1e-4 && flight.standard_deviation(TILT) < 0.02);
}

proptest! {
    /// Whatever an accelerometer says, finite numbers come out of it, and a tilt that can be.
    #[test]
    fn nonsense_stays_finite(
        forces in proptest::collection::vec((-1e30f32..1e30, -1e3f32..1e3, -1e30f32..1e30), 1..60),
        flies in any::<bool>(),
    ) {
        let mut flight = Flight::new(if flies { Support::Air } else { Support::Held });
        for (x, y, z) in forces {
            let force = Vector3::new(x, y, z);
            let imu = ImuStep {
                samples: 1,
                duration_s: 0.01,
                after_gap: false,
                rotation_rad: Vector3::zeros(),
                rate_body_rad_s: Vector3::zeros(),
                specific_force_m_s2: force,
                steady_force_m_s2: force,
                vibration_m_s2: Vector3::zeros(),
            };
            flight.take(&imu);
            prop_assert!(flight.estimate.coords.iter().all(|part| part.is_finite()));
            prop_assert!((flight.estimate.coords.norm() - 1.0).abs() < 1e-5);
            prop_assert!(flight.levelling.velocity_m_s().iter().all(|speed| speed.abs() < 1e30));
        }
        // and it finds back
        flight.fly(5.0, Vector::zeros());
        prop_assert!(flight.levelling.covariance.is_sound());
    }
}
