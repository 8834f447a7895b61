//! Random numbers that are the same bytes for the same seed on every machine.
//!
//! One seed is split into streams by name, so that a new consumer, or one that draws more, changes no other. The
//! generator is PCG64 (O'Neill, PCG, HMC-CS-2014-0905); normal numbers come from Marsaglia's polar method (Marsaglia
//! and Bray, SIAM Review 6, 1964) with `libm`'s logarithm.

use rand_core::Rng;
use rand_pcg::Pcg64;

/// Normal numbers made at a time. In bulk the processor overlaps the logarithms, which halves the time of each.
const BATCH: usize = 64;

/// A stream of random numbers with a seed and a name.
#[derive(Clone, Debug)]
pub struct RandomStream {
    generator: Pcg64,
    normals: [f64; BATCH],
    /// Those before this index are used up.
    next_normal: usize,
}

impl RandomStream {
    /// The stream `name` of `seed`.
    pub fn new(seed: u64, name: &str) -> Self {
        // FNV-1a (Fowler, Noll, Vo) of the name
        let name_hash = name
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3_u64));
        let low = split_mix(seed ^ name_hash);
        let high = split_mix(low ^ seed);
        let state = u128::from(high) << 64 | u128::from(low);
        Self { generator: Pcg64::new(state, u128::from(name_hash)), normals: [0.0; BATCH], next_normal: BATCH }
    }

    /// Normal with mean 0 and standard deviation 1.
    #[inline]
    pub fn normal(&mut self) -> f64 {
        if self.next_normal == BATCH {
            self.make_normals();
            self.next_normal = 0;
        }
        let normal = self.normals[self.next_normal];
        self.next_normal += 1;
        normal
    }

    /// Uniform from 0 to below 1.
    pub fn uniform(&mut self) -> f64 {
        // the 53 bits that a double holds
        (self.generator.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// One 64-bit draw is a point of the square, 2^32 steps a side. A point outside the unit circle (21 %) is
    /// overwritten by the next rather than branched upon.
    fn make_normals(&mut self) {
        let mut points = [[0.0; 3]; BATCH / 2];
        let mut accepted = 0;
        while accepted < points.len() {
            let bits = self.generator.next_u64();
            let (x, y) = (coordinate(bits as u32), coordinate((bits >> 32) as u32));
            let square = x * x + y * y;
            points[accepted] = [x, y, square];
            accepted += usize::from(square < 1.0);
        }
        for (normals, [x, y, square]) in self.normals.chunks_exact_mut(2).zip(points) {
            let scale = (-2.0 * libm::log(square) / square).sqrt();
            normals.copy_from_slice(&[x * scale, y * scale]);
        }
    }
}

/// -1 to 1 without the ends and without zero, symmetric about it.
#[inline]
fn coordinate(bits: u32) -> f64 {
    (f64::from(bits as i32) + 0.5) * (1.0 / (1_u64 << 31) as f64)
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): close seeds give far states.
fn split_mix(seed: u64) -> u64 {
    let mut mixed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: usize = 200_000;

    fn normals(seed: u64, name: &str) -> Vec<f64> {
        let mut stream = RandomStream::new(seed, name);
        (0..COUNT).map(|_| stream.normal()).collect()
    }

    /// Mean of `f` over the values.
    fn mean(values: &[f64], f: impl Fn(f64) -> f64) -> f64 {
        values.iter().map(|&value| f(value)).sum::<f64>() / values.len() as f64
    }

    #[test]
    fn normal_numbers_have_the_moments_and_tails_of_the_normal_distribution() {
        let values = normals(1, "moments");
        let n = COUNT as f64;
        // five standard errors of each estimate: sqrt(var/n) with var 1, 2, 15, 96
        assert!(mean(&values, |v| v).abs() < 5.0 * (1.0 / n).sqrt());
        assert!((mean(&values, |v| v * v) - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
        assert!(mean(&values, |v| v * v * v).abs() < 5.0 * (15.0 / n).sqrt());
        assert!((mean(&values, |v| v * v * v * v) - 3.0).abs() < 5.0 * (96.0 / n).sqrt());
        // P(|v| > 1, 2, 3) from the error function; five standard errors of a proportion
        for (limit, expected) in [(1.0, 0.317_310_5), (2.0, 0.045_500_3), (3.0, 0.002_699_8)] {
            let share = mean(&values, |v| if v.abs() > limit { 1.0 } else { 0.0 });
            assert!((share - expected).abs() < 5.0 * (expected * (1.0 - expected) / n).sqrt(), "{limit}: {share}");
        }
    }

    #[test]
    fn normal_numbers_are_white() {
        let values = normals(2, "white");
        for lag in [1, 2, 3, 7, 50] {
            let products = values.windows(lag + 1).map(|window| window[0] * window[lag]);
            let correlation = products.sum::<f64>() / COUNT as f64;
            // the estimate's standard error is 1/sqrt(n)
            assert!(correlation.abs() < 5.0 / (COUNT as f64).sqrt(), "lag {lag}: {correlation}");
        }
    }

    #[test]
    fn streams_of_other_names_and_seeds_are_unrelated() {
        let reference = normals(3, "gyro");
        for (seed, name) in [(3, "accel"), (4, "gyro"), (3, "gyro2"), (2, "gyro")] {
            let other = normals(seed, name);
            let correlation = reference.iter().zip(&other).map(|(a, b)| a * b).sum::<f64>() / COUNT as f64;
            assert!(correlation.abs() < 5.0 / (COUNT as f64).sqrt(), "{seed} {name}: {correlation}");
        }
    }

    /// The bits themselves, so that a change of generator, seeding or arithmetic cannot pass unseen.
    #[test]
    fn the_same_seed_gives_the_same_bits() {
        let mut stream = RandomStream::new(42, "gyro");
        let bits: Vec<u64> = (0..3).map(|_| stream.normal().to_bits()).collect();
        assert_eq!(bits, [0xbfc1_7e34_fc8f_6657, 0xbfd2_5757_0171_a010, 0xbfc6_13bb_ee7e_5cb0]);
    }
}
