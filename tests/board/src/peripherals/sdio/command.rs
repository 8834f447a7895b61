//! The command path: 48 bits out, then nothing, 48 or 136 bits in, or the end of a wait of 64 clocks. Section 31.3.1.

use super::{CCRCFAIL, CMDREND, CMDSENT, CTIMEOUT, Outgoing, Response, Sdio, Unmodelled};
use crate::time::Ticks;

const COMMAND_BITS: u64 = 48;
/// From the end of a command to the response: 2 to 64 clocks are allowed (N_CR).
const GAP_BITS: u64 = 5;
const SHORT_BITS: u64 = 48;
const LONG_BITS: u64 = 136;
/// The time-out is fixed.
const TIME_OUT_BITS: u64 = 64;
/// Index of a response without one.
const NO_INDEX: u32 = 0x3f;

/// A command under way.
#[derive(Clone, Debug)]
pub(super) enum Command {
    /// On the line until then.
    Sending { until: Ticks },
    /// With whoever is at the other end, since then.
    Heard { at: Ticks },
    /// Over then, with these flags and this content of the response registers.
    Answered { until: Ticks, flags: u32, response: Option<(u32, [u32; 4])> },
}

impl Sdio {
    pub(super) fn begin_command(&mut self, now: Ticks) -> Result<(), Unmodelled> {
        self.is_clocked()?;
        if self.command.is_some() {
            return Err(Unmodelled("SDIO command while another is under way"));
        }
        self.command = Some(Command::Sending { until: now + COMMAND_BITS * self.cycle() });
        Ok(())
    }

    pub(super) fn command_sent(&mut self, now: Ticks) -> Option<Outgoing> {
        match self.command {
            Some(Command::Sending { until }) if until <= now => {
                self.command = Some(Command::Heard { at: until });
                let index = (self.command_register & 0x3f) as u8;
                Some(Outgoing::Command { index, argument: self.argument, at: until })
            }
            _ => None,
        }
    }

    /// What came back to the command that went out.
    pub(crate) fn respond(&mut self, response: Response) {
        let Some(Command::Heard { at }) = self.command else { return };
        let awaits = self.command_register >> 6 & 3;
        let cycle = self.cycle();
        let index = self.command_register & 0x3f;
        let short_until = at + (GAP_BITS + SHORT_BITS) * cycle;
        let (until, flags, response) = match (awaits, response) {
            (0 | 2, _) => (at, CMDSENT, None),
            (1, Response::Short(word)) => (short_until, CMDREND, Some((index, [word, 0, 0, 0]))),
            // ones in place of index and CRC, which the controller takes for a wrong CRC
            (1, Response::Conditions(word)) => (short_until, CCRCFAIL, Some((NO_INDEX, [word, 0, 0, 0]))),
            (3, Response::Long(words)) => (at + (GAP_BITS + LONG_BITS) * cycle, CMDREND, Some((NO_INDEX, words))),
            // one of another length ends in bits that are no CRC
            (1, Response::Long(_)) | (3, Response::Short(_) | Response::Conditions(_)) => {
                (at + (GAP_BITS + LONG_BITS) * cycle, CCRCFAIL, None)
            }
            (_, Response::None) | (4.., _) => (at + TIME_OUT_BITS * cycle, CTIMEOUT, None),
        };
        self.command = Some(Command::Answered { until, flags, response });
    }

    pub(super) fn tick_command(&mut self, now: Ticks) {
        if let Some(Command::Answered { until, flags, response }) = self.command
            && until <= now
        {
            self.flags |= flags;
            if let Some((index, words)) = response {
                (self.response_index, self.responses) = (index, words);
            }
            self.command = None;
        }
    }

    pub(super) fn command_event(&self) -> Option<Ticks> {
        match self.command.as_ref()? {
            Command::Sending { until } | Command::Answered { until, .. } => Some(*until),
            Command::Heard { .. } => None,
        }
    }
}
