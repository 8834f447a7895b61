//! What the owner of a vehicle chooses, kept in one record that survives power loss: controller, rates, pulses, rig.
//! [`table`] has each choice with its name and its range; [`crate::setup`] makes a configuration of them.
//!
//! ```text
//!   0  magic "QCFG"     4  version (u16)     6  length (u16)     8  payload, then CRC-32 of all before
//! ```
//! All little-endian; the payload is a word of 16 bits for each field of the table, in its order. A record that is not
//! whole and sensible gives the defaults and forbids arming until somebody confirms them
//! ([`crate::signals::ArmingBlocks`]).

mod allowed;
pub mod battery;
pub mod counts;
pub mod level;
pub mod pilot;
pub mod radio;
pub mod table;
pub mod vehicle;

use crate::config::Controller;
use crate::output::PulseKind;
use battery::BatteryParams;
use level::LevelParams;
use pilot::PilotParams;
use radio::RadioParams;
use table::Field;
use vehicle::VehicleNumbers;

/// Length of a record, bytes.
pub const RECORD_LEN: usize = HEAD_LEN + PAYLOAD_LEN + CRC_LEN;

const MAGIC: [u8; 4] = *b"QCFG";
const VERSION: u16 = 10;
const HEAD_LEN: usize = 8;
const PAYLOAD_LEN: usize = 2 * Field::ALL.len();
const CRC_LEN: usize = 4;

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
    /// The battery.
    pub battery: BatteryParams,
    /// Throttle at which the vehicle hovers, 1/1000.
    pub hover_throttle_permille: u16,
    /// Drag of the rotors over the mass, 1/1000 1/s.
    pub rotor_drag_permille_1_s: u16,
    /// Notches in the gyro that follow the rotors.
    pub gyro_notches: bool,
    /// The loss of a motor in free flight is noticed and flown with ([`crate::motor_loss`]).
    pub motor_loss: bool,
    /// The MPC learns its vehicle in flight ([`crate::learning`]).
    pub learning: bool,
    /// Free inputs per axis of the MPC, 1 to 30.
    pub control_horizon: u8,
    /// The motors' limits in the MPC, which couple the axes: with at most
    /// [`COUPLED_INPUTS_MAX`](crate::mpc::motor_limits::COUPLED_INPUTS_MAX) free inputs.
    pub motor_limits: bool,
    /// Linearisations of the MPC's pitch axis, 1 to 4.
    pub linearisations: u8,
    /// The MPC is tuned as the fronts have it ([`Tuning::quick`](crate::config::Tuning::quick)).
    pub mpc_quick: bool,
    /// Command of every motor that is armed on the ground, percent.
    pub ground_idle_percent: u8,
    /// Least command of a motor in flight, percent.
    pub flight_idle_percent: u8,
    /// TELEM1, thousands of bits per second: 57 or 115.
    pub telem1_kbaud: u8,
    /// True: the board teaches the ESCs their range, propellers off, and does nothing else.
    pub esc_calibration: bool,
    /// True: the safety button has to be held before anything arms.
    pub safety_button: bool,
    /// The radio.
    pub radio: RadioParams,
    /// How the sticks feel.
    pub pilot: PilotParams,
    /// How the first and the second IMU sit.
    pub level: [LevelParams; 2],
    /// The vehicle's own numbers.
    pub vehicle: VehicleNumbers,
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
        battery: BatteryParams::DEFAULT,
        hover_throttle_permille: 500,
        rotor_drag_permille_1_s: 450,
        gyro_notches: true,
        motor_loss: false,
        learning: false,
        control_horizon: 5,
        motor_limits: false,
        linearisations: 1,
        mpc_quick: false,
        ground_idle_percent: 10,
        flight_idle_percent: 15,
        telem1_kbaud: 57,
        esc_calibration: false,
        safety_button: false,
        radio: RadioParams::DEFAULT,
        pilot: PilotParams::DEFAULT,
        level: [LevelParams { roll_cdeg: 0, pitch_cdeg: 0, down_mm_s2: 0 }; 2],
        vehicle: VehicleNumbers::DEFAULT,
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
    let words = [VERSION, PAYLOAD_LEN as u16].into_iter().chain(Field::ALL.into_iter().map(|field| params.get(field)));
    let body = MAGIC.into_iter().chain(words.flat_map(u16::to_le_bytes));
    let mut record = [0; RECORD_LEN];
    for (to, from) in record.iter_mut().zip(body) {
        *to = from;
    }
    let crc = crc32(record.get(..RECORD_LEN - CRC_LEN).unwrap_or_default());
    for (to, from) in record.iter_mut().skip(RECORD_LEN - CRC_LEN).zip(crc.to_le_bytes()) {
        *to = from;
    }
    record
}

