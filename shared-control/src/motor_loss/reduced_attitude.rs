//! The thrust's axis with three motors: upright, from any attitude, while the vehicle spins about it.
//!
//! The two sides turn alike, so nothing holds the heading: the vehicle spins up until the air's drag balances their
//! reaction torque. Upright, the far motor at rest and the sides carrying half of the weight each is an equilibrium;
//! the sides' difference turns about one axis of the body, which passes through all directions as it spins.

use super::Felt;
use super::allocation::{lifts_n, opposite};
use super::complex::Complex;
use super::spin_disturbance::SpinDisturbance;
use super::spin_frame::SpinFrame;
use super::spin_gains::{SpinGains, Spinning};
use crate::airframe::TORQUE_SIGNS;
use crate::elementary::{asin, larger, limit, sqrt};
use crate::frames::down_in_body;
use crate::lift_curve::LiftCurve;
use crate::vehicle::VehicleParameters;

/// Tilt that counts at most, rad: a vehicle that lies or is upside down turns back at the rate for this.
const TILT_COUNTED_RAD: f32 = 1.2;
/// Lift is raised for the tilt by at most this.
const RAISE_MAX: f32 = 1.3;
/// Torque from outside that is counted at most, of that of a motor's largest lift.
const OUTSIDE_SHARE_MAX: f32 = 0.25;
/// Angular momentum of a rotor over the root of its lift and the arm's third power, kg s^-1 m^-1 N^-1/2: an F450's, of
/// 5.44e-5 kg m^2 and 1.105e-5 N s^2 (`models/f450-free.toml`). Alike rotors have an inertia that goes with the fifth
/// power of their size and a lift that goes with the fourth.
const ROTOR_MOMENTUM: f32 = 1.418;
/// Of the largest lift, what a side makes that carries half of the vehicle.
const SIDE_SHARE: f32 = 0.66;
/// Of the largest lift, what the sides make at least: a rotor that stops takes long to start.
const SIDE_MIN_SHARE: f32 = 0.06;

/// From this spin on the far motor stands still where nothing is asked of it, rad/s, and until then turns as slowly as
/// on the ground: what it lifts turns with the body, and near the spin at which roll and pitch do not couple nothing
/// holds that.
const FAR_STANDS_RAD_S: f32 = 6.0;

/// What it needs to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReducedAttitude {
    gains: SpinGains,
    rotor_nm_s_per_root_n: f32,
    inertia_kg_m2: [f32; 2],
    inertia_ratio: f32,
    lever_m: f32,
    step_s: f32,
    outside_max_rad_s2: f32,
}

impl ReducedAttitude {
    /// For a vehicle in free flight.
    pub fn new(vehicle: &VehicleParameters, loop_rate_hz: f32) -> Self {
        let [roll, pitch, yaw] = vehicle.inertia_kg_m2;
        let mean = 0.5 * (roll + pitch);
        let inertia_ratio = (yaw - mean) / mean;
        let rotor_nm_s_per_root_n = ROTOR_MOMENTUM * vehicle.arm_m * vehicle.arm_m * vehicle.arm_m;
        let side_nm_s = rotor_nm_s_per_root_n * sqrt(SIDE_SHARE * vehicle.lift_curve.lift_max_n);
        let rotors_rad_s = 2.0 * side_nm_s / mean;
        Self {
            gains: SpinGains::new(&Spinning { inertia_ratio, rotors_rad_s, lag_s: vehicle.actuation.lag_s }),
            rotor_nm_s_per_root_n,
            inertia_kg_m2: [roll, pitch],
            inertia_ratio,
            lever_m: vehicle.lever_m(),
            step_s: 1.0 / loop_rate_hz,
            outside_max_rad_s2: OUTSIDE_SHARE_MAX * vehicle.lever_m() * vehicle.lift_curve.lift_max_n / mean,
        }
    }

    /// What is known of a torque from outside as it takes over, from the angular acceleration that no motor explained
    /// until then, rad/s^2.
    pub fn begin(&self, felt: &Felt, [roll_rad_s2, pitch_rad_s2]: [f32; 2]) -> SpinDisturbance {
        let rate = &felt.estimate.rate_body_rad_s;
        SpinDisturbance::at(Complex { re: rate.x, im: rate.y }, Complex { re: roll_rad_s2, im: pitch_rad_s2 })
    }

