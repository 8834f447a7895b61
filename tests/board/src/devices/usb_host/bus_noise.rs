//! A bus on which packets are damaged: who receives one ignores it (USB 2.0, sections 8.6 and 8.7.1), and the host
//! tries the transaction again.

/// What a transaction has lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hurt {
    Nothing,
    /// The token, which the device then has not seen.
    Token,
    /// The packet of data behind it.
    Data,
    /// The acknowledgement of that.
    Handshake,
}

/// Draws which, the same ones in each run.
#[derive(Clone, Debug, Default)]
pub(super) struct BusNoise {
    permille: u32,
    state: u32,
    hurt: u32,
}

impl BusNoise {
    pub(super) fn set(&mut self, permille: u32) {
        self.permille = permille;
    }

    pub(super) fn hurt(&self) -> u32 {
        self.hurt
    }

    pub(super) fn draw(&mut self) -> Hurt {
        if self.next() % 1000 >= self.permille {
            return Hurt::Nothing;
        }
        self.hurt += 1;
        [Hurt::Token, Hurt::Data, Hurt::Handshake][self.next() as usize % 3]
    }

    /// A linear congruential generator's upper bits (Numerical Recipes' constants).
    fn next(&mut self) -> u32 {
        self.state = self.state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.state >> 12
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_are_hurt_as_are_wished_and_each_part_as_often() {
        let mut noise = BusNoise::default();
        assert!((0..1000).all(|_| noise.draw() == Hurt::Nothing) && noise.hurt() == 0);
        noise.set(200);
        let mut counts = [0_u32; 4];
        for _ in 0..30_000 {
            counts[noise.draw() as usize] += 1;
        }
        // 6,000 in all and 2,000 each, within five standard deviations
        assert!(noise.hurt().abs_diff(6000) < 350, "{}", noise.hurt());
        assert!(counts[1..].iter().all(|count| count.abs_diff(2000) < 220), "{counts:?}");
    }
}
