//! What is said of what was learnt.

use core::fmt::{Display, Formatter, Result};

use super::adoption::{LearntModel, Refusal};

/// Nearest whole number, for which no floating point has to be written.
fn whole(value: f32) -> i32 {
    (if value < 0.0 { value - 0.5 } else { value + 0.5 }) as i32
}

impl Display for LearntModel {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let [roll, pitch] = self.gain.map(|gain| whole(100.0 * (gain - 1.0)));
        write!(f, "learnt: roll {roll:+} %, pitch {pitch:+} %, lag {} ms", whole(1e3 * self.lag_s))
    }
}

impl Display for Refusal {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let (axis, what) = match self {
            Refusal::Unstable { axis } => (axis, "might oscillate"),
            Refusal::Sensitive { axis, .. } => (axis, "too sensitive"),
        };
        write!(f, "learnt, not flown: {} {what}", if *axis == 0 { "roll" } else { "pitch" })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::link::Text;
    use core::fmt::Write;

    #[test]
    fn a_model_and_a_refusal_fit_into_a_text() {
        let text = |words: &dyn Display| {
            let mut text = Text::new();
            write!(text, "{words}").unwrap();
            text
        };
        let model = LearntModel { gain: [1.396, 0.6], lag_s: 0.0412 };
        assert_eq!(text(&model), "learnt: roll +40 %, pitch -40 %, lag 41 ms");
        assert_eq!(text(&Refusal::Unstable { axis: 0 }), "learnt, not flown: roll might oscillate");
        let sensitive = Refusal::Sensitive { axis: 1, peak_sensitivity: 2.6 };
        assert_eq!(text(&sensitive), "learnt, not flown: pitch too sensitive");
    }
}
