//! The guess of which inputs are held, and the laws that follow from it.

use super::problem::{Problem, Slot};
use super::quadratic::Law;

/// What a guess says of one input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::mpc) enum Held {
    /// Inside its bounds.
    Free,
    /// At the upper one.
    High,
    /// At the lower one.
    Low,
}

impl Held {
    /// 1 at the upper bound, -1 at the lower.
    #[inline(always)]
    pub(super) fn sign(self) -> f32 {
        match self {
            Self::Free => 0.0,
            Self::High => 1.0,
            Self::Low => -1.0,
        }
    }
}

/// The guess. Without numbers that depend on a model or on weights, it is a warm start for any problem of its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct Pattern<const M: usize, I> {
    pub(super) held: [Held; M],
    /// The plan of the last pass, as many as the control horizon, where the problem keeps it.
    pub(in crate::mpc) inputs: [I; M],
}

impl<const M: usize, I: Slot<f32>> Pattern<M, I> {
    /// Everything free.
    pub(in crate::mpc) const fn new() -> Self {
        Self { held: [Held::Free; M], inputs: [I::BLANK; M] }
    }

    /// Everything free again.
    pub(super) fn clear(&mut self) {
        *self = Self::new();
    }
}

/// Laws of the stages under a guess, and what was computed on the way to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct Laws<const S: usize, const M: usize, C> {
    /// Of a regulation problem those of held stages and of all before them; from `held_count` on they are the free
    /// stages'.
    pub(super) laws: [Law<S>; M],
    /// The costs ahead of the stages before `held_count`, where the problem keeps them.
    pub(super) costs: [C; M],
    /// Stages up to the last held one.
    pub(super) held_count: usize,
    /// Of the prepared problem they belong to, where they are kept.
    pub(super) stamp: u32,
}

impl<const S: usize, const M: usize, C: Copy> Laws<S, M, C> {
    /// Of a guess in which everything is free.
    #[inline(always)]
    pub(in crate::mpc) const fn blank(cost: C) -> Self {
        Self { laws: [Law::ZERO; M], costs: [cost; M], held_count: 0, stamp: 0 }
    }
}

/// A guess with its laws.
pub(in crate::mpc) type PatternOf<P, const S: usize, const M: usize> = Pattern<M, <P as Problem<S>>::Input>;
/// The laws of a problem's guess.
pub(in crate::mpc) type LawsOf<P, const S: usize, const M: usize> = Laws<S, M, <P as Problem<S>>::Cost>;
