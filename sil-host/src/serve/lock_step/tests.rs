//! A board in lock-step without sockets: a simulator's messages in, the answers out. The vehicle stands still here;
//! `tests/clients/px4_simulator.py` has one that flies.

use mavlink::MessageData;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HIL_ACTUATOR_CONTROLS_DATA, HIL_SENSOR_DATA, HilActuatorControlsFlags, HilSensorUpdatedFlags,
    MANUAL_CONTROL_DATA, MavCmd, MavModeFlag,
};
use shared_control::link::Receiver;
use shared_control::params::vehicle::VehicleNumbers;
use shared_control::params::{Params, RECORD_LEN, Rig};
use shared_control::sensing::imu_health::ImuFault;
use shared_control::supervisor::{Arming, DisarmedBecause};

use super::*;
use crate::serve::{LogShelf, ParameterStore, Unsigned};

struct Kept;

impl ParameterStore for Kept {
    fn keep(&mut self, _: &[u8; RECORD_LEN]) -> bool {
        true
    }
}

/// A simulator of a vehicle that stands, and the ground station that it does not know of.
struct Standing {
    lock_step: LockStep,
    writer: FrameWriter,
    ground: FrameWriter,
    receiver: Receiver,
    sample_us: u64,
    time_us: u64,
    sent: Vec<u8>,
}

impl Standing {
    fn new(sample_us: u64) -> Self {
        let (rig, vehicle) = (Rig::Free, VehicleNumbers::F450);
        let params = Params { rig, vehicle, hover_throttle_permille: 540, ..Params::DEFAULT };
        let memory = Memory { parameters: Box::new(Kept), signing: Box::new(Unsigned), logs: LogShelf::in_memory() };
        let mut lock_step = LockStep::new(&params, memory).unwrap();
        lock_step.connected();
        let receiver = Receiver::new(lock_step.board().link_settings());
        let (writer, ground) = (FrameWriter::new(1, 200), FrameWriter::new(255, 190));
        Self { lock_step, writer, ground, receiver, sample_us, time_us: 0, sent: Vec::new() }
    }

    /// A sample of a chip that is never quite quiet.
    fn sample(&self) -> HIL_SENSOR_DATA {
        let noise = |place: u64| ((self.time_us / self.sample_us).wrapping_mul(place) % 7) as f32 - 3.0;
        HIL_SENSOR_DATA {
            time_usec: self.time_us,
            xacc: 0.01 * noise(3),
            yacc: 0.01 * noise(5),
            zacc: -9.81 + 0.01 * noise(11),
            xgyro: 0.002 * noise(13),
            ygyro: 0.002 * noise(17),
            zgyro: 0.002 * noise(19),
            fields_updated: HilSensorUpdatedFlags::from_bits_truncate(0x1FFF),
            ..HIL_SENSOR_DATA::DEFAULT
        }
    }

    fn hear(&mut self, data: &impl MessageData) {
        let mut frame = heapless::Vec::<u8, 100>::new();
        assert!(self.writer.write(data, &mut frame));
        frame.iter().for_each(|byte| self.lock_step.hear(*byte).unwrap());
        self.sent.extend(self.lock_step.take_sent());
    }

    fn order(&mut self, data: &impl MessageData) {
        let mut frame = heapless::Vec::<u8, 100>::new();
        assert!(self.ground.write(data, &mut frame));
        for byte in frame {
            self.lock_step.board().hear(&mut self.receiver, byte, true);
        }
    }

    fn command(&mut self, command: MavCmd, param1: f32) {
        self.order(&COMMAND_LONG_DATA { command, param1, ..COMMAND_LONG_DATA::DEFAULT });
    }

    /// With the sticks of a ground station.
    fn pass(&mut self, seconds: f64) {
        for index in 0..(seconds * 1e6) as u64 / self.sample_us {
            if index % 20 == 0 {
                self.order(&MANUAL_CONTROL_DATA { target: 1, ..MANUAL_CONTROL_DATA::DEFAULT });
            }
            self.time_us += self.sample_us;
            self.hear(&self.sample());
        }
    }

    fn arm(&mut self) {
        self.pass(3.0);
        self.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        self.pass(0.2);
        assert_eq!(self.arming(), Arming::Armed);
    }

    fn arming(&mut self) -> Arming {
        self.lock_step.board().status().arming
    }

    fn answers(&self) -> Vec<HIL_ACTUATOR_CONTROLS_DATA> {
        let mut finder = FrameFinder::default();
        let extra = |id| (id == HIL_ACTUATOR_CONTROLS_DATA::ID).then_some(HIL_ACTUATOR_CONTROLS_DATA::EXTRA_CRC);
        self.sent.iter().filter_map(|byte| message(&finder.push(*byte, extra)?)).collect()
    }
}

/// The simulator waits for each, so there is one, with the sample's time, whatever the board does meanwhile.
#[test]
fn each_sample_has_one_answer() {
    for (sample_us, loop_hz) in [(2500, 400.0), (4000, 250.0), (1000, 1000.0 / 3.0)] {
        let mut standing = Standing::new(sample_us);
        standing.arm();
        standing.pass(1.0);
        let times: Vec<u64> = standing.answers().iter().map(|answer| answer.time_usec).collect();
        assert_eq!(times, (1..=times.len() as u64).map(|index| index * sample_us).collect::<Vec<_>>());
        assert_eq!(times.last(), Some(&standing.time_us));
        let figures = standing.lock_step.figures();
        assert_eq!((figures.loop_hz, figures.sensors), (Some(loop_hz), times.len() as u64));
        // all but those that the rate was found from
        let steps = (figures.sensors - 17) as f64 * loop_hz as f64 * sample_us as f64 * 1e-6;
        assert!((figures.steps as f64 - steps).abs() < 1.0, "{figures:?}");
    }
}

