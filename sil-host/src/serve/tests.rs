//! A served vehicle without sockets: bytes in, bytes out, by simulated time.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

use mavlink::MessageData;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, LOG_DATA_DATA, LOG_REQUEST_DATA_DATA, MANUAL_CONTROL_DATA, MavAutopilot, MavCmd,
    MavModeFlag, MavParamType, MavType, PARAM_SET_DATA,
};
use shared_control::config::Controller;
use shared_control::link::Receiver;
use shared_control::link::frame::{FrameFinder, FrameWriter, message};
use shared_control::params::vehicle::VehicleNumbers;
use shared_control::params::{Params, RECORD_LEN, Rig, decode};
use shared_control::supervisor::Arming;

use super::*;
use crate::effects::Effect;
use crate::model;

/// Keeps what was stored last where a test sees it.
#[derive(Clone, Default)]
struct Kept(Rc<RefCell<Option<Params>>>);

impl ParameterStore for Kept {
    fn keep(&mut self, record: &[u8; RECORD_LEN]) -> bool {
        *self.0.borrow_mut() = decode(record).ok();
        true
    }
}

/// A ground station's hands on a vehicle.
struct Flown {
    vehicle: ServedVehicle,
    receiver: Receiver,
    writer: FrameWriter,
    said: Vec<u8>,
    throttle: i16,
}

impl Flown {
    fn new(model: VehicleModel, params: &Params, kept: Kept) -> Self {
        let memory = Memory { parameters: Box::new(kept), signing: Box::new(Unsigned), logs: LogShelf::in_memory() };
        let mut vehicle = ServedVehicle::new(model, 1, params, memory).unwrap();
        let receiver = Receiver::new(vehicle.board().link_settings());
        Self { vehicle, receiver, writer: FrameWriter::new(255, 190), said: Vec::new(), throttle: 0 }
    }

    fn free() -> Self {
        let model = VehicleModel::nominal(model::Rig::Free);
        let hover_throttle_permille = (model.base_command * 1000.0).round() as u16;
        let vehicle = VehicleNumbers::F450;
        let params = Params { rig: Rig::Free, hover_throttle_permille, vehicle, ..Params::DEFAULT };
        Self::new(model, &params, Kept::default())
    }

    fn send(&mut self, data: &impl MessageData) {
        let mut frame = heapless::Vec::<u8, 100>::new();
        assert!(self.writer.write(data, &mut frame));
        for byte in frame {
            self.vehicle.board().hear(&mut self.receiver, byte, true);
        }
    }

    fn command(&mut self, command: MavCmd, param1: f32) {
        self.send(&COMMAND_LONG_DATA { command, param1, ..COMMAND_LONG_DATA::DEFAULT });
    }

    fn set(&mut self, name: &str, param_value: f32) {
        let (param_id, param_type) = (name.into(), MavParamType::MAV_PARAM_TYPE_REAL32);
        self.send(&PARAM_SET_DATA { param_value, param_id, param_type, ..PARAM_SET_DATA::DEFAULT });
    }

    /// Were these words said?
    fn heard(&self, words: &str) -> bool {
        self.said.windows(words.len()).any(|said| said == words.as_bytes())
    }

    /// A parameter in the head of a log, by ULog's format: its type and name, then 4 bytes.
    fn logged(&mut self, id: u16, name: &str) -> i32 {
        let all = LOG_REQUEST_DATA_DATA { id, count: u32::MAX, target_system: 1, ..LOG_REQUEST_DATA_DATA::DEFAULT };
        self.said.clear();
        self.send(&all);
        self.pass(60.0);
        let (log, key) = (self.log_heard(), format!("int32_t {name}"));
        let length = key.len() as u8;
        let at = |log: &[u8]| {
            log.windows(key.len() + 1).position(|bytes| bytes[0] == length && bytes[1..] == *key.as_bytes())
        };
        let value = at(&log).expect("the parameter") + 1 + key.len();
        i32::from_le_bytes(log[value..value + 4].try_into().unwrap())
    }

    /// With sticks ten times and heartbeats once a second.
    fn pass(&mut self, seconds: f64) {
        for tick in 0..(seconds * 1e6) as u64 / TICK_US {
            if tick.is_multiple_of(200) {
                self.send(&MANUAL_CONTROL_DATA { target: 1, z: self.throttle, ..MANUAL_CONTROL_DATA::DEFAULT });
            }
            if tick.is_multiple_of(2000) {
                let (mavtype, autopilot) = (MavType::MAV_TYPE_GCS, MavAutopilot::MAV_AUTOPILOT_INVALID);
                self.send(&HEARTBEAT_DATA { mavtype, autopilot, ..HEARTBEAT_DATA::DEFAULT });
            }
            self.vehicle.advance().unwrap();
            self.said.extend(self.vehicle.board().take_sent());
        }
    }

    fn arming(&mut self) -> Arming {
        self.vehicle.board().status().arming
    }

