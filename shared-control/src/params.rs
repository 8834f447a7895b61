//! What the owner of a vehicle chooses, kept in one record that survives power loss: controller, rates, pulses, rig.
//! [`table`] has each choice with its name and its range; [`crate::setup`] makes a configuration of them.
//!
//! ```text
//!   0  magic "QCFG"     4  version (u16)     6  length (u16)     8  payload     28  CRC-32 of all before
//! ```
//! All little-endian. A record that is not whole and sensible gives the defaults and forbids arming until somebody
//! confirms them ([`crate::signals::ArmingBlocks`]).

pub mod table;

use crate::config::Controller;
use crate::output::PulseKind;
use table::Field;

/// Length of a record, bytes.
pub const RECORD_LEN: usize = 32;

const MAGIC: [u8; 4] = *b"QCFG";
const VERSION: u16 = 4;
const PAYLOAD_LEN: usize = RECORD_LEN - 12;

/// What the vehicle hangs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rig {
    /// The gimbal of the thesis: yaw locked.
    Gimbal,
    /// Nothing, or a tether.
    Free,
}

/// The owner's choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Params {
    /// Who flies.
    pub controller: Controller,
    /// Steps per second: 100 or 400.
    pub loop_rate_hz: u16,
    /// Kind of pulse.
    pub pulses: PulseKind,
    /// Pulses per second with PWM, 50 to 490; `OneShot125` has one a step.
    pub pwm_rate_hz: u16,
    /// What the vehicle hangs on.
    pub rig: Rig,
    /// True: the IMU is simulated on the other end of the link and the pins stay disarmed.
    pub hil: bool,
    /// Battery voltage needed to arm, mV.
    pub battery_arming_min_mv: u16,
    /// Throttle at which the vehicle hovers, 1/1000.
    pub hover_throttle_permille: u16,
    /// Free inputs per axis of the MPC, 1 to 30.
    pub control_horizon: u8,
    /// The motors' limits in the MPC, which couple the axes: with at most
    /// [`COUPLED_INPUTS_MAX`](crate::mpc::motor_limits::COUPLED_INPUTS_MAX) free inputs.
    pub motor_limits: bool,
    /// Linearisations of the MPC's pitch axis, 1 to 4.
    pub linearisations: u8,
    /// Command of every motor that is armed on the ground, percent.
    pub ground_idle_percent: u8,
    /// Least command of a motor in flight, percent.
    pub flight_idle_percent: u8,
    /// TELEM1, thousands of bits per second: 57 or 115.
    pub telem1_kbaud: u8,
    /// True: the board teaches the ESCs their range, propellers off, and does nothing else.
    pub esc_calibration: bool,
}

impl Params {
    /// What holds where nothing is stored: cascade at 400 Hz, PWM at 400 Hz, on the gimbal. Idle commands are
    /// ArduPilot's (MOT_SPIN_ARM, MOT_SPIN_MIN), TELEM1's rate that of PX4 and of telemetry radios.
    pub const DEFAULT: Params = Params {
        controller: Controller::Cascade,
        loop_rate_hz: 400,
        pulses: PulseKind::Pwm,
        pwm_rate_hz: 400,
        rig: Rig::Gimbal,
        hil: false,
        battery_arming_min_mv: 10_500,
        hover_throttle_permille: 500,
        control_horizon: 5,
        motor_limits: false,
        linearisations: 1,
        ground_idle_percent: 10,
        flight_idle_percent: 15,
        telem1_kbaud: 57,
        esc_calibration: false,
    };
}

/// What is wrong with a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordError {
    /// Nothing was ever stored, or something else.
    NoRecord,
    /// Of another version of the firmware.
    Version(u16),
    /// The CRC does not fit.
    Damaged,
    /// A value can't be flown with.
    Value(&'static str),
}

impl core::fmt::Display for RecordError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            RecordError::NoRecord => f.write_str("configuration: none stored"),
            RecordError::Version(version) => write!(f, "configuration: version {version}, not {VERSION}"),
            RecordError::Damaged => f.write_str("configuration: damaged"),
            RecordError::Value(name) => write!(f, "configuration: bad {name}"),
        }
    }
}

