//! The arming states, with the reasons why motors stand still.

use crate::record::state_words::StateWords;
use crate::sensing::imu_health::ImuFault;

/// May the motors turn?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arming {
    /// No; and why not, if it was requested or taken away.
    Disarmed(DisarmedBecause),
    /// One of them, at a fixed command.
    MotorTest {
        /// Motor, 1 to 4.
        motor: u8,
        /// Its command in percent.
        throttle_percent: u8,
        /// When it ends, on the clock of [`StepInput::time_us`](crate::signals::StepInput::time_us).
        until_us: u64,
    },
    /// Yes.
    Armed,
    /// Yes, level and on the way down ([`super::throttle`]), because nobody has been heard for
    /// [`LINK_LOST_AFTER_US`](super::LINK_LOST_AFTER_US); armed again when somebody is.
    LinkLost {
        /// When the link was given up.
        since_us: u64,
    },
    /// Yes, steered by the pilot and on the way down, because the battery is nearly empty
    /// ([`super::battery_watch`]).
    BatteryLow {
        /// When that was found.
        since_us: u64,
    },
    /// All at full or lowest pulse, propellers off, to teach the ESCs their range.
    EscCalibration {
        /// How far it is.
        stage: EscStage,
        /// When that stage began.
        since_us: u64,
    },
}

/// Stages of teaching the ESCs their range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EscStage {
    /// Full throttle, and the ESCs still have no power.
    Battery,
    /// Full throttle, and they have.
    High,
    /// Lowest throttle.
    Low,
}

impl Default for Arming {
    fn default() -> Self {
        Arming::Disarmed(DisarmedBecause::Start)
    }
}

impl Arming {
    /// Its number in a trace and in the words of a state.
    pub fn number(&self) -> u32 {
        match self {
            Arming::Armed => 0,
            Arming::Disarmed(_) => 1,
            Arming::MotorTest { .. } => 2,
            Arming::LinkLost { .. } => 3,
            Arming::EscCalibration { .. } => 4,
            Arming::BatteryLow { .. } => 5,
        }
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let (detail, time_us) = match *self {
            Arming::Armed => (0, 0),
            Arming::Disarmed(because) => (because.number(), 0),
            Arming::MotorTest { motor, throttle_percent, until_us } => {
                (u32::from(motor) << 8 | u32::from(throttle_percent), until_us)
            }
            Arming::LinkLost { since_us } | Arming::BatteryLow { since_us } => (0, since_us),
            Arming::EscCalibration { stage, since_us } => (stage as u32, since_us),
        };
        words.word(self.number());
        words.word(detail);
        words.time_us(time_us);
    }

    /// Does any motor turn?
    pub fn motors_turn(&self) -> bool {
        match self {
            Arming::Disarmed(_) => false,
            Arming::MotorTest { .. } | Arming::EscCalibration { .. } => true,
            Arming::Armed | Arming::LinkLost { .. } | Arming::BatteryLow { .. } => true,
        }
    }

    /// Is it flown, or ready to be, by whomever?
    pub fn is_armed(&self) -> bool {
        match self {
            Arming::Armed | Arming::LinkLost { .. } | Arming::BatteryLow { .. } => true,
            Arming::Disarmed(_) | Arming::MotorTest { .. } | Arming::EscCalibration { .. } => false,
        }
    }

    /// Since when has it been on its way down by itself, µs? None if it is not.
    pub fn descends_since_us(&self) -> Option<u64> {
        match *self {
            Arming::LinkLost { since_us } | Arming::BatteryLow { since_us } => Some(since_us),
            Arming::Armed | Arming::Disarmed(_) | Arming::MotorTest { .. } | Arming::EscCalibration { .. } => None,
        }
    }
}

/// Why the motors stand still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisarmedBecause {
    /// Nobody armed since start.
    Start,
    /// Asked for.
    Requested,
    /// Arming or a motor test was refused.
    Refused(Refusal),
    /// The attitude is not known any more.
    AttitudeUnknown,
    /// The IMU failed.
    ImuFailed(ImuFault),
    /// Nobody was heard for too long.
    LinkLost,
    /// The motor test is over.
    MotorTestOver,
    /// It lies somewhere and does not answer to its motors.
    Crashed,
    /// The ESCs were shown both ends of their range.
    EscsCalibrated,
    /// Showing them was broken off.
    EscCalibrationEnded,
    /// The kill switch is on.
    Killed,
    /// The battery is nearly empty.
    BatteryLow,
    /// Landed without one of its motors.
    MotorLost,
}

