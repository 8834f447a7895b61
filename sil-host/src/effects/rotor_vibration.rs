//! Rotors that shake the IMU: an imbalance turns with each of them, and two blades push along the vertical. What is
//! felt stands in [`crate::vehicle::Vibration`]; the chip's own low-pass takes its share of every line, and its rate
//! folds what is left.
//!
//! Nothing of it can be found in a log of 100 to 400 rows a second: lines of 80 to 600 Hz appear there as lines of any
//! lower frequency, which change as the speeds do. So it has no hypothesis of its own: a diagnosis measures it as noise
//! of the readings, or says that something is there that it does not know.

use super::{ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// Rotors that shake the IMU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorVibration {
    /// Largest acceleration on an axis, m/s², when the first lines of all four rotors meet at this speed.
    pub peak_m_s2: f64,
    /// The same of the rate, rad/s.
    pub peak_rad_s: f64,
    /// Speed of the rotors, rad/s.
    pub at_rad_s: f64,
}

const PEAK_ACCELERATION: Parameter =
    Parameter::new("peak_m_s2", "m/s^2", "largest acceleration on an axis at the stated speed", [0.0, 200.0]);
const PEAK_RATE: Parameter =
    Parameter::new("peak_rad_s", "rad/s", "largest rate about an axis at the stated speed", [0.0, 10.0]).usual(0.0);
const AT: Parameter =
    Parameter::new("at_rad_s", "rad/s", "speed of the rotors at which these are the peaks", [1.0, 1e4]).usual(500.0);

impl Catalogued for RotorVibration {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "rotor_vibration",
        origin: Origin::Plant,
        acts_on: ActsOn::Vehicle,
        parameters: &[PEAK_ACCELERATION, PEAK_RATE, AT],
        summary: "rotors that are not balanced shake the IMU",
        statement: "the rotors shake the IMU",
        equation: "lines at each rotor's speed w and its harmonics: acceleration grows with w^2, rate with w; not in a \
                   prediction",
        example: "rotor_vibration:peak_m_s2=30,peak_rad_s=0.2,at_rad_s=520",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        let [peak_m_s2, peak_rad_s, at_rad_s] = [&PEAK_ACCELERATION, &PEAK_RATE, &AT].map(|one| given.number(one));
        Ok(Self { peak_m_s2: peak_m_s2?, peak_rad_s: peak_rad_s?, at_rad_s: at_rad_s? })
    }

    fn hypotheses(_: &Scope) -> Vec<Hypothesis> {
        Vec::new()
    }
}

impl Extension for RotorVibration {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("peak_m_s2", self.peak_m_s2), ("peak_rad_s", self.peak_rad_s), ("at_rad_s", self.at_rad_s)]
    }

    fn change(&self, vehicle: &mut Changes) {
        // four rotors share a peak
        let vibration = &mut vehicle.sensors.vibration;
        vibration.acceleration_per_speed2_m += 0.25 * self.peak_m_s2 / (self.at_rad_s * self.at_rad_s);
        vibration.rate_per_speed += 0.25 * self.peak_rad_s / self.at_rad_s;
    }
}