/// Nothing turns before arming; armed motors idle at the parameters' tenth, and the mode says so.
#[test]
fn answers_say_whether_it_is_armed() {
    let mut standing = Standing::new(4000);
    standing.arm();
    standing.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    standing.pass(0.1);
    let answers = standing.answers();
    let is_armed = |answer: &&HIL_ACTUATOR_CONTROLS_DATA| answer.mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
    let (armed, disarmed): (Vec<_>, Vec<_>) = answers.iter().partition(is_armed);
    // from the step that took the order to the one that took the other
    assert_eq!((armed.len(), disarmed.len()), (50, answers.len() - 50));
    assert!(armed.iter().all(|answer| answer.controls[..4] == [0.1; 4] && answer.controls[4..] == [0.0; 12]));
    assert!(disarmed.iter().all(|answer| answer.controls == [0.0; 16]));
    let lockstep = HilActuatorControlsFlags::HIL_ACTUATOR_CONTROLS_FLAGS_LOCKSTEP;
    assert!(answers.iter().all(|answer| answer.flags == lockstep));
}

#[test]
fn the_same_samples_have_the_same_answers() {
    let run = || {
        let mut standing = Standing::new(4000);
        standing.arm();
        // tilted by a simulator's hand, so that there is something to answer
        let mut tilted = standing.sample();
        for _ in 0..200 {
            standing.time_us += 4000;
            tilted = HIL_SENSOR_DATA { time_usec: standing.time_us, yacc: 1.0, xgyro: tilted.xgyro + 1e-3, ..tilted };
            standing.hear(&tilted);
        }
        standing.sent
    };
    assert_eq!(run(), run());
}

/// Of a vehicle whose only IMU is gone nobody can hold the attitude: in flight it goes on for 40 ms, on the ground
/// less, then the motors stop (docs/pixhawk.md).
#[test]
fn without_its_simulator_an_armed_vehicle_stops() {
    let mut standing = Standing::new(2500);
    standing.arm();
    standing.lock_step.disconnected();
    assert!(standing.lock_step.is_alone());
    let mut alone_us = 0;
    while standing.arming() == Arming::Armed {
        alone_us += standing.lock_step.advance_alone().unwrap();
        assert!(alone_us <= 50_000);
    }
    assert!(matches!(standing.arming(), Arming::Disarmed(DisarmedBecause::ImuFailed(ImuFault::Stale))));
    // the simulator is there again, at another rate: a new start, and it arms
    standing.lock_step.connected();
    (standing.sample_us, standing.time_us) = (4000, 0);
    standing.arm();
    assert_eq!(standing.lock_step.figures().loop_hz, Some(250.0));
}

/// Missing samples are steps without one; a few are flown over, as on the board.
#[test]
fn what_is_missing_makes_its_steps() {
    let mut standing = Standing::new(2500);
    standing.arm();
    let before = standing.lock_step.figures().steps;
    standing.time_us += 3 * 2500;
    standing.pass(0.0025);
    assert_eq!((standing.lock_step.figures().steps - before, standing.lock_step.figures().sensors_missing), (4, 3));
    assert_eq!(standing.arming(), Arming::Armed);
    standing.time_us += 200_000;
    standing.pass(0.0025);
    assert!(matches!(standing.arming(), Arming::Disarmed(_)));
    // another simulation: the board starts anew, and says why
    standing.time_us = 0;
    standing.pass(0.0025);
    let news = standing.lock_step.take_news();
    assert!(news.last().is_some_and(|line| line.contains("starts anew")), "{news:?}");
    standing.arm();
}

/// A barometer's message, another IMU's, a message that repeats the time.
#[test]
fn only_samples_of_the_first_imu_make_steps() {
    let mut standing = Standing::new(4000);
    standing.pass(1.0);
    let before = standing.lock_step.figures().clone();
    let count = standing.answers().len();
    let barometer = HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_ABS_PRESSURE;
    standing.time_us += 1000;
    standing.hear(&HIL_SENSOR_DATA { fields_updated: barometer, ..standing.sample() });
    let mut payload = [0; 65];
    standing.sample().ser(mavlink::MavlinkVersion::V2, &mut payload);
    payload[SENSOR_ID_AT] = 1;
    let mut frame = heapless::Vec::<u8, 100>::new();
    let id = (HIL_SENSOR_DATA::ID, HIL_SENSOR_DATA::EXTRA_CRC);
    assert!(standing.writer.write_payload(id, &payload, &mut frame));
    frame.iter().for_each(|byte| standing.lock_step.hear(*byte).unwrap());
    assert_eq!(standing.lock_step.figures(), &before);
    standing.time_us -= 1000;
    standing.hear(&standing.sample());
    assert_eq!((standing.lock_step.figures().steps, standing.answers().len()), (before.steps, count + 1));
}

/// As an owner sets a parameter: it counts from the restart on, and the lock-step goes on.
#[test]
fn a_restart_keeps_the_pace() {
    let mut standing = Standing::new(4000);
    standing.pass(1.0);
    standing.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
    standing.pass(0.5);
    assert_eq!((standing.lock_step.restarts(), standing.lock_step.is_alone()), (1, false));
    assert_eq!(standing.lock_step.board().step_us(), 4000);
    standing.arm();
    assert_eq!(standing.answers().len() as u64, standing.lock_step.figures().sensors);
}
