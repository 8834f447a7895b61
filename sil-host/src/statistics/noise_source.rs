//! Seeded noise for the tests of this module.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

pub(crate) struct NoiseSource(Pcg64);

impl NoiseSource {
    pub(crate) fn new(seed: u64) -> NoiseSource {
        NoiseSource(Pcg64::seed_from_u64(seed))
    }

    /// Uniform in -1..1.
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Standard normal: the sum of twelve uniforms of variance 1/3, scaled; its tails end at 6.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() * 0.5
    }
}
