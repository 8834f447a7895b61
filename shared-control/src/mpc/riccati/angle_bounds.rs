//! Bounds on the angle over the horizon, and what a violation of them costs.

use super::Model;
use crate::elementary::magnitude;
use crate::mpc::HORIZON;

/// Inputs beyond their bounds by so much are within: above rounding, below what matters.
const INPUT_TOLERANCE: f32 = 2e-6;

/// What a violation of the angle's bound costs, per step and unit of angle: the weight of the increments and this
/// floor, all in the axis' units. Where the increments cost next to nothing, it is the tracking over thirty steps that
/// multipliers work against. The multipliers of bounds that can be kept are below it but at the edge (docs/solver.md).
const PENALTY_FLOOR: f32 = 1e5;

/// So much of the bound is rounding, after one step.
const ANGLE_TOLERANCE: f32 = 1.5e-7;

/// What is made once for bounds on the angle, in the axis' units.
#[derive(Clone, Copy, Debug)]
pub(in crate::mpc) struct SoftAngle<const S: usize> {
    /// The angles while the last input is held, as sums of the state before it and the input.
    pub(super) while_held: [([f32; S], f32); HORIZON],
    /// How many they are.
    pub(super) last_steps: usize,
    /// Greatest multiplier: what a violation costs per step and unit of angle, in halves of the cost.
    pub(super) weight: f32,
    /// Violations below it, times the step's number, are rounding.
    pub(super) tolerance: f32,
}

impl<const S: usize> SoftAngle<S> {
    /// `last_steps` are those over which the last input is held, `angle_max` the size of the bound.
    pub(in crate::mpc) fn new(model: &impl Model<S>, last_steps: usize, increment_weight: f32, angle_max: f32) -> Self {
        let (mut state, mut input) = ([0.0; S], 0.0);
        state[0] = 1.0;
        let while_held = [(); HORIZON].map(|()| {
            (state, input) = model.pull_back_linear(&state, input);
            (state, input)
        });
        let (weight, tolerance) = (increment_weight + PENALTY_FLOOR, ANGLE_TOLERANCE * magnitude(angle_max));
        Self { while_held, last_steps, weight, tolerance }
    }
}

/// The bounds on the angle, from the state's origin.
#[derive(Clone, Copy, Debug)]
pub(in crate::mpc) struct AngleBounds<'a, const S: usize> {
    pub(in crate::mpc) lower: f32,
    pub(in crate::mpc) upper: f32,
    pub(in crate::mpc) soft: &'a SoftAngle<S>,
    /// Violations that count as none, of an input and, times the step's number, of an angle.
    pub(super) tolerances: [f32; 2],
}

impl<'a, const S: usize> AngleBounds<'a, S> {
    /// Between two angles, in either order.
    pub(in crate::mpc) fn new([one, other]: [f32; 2], soft: &'a SoftAngle<S>) -> Self {
        let (lower, upper) = if one < other { (one, other) } else { (other, one) };
        Self { lower, upper, soft, tolerances: [INPUT_TOLERANCE, soft.tolerance] }
    }
}