    fn heartbeats(&self) -> Vec<HEARTBEAT_DATA> {
        let mut finder = FrameFinder::default();
        let extra = |id| (id == HEARTBEAT_DATA::ID).then_some(HEARTBEAT_DATA::EXTRA_CRC);
        self.said.iter().filter_map(|byte| message(&finder.push(*byte, extra)?)).collect()
    }

    /// A free vehicle that has stood, armed, and climbed for a second.
    fn in_the_air() -> Self {
        let mut flown = Self::free();
        flown.pass(3.0);
        flown.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        flown.pass(0.5);
        flown.throttle = 600;
        flown.pass(1.0);
        flown
    }

    /// The bytes of `LOG_DATA` in what it said, at their places.
    fn log_heard(&self) -> Vec<u8> {
        let (mut rest, mut log) = (self.said.as_slice(), Vec::new());
        while let [_, length, _, _, _, _, _, id0, id1, _, payload @ ..] = rest {
            let mut data = payload[..usize::from(*length)].to_vec();
            rest = &payload[data.len() + 2..];
            if u32::from_le_bytes([*id0, *id1, 0, 0]) == LOG_DATA_DATA::ID {
                // trailing zeros are not sent
                data.resize(LOG_DATA_DATA::ENCODED_LEN, 0);
                let offset = u32::from_le_bytes([data[0], data[1], data[2], data[3]]) as usize;
                assert_eq!(offset, log.len(), "one after the other");
                log.extend_from_slice(&data[7..7 + usize::from(data[6])]);
            }
        }
        log
    }

    fn tilt_deg(&self) -> f64 {
        let truth = self.vehicle.truth();
        (truth.roll_rad.cos() * truth.pitch_rad.cos()).acos().to_degrees()
    }
}

/// It stands, takes off, comes down, stands again on its legs, and knows each of it.
#[test]
fn a_free_vehicle_takes_off_and_lands() {
    let mut flown = Flown::free();
    flown.pass(3.0);
    let stands_m = flown.vehicle.truth().position_ned_m[2];
    // 10 mm at 1 g
    assert!((stands_m - 0.01).abs() < 1e-3, "legs bend by {stands_m} m");
    flown.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flown.pass(0.5);
    assert_eq!(flown.arming(), Arming::Armed);
    assert!((flown.vehicle.truth().position_ned_m[2] - stands_m).abs() < 0.005, "it idles on the ground");
    flown.throttle = 600;
    flown.pass(2.0);
    assert!(flown.vehicle.truth().position_ned_m[2] < -0.5 && flown.tilt_deg() < 5.0, "it climbs");
    assert!(flown.vehicle.board().status().airborne);
    // half a metre a second downwards, as a careful hand lands
    for _ in 0..300 {
        let truth = flown.vehicle.truth();
        let miss_m_s = truth.velocity_ned_m_s[2] - 0.5;
        let on_ground = truth.position_ned_m[2] > -0.005;
        flown.throttle = if on_ground || flown.throttle == 0 { 0 } else { (540.0 + 100.0 * miss_m_s) as i16 };
        flown.pass(0.1);
    }
    assert!((flown.vehicle.truth().position_ned_m[2] - stands_m).abs() < 0.005 && flown.tilt_deg() < 1.0);
    assert!(!flown.vehicle.board().status().airborne, "it has landed");
    assert_eq!(flown.arming(), Arming::Armed);
    let armed = MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
    assert!(flown.heartbeats().last().is_some_and(|beat| beat.base_mode.contains(armed)));
}

/// On the rig a hand holds what would turn by itself, until the motors do.
#[test]
fn on_the_rig_a_hand_holds_the_vehicle_level() {
    let mut model = VehicleModel::nominal(model::Rig::Gimbal);
    let text = "torque_bias:axis=roll,torque_nm=0.02";
    model.effects.push(Effect::parse_for(text, model.rig(), model.inertia_kg_m2).unwrap());
    let mut flown = Flown::new(model, &Params::DEFAULT, Kept::default());
    flown.pass(5.0);
    // 0.02 N m over 9 1/s^2 times 0.0115 kg m^2: 11 degrees, at rest
    let held_rad = flown.vehicle.truth().roll_rad;
    assert!((0.05..0.3).contains(&held_rad), "{held_rad} rad");
    assert!(flown.vehicle.truth().rate_body_rad_s[0].abs() < 1e-3);
}

/// A parameter that sets up a timer counts from the restart that was ordered over the link, and the same again gives
/// the same bytes.
#[test]
fn a_restart_flies_what_was_stored() {
    let run = || {
        let kept = Kept::default();
        let mut flown = Flown::new(VehicleModel::nominal(model::Rig::Gimbal), &Params::DEFAULT, kept.clone());
        flown.pass(1.0);
        flown.set("LOOP_RATE_HZ", 100.0);
        flown.pass(0.5);
        assert_eq!(kept.0.borrow().map(|params| params.loop_rate_hz), Some(100));
        assert_eq!(flown.vehicle.board().step_us(), 2500, "not before");
        flown.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
        flown.pass(1.0);
        assert_eq!((flown.vehicle.restarts(), flown.vehicle.board().step_us()), (1, 10_000));
        assert!(flown.heard("LOOP_RATE_HZ stored for the next start"));
        flown.said
    };
    assert_eq!(run(), run());
}

