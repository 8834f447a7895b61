//! Noise on a serial line: bytes that are lost, and bytes that come with a bit turned.
//!
//! A radio link or a long cable does both. A turned data bit raises no flag of the receiver (RM0090 section 30.3.3:
//! only the stop bit is checked), a byte of which the start bit is lost is not there at all.

use rand_core::Rng;
use rand_pcg::Pcg64;

/// What becomes of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Received {
    Whole(u8),
    Lost,
}

/// Noise of a given strength, the same at every run.
#[derive(Clone, Debug)]
pub(crate) struct LineNoise {
    lost_permille: u32,
    turned_permille: u32,
    generator: Pcg64,
}

impl LineNoise {
    /// So many bytes of a thousand.
    pub(crate) fn new(lost_permille: u32, turned_permille: u32, seed: u64) -> Self {
        Self { lost_permille, turned_permille, generator: Pcg64::new(u128::from(seed), 0x11e5) }
    }

    /// A byte comes along.
    pub(crate) fn pass(&mut self, byte: u8) -> Received {
        let (draw, bit) = (self.generator.next_u32() % 1000, self.generator.next_u32() % 8);
        if draw < self.lost_permille {
            Received::Lost
        } else if draw < self.lost_permille + self.turned_permille {
            Received::Whole(byte ^ 1 << bit)
        } else {
            Received::Whole(byte)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_bytes_suffer_as_it_is_told() {
        let mut noise = LineNoise::new(50, 100, 1);
        let received = (0..100_000).map(|_| noise.pass(0x5a)).collect::<Vec<_>>();
        let lost = received.iter().filter(|byte| **byte == Received::Lost).count();
        let turned = received.iter().filter(|byte| !matches!(byte, Received::Lost | Received::Whole(0x5a))).count();
        // five standard deviations: 345 and 475
        assert!(lost.abs_diff(5_000) < 345 && turned.abs_diff(10_000) < 475, "{lost} {turned}");
        let one_bit = |byte: &Received| !matches!(byte, Received::Whole(byte) if (byte ^ 0x5a).count_ones() > 1);
        assert!(received.iter().all(one_bit));
    }

    #[test]
    fn without_strength_nothing_happens() {
        let mut noise = LineNoise::new(0, 0, 1);
        assert!((0..=255).all(|byte| noise.pass(byte) == Received::Whole(byte)));
    }
}
