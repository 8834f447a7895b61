//! A steady wind, which drags the airframe along with the square of the speed against it: free flight.

use super::{Effect, Hints, Parameter, Place};
use crate::prediction::model::Model;

/// Over the whole log.
pub(super) struct Wind;

const PARAMETERS: [Parameter; 3] = [
    Parameter { name: "north_m_s", nominal: 0.0, step: 1e-3, min: -50.0, max: 50.0 },
    Parameter { name: "east_m_s", nominal: 0.0, step: 1e-3, min: -50.0, max: 50.0 },
    Parameter { name: "drag_area_m2", nominal: 0.0, step: 1e-5, min: 0.0, max: 2.0 },
];

/// Where fits begin: air that stands still or comes from one side, m/s, and the drag area of a small vehicle, m^2. In still air, or
/// without an area, one of them would show no trace.
const STARTS: [[f64; 3]; 5] =
    [[0.5, 0.5, 0.02], [4.0, 0.0, 0.02], [-4.0, 0.0, 0.02], [0.0, 4.0, 0.02], [0.0, -4.0, 0.02]];

impl Effect for Wind {
    fn in_words(&self) -> &'static str {
        "a steady wind drags the vehicle along"
    }
    fn name(&self) -> &'static str {
        "wind"
    }
    fn place(&self) -> Place {
        Place::Environment
    }
    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }
    fn starts(&self, hints: &Hints) -> Vec<Vec<f64>> {
        let _ = hints;
        STARTS.iter().map(|start| start.to_vec()).collect()
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        let [north, east] = &mut model.air.wind_m_s;
        (*north, *east) = (*north + values[0], *east + values[1]);
        model.air.drag_area_m2 += values[2];
    }
}