/// The choices in a record.
///
/// # Errors
/// What is wrong with it; the caller then takes [`Params::DEFAULT`] and requests confirmation.
pub fn decode(record: &[u8; RECORD_LEN]) -> Result<Params, RecordError> {
    let [m0, m1, m2, m3, version0, version1, length0, length1, ..] = *record;
    if [m0, m1, m2, m3] != MAGIC {
        return Err(RecordError::NoRecord);
    }
    let version = u16::from_le_bytes([version0, version1]);
    if version != VERSION {
        return Err(RecordError::Version(version));
    }
    let (body, crc) = record.split_at(RECORD_LEN - CRC_LEN);
    let length = usize::from(u16::from_le_bytes([length0, length1]));
    if crc32(body).to_le_bytes() != *crc || length != PAYLOAD_LEN {
        return Err(RecordError::Damaged);
    }
    let words = body.get(HEAD_LEN..).unwrap_or_default().chunks_exact(2);
    let mut params = Params::DEFAULT;
    for (field, word) in Field::ALL.into_iter().zip(words) {
        let value = word.iter().rev().fold(0, |value, byte| value << 8 | u16::from(*byte));
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

/// CRC-32 of IEEE 802.3 (start and end inverted).
pub fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| crc32_step(crc, *byte))
}

/// A byte more in a CRC-32 (reflected 0x04C11DB7), bit by bit: what it is for is short and read once.
pub fn crc32_step(crc: u32, byte: u8) -> u32 {
    (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 })
}

#[cfg(test)]
pub(crate) mod tests {
    extern crate std;
    use super::radio::StickParams;
    use super::vehicle::FlownVehicle;
    use super::*;
    use proptest::prelude::*;
    use std::string::ToString;

    pub(crate) fn any_params() -> impl Strategy<Value = Params> {
        let inputs = (1u8..=30, 1u8..=4);
        let idle = (0u8..=30, 0u8..=30);
        let lift = (0u16..=1000, 10u16..=2000);
        (any::<[bool; 12]>(), 50u16..=490, any_battery(), lift, inputs, idle, any_radio(), any_owner()).prop_map(
            |(
                switches,
                pwm_rate_hz,
                battery,
                (hover, rotor_drag),
                inputs,
                idle,
                (safety_button, radio),
                (pilot, level, vehicle),
            )| {
                let [mpc, one_shot, free, hil, slow, limits, escs, fast, gyro_notches, motor_loss, quick, learning] =
                    switches;
                Params {
                    controller: if mpc { Controller::Mpc } else { Controller::Cascade },
                    loop_rate_hz: if slow { 100 } else { 400 },
                    pulses: if one_shot { PulseKind::OneShot125 } else { PulseKind::Pwm },
                    pwm_rate_hz,
                    rig: if free { Rig::Free } else { Rig::Gimbal },
                    hil,
                    battery,
                    hover_throttle_permille: hover,
                    rotor_drag_permille_1_s: rotor_drag,
                    gyro_notches,
                    motor_loss,
                    learning,
                    control_horizon: inputs.0,
                    motor_limits: limits,
                    linearisations: inputs.1,
                    mpc_quick: quick,
                    ground_idle_percent: idle.0,
                    flight_idle_percent: idle.1,
                    telem1_kbaud: if fast { 115 } else { 57 },
                    esc_calibration: escs,
                    safety_button,
                    radio,
                    pilot,
                    level,
                    vehicle,
                }
            },
        )
    }

    fn any_battery() -> impl Strategy<Value = BatteryParams> {
        (any::<[u16; 3]>(), 1u8..=60).prop_map(|([arming_min_mv, low_mv, critical_mv], timer_s)| BatteryParams {
            arming_min_mv,
            low_mv,
            critical_mv,
            timer_s,
        })
    }

    fn any_owner() -> impl Strategy<Value = (PilotParams, [LevelParams; 2], VehicleNumbers)> {
        (any_pilot(), any_level(), any_vehicle())
    }

