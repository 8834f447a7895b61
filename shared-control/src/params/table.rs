//! The fields of [`Params`] by name, each as a whole number: what a ground station lists, reads and sets.

pub use super::allowed::Allowed;
use super::battery::{self, BatteryPart};
pub use super::counts::Counts;
use super::level::{self, LevelPart};
use super::pilot::{self, PilotPart};
use super::radio::{self, RadioPart, Stick, StickPart};
use super::vehicle::{self, VehiclePart};
use super::{Params, Rig};
use crate::config::{Controller, IDLE_PERCENT_MAX};
use crate::mpc::HORIZON;
use crate::mpc::schedule::LINEARISATIONS_MAX;
use crate::output::PulseKind;

/// Longest name, bytes: what a MAVLink parameter has room for.
pub const NAME_MAX: usize = 16;

/// Of a choice between two.
const EITHER: Allowed = Allowed::Either(0, 1);

/// One of the owner's choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// [`Params::controller`].
    Controller,
    /// [`Params::control_horizon`].
    ControlHorizon,
    /// [`Params::motor_limits`].
    MotorLimits,
    /// [`Params::linearisations`].
    Linearisations,
    /// [`Params::mpc_quick`].
    MpcTuning,
    /// [`Params::loop_rate_hz`].
    LoopRate,
    /// [`Params::pulses`].
    Pulses,
    /// [`Params::pwm_rate_hz`].
    PwmRate,
    /// [`Params::rig`].
    Rig,
    /// [`Params::hover_throttle_permille`].
    HoverThrottle,
    /// [`Params::rotor_drag_permille_1_s`].
    RotorDrag,
    /// [`Params::gyro_notches`].
    GyroNotches,
    /// [`Params::motor_loss`].
    MotorLoss,
    /// [`Params::learning`].
    Learning,
    /// One of the battery's numbers.
    Battery(BatteryPart),
    /// [`Params::hil`].
    Hil,
    /// [`Params::ground_idle_percent`].
    GroundIdle,
    /// [`Params::flight_idle_percent`].
    FlightIdle,
    /// [`Params::telem1_kbaud`].
    Telem1Rate,
    /// [`Params::esc_calibration`].
    EscCalibration,
    /// [`Params::safety_button`].
    SafetyButton,
    /// One of the radio's numbers.
    Radio(RadioPart),
    /// A number of a stick.
    Stick(Stick, StickPart),
    /// How the sticks feel.
    Pilot(PilotPart),
    /// How the first or (true) the second IMU sits.
    Level(bool, LevelPart),
    /// One of the vehicle's own numbers.
    Vehicle(VehiclePart),
}

/// What a person is to know of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Name on the link; at most [`NAME_MAX`] bytes.
    pub name: &'static str,
    /// What it can be.
    pub allowed: Allowed,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it does.
    pub meaning: &'static str,
    /// From when on it counts.
    pub counts: Counts,
}

