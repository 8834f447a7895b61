//! How forces turn the vehicle, in the form that a log's windows take: a state in Euler angles, for each rig.
//!
//! | rig | state | equations |
//! |---|---|---|
//! | gimbal | roll, pitch, -, roll', pitch', - | [`Gimbal`] |
//! | free | roll, pitch, yaw, p, q, r; then velocity north, east, down and height | [`FreeBody`], [`Air`] |
//! | axes | roll, pitch, yaw, p, q, r | unit inertia, one input gain each; angles by their own rate or as one body's |

use super::drive::DirectInput;
use super::force_track::ForceAndSpin;
use crate::vehicle::{Air, Airframe, Attitude, FreeBody, Gimbal, Onset, RigidBody, euler_rates_rad_s};
pub(crate) use crate::vehicle::{Moment, Motion};

/// Angles (roll, pitch, yaw; rad), then rates (rad/s): of the angles on the gimbal, of the body when free and on
/// separate axes, where each is its angle's too unless the axes turn as one body's.
pub(crate) type Turning = [f64; TURNING];
/// The same, then velocity (north, east, down; m/s) and height above ground (m), which only a free vehicle has.
pub(crate) type State = [f64; FLYING];
/// Numbers of a vehicle that only turns.
pub(crate) const TURNING: usize = 6;
/// Numbers of one that flies free.
pub(crate) const FLYING: usize = 10;

/// The part of a state that turns.
pub(crate) fn turning(x: &State) -> Turning {
    let [a, b, c, d, e, f, ..] = *x;
    [a, b, c, d, e, f]
}

/// What turns, its numbers ready for the equations.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Body {
    Gimbal { airframe: Airframe, gimbal: Gimbal },
    Free { airframe: Airframe, body: FreeBody },
    Axes { gain_rad_s2: [f64; 3], input: DirectInput },
}

impl Body {
    /// A vehicle's body, its lifts turned into torque by its airframe.
    pub(crate) fn of(airframe: Airframe, body: RigidBody) -> Body {
        match body {
            RigidBody::Gimbal(gimbal) => Body::Gimbal { airframe, gimbal },
            RigidBody::Free(body) => Body::Free { airframe, body },
        }
    }

    /// The motion of a state, as moments see it.
    #[inline]
    fn motion(&self, time_s: f64, x: &Turning, roll: (f64, f64), motors: ForceAndSpin) -> Motion {
        let per_weight_1_n = match self {
            Body::Free { body, .. } => Some(body.per_weight_1_n()),
            Body::Gimbal { .. } | Body::Axes { .. } => None,
        };
        let (angle_rad, rate_rad_s) = ([x[0], x[1], x[2]], [x[3], x[4], x[5]]);
        let ForceAndSpin { force, spin } = motors;
        let is_separate = matches!(self, Body::Axes { .. });
        Motion { time_s, onset: Onset::Ramp, angle_rad, rate_rad_s, roll, is_separate, force, spin, per_weight_1_n }
    }

    /// Change of the state under what the motors do, moments, and those of the air about roll, pitch and yaw.
    pub(crate) fn derivative(
        &self,
        time_s: f64,
        x: &Turning,
        motors: &ForceAndSpin,
        moments: &[Box<dyn Moment>],
        by_air: [f64; 3],
    ) -> Turning {
        let roll = match self {
            Body::Axes { .. } => (0.0, 1.0),
            Body::Gimbal { .. } | Body::Free { .. } => libm::sincos(x[0]),
        };
        let moment = sum(by_air, moments, || self.motion(time_s, x, roll, *motors));
        let force = motors.force;
        let rate = [x[3], x[4], x[5]];
        match self {
            Body::Gimbal { airframe, gimbal } => {
                let [on_roll, on_pitch] = Gimbal::moment_nm(roll, airframe.torque_body_nm(force));
                let moment_nm = [on_roll + moment[0], on_pitch + moment[1]];
                let [roll_acceleration, pitch_acceleration] =
                    gimbal.acceleration_rad_s2(roll, [rate[0], rate[1]], moment_nm);
                [rate[0], rate[1], 0.0, roll_acceleration, pitch_acceleration, 0.0]
            }
            Body::Free { airframe, body } => {
                free(body, roll, libm::sincos(x[1]), rate, airframe.torque_body_nm(force), moment)
            }
            Body::Axes { gain_rad_s2, input } => {
                let command = input.about_axes(force);
                let acceleration = |i: usize| gain_rad_s2[i] * command[i] + moment[i];
                let [a, b, c] = rate;
                [a, b, c, acceleration(0), acceleration(1), acceleration(2)]
            }
        }
    }

    /// The same where nobody sees angles and nothing goes by them: those of a free vehicle stay as they are.
    pub(crate) fn spinning(
        &self,
        time_s: f64,
        x: &Turning,
        motors: &ForceAndSpin,
        moments: &[Box<dyn Moment>],
        by_air: [f64; 3],
    ) -> Turning {
        let Body::Free { airframe, body } = self else {
            return self.derivative(time_s, x, motors, moments, by_air);
        };
        let moment = sum(by_air, moments, || self.motion(time_s, x, (0.0, 1.0), *motors));
        let torque = airframe.torque_body_nm(motors.force);
        let on = core::array::from_fn(|axis| torque[axis] + moment[axis]);
        let [d, e, f] = body.angular_acceleration_rad_s2([x[3], x[4], x[5]], on);
        [0.0, 0.0, 0.0, d, e, f]
    }

