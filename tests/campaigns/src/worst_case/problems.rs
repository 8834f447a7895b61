//! The shipped problems as dense programs, in f64 and from the definition of their cost.

use shared_control::mpc::{HORIZON, MpcSettings, ProblemSettings};

use super::polytope::Affine;
use super::program::Program;

/// The benchmark's problem for the nominal vehicle: thesis' weights, input bounds only.
pub fn benchmark(prediction_step_s: f32) -> ProblemSettings {
    ProblemSettings {
        horizon: HORIZON,
        prediction_step_s,
        input_gain: [0.226 / 0.011_511_8, 0.226 / 0.036_565_1, 1.0 / 0.029_074_2],
        tracking_weight: [100.0; 3],
        increment_weight: [30.0, 30.0, 3000.0],
        input_max: [2.0, 2.0, 0.1],
        output_max_rad: [None; 3],
    }
}

/// One axis: a rigid body behind motors with a lag, over a horizon whose last input is held to the end. In units in
/// which the prediction step, the weight of the angle, the greatest input and the rate that it gives in one step are 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// rho.
    pub increment_weight: f64,
    /// Units of angle per rad.
    pub per_rad: f64,
    /// Units of rate per rad/s.
    pub per_rad_s: f64,
    /// Units of input per N m; 1 where the inputs are no torques.
    pub per_nm: f64,
    /// Time constant of the motors, prediction steps.
    pub lag: f64,
    /// (angle + lead rate) is what is held against the reference; prediction steps.
    pub lead: f64,
}

/// One request for a plan of one axis, in its units.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisRequest {
    /// Angle, rate, torque of the motors.
    pub start: [f64; 3],
    /// The present input.
    pub previous: f64,
    /// Disturbance torque.
    pub disturbance: f64,
    /// After each prediction step.
    pub reference: Vec<f64>,
}

impl Axis {
    /// Without lag and lead: 0 roll, 1 pitch, 2 yaw.
    pub fn new(settings: &ProblemSettings, axis: usize) -> Self {
        let step_s = f64::from(settings.prediction_step_s);
        let input_max = f64::from(settings.input_max[axis]);
        let full_turn_rad = f64::from(settings.input_gain[axis]) * step_s * step_s * input_max;
        let scale = input_max / full_turn_rad;
        let weight_ratio = f64::from(settings.increment_weight[axis]) / f64::from(settings.tracking_weight[axis]);
        Self {
            increment_weight: weight_ratio * scale * scale,
            per_rad: 1.0 / full_turn_rad,
            per_rad_s: step_s / full_turn_rad,
            per_nm: 1.0,
            lag: 0.0,
            lead: 0.0,
        }
    }

    /// Of the MPC that flies.
    pub fn flying(settings: &MpcSettings, axis: usize) -> Self {
        let step_s = f64::from(settings.problem.prediction_step_s);
        Self {
            per_nm: 1.0 / f64::from(settings.torque_max_nm()[axis]),
            lag: f64::from(settings.motor_lag_s) / step_s,
            lead: f64::from(settings.preview.lead_s[axis]) / step_s,
            ..Self::new(&settings.problem, axis)
        }
    }

    /// Angle, rate and torque of the motors one step later.
    fn step(&self, [angle, rate, motor]: [f64; 3], input: f64) -> [f64; 3] {
        let kept = if self.lag > 0.0 { libm::exp(-1.0 / self.lag) } else { 0.0 };
        let excess = motor - input;
        [
            angle + rate + 0.5 * input + excess * self.lag * (1.0 - self.lag * (1.0 - kept)),
            rate + input + excess * self.lag * (1.0 - kept),
            input + excess * kept,
        ]
    }

    /// What is held against the reference, after each step.
    fn outputs(&self, start: [f64; 3], input: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut state = start;
        let mut output = |step| {
            state = self.step(state, input(step));
            state[0] + self.lead * state[1]
        };
        (0..HORIZON).map(&mut output).collect()
    }

    /// The effect of each input on the outputs.
    fn effects(&self, inputs: usize) -> Vec<Vec<f64>> {
        let last = inputs - 1;
        let pulse = |input: usize| move |step: usize| f64::from(u8::from(step.min(last) == input));
        (0..inputs).map(|input| self.outputs([0.0; 3], pulse(input))).collect()
    }

    fn hessian(&self, effects: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = effects.len();
        let increments = |row: usize, column: usize| match row.abs_diff(column) {
            0 if row + 1 < count => 2.0,
            0 => 1.0,
            1 => -1.0,
            _ => 0.0,
        };
        let entry = |row: usize, column: usize| {
            dot(&effects[row], &effects[column]) + self.increment_weight * increments(row, column)
        };
        (0..count).map(|row| (0..count).map(|column| entry(row, column)).collect()).collect()
    }

