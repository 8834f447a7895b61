//! A moment from outside that sets in and stays.

use super::{Effect, Hints, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::body::{Moment, Motion};
use crate::prediction::model::Model;

/// On one axis.
pub(super) struct StepDisturbance(pub(super) Axis);

const PARAMETERS: [Parameter; 2] = [
    Parameter { name: "torque_nm", nominal: 0.0, step: 1e-4, min: -50.0, max: 50.0 },
    Parameter { name: "start_s", nominal: 0.0, step: 2e-3, min: 0.0, max: 1e6 },
];

/// The onset is a ramp this long about the start, s: shorter than a log can tell, and smooth enough to be fitted.
const RAMP_S: f64 = 0.01;

impl Effect for StepDisturbance {
    fn in_words(&self) -> &'static str {
        "a moment from outside sets in during the log"
    }
    fn name(&self) -> &'static str {
        "step_disturbance"
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
        hints.step_start_s[self.0.index()].iter().map(|start_s| vec![0.0, *start_s]).collect()
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        model.moments.push(Box::new(Onset { axis: self.0.index(), torque_nm: values[0], start_s: values[1] }));
    }
}

struct Onset {
    axis: usize,
    torque_nm: f64,
    start_s: f64,
}

impl Moment for Onset {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let share = ((motion.time_s - self.start_s) / RAMP_S + 0.5).clamp(0.0, 1.0);
        moment[self.axis] += self.torque_nm * share;
    }
}
