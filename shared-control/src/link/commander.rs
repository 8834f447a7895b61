//! What the vehicle is to do now: the last of the ground's orders, turned into the input of a step.
//!
//! Set-points come from the sticks, or from the test sequence once it is started; until either comes the set-point is
//! level at zero throttle. The sequence is for a vehicle on its rig; when it is over the vehicle is disarmed, and any
//! set-point from the sticks ends it: from then on they fly. Their throttle counts once it was low after arming, so
//! that no vehicle takes off with a stick that stands in the middle. Sticks that fall silent for half a second leave
//! the throttle as it is and mean level. The link's age counts from the last `MANUAL_CONTROL` where the sticks fly,
//! else from the last `MANUAL_CONTROL` or `HEARTBEAT`.

use mavlink::dialects::common::MavCmd;

use super::orders_and_answers::{Answer, Chore, Order, ParameterRequest};
use super::settings::LinkSettings;
use crate::signals::{ArmingBlocks, ArmingRequest, Setpoint, StepInput};
use crate::supervisor::{Arming, DisarmedBecause, IDLE_THROTTLE_MAX, Refusal};
use crate::test_sequence;

/// Orders that may wait for their step; what comes beyond that is answered as busy.
const REQUESTS_MAX: usize = 4;
/// Silence of the sticks after which their angles count no more, µs: PX4's COM_RC_LOSS_T.
pub const STICKS_STALE_US: u64 = 500_000;

/// The part of a [`StepInput`] that comes over the link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Commands {
    /// What is requested.
    pub setpoint: Setpoint,
    /// Request to the supervisor.
    pub arming: ArmingRequest,
    /// Time since whoever commands was last heard, µs; the largest value if never.
    pub link_age_us: u64,
    /// What stands against arming.
    pub blocks: ArmingBlocks,
}

impl Commands {
    /// Puts them into the input of a step.
    pub fn fill(&self, input: &mut StepInput) {
        input.setpoint = self.setpoint;
        input.arming = self.arming;
        input.link_age_us = Some(self.link_age_us);
        input.blocks = self.blocks;
    }
}

/// Where the set-point comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// From nowhere: level at zero throttle.
    Nobody,
    /// From the sticks.
    Sticks { setpoint: Setpoint, heard_us: u64 },
    /// From the test sequence.
    TestSequence { start_us: u64 },
}

/// Keeps the ground's wishes between its messages and the loop's steps.
#[derive(Clone, Debug)]
pub struct Commander {
    hover_throttle: f32,
    has_test_sequence: bool,
    source: Source,
    /// Low throttle was seen since arming.
    throttle_counts: bool,
    heard_us: Option<u64>,
    blocks: ArmingBlocks,
    /// The board will start anew: nothing turns any more.
    restarting: bool,
    /// Requests that wait for a step, oldest first.
    waiting: heapless::Deque<ArmingRequest, REQUESTS_MAX>,
    /// The request that the last [`Commands`] carried.
    asked: ArmingRequest,
    arming: Arming,
}

impl Commander {
    /// A commander that has heard nothing. `blocks` as found at start.
    pub fn new(settings: &LinkSettings, blocks: ArmingBlocks) -> Self {
        Self {
            hover_throttle: settings.hover_throttle,
            has_test_sequence: settings.has_test_sequence,
            source: Source::Nobody,
            throttle_counts: false,
            heard_us: None,
            blocks,
            restarting: false,
            waiting: heapless::Deque::new(),
            asked: ArmingRequest::None,
            arming: Arming::default(),
        }
    }

