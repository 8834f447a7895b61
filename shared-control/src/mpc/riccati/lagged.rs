//! A rigid body turned by motors that follow their command with a lag.

use super::model::Model;
use super::quadratic::Quadratic;
use crate::lagged_axis::LagStep;

/// Angle, rate, and the motors' effect m, which follows the input u with time constant tau:
///
/// ```text
/// angle'' = m,   tau m' = u - m
/// ```
/// exactly discretised under zero-order hold, in units in which the prediction step and the effect of the input are 1
/// and the cost is (angle + lead rate)^2, which requires an axis off its reference to close in with the time constant
/// `lead`: damping. Without lag m plays no part, and angle and rate are the double integrator's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct LaggedIntegrator {
    /// Share of m that is left after a step: exp(-step / tau).
    kept: f32,
    /// Rate that m leaves behind while it decays.
    rate_of_motor: f32,
    /// Angle that m leaves behind within the step.
    angle_of_motor: f32,
    /// In prediction steps.
    lead: f32,
}

impl LaggedIntegrator {
    /// `lag` is tau over the prediction step; anything but a positive number is no lag.
    pub(in crate::mpc) fn new(lag: f32) -> Self {
        let step = LagStep::new(1.0, lag);
        Self { kept: step.kept, rate_of_motor: step.rate_share, angle_of_motor: step.angle_share, lead: 0.0 }
    }

    /// With a lead, in prediction steps.
    pub(in crate::mpc) fn with_lead(self, lead: f32) -> Self {
        Self { lead, ..self }
    }

    /// What is held against the reference: the angle with its lead.
    #[inline(always)]
    pub(in crate::mpc) fn output(&self, [angle, rate, _]: &[f32; 3]) -> f32 {
        angle + self.lead * rate
    }

    /// What the input adds to (angle, rate, m) in a step.
    #[inline(always)]
    fn of_input(&self) -> [f32; 3] {
        [0.5 - self.angle_of_motor, 1.0 - self.rate_of_motor, 1.0 - self.kept]
    }
}

impl Model<3> for LaggedIntegrator {
    #[inline(always)]
    fn advance(&self, state: &[f32; 3], input: f32) -> [f32; 3] {
        let [angle, rate, motor] = *state;
        let [to_angle, to_rate, to_motor] = self.of_input();
        [
            angle + rate + self.angle_of_motor * motor + to_angle * input,
            rate + self.rate_of_motor * motor + to_rate * input,
            self.kept * motor + to_motor * input,
        ]
    }

    /// T'QT with T = [[A, B], [0, 1]], its products with zeros and ones left out.
    #[inline(always)]
    fn pull_back(&self, after: &Quadratic<3>) -> Quadratic<3> {
        let [[p11, p12, p13], [_, p22, p23], [_, _, p33]] = after.state;
        let [c1, c2, c3] = after.cross;
        let (angle, rate, kept) = (self.angle_of_motor, self.rate_of_motor, self.kept);
        let [to_angle, to_rate, to_motor] = self.of_input();
        // the columns of QT that belong to rate, motor and input
        let rate_column = [p11 + p12, p12 + p22];
        let motor_column = [
            angle * p11 + rate * p12 + kept * p13,
            angle * p12 + rate * p22 + kept * p23,
            angle * p13 + rate * p23 + kept * p33,
        ];
        let input_column = [
            to_angle * p11 + to_rate * p12 + to_motor * p13 + c1,
            to_angle * p12 + to_rate * p22 + to_motor * p23 + c2,
            to_angle * p13 + to_rate * p23 + to_motor * p33 + c3,
        ];
        let of_input = to_angle * c1 + to_rate * c2 + to_motor * c3 + after.input;
        let (state_linear, input_linear) = self.pull_back_linear(&after.state_linear, after.input_linear);
        let [m1, m2, m3] = motor_column;
        let [u1, u2, u3] = input_column;
        Quadratic {
            state: [
                [p11, rate_column[0], m1],
                [0.0, rate_column[0] + rate_column[1], m1 + m2],
                [0.0, 0.0, angle * m1 + rate * m2 + kept * m3],
            ],
            cross: [u1, u1 + u2, angle * u1 + rate * u2 + kept * u3],
            input: to_angle * u1 + to_rate * u2 + to_motor * u3 + of_input,
            state_linear,
            input_linear,
        }
    }

    #[inline(always)]
    fn pull_back_linear(&self, [angle, rate, motor]: &[f32; 3], input: f32) -> ([f32; 3], f32) {
        let [to_angle, to_rate, to_motor] = self.of_input();
        let before =
            [*angle, angle + rate, self.angle_of_motor * angle + self.rate_of_motor * rate + self.kept * motor];
        (before, to_angle * angle + to_rate * rate + to_motor * motor + input)
    }

    #[inline(always)]
    fn add_tracking(&self, cost: &mut Quadratic<3>) {
        let [[angle, angle_rate, _], [_, rate, _], _] = &mut cost.state;
        *angle += 1.0;
        *angle_rate += self.lead;
        *rate += self.lead * self.lead;
    }

    #[inline(always)]
    fn add_reference(&self, [angle, rate, _]: &mut [f32; 3], reference: f32) {
        *angle -= reference;
        *rate -= self.lead * reference;
    }
}