impl DisarmedBecause {
    /// Its number in the words of a state.
    pub fn number(&self) -> u32 {
        match self {
            DisarmedBecause::Start => 0,
            DisarmedBecause::Requested => 1,
            DisarmedBecause::AttitudeUnknown => 2,
            DisarmedBecause::LinkLost => 3,
            DisarmedBecause::MotorTestOver => 4,
            DisarmedBecause::Crashed => 5,
            DisarmedBecause::EscsCalibrated => 6,
            DisarmedBecause::EscCalibrationEnded => 7,
            DisarmedBecause::Killed => 8,
            DisarmedBecause::BatteryLow => 9,
            DisarmedBecause::MotorLost => 10,
            DisarmedBecause::ImuFailed(fault) => 0x10 + fault.number(),
            DisarmedBecause::Refused(refusal) => 0x100 + refusal.number(),
        }
    }
}

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The set-point is not made of finite numbers.
    SetpointNotFinite,
    /// Throttle is not at zero.
    ThrottleNotZero,
    /// The IMU is not to be believed.
    ImuUnhealthy(ImuFault),
    /// The attitude is not known.
    AttitudeUnknown,
    /// The gyro was not calibrated at rest.
    GyroNotCalibrated,
    /// The battery's voltage is too low.
    BatteryLow,
    /// There is no battery: the board is fed over USB alone.
    BatteryAbsent,
    /// Nobody has been heard on the link.
    LinkLost,
    /// The configuration was bad and its replacement is not confirmed.
    ConfigurationUnconfirmed,
    /// The record of a fault waits to be read.
    FaultRecordUnread,
    /// Not while armed.
    Armed,
    /// Only while armed.
    NotArmed,
    /// Not while a motor is tested.
    MotorTestRunning,
    /// There is no such motor.
    NoSuchMotor,
    /// The test sequence is for a vehicle on its rig.
    FliesFree,
    /// The board is set to calibrate ESCs, and does nothing else.
    EscCalibrationSet,
    /// The board is not set to calibrate ESCs.
    EscCalibrationNotSet,
    /// Not while ESCs are being calibrated.
    EscCalibrationRunning,
    /// The ESCs have power already: full throttle would be one.
    BatteryConnected,
    /// Whether the ESCs have power is not known: no battery was seen since start.
    BatteryNeverSeen,
    /// Whether the ESCs have power is not known: nobody measures.
    BatteryUnmeasured,
    /// The kill switch is on.
    KillSwitch,
    /// The safety button was not held, or nobody knows whether it was.
    SafetyOn,
    /// The radio is to fly, and its calibration makes no sense.
    RadioUnusable,
    /// It did not stand still for long enough.
    VehicleMoves,
    /// It does not stand level, by more than a calibration makes good.
    NotLevel,
    /// The owner's vehicle is to fly, and its numbers make no sense; or a free one that nobody has named.
    VehicleUnusable,
    /// The radio has the sticks: nobody else sets points or chooses modes.
    RadioFlies,
    /// Nobody sends the set-points that the mode is about.
    NoSetpoints,
    /// The line has no room for more messages.
    LineFull,
    /// Parameters were set that are not in use yet.
    ParametersWaiting,
}

impl Refusal {
    /// All that say everything by themselves, in the order of their numbers.
    #[cfg(test)]
    pub(crate) const WITHOUT_DETAIL: [Refusal; 30] = [
        Refusal::SetpointNotFinite,
        Refusal::ThrottleNotZero,
        Refusal::AttitudeUnknown,
        Refusal::GyroNotCalibrated,
        Refusal::BatteryLow,
        Refusal::LinkLost,
        Refusal::ConfigurationUnconfirmed,
        Refusal::FaultRecordUnread,
        Refusal::Armed,
        Refusal::NotArmed,
        Refusal::MotorTestRunning,
        Refusal::NoSuchMotor,
        Refusal::BatteryAbsent,
        Refusal::FliesFree,
        Refusal::EscCalibrationSet,
        Refusal::EscCalibrationNotSet,
        Refusal::EscCalibrationRunning,
        Refusal::BatteryConnected,
        Refusal::BatteryNeverSeen,
        Refusal::BatteryUnmeasured,
        Refusal::KillSwitch,
        Refusal::SafetyOn,
        Refusal::RadioUnusable,
        Refusal::VehicleMoves,
        Refusal::NotLevel,
        Refusal::VehicleUnusable,
        Refusal::RadioFlies,
        Refusal::NoSetpoints,
        Refusal::LineFull,
        Refusal::ParametersWaiting,
    ];

