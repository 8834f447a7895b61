//! Random numbers that are the same bytes for the same seed on every machine.
//!
//! One seed is split into streams by name, so that a new consumer, or one that draws more, changes no other. The
//! generator is PCG64 (O'Neill, PCG, HMC-CS-2014-0905); normal numbers come from Marsaglia's polar method (Marsaglia and
//! Bray, SIAM Review 6, 1964) with `libm`'s logarithm.

use rand_core::Rng;
use rand_pcg::Pcg64;

/// A stream of random numbers with a seed and a name.
#[derive(Clone, Debug)]
pub struct RandomStream {
    generator: Pcg64,
    /// The polar method makes two at a time.
    spare_normal: Option<f64>,
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
        Self { generator: Pcg64::new(state, u128::from(name_hash)), spare_normal: None }
    }

    /// Uniform in 0 (included) to 1 (excluded).
    pub fn uniform(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Normal with mean 0 and standard deviation 1.
    #[inline]
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare_normal.take() {
            return spare;
        }
        let [first, second] = self.normal_pair();
        self.spare_normal = Some(second);
        first
    }

    /// One 64-bit draw makes a point of the square, 2^32 steps a side; a point outside the unit circle (21 %) is
    /// thrown away, so that 20 turns in a row happen once in 10^13 calls.
    fn normal_pair(&mut self) -> [f64; 2] {
        loop {
            let bits = self.generator.next_u64();
            // -1 to 1 without the ends, symmetric about zero
            let coordinate = |bits: u32| (f64::from(bits as i32) + 0.5) * (1.0 / (1_u64 << 31) as f64);
            let (x, y) = (coordinate(bits as u32), coordinate((bits >> 32) as u32));
            let square = x * x + y * y;
            if square < 1.0 {
                let scale = (-2.0 * libm::log(square) / square).sqrt();
                return [x * scale, y * scale];
            }
        }
    }
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

    #[test]
    fn uniform_numbers_fill_their_interval_evenly() {
        let mut stream = RandomStream::new(5, "uniform");
        let mut bins = [0_u32; 16];
        for _ in 0..160_000 {
            bins[(stream.uniform() * 16.0) as usize] += 1;
        }
        // chi-square with 15 degrees of freedom: 44.3 is passed with probability 1e-4
        let chi_square: f64 = bins.iter().map(|&count| (f64::from(count) - 1e4).powi(2) / 1e4).sum();
        assert!(chi_square < 44.3, "{chi_square}");
    }
}