    /// Takes an order. What can be answered at once is; arming, disarming and motor tests after their step, by
    /// [`Self::answer`]. The chore is the board's to do.
    pub fn order(&mut self, order: &Order, time_us: u64) -> (Option<Answer>, Option<Chore>) {
        let disarmed = matches!(self.arming, Arming::Disarmed(_));
        match *order {
            Order::Heartbeat => {
                self.heard_us = Some(time_us);
                (None, None)
            }
            Order::Fly(setpoint) => {
                self.heard_us = Some(time_us);
                let takes_over = matches!(self.source, Source::TestSequence { .. });
                self.throttle_counts |= takes_over || self.is_armed() && setpoint.throttle <= IDLE_THROTTLE_MAX;
                self.source = Source::Sticks { setpoint, heard_us: time_us };
                (None, None)
            }
            Order::Arm => (self.request(ArmingRequest::Arm), None),
            Order::Disarm => {
                // before all that waits
                self.waiting.clear();
                (self.request(ArmingRequest::Disarm), None)
            }
            Order::TestMotor(test) => (self.request(ArmingRequest::MotorTest(test)), None),
            Order::CalibrateEscs => (self.request(ArmingRequest::CalibrateEscs), None),
            Order::StartTestSequence => (Some(self.start_test_sequence(time_us)), None),
            Order::ConfirmConfiguration if disarmed => {
                self.blocks.configuration_unconfirmed = false;
                (Some(Answer::Accepted(MavCmd::MAV_CMD_PREFLIGHT_STORAGE)), Some(Chore::StoreConfiguration))
            }
            Order::FaultRecordRead if disarmed => {
                self.blocks.fault_record_unread = false;
                (Some(Answer::Accepted(MavCmd::MAV_CMD_USER_1)), Some(Chore::ClearFaultRecord))
            }
            Order::ConfirmConfiguration => {
                (Some(Answer::Refused(MavCmd::MAV_CMD_PREFLIGHT_STORAGE, Refusal::Armed)), None)
            }
            Order::FaultRecordRead => (Some(Answer::Refused(MavCmd::MAV_CMD_USER_1, Refusal::Armed)), None),
            Order::Restart => self.restart(disarmed),
            Order::Parameters(request) => self.parameters(request, disarmed),
            Order::NotUnderstood { command, known: true } => (Some(Answer::Senseless(command)), None),
            Order::NotUnderstood { command, known: false } => (Some(Answer::Unknown(command)), None),
            Order::HilTick(_) => (None, None),
        }
    }

    /// What the next step is to do. Carries at most one request.
    pub fn commands(&mut self, time_us: u64) -> Commands {
        self.asked = self.waiting.pop_front().unwrap_or_default();
        let mut arming = self.asked;
        let (setpoint, heard_us) = match self.source {
            Source::Nobody => (Setpoint::default(), self.heard_us),
            Source::Sticks { setpoint, heard_us } => (self.sticks(setpoint, heard_us, time_us), Some(heard_us)),
            Source::TestSequence { start_us } => {
                let setpoint = test_sequence::at(time_us.saturating_sub(start_us), self.hover_throttle);
                if setpoint.is_none() {
                    // no request, hence no answer
                    arming = ArmingRequest::Disarm;
                }
                (setpoint.unwrap_or_default(), self.heard_us)
            }
        };
        Commands {
            setpoint,
            arming,
            link_age_us: heard_us.map_or(u64::MAX, |heard_us| time_us.saturating_sub(heard_us)),
            blocks: self.blocks,
        }
    }

    /// What came of the step that [`Self::commands`] was for; the answer to the request that it carried.
    pub fn answer(&mut self, arming: &Arming) -> Option<Answer> {
        self.arming = *arming;
        if !matches!(arming, Arming::Armed) {
            self.end_test_sequence();
        }
        self.throttle_counts &= self.is_armed();
        let command = command_of(&self.asked);
        let answer = match (self.asked, arming) {
            (ArmingRequest::None, _) => None,
            (ArmingRequest::Disarm, _)
            | (ArmingRequest::Arm, Arming::Armed)
            | (ArmingRequest::MotorTest(_), Arming::MotorTest { .. })
            | (ArmingRequest::CalibrateEscs, Arming::EscCalibration { .. }) => Some(Answer::Accepted(command)),
            (_, Arming::Disarmed(DisarmedBecause::Refused(refusal))) => Some(Answer::Refused(command, *refusal)),
            (_, Arming::LinkLost { .. }) => Some(Answer::Refused(command, Refusal::LinkLost)),
            // taken away in the very step that it was requested again
            (ArmingRequest::Arm | ArmingRequest::MotorTest(_) | ArmingRequest::CalibrateEscs, _) => {
                Some(Answer::Refused(command, Refusal::Armed))
            }
        };
        self.asked = ArmingRequest::None;
        answer
    }