    /// Its number in the words of a state.
    pub fn number(&self) -> u32 {
        match self {
            Refusal::SetpointNotFinite => 0,
            Refusal::ThrottleNotZero => 1,
            Refusal::AttitudeUnknown => 2,
            Refusal::GyroNotCalibrated => 3,
            Refusal::BatteryLow => 4,
            Refusal::LinkLost => 5,
            Refusal::ConfigurationUnconfirmed => 6,
            Refusal::FaultRecordUnread => 7,
            Refusal::Armed => 8,
            Refusal::NotArmed => 9,
            Refusal::MotorTestRunning => 10,
            Refusal::NoSuchMotor => 11,
            Refusal::BatteryAbsent => 12,
            Refusal::FliesFree => 13,
            Refusal::EscCalibrationSet => 14,
            Refusal::EscCalibrationNotSet => 15,
            Refusal::EscCalibrationRunning => 16,
            Refusal::BatteryConnected => 17,
            Refusal::BatteryNeverSeen => 18,
            Refusal::BatteryUnmeasured => 19,
            Refusal::KillSwitch => 20,
            Refusal::SafetyOn => 21,
            Refusal::RadioUnusable => 22,
            Refusal::VehicleMoves => 23,
            Refusal::NotLevel => 24,
            Refusal::VehicleUnusable => 25,
            Refusal::RadioFlies => 26,
            Refusal::NoSetpoints => 27,
            Refusal::LineFull => 28,
            Refusal::ParametersWaiting => 29,
            Refusal::ImuUnhealthy(fault) => 0x20 + fault.number(),
        }
    }

    /// In words, for a person; at most 50 bytes, which is what a STATUSTEXT holds.
    pub fn words(&self) -> &'static str {
        match self {
            Refusal::SetpointNotFinite => "refused: set-point is not a number",
            Refusal::ThrottleNotZero => "refused: throttle is not at zero",
            Refusal::ImuUnhealthy(ImuFault::Stale) => "refused: IMU sends nothing",
            Refusal::ImuUnhealthy(ImuFault::BusDead) => "refused: IMU bus is dead",
            Refusal::ImuUnhealthy(ImuFault::Stuck) => "refused: IMU is stuck",
            Refusal::ImuUnhealthy(ImuFault::OutOfRange) => "refused: IMU is at full scale",
            Refusal::AttitudeUnknown => "refused: attitude is not known",
            Refusal::GyroNotCalibrated => "refused: keep still until the gyro is calibrated",
            Refusal::BatteryLow => "refused: battery voltage is too low",
            Refusal::BatteryAbsent => "refused: no battery, USB power alone",
            Refusal::LinkLost => "refused: no set-point or heartbeat for 3 s",
            Refusal::ConfigurationUnconfirmed => "refused: configuration was bad, confirm defaults",
            Refusal::FaultRecordUnread => "refused: fault record is unread",
            Refusal::Armed => "refused: only when disarmed",
            Refusal::NotArmed => "refused: only when armed",
            Refusal::MotorTestRunning => "refused: motor test was running, stopped it",
            Refusal::NoSuchMotor => "refused: motors are 1 to 4",
            Refusal::FliesFree => "refused: test sequence is for the rig",
            Refusal::EscCalibrationSet => "refused: set ESC_CALIBRATION to 0 and restart",
            Refusal::EscCalibrationNotSet => "refused: props off, set ESC_CALIBRATION, restart",
            Refusal::EscCalibrationRunning => "refused: ESC calibration was running, stopped it",
            Refusal::BatteryConnected => "refused: disconnect the battery first",
            Refusal::BatteryNeverSeen => "refused: connect battery once, then disconnect",
            Refusal::BatteryUnmeasured => "refused: battery voltage is not measured",
            Refusal::KillSwitch => "refused: kill switch is on",
            Refusal::SafetyOn => "refused: hold the safety button for a second",
            Refusal::RadioUnusable => "refused: radio calibration makes no sense",
            Refusal::VehicleMoves => "refused: keep still for 3 s",
            Refusal::VehicleUnusable => "refused: vehicle's numbers missing or senseless",
            Refusal::RadioFlies => "refused: the radio has the sticks",
            Refusal::NoSetpoints => "refused: send set-points first",
            Refusal::LineFull => "refused: the line has no room, slow others down",
            Refusal::ParametersWaiting => "refused: new parameters are not in use yet",
            Refusal::NotLevel => "refused: over 10 degrees off level, or not 1 g",
        }
    }
}