    /// Change of a free vehicle's state under lifts as they are far from the ground; what hangs in a rig only turns.
    /// The air turns it as its velocity says, where that is not known by something else.
    pub(crate) fn flying_derivative(
        &self,
        time_s: f64,
        x: &State,
        motors: &ForceAndSpin,
        moments: &[Box<dyn Moment>],
        air: &Air,
        by_air: Option<[f64; 3]>,
    ) -> State {
        let factor = air.lift_factor(x[9]);
        let lifts_n = motors.force.map(|lift_n| factor * lift_n);
        let motors = ForceAndSpin { force: lifts_n, ..*motors };
        let Body::Free { airframe, body } = self else {
            let [a, b, c, d, e, f] = self.derivative(time_s, &turning(x), &motors, moments, [0.0; 3]);
            return [a, b, c, d, e, f, 0.0, 0.0, 0.0, 0.0];
        };
        let [roll, pitch, yaw, p, q, r, north, east, down, _] = *x;
        let attitude = Attitude::of([roll, pitch, yaw]);
        let along = attitude.in_body(air.against_m_s([north, east, down]));
        let by_air = by_air.unwrap_or_else(|| air.torque_body_nm([along[0], along[1]]));
        let moment = sum(by_air, moments, || self.motion(time_s, &turning(x), attitude.roll, motors));
        let torque = airframe.torque_body_nm(lifts_n);
        let [a, b, c, d, e, f] = free(body, attitude.roll, attitude.pitch, [p, q, r], torque, moment);
        let felt = body.specific_force_m_s2(lifts_n.iter().sum(), air.push_n(along));
        let [to_north, to_east, to_down] = attitude.in_world(felt);
        [a, b, c, d, e, f, to_north, to_east, to_down + body.gravity_m_s2, -down]
    }

    /// What an accelerometer at the centre of gravity of a free vehicle feels, body axes, m/s^2; nothing in a rig.
    pub(crate) fn felt_m_s2(&self, x: &State, force: &[f64; 4], air: &Air) -> [f64; 3] {
        let Body::Free { body, .. } = self else { return [0.0; 3] };
        let lift_n = air.lift_factor(x[9]) * force.iter().sum::<f64>();
        let push_n = if air.drags() {
            let velocity = air.against_m_s([x[6], x[7], x[8]]);
            air.push_n(Attitude::of([x[0], x[1], x[2]]).in_body(velocity))
        } else {
            [0.0; 3]
        };
        body.specific_force_m_s2(lift_n, push_n)
    }

    /// True where nothing holds it.
    pub(crate) fn flies_free(&self) -> bool {
        matches!(self, Body::Free { .. })
    }

    /// Body rates p, q, r of a state.
    pub(crate) fn rate_body_rad_s(&self, x: &Turning) -> [f64; 3] {
        match self {
            Body::Gimbal { .. } => Gimbal::rate_body_rad_s(libm::sincos(x[0]), [x[3], x[4]]),
            Body::Free { .. } | Body::Axes { .. } => [x[3], x[4], x[5]],
        }
    }

    /// The state of measured angles and body rates; 0 for what is not measured.
    pub(crate) fn state_of(&self, angle_rad: [f64; 3], rate_body_rad_s: [f64; 3]) -> Turning {
        let [roll, pitch, yaw] = angle_rad;
        let [p, q, r] = rate_body_rad_s;
        match self {
            Body::Gimbal { .. } => {
                let (sin, cos) = libm::sincos(roll);
                let [_, pitch_rate] = Gimbal::rate_rad_s((sin, cos), rate_body_rad_s);
                // without r, and away from 90 degrees, q alone decides
                let pitch_rate = if r == 0.0 { q / cos.abs().max(0.1).copysign(cos) } else { pitch_rate };
                [roll, pitch, 0.0, p, pitch_rate, 0.0]
            }
            Body::Free { .. } | Body::Axes { .. } => [roll, pitch, yaw, p, q, r],
        }
    }
}

/// Sum of the moments of a motion and of what is known of them already.
#[inline]
fn sum(known: [f64; 3], moments: &[Box<dyn Moment>], motion: impl FnOnce() -> Motion) -> [f64; 3] {
    let mut sum = known;
    if !moments.is_empty() {
        let motion = motion();
        moments.iter().for_each(|moment| moment.add(&motion, &mut sum));
    }
    sum
}

#[inline(never)]
fn free(
    body: &FreeBody,
    roll: (f64, f64),
    pitch: (f64, f64),
    rate: [f64; 3],
    torque: [f64; 3],
    moment: [f64; 3],
) -> Turning {
    let [a, b, c] = euler_rates_rad_s(roll, pitch, rate);
    let on = core::array::from_fn(|axis| torque[axis] + moment[axis]);
    let [d, e, f] = body.angular_acceleration_rad_s2(rate, on);
    [a, b, c, d, e, f]
}
