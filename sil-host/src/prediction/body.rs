//! How forces turn the vehicle: the rigs' equations of motion, written for the diagnosis and apart from the plant's.
//!
//! | rig | state | equations |
//! |---|---|---|
//! | gimbal | roll, pitch, -, roll', pitch', - | docs/rig.md, rig A, with an off-diagonal inertia P: kinetic energy + P p q |
//! | free | roll, pitch, yaw, p, q, r; then velocity north, east, down and height | Euler's, angles Z-Y-X; Newton's (`air`) |
//! | axes | angles and their derivatives | unit inertia, one input gain each |

use crate::model::{Mounting, VehicleModel};
use crate::prediction::air::{Air, Attitude};

/// Angles (roll, pitch, yaw; rad), then rates (rad/s): of the angles on the gimbal and on separate axes, of the body when free.
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

/// What a moment may depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Time, s.
    pub(crate) time_s: f64,
    /// Roll, pitch, yaw, rad.
    pub(crate) angle_rad: [f64; 3],
    /// Rates that plant effects act against (docs/effects.md): of the angles, or of the body when free.
    pub(crate) rate_rad_s: [f64; 3],
    /// Sine and cosine of roll.
    pub(crate) roll: (f64, f64),
    /// The four forces: the motors' lifts, N; on separate axes the axis commands.
    pub(crate) force: [f64; 4],
}

/// A moment beside the motors', about the rig's axes or, free, the body's.
pub(crate) trait Moment: Sync + Send {
    /// Adds it, N m (rad/s^2 on separate axes).
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]);
}

/// Rig and inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Body {
    pub(crate) rig: BodyRig,
    /// True over nominal inertia per axis.
    pub(crate) inertia_scale: [f64; 3],
    /// Off-diagonal inertia P between roll and pitch, kg m^2.
    pub(crate) product_kg_m2: f64,
}

/// The numbers of each rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BodyRig {
    Gimbal { airframe: Airframe, inertia_kg_m2: [f64; 3], ring_inertia_kg_m2: f64 },
    Free { airframe: Airframe, inertia_kg_m2: [f64; 3], mass_kg: f64, gravity_m_s2: f64 },
    Axes { gain_rad_s2: [f64; 3] },
}

/// From lifts to torques, quad-X (docs/rig.md, "Frames and motors").
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Airframe {
    lever_m: f64,
    reaction_torque_per_lift_m: f64,
}

impl Airframe {
    fn torque_body_nm(&self, f: &[f64; 4]) -> [f64; 3] {
        [
            self.lever_m * (f[1] + f[2] - f[0] - f[3]),
            self.lever_m * (f[0] + f[2] - f[1] - f[3]),
            self.reaction_torque_per_lift_m * (f[0] + f[1] - f[2] - f[3]),
        ]
    }
}

impl Body {
    /// The nominal body of a model.
    pub(crate) fn of(model: &VehicleModel) -> Body {
        let airframe = Airframe {
            lever_m: model.arm_m * core::f64::consts::FRAC_1_SQRT_2,
            reaction_torque_per_lift_m: model.propulsion.reaction_torque_per_lift_m(),
        };
        let inertia_kg_m2 = model.inertia_kg_m2;
        let rig = match model.mounting {
            Mounting::Gimbal { ring_inertia_kg_m2 } => BodyRig::Gimbal { airframe, inertia_kg_m2, ring_inertia_kg_m2 },
            Mounting::Free { mass_kg } => {
                BodyRig::Free { airframe, inertia_kg_m2, mass_kg, gravity_m_s2: model.gravity_m_s2 }
            }
        };
        Body { rig, inertia_scale: [1.0; 3], product_kg_m2: 0.0 }
    }

    /// Separate axes.
    pub(crate) fn axes(gain_rad_s2: [f64; 3]) -> Body {
        Body { rig: BodyRig::Axes { gain_rad_s2 }, inertia_scale: [1.0; 3], product_kg_m2: 0.0 }
    }