impl core::error::Error for RecordError {}

/// The record of a set of choices.
pub fn encode(params: &Params) -> [u8; RECORD_LEN] {
    let [version0, version1] = VERSION.to_le_bytes();
    let [length0, length1] = (PAYLOAD_LEN as u16).to_le_bytes();
    let [loop0, loop1] = params.loop_rate_hz.to_le_bytes();
    let [pwm0, pwm1] = params.pwm_rate_hz.to_le_bytes();
    let [battery0, battery1] = params.battery_arming_min_mv.to_le_bytes();
    let [hover0, hover1] = params.hover_throttle_permille.to_le_bytes();
    // single bytes: the table keeps all of these below 256
    let [controller, pulses, rig, hil, motor_limits, escs] =
        [Field::Controller, Field::Pulses, Field::Rig, Field::Hil, Field::MotorLimits, Field::EscCalibration]
            .map(|f| params.get(f) as u8);
    let [m0, m1, m2, m3] = MAGIC;
    #[rustfmt::skip]
    let body = [
        m0, m1, m2, m3, version0, version1, length0, length1,
        controller, pulses, rig, hil, loop0, loop1, pwm0, pwm1,
        battery0, battery1, hover0, hover1, params.control_horizon, motor_limits, params.linearisations, escs,
        params.ground_idle_percent, params.flight_idle_percent, params.telem1_kbaud, 0,
    ];
    let mut record = [0; RECORD_LEN];
    for (to, from) in record.iter_mut().zip(body.into_iter().chain(crc32(&body).to_le_bytes())) {
        *to = from;
    }
    record
}

/// The choices in a record.
///
/// # Errors
/// What is wrong with it; the caller then takes [`Params::DEFAULT`] and requests confirmation.
pub fn decode(record: &[u8; RECORD_LEN]) -> Result<Params, RecordError> {
    #[rustfmt::skip]
    let [
        m0, m1, m2, m3, version0, version1, length0, length1,
        controller, pulses, rig, hil, loop0, loop1, pwm0, pwm1,
        battery0, battery1, hover0, hover1, control_horizon, motor_limits, linearisations, escs,
        ground_idle, flight_idle, telem1_kbaud, _, crc @ ..
    ] = *record;
    if [m0, m1, m2, m3] != MAGIC {
        return Err(RecordError::NoRecord);
    }
    let version = u16::from_le_bytes([version0, version1]);
    if version != VERSION {
        return Err(RecordError::Version(version));
    }
    let body = record.get(..RECORD_LEN - 4).unwrap_or_default();
    if crc32(body) != u32::from_le_bytes(crc) || usize::from(u16::from_le_bytes([length0, length1])) != PAYLOAD_LEN {
        return Err(RecordError::Damaged);
    }
    let values = [
        (Field::Controller, u16::from(controller)),
        (Field::LoopRate, u16::from_le_bytes([loop0, loop1])),
        (Field::Pulses, u16::from(pulses)),
        (Field::PwmRate, u16::from_le_bytes([pwm0, pwm1])),
        (Field::Rig, u16::from(rig)),
        (Field::Hil, u16::from(hil)),
        (Field::BatteryArmingMin, u16::from_le_bytes([battery0, battery1])),
        (Field::HoverThrottle, u16::from_le_bytes([hover0, hover1])),
        (Field::ControlHorizon, u16::from(control_horizon)),
        (Field::MotorLimits, u16::from(motor_limits)),
        (Field::Linearisations, u16::from(linearisations)),
        (Field::GroundIdle, u16::from(ground_idle)),
        (Field::FlightIdle, u16::from(flight_idle)),
        (Field::Telem1Rate, u16::from(telem1_kbaud)),
        (Field::EscCalibration, u16::from(escs)),
    ];
    let mut params = Params::DEFAULT;
    for (field, value) in values {
        params = params.with(field, value).ok_or(RecordError::Value(field.row().name))?;
    }
    Ok(params)
}

