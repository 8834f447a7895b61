//! Signed frames of MAVLink 2: nobody without the key commands the vehicle.
//!
//! A signature is what SHA-256 makes of key, frame and a timestamp that only grows
//! (<https://mavlink.io/en/guide/message_signing.html>). Four parts:
//!
//! - [`signature`]: what it is computed from;
//! - [`Guard`], where bytes arrive: which frames are let in;
//! - [`Signing`], where there is time: the vehicle's clock of timestamps, and what lasts of it;
//! - [`record`]: how that is written into a memory that survives power loss.
//!
//! Timestamps count 10 us since 2015. The vehicle knows no date: its clock goes on where it stopped, and jumps to the
//! latest timestamp that came with a right signature.
//!
//! **No old frame passes, whatever cuts the power.** A timestamp counts only up to the *ceiling*, which is stored
//! before it is used, and after a start only above the ceiling that was found. What is above the ceiling is not obeyed,
//! but raises it if it is signed rightly: the next one is. Where the memory fails the ceiling stays, and in the end
//! nothing is let in.
//!
//! Unsigned, with a key in force, these are let in: `HIL_SENSOR`, which has an effect only where the pins stay
//! disarmed, and `SETUP_SIGNING` on a link that only somebody beside the vehicle can use ([`Receiver::local`]), since
//! whoever has lost the key needs a way out. An unsigned `HEARTBEAT` keeps no link alive, and `RADIO_STATUS` means
//! nothing here.
//!
//! [`Receiver::local`]: crate::link::Receiver::local

mod guard;
pub mod record;
pub mod signature;

pub use guard::{Guard, Refused};
pub use record::{SIGNING_RECORD_LEN, SigningRecord};
pub use signature::{Key, Signer};

/// Timestamps per second.
pub const PER_SECOND: u64 = 100_000;
/// How far behind the latest timestamp a sender that was not heard before may be: a minute, as the protocol says.
const NEWCOMER_BEHIND: u64 = 60 * PER_SECOND;
/// How far the ceiling is above the clock when it is stored: what a ground station may have to wait after a restart.
const RESERVE: u64 = 4 * PER_SECOND;
/// A first timestamp beyond this (2059) is a mistake that would soon leave none.
pub const FIRST_TIMESTAMP_MAX: u64 = 1 << 47;

/// What the ground wants: `SETUP_SIGNING`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SigningSetup {
    /// The key from now on; `None` ends signing.
    pub key: Option<Key>,
    /// Where timestamps begin.
    pub first_timestamp: u64,
    /// Did it come over a link that only somebody beside the vehicle can use?
    pub is_local: bool,
}

/// What a [`Guard`] goes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// The key in force.
    pub key: Option<Key>,
    /// Nothing up to this one is let in.
    pub floor: u64,
    /// Nothing above this one is let in.
    pub ceiling: u64,
    /// The vehicle's clock.
    pub now: u64,
}

/// The key in force and the vehicle's clock of timestamps.
#[derive(Clone, Copy, Debug)]
pub struct Signing {
    kept: SigningRecord,
    floor: u64,
    /// The clock said this at that time, µs.
    clock: (u64, u64),
}

impl Signing {
    /// Goes on from what was kept; time is 0.
    pub fn new(kept: SigningRecord) -> Self {
        Self { kept, floor: kept.ceiling, clock: (kept.ceiling, 0) }
    }

    /// The key in force.
    pub fn key(&self) -> Option<Key> {
        self.kept.key
    }

    /// What the clock says.
    pub fn now(&self, time_us: u64) -> u64 {
        let (then, then_us) = self.clock;
        then.saturating_add(time_us.saturating_sub(then_us) / 10)
    }

    /// Follows the clock of whoever signs, and raises the ceiling in time. `seen` is [`Guard::latest_seen`]; `store`
    /// puts a record into lasting memory, false if it was not kept.
    pub fn update(&mut self, seen: u64, time_us: u64, store: impl FnOnce(&SigningRecord) -> bool) {
        if self.kept.key.is_none() {
            return;
        }
        if seen > self.now(time_us) {
            self.clock = (seen, time_us);
        }
        let now = self.now(time_us);
        if self.kept.ceiling < now.saturating_add(RESERVE / 2) {
            self.keep(SigningRecord { ceiling: now.saturating_add(RESERVE), ..self.kept }, store);
        }
    }

    /// Takes another key into force, or none; false if the memory did not keep it. The same key again changes nothing,
    /// least of all the clock.
    pub fn set_up(&mut self, setup: &SigningSetup, time_us: u64, store: impl FnOnce(&SigningRecord) -> bool) -> bool {
        if setup.key == self.kept.key {
            return true;
        }
        let begin = setup.first_timestamp.saturating_sub(1);
        let ceiling = begin.saturating_add(RESERVE);
        let kept = self.keep(SigningRecord { key: setup.key, ceiling, ..self.kept }, store);
        if kept {
            (self.floor, self.clock) = (begin, (begin, time_us));
        }
        kept
    }

    /// What a guard goes by.
    pub fn terms(&self, time_us: u64) -> Terms {
        let SigningRecord { key, ceiling, .. } = self.kept;
        Terms { key, floor: self.floor, ceiling, now: self.now(time_us) }
    }

    fn keep(&mut self, record: SigningRecord, store: impl FnOnce(&SigningRecord) -> bool) -> bool {
        let next = SigningRecord { serial: self.kept.serial.wrapping_add(1), ..record };
        let kept = store(&next);
        if kept {
            self.kept = next;
        }
        kept
    }
}

#[cfg(test)]
mod tests;
