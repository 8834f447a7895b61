//! What the vehicle is to do now: the last of the ground's orders, turned into the input of a step.
//!
//! Set-points come from the sticks, or from the test sequence once it is started; until either comes the set-point is
//! level at zero throttle. The sequence is for a vehicle on its rig; when it is over the vehicle is disarmed, and any
//! set-point from the sticks ends it: from then on they fly. Their throttle counts once it was low after arming, so
//! that no vehicle takes off with a stick that stands in the middle. Sticks that fall silent for half a second leave
//! the throttle as it is and mean level. The link's age counts from the last `MANUAL_CONTROL` where the sticks fly,
//! else from the last `MANUAL_CONTROL` or `HEARTBEAT`; on the ground sticks fly no longer once they were silent as long
//! as loses a link.
//!
//! In offboard a companion computer's set-points fly instead of sticks, with the same rules when they fall silent. The
//! mode is entered on command while they come, and left on command or when the vehicle is disarmed.
//!
//! Where the radio flies ([`Commander::with_radio`]), it alone has sticks: `MANUAL_CONTROL` moves nothing, and the age
//! is the radio's. A radio that is lost, by its receiver's own word or by the IO chip's silence, is a lost link at
//! once. The ground's commands are obeyed as before, but for the choice of a mode. Its mode switch chooses between
//! stabilise and acro; the ground's sticks and the test sequence fly angles.

mod choices;
mod who_flies;

use mavlink::dialects::common::MavCmd;

use super::orders_and_answers::{Answer, Chore, Order};
use super::settings::LinkSettings;
use crate::io_chip::{IoReport, Safety};
use crate::radio::{Pilot, StickOrder, Sticks};
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
    /// Time since whoever commands was last heard, µs; the largest value if never, or if the radio is lost.
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
    /// From a companion computer.
    Offboard,
    /// From the test sequence.
    TestSequence { start_us: u64, sticks: Option<Sticks> },
}

/// Who made a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asker {
    /// Somebody on the link, who wants an answer.
    Ground,
    /// The pilot's sticks.
    Radio,
}

/// A request, and whose it is.
type Asked = (ArmingRequest, Asker);
const NOTHING: Asked = (ArmingRequest::None, Asker::Ground);

/// Keeps the ground's wishes between its messages and the loop's steps.
#[derive(Clone, Debug)]
pub struct Commander {
    settings: LinkSettings,
    /// The pilot at the transmitter, where the radio flies.
    pilot: Option<Pilot>,
    /// Is the safety button wanted, and what does it say?
    safety_button: bool,
    safety: Safety,
    source: Source,
    /// What a companion computer requested last, and when.
    offboard: Option<(Setpoint, u64)>,
    /// Low throttle was seen since arming.
    throttle_counts: bool,
    heard_us: Option<u64>,
    blocks: ArmingBlocks,
    /// Changes of parameters that were handed on, and those of them that need not be waited for, modulo 256.
    changes: u8,
    settled: u8,
    /// Since when a request to arm waits for them.
    arming_held_us: Option<u64>,
    /// The board will start anew: nothing turns any more.
    restarting: bool,
    /// Requests that wait for a step, oldest first.
    waiting: heapless::Deque<Asked, REQUESTS_MAX>,
    /// The request that the last [`Commands`] carried.
    asked: Asked,
    arming: Arming,
    /// How often the link was lost, modulo 256: it shows what came and went to whoever looks at some steps only.
    pub link_losses: u8,
}

impl Commander {
    /// A commander that has heard nothing. `blocks` as found at start.
    pub fn new(settings: &LinkSettings, blocks: ArmingBlocks) -> Self {
        Self {
            settings: *settings,
            pilot: None,
            safety_button: false,
            safety: Safety::Unknown,
            source: Source::Nobody,
            offboard: None,
            throttle_counts: false,
            heard_us: None,
            blocks,
            changes: 0,
            settled: 0,
            arming_held_us: None,
            restarting: false,
            waiting: heapless::Deque::new(),
            asked: NOTHING,
            arming: Arming::default(),
            link_losses: 0,
        }
    }

    /// The same where a pilot's radio flies, if there is one, and the safety button is looked at, if it is wanted.
    pub fn with_radio(self, pilot: Option<Pilot>, safety_button: bool) -> Self {
        Self { pilot, safety_button, ..self }
    }