    /// Any numbers that the table allows, and as often such as a person might set.
    fn any_vehicle() -> impl Strategy<Value = VehicleNumbers> {
        let flown = prop_oneof![Just(FlownVehicle::Unnamed), Just(FlownVehicle::Own), Just(FlownVehicle::F450)];
        let (mass, arm, ring) = (100u16..=10_000, 50u16..=1000, any::<u16>());
        let likely = ([1000u16..=3000, 1000u16..=3000, 1500u16..=3500], 9_000u16..=12_000, 0u16..=100);
        let allowed = ([10u16..=65535, 10u16..=65535, 10u16..=65535], 200u16..=65535, 0u16..=20_000);
        let body_and_lift = prop_oneof![likely, allowed];
        (flown, mass, arm, ring, body_and_lift, 1000u16..=65535, 0u16..=2000, 0u16..=300).prop_map(
            |(flown, mass_g, arm_mm, ring_e5_kg_m2, (inertia, max, min), torque_per_lift_um, lag_e4_s, delay_e4_s)| {
                #[rustfmt::skip]
                let vehicle = VehicleNumbers {
                    flown, mass_g, arm_mm, inertia_e5_kg_m2: inertia, ring_e5_kg_m2, torque_per_lift_um,
                    lift_min_mn: min, lift_max_mn: max, lag_e4_s, delay_e4_s,
                };
                vehicle
            },
        )
    }

    fn any_level() -> impl Strategy<Value = [LevelParams; 2]> {
        let one = (-1000i16..=1000, -1000i16..=1000, -1000i16..=1000);
        let one = one.prop_map(|(roll_cdeg, pitch_cdeg, down_mm_s2)| LevelParams { roll_cdeg, pitch_cdeg, down_mm_s2 });
        [one.clone(), one]
    }

    fn any_radio() -> impl Strategy<Value = (bool, RadioParams)> {
        let range = (1u8..=16, 800u16..=2200, 800u16..=2200, 800u16..=2200, any::<bool>(), 0u16..=200);
        let stick = range.prop_map(|(channel, min_us, trim_us, max_us, reversed, dead_zone_us)| StickParams {
            channel,
            min_us,
            trim_us,
            max_us,
            reversed,
            dead_zone_us,
        });
        let channels = (0u8..=16, 0u8..=16);
        (any::<[bool; 4]>(), [stick.clone(), stick.clone(), stick.clone(), stick], channels, 0u16..=1500).prop_map(
            |([button, flies, kill_reversed, acro_reversed], sticks, (kill_channel, acro_channel), fail_below_us)| {
                #[rustfmt::skip]
                let radio = RadioParams {
                    flies, sticks, kill_channel, kill_reversed, fail_below_us, acro_channel, acro_reversed,
                };
                (button, radio)
            },
        )
    }

    pub(crate) fn any_pilot() -> impl Strategy<Value = PilotParams> {
        let stabilise = (10u8..=60, 10u16..=114, 0u8..=100);
        let acro = (10u16..=286, 10u16..=114, 0u8..=100);
        (stabilise, acro, 20u8..=80, 0u8..=100).prop_map(|(stabilise, acro, mid, throttle_expo_percent)| {
            let ((tilt_deg, yaw_deg_s, expo_percent), (acro_tilt_deg_s, acro_yaw_deg_s, acro_expo_percent)) =
                (stabilise, acro);
            #[rustfmt::skip]
            let pilot = PilotParams {
                tilt_deg, yaw_deg_s, expo_percent, acro_tilt_deg_s, acro_yaw_deg_s, acro_expo_percent,
                throttle_mid_percent: mid, throttle_expo_percent,
            };
            pilot
        })
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

    /// The head of a record: magic, version 10, and the length of what lies between head and CRC.
    #[test]
    fn a_record_begins_with_its_head() {
        let record = encode(&Params::DEFAULT);
        assert_eq!(record[..8], *b"QCFG\x0a\0\xa0\0");
        assert_eq!(record.len(), 8 + 160 + 4);
        // a field of 16 bits each: the first is the controller, the sixth the rate of the loop
        assert_eq!(record[8..20], [0, 0, 5, 0, 0, 0, 1, 0, 0, 0, 0x90, 1]);
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
