//! What the MPC takes for the reference over its horizon.

use super::HORIZON;
use crate::attitude::angle::AngleConfig;
use crate::attitude::course::Course;
use crate::attitude::shaping::{Goal, ShapedReference, ShapingConfig};
use crate::signals::PlanRequest;

/// What is known of the reference ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReferenceAhead {
    /// The set-point as it was given, constant: the thesis' controller.
    Setpoint,
    /// The shaped reference where it is now, constant.
    Held,
    /// The shaped reference where it will be: the shaping runs ahead over the horizon, from its present state to the
    /// present set-point.
    #[default]
    Shaped,
}

/// How the reference over the horizon is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preview {
    /// What is known of it.
    pub ahead: ReferenceAhead,
    /// The law that moves the shaped reference, the same as the cascade's.
    pub shaping: AngleConfig,
    /// Prediction step, s.
    pub prediction_step_s: f32,
    /// Control step, s, in which the reference moves.
    pub control_step_s: f32,
    /// How much of the reference's rate is added to its angle, s.
    pub lead_s: [f32; 3],
    /// Time from the shaped reference's present state to the moment at which a plan begins to act, s.
    pub delay_s: f32,
}

impl Preview {
    /// Reference at the end of each prediction step, its lead included, rad, per axis (roll, pitch, heading).
    pub fn references_rad(&self, request: &PlanRequest) -> [[f32; HORIZON]; 3] {
        let reference = &request.reference.reference;
        let mut ahead_rad = reference.map(|axis| [axis.angle_rad; HORIZON]);
        match self.ahead {
            ReferenceAhead::Held => {}
            ReferenceAhead::Setpoint => {
                let [roll, pitch, _] = &mut ahead_rad;
                *roll = [self.shaping.tilt_asked_rad(request.setpoint.roll_rad); HORIZON];
                *pitch = [self.shaping.tilt_asked_rad(request.setpoint.pitch_rad); HORIZON];
            }
            ReferenceAhead::Shaped => {
                let goals = self.shaping.goals(&request.setpoint);
                let axes = self.shaping.shaping.iter().zip(goals).zip(self.lead_s).zip(reference);
                for (ahead_rad, (((shaping, goal), lead_s), start)) in ahead_rad.iter_mut().zip(axes) {
                    self.run_ahead(shaping, (*start, goal), lead_s, ahead_rad);
                }
            }
        }
        ahead_rad
    }

    /// In control steps, as the reference will move; in parts a little longer or shorter where the prediction step is
    /// no multiple.
    fn run_ahead(
        &self,
        shaping: &ShapingConfig,
        (start, goal): (ShapedReference, Goal),
        lead_s: f32,
        ahead_rad: &mut [f32; HORIZON],
    ) {
        let delay_steps = whole_steps(self.delay_s, self.control_step_s);
        let start = Course::new(shaping, start, goal, self.control_step_s, delay_steps).advance();
        let parts = whole_steps(self.prediction_step_s, self.control_step_s).max(1);
        let part_s = self.prediction_step_s / f32::from(parts);
        let mut course = Course::new(shaping, start, goal, part_s, parts);
        for ahead_rad in ahead_rad {
            let then = course.advance();
            *ahead_rad = then.angle_rad + lead_s * then.rate_rad_s;
        }
    }
}

/// To the nearest number; 255 at most.
fn whole_steps(duration_s: f32, step_s: f32) -> u8 {
    (duration_s / step_s + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::angle::{self, AngleState};
    use crate::signals::Setpoint;
    use proptest::prelude::*;

    const SHAPING: ShapingConfig = ShapingConfig { gain_1_s: 7.0, acceleration_max_rad_s2: 16.0, rate_max_rad_s: 3.0 };

    fn preview(ahead: ReferenceAhead, delay_s: f32) -> Preview {
        let shaping = AngleConfig {
            shaping: [SHAPING; 3],
            gain_1_s: [8.0; 3],
            acceleration_max_rad_s2: [8.0; 3],
            rate_max_rad_s: [5.0; 3],
            tilt_max_rad: 1.0,
            acceleration_feed_forward: 0.0,
            yaw_locked: false,
        };
        Preview { ahead, shaping, prediction_step_s: 0.01, control_step_s: 0.0025, lead_s: [0.0, 0.1, 0.2], delay_s }
    }

    proptest! {
        /// What was said of the reference is what it then does, at every later time, to the bit; on its way, when it
        /// arrives and long after.
        #[test]
        fn the_reference_goes_where_it_was_said(
            roll_rad in -1.5f32..1.5,
            pitch_rad in -1.5f32..1.5,
            yaw_rate_rad_s in -2f32..2.0,
            steps_before in prop_oneof![0usize..100, 100usize..1500],
            delay_steps in 0u8..8,
        ) {
            let setpoint = Setpoint { roll_rad, pitch_rad, yaw_rate_rad_s, throttle: 0.5, acro_rad_s: None };
            let preview = preview(ReferenceAhead::Shaped, 0.0025 * f32::from(delay_steps));
            let mut state = AngleState::default();
            let go_on = |state: &mut AngleState, steps: usize| {
                for _ in 0..steps {
                    angle::shape(&preview.shaping, state, &setpoint, 0.0025);
                }
            };
            go_on(&mut state, steps_before);
            let said = preview.references_rad(&PlanRequest { reference: state, setpoint, ..PlanRequest::default() });
            go_on(&mut state, usize::from(delay_steps));
            let [roll, pitch, heading] = said;
            for ((roll, pitch), heading) in roll.into_iter().zip(pitch).zip(heading) {
                go_on(&mut state, 4);
                for ((said, then), lead_s) in [roll, pitch, heading].iter().zip(state.reference).zip(preview.lead_s) {
                    let expected = then.angle_rad + lead_s * then.rate_rad_s;
                    prop_assert_eq!(said.to_bits(), expected.to_bits());
                }
            }
        }
    }

    #[test]
    fn without_preview_it_stands_still() {
        let mut reference = AngleState::default();
        for (axis, angle_rad) in reference.reference.iter_mut().zip([0.1, -0.2, 0.3]) {
            axis.angle_rad = angle_rad;
        }
        let setpoint = Setpoint { roll_rad: 1.4, pitch_rad: -0.5, ..Setpoint::default() };
        let request = PlanRequest { reference, setpoint, ..PlanRequest::default() };
        let of = |ahead| preview(ahead, 0.0).references_rad(&request).map(|axis| [axis[0], axis[HORIZON - 1]]);
        assert_eq!(of(ReferenceAhead::Held), [[0.1; 2], [-0.2; 2], [0.3; 2]]);
        assert_eq!(of(ReferenceAhead::Setpoint), [[1.0; 2], [-0.5; 2], [0.3; 2]]);
    }
}
