//! The slow end of the link: tells the ground, and does what it wants done outside the loop.

use mavlink::dialects::common::MavSeverity;
use shared_control::link::{Answer, Chore, LinkSettings, Telemetry, VehicleStatus};

use super::fault::FaultRecord;
use super::link_port::LinkSender;
use super::queue::Consumer;

/// Telemetry with its port and its queues.
pub struct Ground {
    telemetry: Telemetry,
    sender: LinkSender,
    answers: Consumer<'static, Answer>,
    chores: Consumer<'static, Chore>,
}

impl Ground {
    /// Begins with what happened before.
    pub fn new(
        settings: &LinkSettings,
        sender: LinkSender,
        answers: Consumer<'static, Answer>,
        chores: Consumer<'static, Chore>,
    ) -> Self {
        Self { telemetry: Telemetry::new(settings), sender, answers, chores }
    }

    /// Tells a person something that should not have happened, or that explains the start.
    pub fn tell(&mut self, words: &str) {
        self.telemetry.text(MavSeverity::MAV_SEVERITY_WARNING, words);
    }

    /// To be called at least every 20 ms, the period of the fastest message.
    pub fn update(&mut self, time_us: u64, status: &VehicleStatus) {
        while let Some(answer) = self.answers.dequeue() {
            self.telemetry.answer(answer);
        }
        while let Some(chore) = self.chores.dequeue() {
            match chore {
                Chore::ClearFaultRecord => FaultRecord::clear(),
                // the configuration is compiled in: there is nothing to store yet
                Chore::StoreConfiguration => {}
            }
        }
        self.sender.send(|buffer| self.telemetry.poll(time_us, status, buffer));
    }
}
