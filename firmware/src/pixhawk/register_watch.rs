//! Does the MPU6000 still have its settings? One register is read behind each sample, all of them within 9 ms.
//!
//! ```text
//!  Kept --differs--> Asked --another, or nobody, answers--> Kept: no case for settings, the loop judges the samples
//!   ^                  `--the MPU6000--> Restored --all written--> Proven --all read back--> Kept
//!   |               ^-----------------------differs-----------------|
//!   `-- its samples count again when it has settled              after 0.5 s --> GivenUp
//! ```
//! From the first register that differs until it has settled its samples are held back: a range or a filter that is
//! not the one that was set makes wrong rates of right words. The loop takes that for an IMU that sends nothing. A chip
//! that does not keep its settings stays out until the board is started again.

use super::counters::{FIRST_IMU_GIVEN_UP, FIRST_IMU_RESTORED};
use super::mpu6000::{self, SETTINGS, Settings};

/// Another round of writing and reading is tried for so long.
const GIVE_UP_US: u32 = 500_000;
/// After its ranges and filters were set again: two samples.
const SETTLE_US: u32 = 2_000;
/// After it was woken: its gyro takes 30 ms (product specification 6.1).
const WAKE_US: u32 = 50_000;

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
    settings: Settings,
    state: State,
    place: usize,
    /// Since when its settings are known to be lost.
    lost_us: Option<u32>,
    /// It was asleep when that was found.
    slept: bool,
    /// Samples count again when so much time is over.
    settles: Option<(u32, u32)>,
}

impl RegisterWatch {
    /// Of a chip that has just been set up with these.
    pub fn new(settings: Settings) -> Self {
        Self { settings, state: State::Kept, place: 0, lost_us: None, slept: false, settles: None }
    }

    /// The next thing to do, while the chip is worth it.
    pub fn access(&self) -> Option<Access> {
        let (register, value) = self.settings[self.place % SETTINGS];
        match self.state {
            State::Kept | State::Proven => Some(Access::Read(register)),
            State::Asked => Some(Access::Read(mpu6000::WHO_AM_I)),
            State::Restored => Some(Access::Write(register, value)),
            State::GivenUp => None,
        }
    }

    /// Is there more to be done at once? Who did not keep its settings is asked again behind the next sample, or in
    /// the next step.
    pub fn is_busy(&self) -> bool {
        matches!(self.state, State::Restored | State::Proven)
    }

    /// It sends nothing: whether it sleeps is the first thing to know.
    pub fn is_silent(&mut self) {
        if self.state == State::Kept {
            self.place = 0;
        }
    }

    /// The access that was to be made has brought this answer.
    pub fn answered(&mut self, answer: u8, now_us: u32) {
        let (register, value) = self.settings[self.place % SETTINGS];
        match self.state {
            State::Kept if answer == value => self.advance(State::Kept),
            State::Kept => {
                self.slept = register == mpu6000::PWR_MGMT_1;
                self.go(State::Asked);
            }
            State::Asked if answer == mpu6000::IDENTITY => {
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
                    self.settles = Some((now_us, if self.slept { WAKE_US } else { SETTLE_US }));
                    FIRST_IMU_RESTORED.add();
                }
            }
            State::Proven if self.lost_us.is_some_and(|lost_us| now_us.wrapping_sub(lost_us) > GIVE_UP_US) => {
                self.go(State::GivenUp);
                FIRST_IMU_GIVEN_UP.add();
            }
            State::Proven => self.go(State::Asked),
        }
    }

    /// May its samples be used?
    pub fn trusts(&mut self, now_us: u32) -> bool {
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
        if self.place == SETTINGS {
            self.go(behind_the_last);
        }
    }

    fn go(&mut self, state: State) {
        (self.state, self.place) = (state, 0);
    }
}