/// On the ground what is set flies without a restart, and the log of each flight says what that was flown with.
#[test]
fn what_is_set_on_the_ground_flies_next() {
    let mut flown = Flown::new(VehicleModel::nominal(model::Rig::Gimbal), &Params::DEFAULT, Kept::default());
    flown.pass(3.0);
    for (controller, horizon) in [(0.0, 5.0), (1.0, 12.0), (0.0, 12.0)] {
        flown.set("CONTROLLER", controller);
        flown.set("CONTROL_HORIZON", horizon);
        // no pause: arming waits
        flown.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        flown.pass(0.1);
        let is_changed = (controller, horizon) != (0.0, 5.0);
        assert_eq!(flown.arming() == Arming::Armed, !is_changed, "{controller}");
        flown.pass(0.6);
        assert_eq!(flown.arming(), Arming::Armed, "{controller}");
        flown.throttle = 500;
        flown.pass(1.0);
        let status = *flown.vehicle.board().status();
        assert_eq!(status.controller == Controller::Mpc, controller == 1.0);
        assert_eq!(status.planning.status.is_some(), controller == 1.0);
        assert!(status.estimate.valid, "the attitude is not lost");
        flown.throttle = 0;
        flown.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
        flown.pass(2.0);
    }
    assert!(flown.heard("2 parameters in use now") && flown.heard("CONTROLLER in use now"));
    for (log, (controller, horizon)) in [(0, 5), (1, 12), (0, 12)].into_iter().enumerate() {
        assert_eq!(flown.logged(log as u16, "CONTROLLER"), controller);
        assert_eq!(flown.logged(log as u16, "CONTROL_HORIZON"), horizon);
    }
}

/// In the air nothing changes; after the flight and its log it counts.
#[test]
fn what_is_set_in_the_air_counts_after_disarming() {
    let mut flown = Flown::in_the_air();
    flown.set("CONTROLLER", 1.0);
    flown.pass(1.0);
    assert!(flown.heard("CONTROLLER stored; counts after disarming"));
    assert_eq!(flown.vehicle.board().status().controller, Controller::Cascade);
    flown.throttle = 0;
    flown.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    flown.pass(0.5);
    assert_eq!(flown.vehicle.board().status().controller, Controller::Cascade, "its log is not complete yet");
    flown.pass(1.0);
    assert!(flown.heard("CONTROLLER in use now"));
    assert_eq!(flown.vehicle.board().status().controller, Controller::Mpc);
    assert_eq!(flown.logged(0, "CONTROLLER"), 0);
}

/// Sticks mean what was set a moment before.
#[test]
fn the_grounds_sticks_follow_their_curves() {
    let mut flown = Flown::free();
    flown.pass(3.0);
    flown.throttle = 500;
    flown.pass(0.2);
    let throttle = |flown: &mut Flown| flown.vehicle.board().status().setpoint.throttle;
    let before = throttle(&mut flown);
    flown.set("THR_MID_PCT", 30.0);
    flown.pass(0.6);
    assert!((before - 0.5).abs() < 1e-3 && (throttle(&mut flown) - 0.3).abs() < 1e-3, "{}", throttle(&mut flown));
}

/// A flight leaves a log, which outlasts a restart, comes over the link, and is read as other people's are.
#[test]
fn a_flight_leaves_a_log() {
    let mut flown = Flown::in_the_air();
    flown.throttle = 0;
    flown.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    flown.pass(0.5);
    // before the log has ended by itself
    flown.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
    flown.pass(1.0);
    assert_eq!(flown.vehicle.restarts(), 1);
    let all = LOG_REQUEST_DATA_DATA { count: u32::MAX, target_system: 1, ..LOG_REQUEST_DATA_DATA::DEFAULT };
    flown.said.clear();
    flown.send(&all);
    flown.pass(20.0);
    let log = crate::log::parse_bytes(Path::new("x.ulg"), flown.log_heard(), None).unwrap();
    assert_eq!(log.flight_controller.as_deref(), Some("PX4"));
    // armed for 1.5 s, and until 0.1 s after the restart was ordered
    let duration_s = log.time_s[log.rows() - 1] - log.time_s[0];
    assert!((2.0..2.2).contains(&duration_s), "{duration_s} s");
    let motors = log.motors().unwrap();
    let in_flight = |row: &usize| (1.0..1.4).contains(&(log.time_s[*row] - log.time_s[0]));
    let rows: Vec<usize> = (0..log.rows()).filter(in_flight).collect();
    let mean = |of: &[f64]| rows.iter().map(|row| of[*row]).sum::<f64>() / rows.len() as f64;
    for motor in motors {
        assert!((mean(motor) - 0.6).abs() < 0.02, "{}", mean(motor));
    }
    assert!(log.battery_v.is_some() && log.accel_body_m_s2.iter().all(Option::is_some));
}