    /// Does the radio fly?
    pub fn radio_flies(&self) -> bool {
        self.pilot.is_some()
    }

    /// Takes what the IO chip has told.
    pub fn take_io(&mut self, report: &IoReport, time_us: u64) {
        self.safety = report.safety;
        if let Some(pilot) = &mut self.pilot {
            pilot.take(&report.radio, time_us);
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
                if self.pilot.is_some() || self.source == Source::Offboard {
                    return (None, None);
                }
                let takes_over = matches!(self.source, Source::TestSequence { .. });
                self.throttle_counts |= takes_over || self.is_armed() && setpoint.throttle <= IDLE_THROTTLE_MAX;
                self.source = Source::Sticks { setpoint, heard_us: time_us };
                (None, None)
            }
            Order::FlyOffboard(setpoint) => {
                self.offboard = Some((setpoint, time_us));
                (None, None)
            }
            Order::ChooseMode(mode) => (Some(self.choose(mode, time_us)), None),
            Order::Stop(command) => {
                self.waiting.clear();
                // there is room now, and it is always obeyed
                let _ = self.waiting.push_back((ArmingRequest::Kill, Asker::Ground));
                (Some(Answer::Accepted(command)), None)
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
            Order::CalibrateLevel => self.calibrate_level(disarmed),
            Order::Restart => self.restart(disarmed),
            Order::Parameters(request) => self.parameters(request),
            Order::Inquire(inquiry) => (None, Some(Chore::Tell(inquiry))),
            Order::Logs(request) if disarmed => (None, Some(Chore::Logs(request))),
            Order::Logs(_) => (Some(Answer::LogsRefused(Refusal::Armed)), None),
            Order::Files(request) => (None, Some(Chore::Files(request))),
            Order::SetUpSigning(setup) => (None, Some(Chore::SetUpSigning(setup))),
            Order::Senseless(command) => (Some(Answer::Senseless(command)), None),
            Order::UnknownCommand(command) => (Some(Answer::Unknown(command)), None),
            Order::HilTick(_) => (None, None),
        }
    }

    /// What the next step is to do. Carries at most one request.
    pub fn commands(&mut self, time_us: u64) -> Commands {
        self.take_radio(time_us);
        self.forget_sticks(time_us);
        let killed = self.pilot.as_ref().is_some_and(|pilot| pilot.kills(time_us));
        let stops = killed && !matches!(self.arming, Arming::Disarmed(_));
        // what waits is refused in the next step
        self.asked = if stops { NOTHING } else { self.next_request(time_us) };
        let mut arming = if stops { ArmingRequest::Kill } else { self.asked.0 };
        let (setpoint, heard_us) = match self.source {
            Source::Nobody => (Setpoint::default(), self.heard_us),
            Source::Sticks { setpoint, heard_us } => (self.sticks(setpoint, heard_us, time_us), Some(heard_us)),
            Source::Offboard => {
                let (setpoint, heard_us) = self.offboard.unwrap_or_default();
                (level_if_stale(setpoint, heard_us, time_us), Some(heard_us))
            }
            Source::TestSequence { start_us, .. } => {
                let setpoint = test_sequence::at(time_us.saturating_sub(start_us), self.settings.hover_throttle);
                if setpoint.is_none() && !stops {
                    // no request, hence no answer
                    arming = ArmingRequest::Disarm;
                }
                (setpoint.unwrap_or_default(), self.heard_us)
            }
        };
        let age_us = match &self.pilot {
            Some(pilot) => pilot.age_us(time_us),
            None => heard_us.map(|heard_us| time_us.saturating_sub(heard_us)),
        };
        let safety_on = self.safety_button && self.safety != Safety::Off;
        let parameters_waiting = self.parameters_waiting();
        let blocks = ArmingBlocks { safety_on, kill_switch: killed, parameters_waiting, ..self.blocks };
        Commands { setpoint, arming, link_age_us: age_us.unwrap_or(u64::MAX), blocks }
    }

