//! What a co-simulated flight leaves behind: one row per control step, and how the controller fared.

use shared_control::flight_core::TorqueSource;

/// A flight as series of equal length, one sample per control step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlightRecord {
    /// Time since the rig let go, s.
    pub time_s: Vec<f64>,
    /// Raw reference (roll, pitch), rad.
    pub reference_rad: Vec<[f64; 2]>,
    /// Shaped reference of the cascade (roll, pitch), rad.
    pub shaped_reference_rad: Vec<[f64; 2]>,
    /// True angles (roll, pitch, yaw), rad.
    pub angle_rad: Vec<[f64; 3]>,
    /// True body rates (p, q, r), rad/s.
    pub rate_body_rad_s: Vec<[f64; 3]>,
    /// Angles as a logger reports them, rad.
    pub logged_angle_rad: Vec<[f64; 3]>,
    /// Body rates as the gyro read them at this instant, rad/s.
    pub logged_rate_body_rad_s: Vec<[f64; 3]>,
    /// Specific force as the accelerometer read it, m/s².
    pub logged_force_m_s2: Vec<[f64; 3]>,
    /// Velocity (north, east, down, m/s) and height above ground (m) as a flight controller estimates them; empty where
    /// the vehicle does not fly free.
    pub logged_navigation: Vec<[f64; 4]>,
    /// Commands in force from this sample to the next.
    pub commands: Vec<[f64; 4]>,
    /// Compare values written to the timer.
    pub compare_counts: Vec<[u16; 4]>,
    /// Torque demanded of the mixer, body axes, N m.
    pub torque_body_nm: Vec<[f64; 3]>,
    /// Who made the torque.
    pub source: Vec<TorqueSource>,
    /// True if the flight ended because the plant's state was no longer finite.
    pub ended_early: bool,
    /// What the planner did, where there is one.
    pub planning: Planning,
}

/// How the plans of a flight went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Planning {
    /// Most solver iterations of a plan (all axes).
    pub iterations_max: u32,
    /// Steps that the cascade flew in the MPC's place.
    pub fallbacks: u32,
    /// Plans that were not solved.
    pub unsolved: u32,
}

impl FlightRecord {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// True angle of an axis (0 roll, 1 pitch), rad.
    pub fn angle_of(&self, axis: usize) -> Vec<f64> {
        self.angle_rad.iter().map(|angles| angles[axis]).collect()
    }

    /// Raw reference of an axis (0 roll, 1 pitch), rad.
    pub fn reference_of(&self, axis: usize) -> Vec<f64> {
        self.reference_rad.iter().map(|reference| reference[axis]).collect()
    }
}
