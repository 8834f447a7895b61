//! The cost ahead of a stage as a quadratic in state and input, and what one stage makes of it.
//!
//! Dynamic programming (Riccati recursion) for the problem at the head of [`super`]: the cost from stage k on, once its
//! own input is eliminated, is a quadratic again, in the state and the previous input.

/// x'Px + 2 c'x u + g u^2 + 2 l'x + 2 n u, without its constant, over S states x and one input u.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct Quadratic<const S: usize> {
    /// P; symmetric, of which only the part on and above the diagonal is read or kept.
    pub(in crate::mpc) state: [[f32; S]; S],
    /// c.
    pub(in crate::mpc) cross: [f32; S],
    /// g.
    pub(in crate::mpc) input: f32,
    /// l.
    pub(in crate::mpc) state_linear: [f32; S],
    /// n.
    pub(in crate::mpc) input_linear: f32,
}

/// The input as an affine function: state'x + previous u_prev + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct Law<const S: usize> {
    pub(in crate::mpc) state: [f32; S],
    pub(in crate::mpc) previous: f32,
    pub(in crate::mpc) offset: f32,
}

impl<const S: usize> Law<S> {
    pub(in crate::mpc) const ZERO: Self = Self { state: [0.0; S], previous: 0.0, offset: 0.0 };

    #[inline(always)]
    pub(in crate::mpc) fn input(&self, state: &[f32; S], previous: f32) -> f32 {
        let start = self.previous * previous + self.offset;
        self.state.iter().zip(state).fold(start, |sum, (gain, value)| sum + gain * value)
    }
}

impl<const S: usize> Quadratic<S> {
    pub(in crate::mpc) const ZERO: Self =
        Self { state: [[0.0; S]; S], cross: [0.0; S], input: 0.0, state_linear: [0.0; S], input_linear: 0.0 };

    /// Adds rho (u - u_prev)^2 and eliminates u: the minimising law without bounds, and what remains if u follows it
    /// (`held` is none) or is held at a bound, as a quadratic in the state and u_prev.
    #[inline(always)]
    pub(in crate::mpc) fn eliminate(&self, increment_weight: f32, held: Option<f32>) -> (Law<S>, Self) {
        let inverse = 1.0 / (self.input + increment_weight);
        let law = Law {
            state: self.cross.map(|entry| -entry * inverse),
            previous: increment_weight * inverse,
            offset: -self.input_linear * inverse,
        };
        (
            law,
            match held {
                None => self.follow(&law, increment_weight),
                Some(input) => self.hold(input, increment_weight),
            },
        )
    }

    /// With u put in by `law`.
    #[inline(always)]
    fn follow(&self, law: &Law<S>, increment_weight: f32) -> Self {
        let mut remaining = *self;
        for (row, (entries, cross)) in remaining.state.iter_mut().zip(&self.cross).enumerate() {
            for (entry, gain) in entries.iter_mut().zip(&law.state).skip(row) {
                *entry += cross * gain;
            }
        }
        for (entry, gain) in remaining.state_linear.iter_mut().zip(&law.state) {
            *entry += self.input_linear * gain;
        }
        remaining.cross = law.state.map(|gain| -increment_weight * gain);
        // rho - rho^2 / (g + rho), without the difference of two large numbers
        remaining.input = self.input * law.previous;
        remaining.input_linear = -increment_weight * law.offset;
        remaining
    }

    /// With u at a bound.
    #[inline(always)]
    pub(in crate::mpc) fn hold(&self, input: f32, increment_weight: f32) -> Self {
        let mut remaining = *self;
        for (entry, cross) in remaining.state_linear.iter_mut().zip(&self.cross) {
            *entry += cross * input;
        }
        remaining.cross = [0.0; S];
        remaining.input = increment_weight;
        remaining.input_linear = -increment_weight * input;
        remaining
    }
}
