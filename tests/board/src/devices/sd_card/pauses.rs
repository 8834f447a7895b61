//! When a card answers: its own business, within what the specification allows.
//!
//! SD Physical Layer Simplified Specification 6.00, section 4.6.2.2: a write may keep the card busy for 250 ms, of an
//! SDXC card 500 ms. Cards that log flights do so now and then, when they move blocks about; the rest of the time a
//! write takes about a millisecond.

use rand_core::Rng;
use rand_pcg::Pcg64;

use crate::time::{TICKS_PER_US, Ticks};

const MILLISECOND: Ticks = 1000 * TICKS_PER_US;

/// How a card takes its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pauses {
    /// From a read command to the first bit, and from block to block.
    pub access: Ticks,
    /// Busy after a block whose successor follows at once.
    pub between_blocks: Ticks,
    /// Busy after the last block.
    pub after_write: Ticks,
    /// One in so many commands to write ends in a long pause; 0 for none.
    pub long_one_in: u32,
    /// Shortest and longest of those.
    pub long: [Ticks; 2],
}

impl Pauses {
    /// A card as they are sold.
    pub const USUAL: Self = Self {
        access: 300 * TICKS_PER_US,
        between_blocks: 20 * TICKS_PER_US,
        after_write: MILLISECOND,
        long_one_in: 25,
        long: [100 * MILLISECOND, 250 * MILLISECOND],
    };
    /// Each write takes what a write may take at most.
    pub const SLOWEST: Self =
        Self { after_write: 250 * MILLISECOND, long_one_in: 0, access: 100 * MILLISECOND, ..Self::USUAL };
}

/// Pauses, drawn from a seed.
#[derive(Clone, Debug)]
pub(super) struct Clockwork {
    pub(super) pauses: Pauses,
    random: Pcg64,
}

impl Clockwork {
    pub(super) fn new(pauses: Pauses, seed: u64) -> Self {
        Self { pauses, random: Pcg64::new(u128::from(seed), 0x5d_ca4d) }
    }

    /// How long the end of a write keeps the card busy.
    pub(super) fn after_write(&mut self) -> Ticks {
        let Pauses { after_write, long_one_in, long: [shortest, longest], .. } = self.pauses;
        let drawn = self.random.next_u64();
        if long_one_in > 0 && drawn.is_multiple_of(u64::from(long_one_in)) {
            shortest + (drawn >> 32) % (longest - shortest + 1)
        } else {
            after_write
        }
    }
}