    /// Commands of the four motors, of which one is lost, with what the others lift now, N, and the command of one that
    /// rests.
    pub fn commands(
        &self,
        felt: &Felt,
        outside: &mut SpinDisturbance,
        lost: usize,
        lifting_n: &[f32; 4],
        (curve, rest_command): (&LiftCurve, f32),
    ) -> [f32; 4] {
        let down = down_in_body(&felt.estimate.q_world_from_body);
        let rate = &felt.estimate.rate_body_rad_s;
        let turning = Complex { re: self.turning(0, lifting_n), im: self.turning(1, lifting_n) };
        let rolling = Complex { re: rate.x, im: rate.y };
        let spins = [rate.z, self.precession_rad_s(rate.z, lifting_n), self.outside_max_rad_s2];
        let outside = outside.update(self.step_s, spins, rolling, turning);
        let frame = SpinFrame::without(lost);
        let now = [tilt_error(down.x, down.y, down.z), rolling, turning, outside].map(|value| frame.seen(value));
        let spin_rad_s = frame.spin_rad_s(rate.z);
        let wanted = frame.roll_pitch(self.gains.at(spin_rad_s).answer(now));
        let [roll, pitch] = self.inertia_kg_m2;
        let torque_nm = [roll * finite(wanted.re), pitch * finite(wanted.im)];
        let upright = limit(1.0 / larger(down.z, 0.5), 1.0, RAISE_MAX);
        let sum_n = 4.0 * felt.lift_per_motor_n * upright;
        let limits_n = [SIDE_MIN_SHARE * curve.lift_max_n, curve.lift_max_n];
        let lifts = lifts_n(lost, torque_nm, sum_n, self.lever_m, limits_n);
        let mut commands = [0.0; 4];
        for (motor, (command, lift_n)) in commands.iter_mut().zip(lifts).enumerate() {
            let rests = motor == opposite(lost) && lift_n <= curve.lift_min_n;
            *command = match rests {
                _ if motor == lost || rests && spin_rad_s > FAR_STANDS_RAD_S => 0.0,
                true => rest_command,
                false => curve.command(lift_n),
            };
        }
        commands
    }

    /// How fast roll and pitch would turn into each other in the body without any torque, rad/s.
    fn precession_rad_s(&self, yaw_rad_s: f32, lifting_n: &[f32; 4]) -> f32 {
        let [roll, pitch] = self.inertia_kg_m2;
        // a rotor turns against the torque that the air's drag on it has on the body
        let signs = TORQUE_SIGNS[2].iter().zip(lifting_n);
        let rotors_nm_s: f32 =
            signs.map(|(sign, lift_n)| -sign * self.rotor_nm_s_per_root_n * sqrt(larger(*lift_n, 0.0))).sum();
        self.inertia_ratio * yaw_rad_s + rotors_nm_s / (0.5 * (roll + pitch))
    }

    /// Angular acceleration that the motors make about roll or pitch, rad/s^2.
    fn turning(&self, axis: usize, lifting_n: &[f32; 4]) -> f32 {
        let lift_n: f32 = TORQUE_SIGNS[axis].iter().zip(lifting_n).map(|(sign, lift_n)| sign * lift_n).sum();
        self.lever_m * lift_n / self.inertia_kg_m2[axis]
    }
}

/// The rotation about roll and pitch that brings the thrust upright, rad, from where down is in the body.
fn tilt_error(x: f32, y: f32, z: f32) -> Complex {
    let sine = sqrt(x * x + y * y);
    let tilt_rad = if z > 0.0 { limit(asin(sine), 0.0, TILT_COUNTED_RAD) } else { TILT_COUNTED_RAD };
    // straight upside down any way will do
    if sine > 1e-6 {
        Complex { re: -y, im: x }.scaled(tilt_rad / sine)
    } else if z > 0.0 {
        Complex::ZERO
    } else {
        Complex { re: TILT_COUNTED_RAD, im: 0.0 }
    }
}

fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}
