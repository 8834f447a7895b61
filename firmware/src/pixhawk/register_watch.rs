//! Does a sensor still have its settings? One register is read behind a sample, all of them within some 20 ms.
//!
//! ```text
//!  Kept --differs--> Asked --another, or nobody, answers--> Kept: no case for settings, the loop judges the samples
//!   ^                  `--the chip itself--> Restored --all written--> Proven --all read back--> Kept
//!   |               ^-----------------------differs-----------------|
//!   `-- its samples count again when it has settled              after 0.5 s --> GivenUp
//! ```
//! From the first register that differs until it has settled its samples are held back: a range or a filter that is
//! not the one that was set makes wrong rates of right words. The loop takes that for an IMU that sends nothing. A chip
//! that does not keep its settings stays out until the board is started again.

use heapless::Vec;

use super::counters::Counter;

/// Another round of writing and reading is tried for so long.
const GIVE_UP_US: u32 = 500_000;

/// Registers of a chip with their values, in the order in which they are written.
pub type Settings = Vec<(u8, u8), 10>;

/// Several lists as one. There is room for the longest, the LSM303D's.
pub fn settings(lists: &[&[(u8, u8)]]) -> Settings {
    let mut all = Settings::new();
    for list in lists {
        let _ = all.extend_from_slice(list);
    }
    all
}

/// What a watch must know of a chip.
pub struct Watched {
    /// The register that says who it is, and what it says.
    pub identity: (u8, u8),
    /// The register that switches it on.
    pub power: u8,
    /// After its ranges and filters were set again, until its samples are right, us.
    pub settle_us: u32,
    /// After it was switched on.
    pub wake_us: u32,
    /// So often were its settings lost, and set up again.
    pub restored: &'static Counter,
    /// They were lost and not kept when they were written again: it is out of use.
    pub given_up: &'static Counter,
}

/// What is to go over the bus.
#[derive(Clone, Copy)]
pub enum Access {
    /// Of this register.
    Read(u8),
    /// Of this register with this value.
    Write(u8, u8),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Kept,
    Asked,
    Restored,
    Proven,
    GivenUp,
}

/// The settings, and how far they have been looked at.
pub struct RegisterWatch {
    watched: &'static Watched,
    settings: Settings,
    /// The first so many are written and never read: registers that the data sheet does not have.
    unread: usize,
    state: State,
    place: usize,
    /// Since when its settings are known to be lost.
    lost_us: Option<u32>,
    /// It was switched off when that was found.
    slept: bool,
    /// Samples count again when so much time is over.
    settles: Option<(u32, u32)>,
    /// No sample came since this was said.
    silent: bool,
}

impl RegisterWatch {
    /// Of a chip that has just been set up with these, of which the first few are never read.
    pub fn new(watched: &'static Watched, settings: Settings, unread: usize) -> Self {
        let (state, lost_us, settles) = (State::Kept, None, None);
        Self { watched, settings, unread, state, place: unread, lost_us, slept: false, settles, silent: false }
    }

    fn setting(&self) -> (u8, u8) {
        self.settings.get(self.place).copied().unwrap_or(self.watched.identity)
    }

    /// The next thing to do, while the chip is worth it.
    pub fn access(&self) -> Option<Access> {
        let (register, value) = self.setting();
        match self.state {
            State::Kept | State::Proven => Some(Access::Read(register)),
            State::Asked => Some(Access::Read(self.watched.identity.0)),
            State::Restored => Some(Access::Write(register, value)),
            State::GivenUp => None,
        }
    }

    /// Is there more to be done at once? Who did not keep its settings is asked again behind the next sample, or in
    /// the next step.
    pub fn is_busy(&self) -> bool {
        matches!(self.state, State::Restored | State::Proven)
    }

    /// It sends nothing: whether it is switched on is the first thing to know, then all the others.
    pub fn is_silent(&mut self) {
        if !core::mem::replace(&mut self.silent, true) && self.state == State::Kept {
            let power = self.settings.iter().position(|(register, _)| *register == self.watched.power);
            self.place = power.unwrap_or(self.unread);
        }
    }

    /// The access that was to be made has brought this answer.
    pub fn answered(&mut self, answer: u8, now_us: u32) {
        let (register, value) = self.setting();
        match self.state {
            State::Kept if answer == value => self.advance(State::Kept),
            State::Kept => {
                self.slept = register == self.watched.power;
                self.go(State::Asked);
            }
            State::Asked if answer == self.watched.identity.1 => {
                self.lost_us = self.lost_us.or(Some(now_us));
                self.go(State::Restored);
            }
            State::Asked if self.lost_us.is_none() => self.go(State::Kept),
            State::Asked | State::GivenUp => {}
            State::Restored => self.advance(State::Proven),
            State::Proven if answer == value => {
                self.advance(State::Kept);
                if self.state == State::Kept {
                    self.lost_us = None;
                    let settles_us = if self.slept { self.watched.wake_us } else { self.watched.settle_us };
                    self.settles = Some((now_us, settles_us));
                    self.watched.restored.add();
                }
            }
            State::Proven if self.lost_us.is_some_and(|lost_us| now_us.wrapping_sub(lost_us) > GIVE_UP_US) => {
                self.go(State::GivenUp);
                self.watched.given_up.add();
            }
            State::Proven => self.go(State::Asked),
        }
    }

    /// A sample has come. May it be used?
    pub fn trusts(&mut self, now_us: u32) -> bool {
        self.silent = false;
        if let Some((since_us, duration_us)) = self.settles
            && now_us.wrapping_sub(since_us) >= duration_us
        {
            self.settles = None;
        }
        self.settles.is_none() && self.lost_us.is_none()
    }

    /// On to the next register; behind the last, to another state.
    fn advance(&mut self, behind_the_last: State) {
        self.place += 1;
        if self.place >= self.settings.len() {
            self.go(behind_the_last);
        }
    }

    fn go(&mut self, state: State) {
        self.state = state;
        self.place = if state == State::Restored { 0 } else { self.unread };
    }
}