impl Field {
    /// All of them, in the order of their index on the link.
    pub const ALL: [Field; 80] = [
        Field::Controller,
        Field::ControlHorizon,
        Field::MotorLimits,
        Field::Linearisations,
        Field::MpcTuning,
        Field::LoopRate,
        Field::Pulses,
        Field::PwmRate,
        Field::Rig,
        Field::HoverThrottle,
        Field::RotorDrag,
        Field::GyroNotches,
        Field::MotorLoss,
        Field::Learning,
        Field::Battery(BatteryPart::ArmingMin),
        Field::Battery(BatteryPart::Low),
        Field::Battery(BatteryPart::Critical),
        Field::Battery(BatteryPart::Timer),
        Field::Hil,
        Field::GroundIdle,
        Field::FlightIdle,
        Field::Telem1Rate,
        Field::EscCalibration,
        Field::SafetyButton,
        Field::Radio(RadioPart::Flies),
        Field::Radio(RadioPart::KillChannel),
        Field::Radio(RadioPart::KillReversed),
        Field::Radio(RadioPart::FailBelow),
        Field::Radio(RadioPart::AcroChannel),
        Field::Radio(RadioPart::AcroReversed),
        Field::Stick(Stick::Roll, StickPart::Channel),
        Field::Stick(Stick::Roll, StickPart::Min),
        Field::Stick(Stick::Roll, StickPart::Trim),
        Field::Stick(Stick::Roll, StickPart::Max),
        Field::Stick(Stick::Roll, StickPart::Reversed),
        Field::Stick(Stick::Roll, StickPart::DeadZone),
        Field::Stick(Stick::Pitch, StickPart::Channel),
        Field::Stick(Stick::Pitch, StickPart::Min),
        Field::Stick(Stick::Pitch, StickPart::Trim),
        Field::Stick(Stick::Pitch, StickPart::Max),
        Field::Stick(Stick::Pitch, StickPart::Reversed),
        Field::Stick(Stick::Pitch, StickPart::DeadZone),
        Field::Stick(Stick::Throttle, StickPart::Channel),
        Field::Stick(Stick::Throttle, StickPart::Min),
        Field::Stick(Stick::Throttle, StickPart::Trim),
        Field::Stick(Stick::Throttle, StickPart::Max),
        Field::Stick(Stick::Throttle, StickPart::Reversed),
        Field::Stick(Stick::Throttle, StickPart::DeadZone),
        Field::Stick(Stick::Yaw, StickPart::Channel),
        Field::Stick(Stick::Yaw, StickPart::Min),
        Field::Stick(Stick::Yaw, StickPart::Trim),
        Field::Stick(Stick::Yaw, StickPart::Max),
        Field::Stick(Stick::Yaw, StickPart::Reversed),
        Field::Stick(Stick::Yaw, StickPart::DeadZone),
        Field::Pilot(PilotPart::Tilt),
        Field::Pilot(PilotPart::YawRate),
        Field::Pilot(PilotPart::Expo),
        Field::Pilot(PilotPart::AcroTiltRate),
        Field::Pilot(PilotPart::AcroYawRate),
        Field::Pilot(PilotPart::AcroExpo),
        Field::Pilot(PilotPart::ThrottleMid),
        Field::Pilot(PilotPart::ThrottleExpo),
        Field::Level(false, LevelPart::Roll),
        Field::Level(false, LevelPart::Pitch),
        Field::Level(false, LevelPart::Down),
        Field::Level(true, LevelPart::Roll),
        Field::Level(true, LevelPart::Pitch),
        Field::Level(true, LevelPart::Down),
        Field::Vehicle(VehiclePart::Flown),
        Field::Vehicle(VehiclePart::Mass),
        Field::Vehicle(VehiclePart::Arm),
        Field::Vehicle(VehiclePart::Roll),
        Field::Vehicle(VehiclePart::Pitch),
        Field::Vehicle(VehiclePart::Yaw),
        Field::Vehicle(VehiclePart::Ring),
        Field::Vehicle(VehiclePart::TorquePerLift),
        Field::Vehicle(VehiclePart::LiftMin),
        Field::Vehicle(VehiclePart::LiftMax),
        Field::Vehicle(VehiclePart::Lag),
        Field::Vehicle(VehiclePart::Delay),
    ];