/// Choices, and whether they are to be confirmed before anything arms.
pub fn load(record: &[u8; RECORD_LEN]) -> (Params, Option<RecordError>) {
    match decode(record) {
        Ok(params) => (params, None),
        Err(error) => (Params::DEFAULT, Some(error)),
    }
}

/// CRC-32 of IEEE 802.3 (reflected 0x04C11DB7, start and end inverted), bit by bit: records are short and read once.
pub fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            let carry = crc & 1;
            crc >>= 1;
            if carry == 1 {
                crc ^= 0xEDB8_8320;
            }
        }
    }
    !crc
}

#[cfg(test)]
pub(crate) mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::string::ToString;

    pub(crate) fn any_params() -> impl Strategy<Value = Params> {
        let inputs = (1u8..=30, 1u8..=4);
        let idle = (0u8..=30, 0u8..=30);
        (any::<[bool; 8]>(), 50u16..=490, any::<u16>(), 0u16..=1000, inputs, idle).prop_map(
            |(switches, pwm_rate_hz, battery_arming_min_mv, hover, inputs, idle)| {
                let [mpc, one_shot, free, hil, slow, limits, escs, fast] = switches;
                Params {
                    controller: if mpc { Controller::Mpc } else { Controller::Cascade },
                    loop_rate_hz: if slow { 100 } else { 400 },
                    pulses: if one_shot { PulseKind::OneShot125 } else { PulseKind::Pwm },
                    pwm_rate_hz,
                    rig: if free { Rig::Free } else { Rig::Gimbal },
                    hil,
                    battery_arming_min_mv,
                    hover_throttle_permille: hover,
                    control_horizon: inputs.0,
                    motor_limits: limits,
                    linearisations: inputs.1,
                    ground_idle_percent: idle.0,
                    flight_idle_percent: idle.1,
                    telem1_kbaud: if fast { 115 } else { 57 },
                    esc_calibration: escs,
                }
            },
        )
    }

    proptest! {
        #[test]
        fn what_is_stored_comes_back(params in any_params()) {
            prop_assert_eq!(decode(&encode(&params)), Ok(params));
        }

        /// A CRC-32 finds every burst of up to 32 bits.
        #[test]
        fn any_damaged_byte_is_noticed(params in any_params(), at in 0usize..RECORD_LEN, flip in 1u8..) {
            let mut record = encode(&params);
            record[at] ^= flip;
            prop_assert!(decode(&record).is_err());
            prop_assert_eq!(load(&record).0, Params::DEFAULT);
        }
    }

    #[test]
    fn crc_is_the_usual_one() {
        // the check value of the catalogue of parametrised CRC algorithms, CRC-32/ISO-HDLC
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
        assert_eq!(crc32(b""), 0);
    }

    /// The head of a record: magic, version 4, and the length of what lies between head and CRC.
    #[test]
    fn a_record_begins_with_its_head() {
        let record = encode(&Params::DEFAULT);
        assert_eq!(record[..8], *b"QCFG\x04\0\x14\0");
        assert_eq!(record.len(), 8 + 20 + 4);
    }

    #[test]
    fn errors_name_what_is_wrong() {
        assert_eq!(load(&[0xFF; RECORD_LEN]), (Params::DEFAULT, Some(RecordError::NoRecord)));
        assert_eq!(load(&[0; RECORD_LEN]).1, Some(RecordError::NoRecord));
        let mut older = encode(&Params::DEFAULT);
        older[4] = 1;
        assert_eq!(decode(&older), Err(RecordError::Version(1)));
        let refused = |params: &Params| decode(&encode(params)).unwrap_err();
        assert_eq!(refused(&Params { loop_rate_hz: 250, ..Params::DEFAULT }), RecordError::Value("LOOP_RATE_HZ"));
        assert_eq!(refused(&Params { control_horizon: 0, ..Params::DEFAULT }), RecordError::Value("CONTROL_HORIZON"));
        let longest = RecordError::Value("CONTROL_HORIZON").to_string();
        assert!(longest.contains("CONTROL_HORIZON"), "{longest}");
        // they go out as STATUSTEXT
        assert!(longest.len() <= 50);
    }
}
