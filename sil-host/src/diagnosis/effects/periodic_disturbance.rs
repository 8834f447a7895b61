//! A moment from outside that swings: `A sin(2 pi f t + phase)`. Fitted as the amplitudes of sine and cosine, in which the
//! prediction is linear, and told as amplitude and phase.

use super::{Effect, Hints, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::body::{Moment, Motion};
use crate::prediction::model::Model;

/// On one axis.
pub(super) struct PeriodicDisturbance(pub(super) Axis);

const PARAMETERS: [Parameter; 3] = [
    Parameter { name: "sine_nm", nominal: 0.0, step: 1e-4, min: -50.0, max: 50.0 },
    Parameter { name: "cosine_nm", nominal: 0.0, step: 1e-4, min: -50.0, max: 50.0 },
    Parameter { name: "frequency_hz", nominal: 1.0, step: 1e-5, min: 0.01, max: 100.0 },
];

impl Effect for PeriodicDisturbance {
    fn in_words(&self) -> &'static str {
        "a periodic moment acts from outside"
    }
    fn name(&self) -> &'static str {
        "periodic_disturbance"
    }
    fn place(&self) -> Place {
        Place::Environment
    }
    fn axis(&self) -> Option<Axis> {
        Some(self.0)
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn starts(&self, hints: &Hints) -> Vec<Vec<f64>> {
        hints.frequency_hz[self.0.index()].into_iter().map(|frequency_hz| vec![0.0, 0.0, frequency_hz]).collect()
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        let [sine_nm, cosine_nm, frequency_hz] = [values[0], values[1], values[2]];
        model.moments.push(Box::new(Swing { axis: self.0.index(), sine_nm, cosine_nm, frequency_hz }));
    }
    fn told(&self, values: &[f64]) -> Vec<(&'static str, f64)> {
        let [sine_nm, cosine_nm, frequency_hz] = [values[0], values[1], values[2]];
        vec![
            ("amplitude_nm", (sine_nm * sine_nm + cosine_nm * cosine_nm).sqrt()),
            ("frequency_hz", frequency_hz),
            ("phase_rad", libm::atan2(cosine_nm, sine_nm)),
        ]
    }
    fn values_of(&self, told: &dyn Fn(&str) -> Option<f64>) -> Vec<f64> {
        let [amplitude_nm, frequency_hz, phase_rad] =
            ["amplitude_nm", "frequency_hz", "phase_rad"].map(|name| told(name).unwrap_or_default());
        let (sin, cos) = libm::sincos(phase_rad);
        vec![amplitude_nm * cos, amplitude_nm * sin, frequency_hz]
    }
}

struct Swing {
    axis: usize,
    sine_nm: f64,
    cosine_nm: f64,
    frequency_hz: f64,
}

impl Moment for Swing {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let (sin, cos) = libm::sincos(core::f64::consts::TAU * self.frequency_hz * motion.time_s);
        moment[self.axis] += self.sine_nm * sin + self.cosine_nm * cos;
    }
}