    /// Change of the state under forces and moments.
    pub(crate) fn derivative(
        &self,
        time_s: f64,
        x: &Turning,
        force: &[f64; 4],
        moments: &[Box<dyn Moment>],
    ) -> Turning {
        let level = (0.0, 1.0);
        let roll = match self.rig {
            BodyRig::Axes { .. } => level,
            BodyRig::Gimbal { .. } | BodyRig::Free { .. } => libm::sincos(x[0]),
        };
        let motion =
            Motion { time_s, angle_rad: [x[0], x[1], x[2]], rate_rad_s: [x[3], x[4], x[5]], roll, force: *force };
        let mut moment = [0.0; 3];
        for effect in moments {
            effect.add(&motion, &mut moment);
        }
        match &self.rig {
            BodyRig::Gimbal { airframe, inertia_kg_m2, ring_inertia_kg_m2 } => {
                self.gimbal(&motion, &airframe.torque_body_nm(force), &moment, inertia_kg_m2, *ring_inertia_kg_m2)
            }
            BodyRig::Free { airframe, inertia_kg_m2, .. } => {
                let pitch = libm::sincos(x[1]);
                self.free(&motion, pitch, &airframe.torque_body_nm(force), &moment, inertia_kg_m2)
            }
            BodyRig::Axes { gain_rad_s2 } => {
                let acceleration = |i: usize| (gain_rad_s2[i] * force[i] + moment[i]) / self.inertia_scale[i];
                [x[3], x[4], x[5], acceleration(0), acceleration(1), acceleration(2)]
            }
        }
    }

    fn gimbal(&self, m: &Motion, tau: &[f64; 3], moment: &[f64; 3], inertia: &[f64; 3], ring: f64) -> Turning {
        let [roll_rate, pitch_rate, _] = m.rate_rad_s;
        let ((sin, cos), [ixx, iyy, izz]) = (m.roll, *inertia);
        let j = self.inertia_scale[1] * (ring + iyy * cos * cos + izz * sin * sin);
        let j_slope = self.inertia_scale[1] * 2.0 * (izz - iyy) * sin * cos;
        let i = self.inertia_scale[0] * ixx;
        let on_roll = tau[0] + moment[0] + 0.5 * j_slope * pitch_rate * pitch_rate;
        let on_pitch = tau[1] * cos - tau[2] * sin + moment[1] - j_slope * roll_rate * pitch_rate
            + self.product_kg_m2 * sin * roll_rate * roll_rate;
        // mass matrix [i, c; c, j]
        let c = self.product_kg_m2 * cos;
        let determinant = i * j - c * c;
        let roll_acceleration = (j * on_roll - c * on_pitch) / determinant;
        let pitch_acceleration = (i * on_pitch - c * on_roll) / determinant;
        [roll_rate, pitch_rate, 0.0, roll_acceleration, pitch_acceleration, 0.0]
    }

    #[inline(never)]
    fn free(
        &self,
        m: &Motion,
        (sin_pitch, cos_pitch): (f64, f64),
        tau: &[f64; 3],
        moment: &[f64; 3],
        inertia: &[f64; 3],
    ) -> Turning {
        let [p, q, r] = m.rate_rad_s;
        let [ix, iy, iz] = [0, 1, 2].map(|axis: usize| inertia[axis] * self.inertia_scale[axis]);
        let product = self.product_kg_m2;
        // angular momentum with the off-diagonal entry, and its turn with the body
        let h = [ix * p + product * q, product * p + iy * q, iz * r];
        let on = [
            tau[0] + moment[0] - (q * h[2] - r * h[1]),
            tau[1] + moment[1] - (r * h[0] - p * h[2]),
            tau[2] + moment[2] - (p * h[1] - q * h[0]),
        ];
        let determinant = ix * iy - product * product;
        let (sin_roll, cos_roll) = m.roll;
        // near the vertical the angles lose their meaning, the formulas stay finite
        let heading = (q * sin_roll + r * cos_roll) / cos_pitch.abs().max(1e-3).copysign(cos_pitch);
        [
            p + sin_pitch * heading,
            q * cos_roll - r * sin_roll,
            heading,
            (iy * on[0] - product * on[1]) / determinant,
            (ix * on[1] - product * on[0]) / determinant,
            on[2] / iz,
        ]
    }