    fn restart(&mut self, disarmed: bool) -> (Option<Answer>, Option<Chore>) {
        const COMMAND: MavCmd = MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN;
        if !disarmed {
            return (Some(Answer::Refused(COMMAND, Refusal::Armed)), None);
        }
        if !self.waiting.is_empty() {
            return (Some(Answer::Busy(COMMAND)), None);
        }
        self.restarting = true;
        (Some(Answer::Accepted(COMMAND)), Some(Chore::Restart))
    }

    /// Telling is always allowed. Setting is not while defaults stand in for a bad record: one field would vouch for
    /// all.
    fn parameters(&self, request: ParameterRequest, disarmed: bool) -> (Option<Answer>, Option<Chore>) {
        match request {
            ParameterRequest::Set { field, .. } if !disarmed => {
                (Some(Answer::ParameterRefused(field, Refusal::Armed)), None)
            }
            ParameterRequest::Set { field, .. } if self.blocks.configuration_unconfirmed => {
                (Some(Answer::ParameterRefused(field, Refusal::ConfigurationUnconfirmed)), None)
            }
            _ => (None, Some(Chore::Parameters(request))),
        }
    }

    fn request(&mut self, request: ArmingRequest) -> Option<Answer> {
        if self.restarting && request != ArmingRequest::Disarm {
            return Some(Answer::Busy(command_of(&request)));
        }
        match self.waiting.push_back(request) {
            Ok(()) => None,
            Err(request) => Some(Answer::Busy(command_of(&request))),
        }
    }

    fn is_armed(&self) -> bool {
        matches!(self.arming, Arming::Armed | Arming::LinkLost { .. })
    }

    fn sticks(&self, setpoint: Setpoint, heard_us: u64, time_us: u64) -> Setpoint {
        let throttle = if self.is_armed() && !self.throttle_counts { 0.0 } else { setpoint.throttle };
        let silent = time_us.saturating_sub(heard_us) >= STICKS_STALE_US;
        if silent { Setpoint { throttle, ..Setpoint::default() } } else { Setpoint { throttle, ..setpoint } }
    }

    fn start_test_sequence(&mut self, time_us: u64) -> Answer {
        match self.arming {
            Arming::Armed if !self.has_test_sequence => {
                Answer::Refused(MavCmd::MAV_CMD_MISSION_START, Refusal::FliesFree)
            }
            Arming::Armed => {
                self.source = Source::TestSequence { start_us: time_us };
                Answer::Accepted(MavCmd::MAV_CMD_MISSION_START)
            }
            Arming::Disarmed(_) | Arming::MotorTest { .. } | Arming::EscCalibration { .. } => {
                Answer::Refused(MavCmd::MAV_CMD_MISSION_START, Refusal::NotArmed)
            }
            Arming::LinkLost { .. } => Answer::Refused(MavCmd::MAV_CMD_MISSION_START, Refusal::LinkLost),
        }
    }

    fn end_test_sequence(&mut self) {
        if let Source::TestSequence { .. } = self.source {
            self.source = Source::Nobody;
        }
    }
}

/// The command that a request came as. No request is nobody's command, and is never answered.
fn command_of(request: &ArmingRequest) -> MavCmd {
    match request {
        ArmingRequest::None | ArmingRequest::Arm | ArmingRequest::Disarm => MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
        ArmingRequest::MotorTest(_) => MavCmd::MAV_CMD_DO_MOTOR_TEST,
        ArmingRequest::CalibrateEscs => MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION,
    }
}
