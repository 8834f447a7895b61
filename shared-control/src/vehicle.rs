//! What the controllers know of the vehicle. Numbers only: the plant is somewhere else and shares no code with this.

use crate::lift_curve::LiftCurve;

/// Parameters of the vehicle on its rig, as the controllers need them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleParameters {
    /// Gravity, m/s^2.
    pub gravity_m_s2: f32,
    /// Motor to centre, m.
    pub arm_m: f32,
    /// Inertia about the body axes with whatever turns along with them (the rig's rings), kg m^2.
    pub inertia_kg_m2: [f32; 3],
    /// Reaction torque per lift of one motor, m.
    pub torque_per_lift_m: f32,
    /// Command and lift of one motor.
    pub lift_curve: LiftCurve,
    /// True on a rig whose heading can't move.
    pub yaw_locked: bool,
}

impl VehicleParameters {
    /// Distance of each motor from the roll and the pitch axis, m.
    pub fn lever_m(&self) -> f32 {
        self.arm_m * core::f32::consts::FRAC_1_SQRT_2
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
