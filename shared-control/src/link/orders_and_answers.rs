//! What passes between the link's parts: orders inwards, answers and texts outwards.

use mavlink::dialects::common::MavCmd;

use super::file_transfer::FileRequest;
use super::hil::HilTick;
use super::log_download::LogRequest;
use super::mode::Mode;
use super::signing::SigningSetup;
use crate::params::table::Field;
use crate::signals::{MotorTest, Setpoint};
use crate::supervisor::Refusal;

/// What the ground wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Nothing; but it is there.
    Heartbeat,
    /// Fly this.
    Fly(Setpoint),
    /// Arm.
    Arm,
    /// Disarm.
    Disarm,
    /// Stop the motors at once, wherever the vehicle is; as which command it came.
    Stop(MavCmd),
    /// Fly this, in the mode for it; not by sticks but by a companion computer.
    FlyOffboard(Setpoint),
    /// Fly in another mode.
    ChooseMode(Mode),
    /// Start the test sequence.
    StartTestSequence,
    /// Turn one motor.
    TestMotor(MotorTest),
    /// Teach the ESCs their range.
    CalibrateEscs,
    /// The vehicle stands level: store how its IMUs sit.
    CalibrateLevel,
    /// The configuration in use is right: store it.
    ConfirmConfiguration,
    /// The fault record has been read.
    FaultRecordRead,
    /// Start anew.
    Restart,
    /// Tell or change parameters.
    Parameters(ParameterRequest),
    /// Tell something else.
    Inquire(Inquiry),
    /// List, send or erase logs.
    Logs(LogRequest),
    /// Show a file.
    Files(FileRequest),
    /// Sign with this key, or with none.
    SetUpSigning(SigningSetup),
    /// A command whose parameters make no sense.
    Senseless(MavCmd),
    /// A command that this vehicle does not know.
    UnknownCommand(u16),
    /// Hardware in the loop: make a step, with the IMU's sample in it.
    HilTick(HilTick),
}

/// What the ground demands of the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterRequest {
    /// Tell all.
    List,
    /// Tell one.
    Read(Field),
    /// Change one.
    Set {
        /// Which.
        field: Field,
        /// To what; not a number where it came as another type than REAL32.
        value: f32,
    },
    /// Something of one that does not exist.
    Unknown,
}

/// What else the ground wants to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inquiry {
    /// A message, once.
    Message {
        /// Its id.
        message_id: u32,
        /// Which of a list, from 1, and 0 all; or of which other message.
        index: u32,
        /// The command that it came as.
        command: MavCmd,
    },
    /// A message every so often.
    Interval {
        /// Its id.
        message_id: u32,
        /// µs; 0 as at start, -1 never.
        interval_us: f32,
    },
    /// How often a message is sent.
    TellInterval {
        /// Its id.
        message_id: u32,
    },
    /// How many items a plan has; there is none of any kind.
    PlanLength {
        /// Of which kind: mission, fence, rally points.
        kind: u8,
        /// Who wants to know.
        asker: [u8; 2],
    },
    /// What the vehicle's clock says.
    Time {
        /// The other clock's, ns.
        their_ns: i64,
    },
}

/// The answer to a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// Done.
    Accepted(MavCmd),
    /// Not done, for a reason that has words.
    Refused(MavCmd, Refusal),
    /// Not done, because its parameters make no sense.
    Senseless(MavCmd),
    /// Not done, because this vehicle has no such command.
    Unknown(u16),
    /// Not done, because others wait before it, or because the board is about to start anew.
    Busy(MavCmd),
    /// A parameter was not set, for a reason that has words.
    ParameterRefused(Field, Refusal),
    /// The pilot's sticks did not arm it, for a reason that has words.
    RadioRefused(Refusal),
    /// Logs are not listed, sent or erased, for a reason that has words.
    LogsRefused(Refusal),
}

/// What the board has to do outside the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Chore {
    /// Store the configuration in use.
    StoreConfiguration,
    /// Clear the fault record.
    ClearFaultRecord,
    /// Store how the IMUs sit on a vehicle that stands level.
    CalibrateLevel,
    /// Start anew, once the answer has left.
    Restart,
    /// Tell or change parameters.
    Parameters(ParameterRequest),
    /// Tell something else.
    Tell(Inquiry),
    /// List, send or erase logs.
    Logs(LogRequest),
    /// Show a file.
    Files(FileRequest),
    /// Sign with this key, or with none.
    SetUpSigning(SigningSetup),
}

impl Chore {
    /// Does it change parameters? Whoever hands it on has the commander wait for what comes of it.
    pub fn changes_parameters(&self) -> bool {
        matches!(self, Chore::Parameters(ParameterRequest::Set { .. }) | Chore::CalibrateLevel)
    }
}

/// Text of a `STATUSTEXT`.
pub type Text = heapless::String<50>;
