//! The log of a simulated board: the recorder of its loop, and the task that empties it onto the shelf.

use std::io;

use shared_control::config::Config;
use shared_control::flight_core::StepOutput;
use shared_control::link::Mode;
use shared_control::onboard_log::{Recorder, Stage, head};
use shared_control::params::Params;
use shared_control::radio::RadioFrame;
use shared_control::signals::StepInput;

use super::log_shelf::LogShelf;

/// Room between the loop and the memory, bytes: 170 ms at the most that the loop writes.
const RING_BYTES: usize = 16 << 10;

/// What the loop has recorded, and where it goes.
pub(super) struct BoardLog {
    recorder: Recorder<RING_BYTES>,
    shelf: LogShelf,
    /// The shelf has failed: nothing more of this log is written.
    failed: bool,
}

impl BoardLog {
    /// Nothing recorded yet.
    pub(super) fn new(shelf: LogShelf) -> Self {
        Self { recorder: Recorder::new(), shelf, failed: false }
    }

    /// Complete logs.
    pub(super) fn shelf(&mut self) -> &mut LogShelf {
        &mut self.shelf
    }

    /// Nothing is recorded, and no log is open.
    pub(super) fn is_idle(&self) -> bool {
        self.recorder.stage() == Stage::Idle
    }

    /// The shelf, for the next start of the board; a log under way ends here.
    pub(super) fn into_shelf(mut self) -> LogShelf {
        // what fails now nobody is there to be told
        let _ = self.write_ring().and_then(|()| self.shelf.end());
        self.shelf
    }

    /// Takes a step of the loop.
    pub(super) fn record(
        &mut self,
        config: &Config,
        input: &StepInput,
        output: &StepOutput,
        pilot: (&RadioFrame, Mode),
    ) {
        self.recorder.record(config, input, output, pilot);
    }

    /// Writes what waits.
    ///
    /// # Errors
    /// Once for a log that cannot be written; what there is of it stays.
    pub(super) fn write(&mut self, params: &Params) -> io::Result<()> {
        let result = if self.failed { Ok(()) } else { self.go_on(params) };
        self.failed |= result.is_err();
        if self.failed {
            self.recorder.discard();
        }
        if self.recorder.stage() == Stage::Ended && self.recorder.waiting() == 0 {
            self.recorder.close();
            self.failed = false;
            self.shelf.end()?;
        }
        result
    }

    fn go_on(&mut self, params: &Params) -> io::Result<()> {
        if let (Stage::Running { start_us }, false) = (self.recorder.stage(), self.shelf.is_open()) {
            self.shelf.begin()?;
            let topics = Recorder::<RING_BYTES>::TOPICS;
            let mut bytes = Vec::new();
            let information = [("sys_name", "sil serve")];
            head(start_us, topics, &information, Some(params), &mut |more: &[u8]| bytes.extend_from_slice(more));
            self.shelf.append(&bytes)?;
        }
        self.write_ring()
    }

    fn write_ring(&mut self) -> io::Result<()> {
        let mut block = [0; 512];
        loop {
            let count = self.recorder.take(&mut block);
            if count == 0 {
                return Ok(());
            }
            self.shelf.append(&block[..count])?;
        }
    }
}
