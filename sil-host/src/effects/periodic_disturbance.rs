//! A sinusoidal torque, `A sin(2 pi f t + phase)`: a rotor out of balance seen through the sampling, a swinging load.

use super::text::read_axis;
use super::{ANY_RIG, AxisMotion, CatalogueEntry, Catalogued, Extension, Origin};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

/// A sinusoidal torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicDisturbance {
    /// The axis it acts on.
    pub axis: Axis,
    /// Amplitude, N m.
    pub amplitude_nm: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Phase at the start, rad.
    pub phase_rad: f64,
}

impl Catalogued for PeriodicDisturbance {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "periodic_disturbance",
        origin: Origin::Environment,
        summary: "a sinusoidal torque",
        example: "periodic_disturbance:axis=roll,amplitude_nm=0.02,frequency_hz=2,phase_rad=0.5",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            axis: read_axis(section, rig)?,
            amplitude_nm: section.number("amplitude_nm", admissible(-20.0, 20.0, "a moment in N m"))?,
            frequency_hz: section.number("frequency_hz", admissible(0.0, 500.0, "a frequency in Hz"))?,
            phase_rad: section.optional_number("phase_rad", admissible(-7.0, 7.0, "an angle in rad"))?.unwrap_or(0.0),
        })
    }
}

impl Extension for PeriodicDisturbance {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("amplitude_nm", self.amplitude_nm), ("frequency_hz", self.frequency_hz), ("phase_rad", self.phase_rad)]
    }

    fn axis_torque_nm(&self, motion: AxisMotion) -> f64 {
        let turns = self.frequency_hz * motion.instant.time_s;
        self.amplitude_nm * libm::sin(core::f64::consts::TAU * turns + self.phase_rad)
    }

    fn step_max_s(&self, _inertia_kg_m2: [f64; 3]) -> f64 {
        // forty steps a period
        0.025 / self.frequency_hz
    }
}
