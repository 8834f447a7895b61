//! What the controllers know of the vehicle. Numbers only: the plant is somewhere else and shares no code with this.

use crate::gravity_moment::GravityMoment;
use crate::lift_curve::LiftCurve;
use crate::mpc::schedule::PitchInertia;

/// Parameters of the vehicle on its rig, as the controllers need them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleParameters {
    /// Gravity, m/s^2.
    pub gravity_m_s2: f32,
    /// Motor to centre, m.
    pub arm_m: f32,
    /// Inertia about the body axes with whatever turns along with them (the rig's rings), kg m^2.
    pub inertia_kg_m2: [f32; 3],
    /// Part of the inertia about pitch that does not roll along: the rig's ring, kg m^2; 0 in free flight.
    pub ring_inertia_kg_m2: f32,
    /// Reaction torque per lift of one motor, m.
    pub torque_per_lift_m: f32,
    /// Command and lift of one motor.
    pub lift_curve: LiftCurve,
    /// From command to lift.
    pub actuation: Actuation,
    /// What gravity does to masses off the rig's axes.
    pub gravity_moment: GravityMoment,
    /// True on a rig whose heading can't move.
    pub yaw_locked: bool,
}

/// How a motor's lift follows its command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actuation {
    /// Pure delay, s.
    pub delay_s: f32,
    /// Time constant of the first-order lag behind it, s.
    pub lag_s: f32,
}

impl VehicleParameters {
    /// The F450 on the gimbal of the thesis, as `models/f450-gimbal.toml` describes it; a test of the workspace
    /// compares every number. Pitch turns the ring along.
    pub const F450_GIMBAL: VehicleParameters = VehicleParameters {
        gravity_m_s2: 9.81,
        arm_m: 0.226,
        inertia_kg_m2: [0.0115118, 0.0365651, 0.02],
        ring_inertia_kg_m2: 0.0250533,
        torque_per_lift_m: 0.037823286,
        lift_curve: LiftCurve {
            lift_min_n: 0.0017807509,
            lift_max_n: 1.948443,
            // the motors' equilibrium lift over command, turned around
            #[rustfmt::skip]
            command_at: [
                0.0, 0.04515279, 0.070559986, 0.092107505, 0.11188951, 0.13073838,
                0.14909784, 0.16724801, 0.1853882, 0.20367438, 0.22223851, 0.24119984,
                0.26067212, 0.28076872, 0.30160663, 0.32330966, 0.34601173, 0.3698597,
                0.39501598, 0.42166147, 0.4499974, 0.48024687, 0.51265436, 0.54748243,
                0.5850039, 0.6254873, 0.66917384, 0.7162443, 0.7667802, 0.82072437,
                0.8778553, 0.93778676, 1.0,
            ],
        },
        actuation: Actuation { delay_s: 0.0, lag_s: 0.0019886284 },
        gravity_moment: GravityMoment::NONE,
        yaw_locked: true,
    };

    /// The F450 in free flight, as `models/f450-free.toml` describes it; the same test compares every number.
    pub const F450_FREE: VehicleParameters = VehicleParameters {
        gravity_m_s2: 9.81,
        arm_m: 0.226,
        inertia_kg_m2: [0.0115118, 0.0115118, 0.02],
        ring_inertia_kg_m2: 0.0,
        torque_per_lift_m: 0.016099548,
        lift_curve: LiftCurve {
            lift_min_n: 0.0,
            lift_max_n: 8.87596,
            #[rustfmt::skip]
            command_at: [
                0.0, 0.15385388, 0.2204657, 0.27272406, 0.3175525, 0.35763285,
                0.39434046, 0.42849237, 0.46062094, 0.49109593, 0.52018654, 0.54809606,
                0.5749824, 0.6009711, 0.62616396, 0.65064496, 0.6744841, 0.6977408,
                0.7204657, 0.7427026, 0.76448953, 0.7858599, 0.80684304, 0.8274652,
                0.84774953, 0.867717, 0.88738656, 0.90677506, 0.9258981, 0.94476974,
                0.96340287, 0.9818093, 1.0,
            ],
        },
        actuation: Actuation { delay_s: 0.0, lag_s: 0.0528285 },
        gravity_moment: GravityMoment::NONE,
        yaw_locked: false,
    };

