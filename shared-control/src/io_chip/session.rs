//! Which request comes next, and what is known so far.

use super::firmware::{Button, Firmware, IDENTITY, Safety};
use super::packet::{Bytes, Reply, Request};
use crate::radio::RadioFrame;

/// Slots without an answer after which the chip may have started anew, and is made safe again: 20 ms. At 1 % of
/// damaged packets that happens once a day.
const ASK_AGAIN_SLOTS: u16 = 4;
/// Slots without an answer after which it counts as silent: 100 ms.
const SILENT_SLOTS: u16 = 20;
/// The same before it was ever heard, 2 s: it starts with the board, by a bootloader of its own.
const NEVER_HEARD_SLOTS: u16 = 400;
/// The safety button is looked at in one slot of so many: every 50 ms.
const SAFETY_SLOTS: u16 = 10;
/// A firmware that is not known is asked again in one slot of so many: every 100 ms.
const UNKNOWN_SLOTS: u16 = 20;

/// Who is at the other end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IoState {
    /// Nobody has answered yet.
    #[default]
    Unheard,
    /// A firmware that is known.
    Known(Firmware),
    /// Another one: registers 0 and 1 of page 0.
    Unknown(u16, u16),
    /// Nobody answers any more.
    Silent,
}

/// What the chip has told so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IoReport {
    /// Who it is.
    pub state: IoState,
    /// The receiver; not heard while the chip is not.
    pub radio: RadioFrame,
    /// The safety button.
    pub safety: Safety,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Recognise,
    SetUp(Firmware, usize),
    Run(Firmware),
    /// A firmware that is not known, or that refused what its kind does not refuse.
    LeaveAlone,
}

/// The conversation with the chip.
#[derive(Clone, Debug)]
pub struct IoSession {
    phase: Phase,
    slot: u16,
    /// Slots since the last answer.
    unanswered: u16,
    asked: Option<Request>,
    /// Of protocol 5: what is still to be said after a press of the button.
    to_say: usize,
    report: IoReport,
    /// Replies that were damaged, or that answered something else.
    pub damaged: u32,
}

impl Default for IoSession {
    fn default() -> Self {
        Self {
            phase: Phase::Recognise,
            slot: 0,
            unanswered: 0,
            asked: None,
            to_say: 0,
            report: IoReport::default(),
            damaged: 0,
        }
    }
}

impl IoSession {
    /// At the beginning of each slot: the request that is sent now, whether or not the last was answered.
    pub fn begin_slot(&mut self) -> Option<Bytes> {
        self.slot = self.slot.wrapping_add(1);
        self.unanswered = self.unanswered.saturating_add(1);
        if self.unanswered > ASK_AGAIN_SLOTS {
            self.phase = Phase::Recognise;
        }
        let silent = if self.report.state == IoState::Unheard { NEVER_HEARD_SLOTS } else { SILENT_SLOTS };
        if self.unanswered > silent {
            self.report = IoReport { state: IoState::Silent, safety: self.report.safety, ..IoReport::default() };
        }
        self.asked = match self.phase {
            Phase::Recognise => Some(IDENTITY),
            Phase::LeaveAlone => {
                // its silence is not waited for
                self.unanswered = 0;
                self.slot.is_multiple_of(UNKNOWN_SLOTS).then_some(IDENTITY)
            }
            Phase::SetUp(firmware, step) => firmware.set_up(step),
            Phase::Run(firmware) => Some(firmware.radio_request()),
        };
        self.asked.map(|request| request.bytes())
    }

    /// Takes what arrived until the line was idle; what is asked next in this slot.
    pub fn take(&mut self, bytes: &[u8]) -> Option<Bytes> {
        let request = self.asked?;
        let Some(reply) = Reply::to(&request, bytes) else {
            self.damaged = self.damaged.saturating_add(1);
            return None;
        };
        self.unanswered = 0;
        self.asked = match reply {
            Reply::Refused => {
                self.leave_alone(self.report.state);
                None
            }
            Reply::Done(registers) => match self.phase {
                Phase::Recognise | Phase::LeaveAlone => self.recognise(registers.first(), registers.get(1)),
                Phase::SetUp(firmware, step) => self.set_up(firmware, step + 1),
                Phase::Run(firmware) if request == firmware.radio_request() => {
                    self.report.radio = firmware.radio(&registers);
                    self.slot.is_multiple_of(SAFETY_SLOTS).then(|| firmware.safety_request())
                }
                Phase::Run(firmware) if request == firmware.safety_request() => {
                    self.button(firmware.safety(&registers));
                    self.next_to_say()
                }
                Phase::Run(_) => {
                    self.to_say = self.to_say.saturating_sub(1);
                    self.next_to_say()
                }
            },
        };
        self.asked.map(|request| request.bytes())
    }

    /// What is known.
    pub fn report(&self) -> &IoReport {
        &self.report
    }

    fn recognise(&mut self, first: Option<&u16>, second: Option<&u16>) -> Option<Request> {
        let (Some(first), Some(second)) = (first, second) else { return None };
        match Firmware::of(*first, *second) {
            Some(firmware) => self.set_up(firmware, 0),
            None => {
                self.leave_alone(IoState::Unknown(*first, *second));
                None
            }
        }
    }

    fn leave_alone(&mut self, state: IoState) {
        self.phase = Phase::LeaveAlone;
        self.report = IoReport { state, ..IoReport::default() };
    }

    fn set_up(&mut self, firmware: Firmware, step: usize) -> Option<Request> {
        let next = firmware.set_up(step);
        if next.is_some() {
            self.phase = Phase::SetUp(firmware, step);
        } else {
            self.phase = Phase::Run(firmware);
            (self.report.state, self.report.safety, self.to_say) = (IoState::Known(firmware), Safety::On, 0);
        }
        next
    }

    fn button(&mut self, button: Button) {
        match button {
            Button::Is(safety) => self.report.safety = safety,
            // a press that was not acknowledged yet has been counted
            Button::Pressed(true) if self.to_say == 0 => {
                self.report.safety = if self.report.safety == Safety::On { Safety::Off } else { Safety::On };
                self.to_say = Firmware::after_press(self.report.safety).len();
            }
            Button::Pressed(_) => {}
        }
    }

    fn next_to_say(&self) -> Option<Request> {
        let said = Firmware::after_press(self.report.safety);
        said.len().checked_sub(self.to_say).and_then(|next| said.get(next)).copied()
    }
}

#[cfg(test)]
mod tests;
