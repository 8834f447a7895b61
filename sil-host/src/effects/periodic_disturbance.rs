//! A sinusoidal torque, `A sin(2 pi f t + phase)`: a rotor out of balance seen through the sampling, a swinging load.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::{Moment, Motion};

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

const AMPLITUDE: Parameter = Parameter::new("amplitude_nm", "N m", "largest moment", [-20.0, 20.0]);
const FREQUENCY: Parameter = Parameter::new("frequency_hz", "Hz", "frequency", [0.0, 500.0]);
const PHASE: Parameter = Parameter::new("phase_rad", "rad", "phase at the start", [-7.0, 7.0]).usual(0.0);

impl Catalogued for PeriodicDisturbance {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "periodic_disturbance",
        origin: Origin::Environment,
        acts_on: ActsOn::TurningAxis,
        parameters: &[AMPLITUDE, FREQUENCY, PHASE],
        summary: "a sinusoidal torque",
        statement: "a periodic moment acts from outside",
        equation: "Q = amplitude_nm sin(2 pi frequency_hz t + phase_rad)",
        example: "periodic_disturbance:axis=roll,amplitude_nm=0.02,frequency_hz=2,phase_rad=0.5",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self {
            axis: given.axis()?,
            amplitude_nm: given.number(&AMPLITUDE)?,
            frequency_hz: given.number(&FREQUENCY)?,
            phase_rad: given.number(&PHASE)?,
        })
    }

    /// Fitted as the amplitudes of sine and cosine, in which the prediction is linear, from the strongest frequency on.
    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let [sine, cosine] = ["sine_nm", "cosine_nm"].map(|name| Unknown::moment(name, &scope.scale));
        // without amplitude any frequency is as good
        let frequency = Unknown::of(&FREQUENCY, 1e-5).within(0.01, 100.0).nominal(1.0);
        let of_axis = |axis: Axis| {
            Hypothesis::new(Self::ENTRY, [sine, cosine, frequency], move |[sine_nm, cosine_nm, frequency_hz]| Self {
                axis,
                amplitude_nm: (sine_nm * sine_nm + cosine_nm * cosine_nm).sqrt(),
                frequency_hz,
                phase_rad: libm::atan2(cosine_nm, sine_nm),
            })
            .starting(move |hints| {
                hints.frequency_hz[axis.index()].into_iter().map(|frequency_hz| vec![0.0, 0.0, frequency_hz]).collect()
            })
        };
        scope.turning_axes().map(of_axis).collect()
    }
}

impl Extension for PeriodicDisturbance {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("amplitude_nm", self.amplitude_nm), ("frequency_hz", self.frequency_hz), ("phase_rad", self.phase_rad)]
    }

    fn moment(&self) -> Option<&dyn Moment> {
        Some(self)
    }

    fn keeps_to_axis(&self) -> bool {
        true
    }

    fn step_max_s(&self, _inertia_kg_m2: [f64; 3]) -> f64 {
        // forty steps a period
        0.025 / self.frequency_hz
    }
}

impl Moment for PeriodicDisturbance {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let turns = self.frequency_hz * motion.time_s;
        moment[self.axis.index()] += self.amplitude_nm * libm::sin(core::f64::consts::TAU * turns + self.phase_rad);
    }
}