    /// Distance of each motor from the roll and the pitch axis, m.
    pub fn lever_m(&self) -> f32 {
        self.arm_m * core::f32::consts::FRAC_1_SQRT_2
    }

    /// How pitch answers to torque, over roll. Where yaw is locked the body's other inertia turns into pitch's.
    pub fn pitch_inertia(&self) -> PitchInertia {
        let [_, level_kg_m2, yaw_kg_m2] = self.inertia_kg_m2;
        let rolled_kg_m2 = if self.yaw_locked { self.ring_inertia_kg_m2 + yaw_kg_m2 } else { level_kg_m2 };
        PitchInertia { level_kg_m2, rolled_kg_m2 }
    }

    /// Difference between the largest and the smallest lift of one motor, N.
    pub fn lift_span_n(&self) -> f32 {
        self.lift_curve.lift_max_n - self.lift_curve.lift_min_n
    }

    /// Angular acceleration, rad/s^2, that roll and pitch can reach both at the same time and in either direction,
    /// and that yaw can reach with half of the span: one motor's span at the lever.
    pub fn acceleration_authority_rad_s2(&self) -> [f32; 3] {
        let tilt_torque_nm = self.lever_m() * self.lift_span_n();
        let yaw_torque_nm = self.torque_per_lift_m * self.lift_span_n();
        let [roll, pitch, yaw] = self.inertia_kg_m2;
        [tilt_torque_nm / roll, tilt_torque_nm / pitch, yaw_torque_nm / yaw]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airframe::TORQUE_SIGNS;

    /// From the motors' signs: full roll and pitch together take each motor from the middle of its range to an end or
    /// leave it there; full yaw takes half of that.
    #[test]
    fn the_authority_is_what_four_motors_can_do() {
        let mut vehicle = VehicleParameters::F450_GIMBAL;
        vehicle.lift_curve.lift_min_n = 0.4;
        let span_n = vehicle.lift_curve.lift_max_n - 0.4;
        assert!((vehicle.lift_span_n() - span_n).abs() < 1e-6);
        let arms_m = [vehicle.arm_m / 2f32.sqrt(), vehicle.arm_m / 2f32.sqrt(), vehicle.torque_per_lift_m];
        for (axis, authority) in vehicle.acceleration_authority_rad_s2().into_iter().enumerate() {
            let torque_nm: f32 = TORQUE_SIGNS[axis].iter().map(|sign| sign * sign * 0.25 * span_n * arms_m[axis]).sum();
            assert!((authority * vehicle.inertia_kg_m2[axis] - torque_nm).abs() < 1e-5 * torque_nm, "axis {axis}");
        }
        let [roll, pitch, _] = TORQUE_SIGNS;
        for motor in 0..4 {
            let moved_n = 0.25 * span_n * (roll[motor] + pitch[motor]);
            assert!(moved_n.abs() <= 0.5 * span_n);
        }
    }

    /// `docs/tuning.md`: 27 rad/s^2 in roll and 8.5 in pitch on the gimbal.
    #[test]
    fn the_gimbals_authority_is_the_pages() {
        let [roll, pitch, _] = VehicleParameters::F450_GIMBAL.acceleration_authority_rad_s2();
        assert!((roll - 27.0).abs() < 0.5 && (pitch - 8.5).abs() < 0.05, "{roll} {pitch}");
    }

    /// On its side, the body on the gimbal turns about its own yaw axis within the ring; in free flight pitch is the
    /// body's y axis however it is rolled.
    #[test]
    fn pitch_rolled_by_a_right_angle_turns_the_ring_and_the_bodys_yaw_inertia() {
        let gimbal = VehicleParameters { ring_inertia_kg_m2: 0.025, ..VehicleParameters::F450_GIMBAL };
        let PitchInertia { level_kg_m2, rolled_kg_m2 } = gimbal.pitch_inertia();
        assert_eq!(level_kg_m2, gimbal.inertia_kg_m2[1]);
        assert!((rolled_kg_m2 - 0.045).abs() < 1e-7, "{rolled_kg_m2}");
        let free = VehicleParameters::F450_FREE.pitch_inertia();
        assert_eq!(free.level_kg_m2, free.rolled_kg_m2);
    }
}