    /// What it belongs to, for lists that put together what is set together.
    pub const fn group(self) -> &'static str {
        match self {
            Field::Controller | Field::ControlHorizon | Field::MotorLimits => "Controller",
            Field::Linearisations | Field::MpcTuning | Field::Learning => "Controller",
            Field::Battery(_) => "Battery",
            Field::Radio(_) | Field::Stick(..) => "Radio",
            Field::Pilot(_) => "Sticks",
            Field::Level(..) | Field::GyroNotches => "IMU",
            Field::Vehicle(_) | Field::Rig | Field::HoverThrottle | Field::RotorDrag => "Vehicle",
            Field::Pulses | Field::PwmRate | Field::GroundIdle | Field::FlightIdle => "Motors",
            Field::EscCalibration | Field::MotorLoss => "Motors",
            Field::LoopRate | Field::Hil | Field::Telem1Rate | Field::SafetyButton => "Board",
        }
    }

    /// Its name, range, unit and meaning, and when it counts.
    pub const fn row(self) -> Row {
        #[rustfmt::skip] // a field a line or two, as in a table
        let (name, allowed, unit, meaning) = match self {
            Field::Controller => ("CONTROLLER", EITHER, "", "who flies: 0 PID cascade, 1 MPC"),
            Field::ControlHorizon =>
                ("CONTROL_HORIZON", Allowed::Range(1, HORIZON as u16), "", "free inputs per axis of the MPC (M)"),
            Field::MotorLimits => ("MOTOR_LIMITS", EITHER, "",
                "1: the MPC keeps the motors' limits, all axes together, where CONTROL_HORIZON is at most 10; \
                 0: bounds of each axis' own"),
            Field::Linearisations => ("LINEARISATIONS", Allowed::Range(1, LINEARISATIONS_MAX as u16), "",
                "models of the pitch axis that the MPC switches between as roll grows"),
            Field::MpcTuning => ("MPC_TUNING", EITHER, "",
                "the MPC's: 0 for motors that nobody has measured, 1 quick, where their lag is known to a fifth"),
            Field::LoopRate =>
                ("LOOP_RATE_HZ", Allowed::Either(100, 400), "Hz", "steps of the control loop per second"),
            Field::Pulses => ("PULSES", EITHER, "", "pulse to the ESCs: 0 PWM, 1 OneShot125"),
            Field::PwmRate => ("PWM_RATE_HZ", Allowed::Range(50, 490), "Hz",
                "pulses per second with PWM; \
                 their delay is constant if this is a multiple or a divisor of LOOP_RATE_HZ"),
            Field::Rig => ("RIG", EITHER, "", "vehicle: 0 F450 on the gimbal (yaw locked), 1 F450 in free flight"),
            Field::HoverThrottle =>
                ("HOVER_PERMILLE", Allowed::Range(0, 1000), "1/1000", "throttle of the test sequence"),
            Field::RotorDrag => ("ROTOR_DRAG_PM_S", Allowed::Range(10, 2000), "1/1000 1/s",
                "drag of the rotors over airspeed and mass: what shows the tilt in free flight"),
            Field::GyroNotches =>
                ("GYRO_NOTCHES", EITHER, "", "1: notches follow the rotors, where LOOP_RATE_HZ is 400"),
            Field::MotorLoss => ("MOTOR_LOSS", EITHER, "",
                "1: in free flight a motor that fails is noticed, and flown without, the heading given up"),
            Field::Learning => ("LEARNING", EITHER, "",
                "1: in flight the MPC learns how roll and pitch answer and how slow the motors are"),
            Field::Battery(part) => battery::row(part),
            Field::Hil => ("HIL", EITHER, "",
                "1: hardware in the loop, the IMU is simulated on the link and the pulses stay disarmed"),
            Field::GroundIdle => ("MOT_SPIN_ARM_PCT", Allowed::Range(0, IDLE_PERCENT_MAX), "%",
                "command of all motors when armed on the ground"),
            Field::FlightIdle =>
                ("MOT_SPIN_MIN_PCT", Allowed::Range(0, IDLE_PERCENT_MAX), "%", "least command of a motor in flight"),
            Field::Telem1Rate => ("TELEM1_KBAUD", Allowed::Either(57, 115), "",
                "TELEM1's rate: 57 is 57600 bits per second, 115 is 115200"),
            Field::EscCalibration =>
                ("ESC_CALIBRATION", EITHER, "", "1: propellers are off, ESCs are calibrated, no arming"),
            Field::SafetyButton =>
                ("SAFETY_BUTTON", EITHER, "", "1: no arming before the safety button was held for a second"),
            Field::Radio(part) => radio::row(part),
            Field::Stick(stick, part) => radio::stick_row(stick, part),
            Field::Pilot(part) => pilot::row(part),
            Field::Level(second, part) => level::row(second, part),
            Field::Vehicle(part) => vehicle::row(part),
        };
        Row { name, allowed, unit, meaning, counts: self.counts() }
    }

    /// The field of a name.
    pub fn by_name(name: &[u8]) -> Option<Field> {
        Field::ALL.into_iter().find(|field| field.row().name.as_bytes() == name)
    }

    /// The field of an index.
    pub fn by_index(index: usize) -> Option<Field> {
        Field::ALL.get(index).copied()
    }

    /// Its index on the link.
    pub fn index(self) -> u8 {
        Field::ALL.into_iter().position(|field| field == self).unwrap_or_default() as u8
    }
}

impl Params {
    /// A field's bits; [`Allowed::number`] says which number they are.
    pub fn get(&self, field: Field) -> u16 {
        match field {
            Field::Controller => u16::from(self.controller == Controller::Mpc),
            Field::ControlHorizon => u16::from(self.control_horizon),
            Field::MotorLimits => u16::from(self.motor_limits),
            Field::Linearisations => u16::from(self.linearisations),
            Field::MpcTuning => u16::from(self.mpc_quick),
            Field::LoopRate => self.loop_rate_hz,
            Field::Pulses => u16::from(self.pulses == PulseKind::OneShot125),
            Field::PwmRate => self.pwm_rate_hz,
            Field::Rig => u16::from(self.rig == Rig::Free),
            Field::HoverThrottle => self.hover_throttle_permille,
            Field::RotorDrag => self.rotor_drag_permille_1_s,
            Field::GyroNotches => u16::from(self.gyro_notches),
            Field::MotorLoss => u16::from(self.motor_loss),
            Field::Learning => u16::from(self.learning),
            Field::Battery(part) => self.battery.get(part),
            Field::Hil => u16::from(self.hil),
            Field::GroundIdle => u16::from(self.ground_idle_percent),
            Field::FlightIdle => u16::from(self.flight_idle_percent),
            Field::Telem1Rate => u16::from(self.telem1_kbaud),
            Field::EscCalibration => u16::from(self.esc_calibration),
            Field::SafetyButton => u16::from(self.safety_button),
            Field::Radio(part) => self.radio.get(part),
            Field::Stick(stick, part) => self.radio.stick(stick, part),
            Field::Pilot(part) => self.pilot.get(part),
            Field::Vehicle(part) => self.vehicle.get(part),
            Field::Level(second, part) => {
                let [one, two] = &self.level;
                if second { two.get(part) } else { one.get(part) }
            }
        }
    }