    /// Change of a free vehicle's state under lifts as they are far from the ground; what hangs in a rig only turns.
    pub(crate) fn flying_derivative(
        &self,
        time_s: f64,
        x: &State,
        force: &[f64; 4],
        moments: &[Box<dyn Moment>],
        air: &Air,
    ) -> State {
        let factor = air.lift_factor(x[9]);
        let lifts_n = force.map(|lift_n| factor * lift_n);
        let BodyRig::Free { airframe, inertia_kg_m2, mass_kg, gravity_m_s2 } = &self.rig else {
            let [a, b, c, d, e, f] = self.derivative(time_s, &turning(x), &lifts_n, moments);
            return [a, b, c, d, e, f, 0.0, 0.0, 0.0, 0.0];
        };
        let [roll, pitch, yaw, p, q, r, north, east, down, _] = *x;
        let attitude = Attitude::of(roll, pitch, yaw);
        let motion = Motion {
            time_s,
            angle_rad: [roll, pitch, yaw],
            rate_rad_s: [p, q, r],
            roll: attitude.roll,
            force: lifts_n,
        };
        let mut moment = [0.0; 3];
        for effect in moments {
            effect.add(&motion, &mut moment);
        }
        let tau = airframe.torque_body_nm(&lifts_n);
        let [a, b, c, d, e, f] = self.free(&motion, attitude.pitch, &tau, &moment, inertia_kg_m2);
        let specific = air.specific_force_m_s2(*mass_kg, lifts_n.iter().sum(), &attitude, [north, east, down]);
        let [to_north, to_east, to_down] = attitude.in_world(specific);
        [a, b, c, d, e, f, to_north, to_east, to_down + gravity_m_s2, -down]
    }

    /// What an accelerometer at the centre of gravity of a free vehicle feels, body axes, m/s^2; nothing in a rig.
    pub(crate) fn felt_m_s2(&self, x: &State, force: &[f64; 4], air: &Air) -> [f64; 3] {
        let BodyRig::Free { mass_kg, .. } = self.rig else { return [0.0; 3] };
        let lift_n = air.lift_factor(x[9]) * force.iter().sum::<f64>();
        air.specific_force_m_s2(mass_kg, lift_n, &Attitude::of(x[0], x[1], x[2]), [x[6], x[7], x[8]])
    }

    /// True where nothing holds it.
    pub(crate) fn flies_free(&self) -> bool {
        matches!(self.rig, BodyRig::Free { .. })
    }

    /// Body rates p, q, r of a state.
    pub(crate) fn rate_body_rad_s(&self, x: &Turning) -> [f64; 3] {
        match self.rig {
            BodyRig::Gimbal { .. } => {
                let (sin, cos) = libm::sincos(x[0]);
                [x[3], x[4] * cos, -x[4] * sin]
            }
            BodyRig::Free { .. } | BodyRig::Axes { .. } => [x[3], x[4], x[5]],
        }
    }

    /// The state of measured angles and body rates; 0 for what is not measured.
    pub(crate) fn state_of(&self, angle_rad: [f64; 3], rate_body_rad_s: [f64; 3]) -> Turning {
        let [roll, pitch, yaw] = angle_rad;
        let [p, q, r] = rate_body_rad_s;
        match self.rig {
            BodyRig::Gimbal { .. } => {
                let (sin, cos) = libm::sincos(roll);
                // without r, and away from 90 degrees, q alone tells
                let pitch_rate = if r == 0.0 { q / cos.abs().max(0.1).copysign(cos) } else { q * cos - r * sin };
                [roll, pitch, 0.0, p, pitch_rate, 0.0]
            }
            BodyRig::Free { .. } | BodyRig::Axes { .. } => [roll, pitch, yaw, p, q, r],
        }
    }
}