    /// What came of the step that [`Self::commands`] was for; the answer to the request that it carried.
    pub fn answer(&mut self, arming: &Arming) -> Option<Answer> {
        let was_armed = self.is_armed();
        let [was_lost, is_lost] = [&self.arming, arming].map(|arming| matches!(arming, Arming::LinkLost { .. }));
        self.link_losses = self.link_losses.wrapping_add(u8::from(is_lost && !was_lost));
        self.arming = *arming;
        if !matches!(arming, Arming::Armed) {
            self.end_test_sequence();
        }
        if was_armed && !self.is_armed() && self.source == Source::Offboard {
            self.source = Source::Nobody;
        }
        self.throttle_counts &= self.is_armed();
        let (asked, asker) = core::mem::replace(&mut self.asked, NOTHING);
        if asker == Asker::Radio {
            return match (asked, arming) {
                (ArmingRequest::Arm, Arming::Disarmed(DisarmedBecause::Refused(refusal))) => {
                    Some(Answer::RadioRefused(*refusal))
                }
                _ => None,
            };
        }
        let command = command_of(&asked);
        match (asked, arming) {
            (ArmingRequest::None | ArmingRequest::Kill | ArmingRequest::DisarmLanded, _) => None,
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
        }
    }

    /// The pilot's sticks and what they ask for, where the radio flies.
    fn take_radio(&mut self, time_us: u64) {
        let disarmed = matches!(self.arming, Arming::Disarmed(_));
        let Some(pilot) = &mut self.pilot else { return };
        let request = match pilot.stick_order(time_us) {
            Some(StickOrder::Arm) if disarmed && !self.restarting => Some(ArmingRequest::Arm),
            Some(StickOrder::Disarm) if !disarmed => Some(ArmingRequest::DisarmLanded),
            _ => None,
        };
        let sticks = pilot.sticks(time_us);
        if let Some(request) = request {
            // held sticks that find no room are held again
            let _ = self.waiting.push_back((request, Asker::Radio));
        }
        let Some(sticks) = sticks else { return };
        match &mut self.source {
            Source::TestSequence { sticks: before, .. } => {
                let before = *before.get_or_insert(sticks);
                if sticks.moved_since(&before) {
                    self.throttle_counts = true;
                    self.source = self.sticks_of(&sticks, time_us);
                }
            }
            Source::Nobody | Source::Sticks { .. } | Source::Offboard => {
                self.throttle_counts |= self.is_armed() && sticks.throttle <= IDLE_THROTTLE_MAX;
                self.source = self.sticks_of(&sticks, time_us);
            }
        }
    }

    fn sticks_of(&self, sticks: &Sticks, time_us: u64) -> Source {
        let acro = self.pilot.as_ref().is_some_and(Pilot::flies_acro);
        let curves = &self.settings.curves;
        let setpoint = if acro { curves.acro(sticks) } else { curves.stabilise(sticks) };
        Source::Sticks { setpoint, heard_us: time_us }
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

    fn request(&mut self, request: ArmingRequest) -> Option<Answer> {
        if self.restarting && request != ArmingRequest::Disarm {
            return Some(Answer::Busy(command_of(&request)));
        }
        match self.waiting.push_back((request, Asker::Ground)) {
            Ok(()) => None,
            Err((request, _)) => Some(Answer::Busy(command_of(&request))),
        }
    }

    fn is_armed(&self) -> bool {
        self.arming.is_armed()
    }

    fn sticks(&self, setpoint: Setpoint, heard_us: u64, time_us: u64) -> Setpoint {
        let throttle = if self.is_armed() && !self.throttle_counts { 0.0 } else { setpoint.throttle };
        level_if_stale(Setpoint { throttle, ..setpoint }, heard_us, time_us)
    }
}

/// Whoever has been silent for too long means level, and the throttle as it was.
fn level_if_stale(setpoint: Setpoint, heard_us: u64, time_us: u64) -> Setpoint {
    let silent = time_us.saturating_sub(heard_us) >= STICKS_STALE_US;
    if silent { Setpoint { throttle: setpoint.throttle, ..Setpoint::default() } } else { setpoint }
}

/// The command that a request came as. No request is nobody's command, and is never answered.
fn command_of(request: &ArmingRequest) -> MavCmd {
    match request {
        ArmingRequest::None
        | ArmingRequest::Arm
        | ArmingRequest::Disarm
        | ArmingRequest::Kill
        | ArmingRequest::DisarmLanded => MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
        ArmingRequest::MotorTest(_) => MavCmd::MAV_CMD_DO_MOTOR_TEST,
        ArmingRequest::CalibrateEscs => MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION,
    }
}