    /// The same with one field changed; none where it can't take the value.
    pub fn with(&self, field: Field, value: u16) -> Option<Params> {
        if !field.row().allowed.contains(value) {
            return None;
        }
        let mut params = *self;
        match field {
            Field::Controller => params.controller = if value == 0 { Controller::Cascade } else { Controller::Mpc },
            Field::ControlHorizon => params.control_horizon = value as u8,
            Field::MotorLimits => params.motor_limits = value == 1,
            Field::Linearisations => params.linearisations = value as u8,
            Field::MpcTuning => params.mpc_quick = value == 1,
            Field::LoopRate => params.loop_rate_hz = value,
            Field::Pulses => params.pulses = if value == 0 { PulseKind::Pwm } else { PulseKind::OneShot125 },
            Field::PwmRate => params.pwm_rate_hz = value,
            Field::Rig => params.rig = if value == 0 { Rig::Gimbal } else { Rig::Free },
            Field::HoverThrottle => params.hover_throttle_permille = value,
            Field::RotorDrag => params.rotor_drag_permille_1_s = value,
            Field::GyroNotches => params.gyro_notches = value == 1,
            Field::MotorLoss => params.motor_loss = value == 1,
            Field::Learning => params.learning = value == 1,
            Field::Battery(part) => params.battery.set(part, value),
            Field::Hil => params.hil = value == 1,
            Field::GroundIdle => params.ground_idle_percent = value as u8,
            Field::FlightIdle => params.flight_idle_percent = value as u8,
            Field::Telem1Rate => params.telem1_kbaud = value as u8,
            Field::EscCalibration => params.esc_calibration = value == 1,
            Field::SafetyButton => params.safety_button = value == 1,
            Field::Radio(part) => params.radio.set(part, value),
            Field::Stick(stick, part) => params.radio.set_stick(stick, part, value),
            Field::Pilot(part) => params.pilot.set(part, value),
            Field::Vehicle(part) => params.vehicle.set(part, value),
            Field::Level(second, part) => {
                let [one, two] = &mut params.level;
                if second { two.set(part, value) } else { one.set(part, value) }
            }
        }
        Some(params)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::tests::any_params;
    use proptest::prelude::*;

    proptest! {
        /// Setting a field gives that field the value and leaves the others; what is not allowed is refused.
        #[test]
        fn a_field_is_set_alone(params in any_params(), at in 0..Field::ALL.len(), any_value: u16, small in 0u16..500) {
            let field = Field::ALL[at];
            for value in [any_value, small] {
                let allowed = field.row().allowed.contains(value);
                let Some(changed) = params.with(field, value) else {
                    prop_assert!(!allowed);
                    continue;
                };
                prop_assert!(allowed);
                prop_assert_eq!(changed.get(field), value);
                for other in Field::ALL.into_iter().filter(|other| *other != field) {
                    prop_assert_eq!(changed.get(other), params.get(other));
                }
            }
        }

        /// Every field together is the whole: what can be read out can be put in again.
        #[test]
        fn the_fields_are_all_there_is(params in any_params()) {
            let copied = Field::ALL.into_iter().try_fold(Params::DEFAULT, |copy, f| copy.with(f, params.get(f)));
            prop_assert_eq!(copied, Some(params));
        }
    }

    #[test]
    fn names_fit_the_link_and_find_their_field() {
        for (index, field) in Field::ALL.into_iter().enumerate() {
            let Row { name, allowed, .. } = field.row();
            assert!(name.len() <= NAME_MAX && name.is_ascii(), "{name}");
            assert_eq!((Field::by_name(name.as_bytes()), Field::by_index(index)), (Some(field), Some(field)));
            assert_eq!(usize::from(field.index()), index);
            assert!(allowed.contains(Params::DEFAULT.get(field)), "{name}");
        }
        assert_eq!((Field::by_name(b"PWM_RATE"), Field::by_name(b""), Field::by_index(80)), (None, None, None));
    }
}