    /// The problem of a constant reference over (angle from it, rate, previous input), each as a share of its limit: of
    /// `angle_max_rad` and `rate_max_rad_s`, and of the input's bound.
    pub fn regulation(&self, inputs: usize, angle_max_rad: f64, rate_max_rad_s: f64) -> Program<3> {
        let effects = self.effects(inputs);
        let angle = self.outputs([angle_max_rad * self.per_rad, 0.0, 0.0], |_| 0.0);
        let rate = self.outputs([0.0, rate_max_rad_s * self.per_rad_s, 0.0], |_| 0.0);
        let linear = |(input, effect): (usize, &Vec<f64>)| {
            let previous = if input == 0 { -self.increment_weight } else { 0.0 };
            Affine { gradient: [dot(effect, &angle), dot(effect, &rate), previous], constant: 0.0 }
        };
        Program { linear: effects.iter().enumerate().map(linear).collect(), hessian: self.hessian(&effects) }
    }

    /// The problem that flies for one request, without parameters. The unknowns are the motors' torques as they come: a
    /// disturbance adds to what they do.
    pub fn tracking_of(&self, inputs: usize, request: &AxisRequest) -> Program<0> {
        let effects = self.effects(inputs);
        let [angle, rate, motor] = request.start;
        let errors: Vec<f64> = self
            .outputs([angle, rate, motor + request.disturbance], |_| request.disturbance)
            .iter()
            .zip(&request.reference)
            .map(|(output, reference)| output - reference)
            .collect();
        let linear = |(input, effect): (usize, &Vec<f64>)| {
            let previous = if input == 0 { self.increment_weight * request.previous } else { 0.0 };
            Affine::constant(dot(effect, &errors) - previous)
        };
        Program { linear: effects.iter().enumerate().map(linear).collect(), hessian: self.hessian(&effects) }
    }

    /// The problem that flies under a reference that stands still, over (angle from it in rad, rate in rad/s, torque of
    /// the motors, present input, disturbance), each as a share of its limit; the last three limits are shares of the
    /// greatest input.
    pub fn held_reference(&self, inputs: usize, limits: [f64; 5]) -> Program<5> {
        let effects = self.effects(inputs);
        let [angle_rad, rate_rad_s, motor, previous, disturbance] = limits;
        let outputs = [
            self.outputs([angle_rad * self.per_rad, 0.0, 0.0], |_| 0.0),
            self.outputs([0.0, rate_rad_s * self.per_rad_s, 0.0], |_| 0.0),
            self.outputs([0.0, 0.0, motor], |_| 0.0),
            vec![0.0; HORIZON],
            self.outputs([0.0, 0.0, disturbance], |_| disturbance),
        ];
        let linear = |(input, effect): (usize, &Vec<f64>)| {
            let mut gradient = std::array::from_fn(|parameter| dot(effect, &outputs[parameter]));
            if input == 0 {
                gradient[3] = -self.increment_weight * previous;
            }
            Affine { gradient, constant: 0.0 }
        };
        Program { linear: effects.iter().enumerate().map(linear).collect(), hessian: self.hessian(&effects) }
    }

    /// The problem that flies, with M inputs, over every request at once: state, reference, disturbance and present
    /// input enter the program through its linear term alone, which has M entries. The parameters are the inputs of the
    /// optimum without bounds, as shares of the greatest that `widest` says.
    pub fn tracking<const M: usize>(&self, widest: &[f64; M]) -> Program<M> {
        let hessian = self.hessian(&self.effects(M));
        let linear = hessian
            .iter()
            .map(|row| Affine { gradient: std::array::from_fn(|input| -row[input] * widest[input]), constant: 0.0 });
        Program { linear: linear.collect(), hessian }
    }

    /// The greatest inputs of the optimum without bounds over all requests within these limits, in the axis' units: of
    /// the difference between output and reference after each step if no torque were requested, every step's on its
    /// own, and of the present input.
    pub fn widest<const M: usize>(&self, error_max: f64, previous_max: f64) -> [f64; M] {
        let effects = self.effects(M);
        let hessian = self.hessian(&effects);
        let mut widest = [0.0; M];
        let mut add = |right: [f64; M], size: f64| {
            for (sum, share) in widest.iter_mut().zip(solve(hessian.clone(), right)) {
                *sum += size * share.abs();
            }
        };
        (0..HORIZON).for_each(|step| add(std::array::from_fn(|input| effects[input][step]), error_max));
        add(std::array::from_fn(|input| if input == 0 { self.increment_weight } else { 0.0 }), previous_max);
        widest
    }
}

/// H x = right, H positive definite, by elimination.
fn solve<const M: usize>(mut hessian: Vec<Vec<f64>>, mut right: [f64; M]) -> [f64; M] {
    for column in 0..M {
        let pivot = hessian[column].clone();
        for row in column + 1..M {
            let factor = hessian[row][column] / pivot[column];
            for (entry, value) in hessian[row].iter_mut().zip(&pivot) {
                *entry -= factor * value;
            }
            right[row] -= factor * right[column];
        }
    }
    for row in (0..M).rev() {
        let known: f64 = (row + 1..M).map(|column| hessian[row][column] * right[column]).sum();
        right[row] = (right[row] - known) / hessian[row][row];
    }
    right
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}
