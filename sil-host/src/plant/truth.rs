//! What an observer who sees everything would say of the plant.

use super::free_flight::loads_of_air;
use super::{Body, Plant};
use crate::vehicle::{Gimbal, euler_rad, euler_rates_rad_s, quaternion_world_from_body};

/// The vehicle's true motion at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Time since the start, s.
    pub time_s: f64,
    /// Roll, rad (Euler Z-Y-X).
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Yaw, rad; 0 on the gimbal.
    pub yaw_rad: f64,
    /// Rate of roll, pitch and yaw, rad/s: derivatives of the Euler angles, not body rates.
    pub euler_rate_rad_s: [f64; 3],
    /// Rotation that takes body vectors to world vectors, (w, x, y, z).
    pub q_world_from_body: [f64; 4],
    /// Body rate (p, q, r), rad/s.
    pub rate_body_rad_s: [f64; 3],
    /// What an ideal accelerometer at the centre of gravity (on the gimbal: the pivot) reads, body axes, m/s².
    pub specific_force_body_m_s2: [f64; 3],
    /// Position north, east, down of the start, m; 0 on the gimbal.
    pub position_ned_m: [f64; 3],
    /// Velocity north, east, down, m/s; 0 on the gimbal.
    pub velocity_ned_m_s: [f64; 3],
    /// Height of the rotors above ground, m.
    pub height_m: f64,
    /// Speed of motors 1 to 4, rad/s; 0 where the propulsion model has no rotors.
    pub motor_speed_rad_s: [f64; 4],
    /// Angle of rotors 1 to 4, rad, of a vehicle that they shake; none while its clock stands still.
    pub rotor_phase_rad: Option<[f64; 4]>,
    /// Lift of motors 1 to 4, N.
    pub lift_n: [f64; 4],
}

impl Plant {
    /// Everything about the motion at this instant.
    pub fn truth(&self) -> Truth {
        let ([roll_rad, pitch_rad, yaw_rad], q_world_from_body, position, velocity) = match &self.body {
            Body::Gimbal(_, [roll, pitch, _, _]) => {
                let angles = [*roll, *pitch, 0.0];
                let quaternion = quaternion_world_from_body(angles);
                (angles, quaternion, [0.0; 3], [0.0; 3])
            }
            Body::Free(_, state) => {
                let [x, y, z, vx, vy, vz, qw, qx, qy, qz, ..] = *state;
                let quaternion = [qw, qx, qy, qz];
                let angles = euler_rad(quaternion);
                (angles, quaternion, [x, y, z], [vx, vy, vz])
            }
        };
        let rate_body_rad_s = self.rate_body_rad_s();
        Truth {
            time_s: self.time_s,
            roll_rad,
            pitch_rad,
            yaw_rad,
            euler_rate_rad_s: euler_rates_rad_s(libm::sincos(roll_rad), libm::sincos(pitch_rad), rate_body_rad_s),
            q_world_from_body,
            rate_body_rad_s,
            specific_force_body_m_s2: self.specific_force_body_m_s2(),
            position_ned_m: position,
            velocity_ned_m_s: velocity,
            height_m: self.start_height_m - position[2],
            motor_speed_rad_s: self.motor_speed_rad_s(),
            rotor_phase_rad: self.rotor_phase_rad,
            lift_n: self.lifts_n(),
        }
    }

    /// Body rate (p, q, r), rad/s: what an ideal gyro reads.
    pub fn rate_body_rad_s(&self) -> [f64; 3] {
        match &self.body {
            Body::Gimbal(_, [roll, _, roll_rate, pitch_rate]) => {
                Gimbal::rate_body_rad_s(libm::sincos(*roll), [*roll_rate, *pitch_rate])
            }
            Body::Free(_, [.., p, q, r]) => [*p, *q, *r],
        }
    }

    /// Specific force at the centre of gravity (on the gimbal: the pivot), body axes, m/s²: what an ideal
    /// accelerometer there reads. Level and at rest it is (0, 0, -g).
    pub fn specific_force_body_m_s2(&self) -> [f64; 3] {
        match &self.body {
            Body::Gimbal(_, [roll, pitch, ..]) => Gimbal::specific_force_body_m_s2([*roll, *pitch], self.gravity_m_s2),
            Body::Free(body, state) => {
                let air_n = loads_of_air(&self.changes.air, state).push_body_n;
                let push_body_n = core::array::from_fn(|axis| air_n[axis] + self.disturbance_force_body_n[axis]);
                body.specific_force_m_s2(self.lifts_n().iter().sum(), push_body_n)
            }
        }
    }

    /// Speed of motors 1 to 4, rad/s.
    pub fn motor_speed_rad_s(&self) -> [f64; 4] {
        let [s1, s2, s3, s4, ..] = self.rotors;
        [s1, s2, s3, s4]
    }

    /// Angle of rotors 1 to 4, rad, of a vehicle that they shake; none while its clock stands still.
    pub fn rotor_phase_rad(&self) -> Option<[f64; 4]> {
        self.rotor_phase_rad
    }

    /// Lift of motors 1 to 4, N.
    pub fn lifts_n(&self) -> [f64; 4] {
        let free = match &self.body {
            Body::Gimbal(..) => None,
            Body::Free(_, state) => Some(state),
        };
        self.forces().lifts_n(&self.rotors, free)
    }
}
