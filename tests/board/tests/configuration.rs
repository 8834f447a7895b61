//! The owner's choices on the board: read from the FRAM at start, set over the link, obeyed by the timers.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use emulated_board::time::{TICKS_PER_S, TICKS_PER_US, Ticks};
use emulated_board::{Counts, Image, Machine, Pulse, SecondGyro, Surroundings, Vehicle, World, step_trace};
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, MavCmd, MavMessage, MavParamType, MavResult, MavType, PARAM_REQUEST_LIST_DATA,
    PARAM_SET_DATA,
};
use mavlink::{MAVLinkV2MessageRaw, MavlinkVersion, Message, MessageData};
use shared_control::link::frame::FrameWriter;
use shared_control::output::PulseKind;
use shared_control::params::table::Field;
use shared_control::params::{Params, RECORD_LEN, encode};
use shared_control::supervisor::Arming;
use sil_host::model::{Rig, VehicleModel};

const MILLISECOND: Ticks = 1000 * TICKS_PER_US;
/// From power-on to a gyro that is calibrated.
const START: Ticks = 3000 * MILLISECOND;

/// The vehicle, and a record of the pulses.
struct Recorder {
    surroundings: Surroundings,
    pulses: Rc<RefCell<Vec<Pulse>>>,
}

impl World for Recorder {
    fn imu(&mut self, now: Ticks) -> Counts {
        self.surroundings.imu(now)
    }
    fn pulse(&mut self, pulse: Pulse) {
        self.pulses.borrow_mut().push(pulse);
    }
    fn second_gyro(&self) -> Option<SecondGyro> {
        self.surroundings.second_gyro()
    }
    fn second_imu(&mut self, now: Ticks) -> Counts {
        self.surroundings.second_imu(now)
    }
}

/// A board on the bench with a ground station on TELEM1.
struct Bench {
    machine: Machine,
    trace_address: u32,
    pulses: Rc<RefCell<Vec<Pulse>>>,
    writer: FrameWriter,
    received: Vec<u8>,
}

impl Bench {
    /// At power-on with these bytes in the FRAM.
    fn new(record: &[u8]) -> Self {
        let built = std::env::var_os("FIRMWARE_ELF").map(PathBuf::from).unwrap_or_else(|| {
            let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
            workspace.join("target/thumbv7em-none-eabihf/release/firmware")
        });
        let image = Image::load(&built).unwrap_or_else(|error| panic!("run this by `cargo xtask board-test`: {error}"));
        let pulses = Rc::default();
        let surroundings = Surroundings(Vehicle::new(&VehicleModel::nominal(Rig::Gimbal), 1));
        let world = Recorder { surroundings, pulses: Rc::clone(&pulses) };
        let mut machine = Machine::new(&image, Box::new(world), 1).unwrap();
        machine.write_fram(0, record);
        let trace_address = image.symbol("FLIGHT_TRACE").expect("the firmware's record of its steps");
        Self { machine, trace_address, pulses, writer: FrameWriter::new(255, 190), received: Vec::new() }
    }

    fn run_for(&mut self, duration: Ticks) {
        let end = self.machine.now() + duration;
        while self.machine.now() < end {
            self.send(&HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT });
            for _ in 0..20 {
                self.run_until(end.min(self.machine.now() + 10 * MILLISECOND));
                self.received.extend(self.machine.telem1_receive());
            }
        }
    }

    fn run_until(&mut self, end: Ticks) {
        self.machine.run_until(end).unwrap_or_else(|stop| panic!("{stop}"));
    }

    fn send(&mut self, message: &impl MessageData) {
        let mut bytes = heapless::Vec::<u8, 128>::new();
        assert!(self.writer.write(message, &mut bytes));
        self.machine.telem1_send(&bytes);
    }

    /// What the board says within 0.3 s of a message to it.
    fn ask(&mut self, message: &impl MessageData) -> Vec<MavMessage> {
        self.said();
        self.send(message);
        self.run_for(300 * MILLISECOND);
        self.said()
    }

    fn command(&mut self, command: MavCmd, param1: f32) -> Vec<MavMessage> {
        let (target_system, target_component) = (1, 1);
        self.ask(&COMMAND_LONG_DATA { command, param1, target_system, target_component, ..COMMAND_LONG_DATA::DEFAULT })
    }

    fn set(&mut self, name: &str, param_value: f32) -> Vec<MavMessage> {
        let (param_id, param_type) = (name.into(), MavParamType::MAV_PARAM_TYPE_REAL32);
        self.ask(&PARAM_SET_DATA { param_value, target_system: 1, target_component: 1, param_id, param_type })
    }

    /// Whole messages since the last call, telemetry that comes by itself left out. A reset may cut one.
    fn said(&mut self) -> Vec<MavMessage> {
        let mut messages = Vec::new();
        while let [_, length, ..] = self.received[..]
            && self.received.len() >= 12 + usize::from(length)
        {
            let mut raw = MAVLinkV2MessageRaw::new();
            let length = 12 + usize::from(length);
            raw.as_mut_slice()[..length].copy_from_slice(&self.received[..length]);
            let whole = raw.has_valid_crc::<MavMessage>();
            self.received.drain(..if whole { length } else { 1 });
            if whole && [22, 77, 253].contains(&raw.message_id()) {
                messages.push(MavMessage::parse(MavlinkVersion::V2, raw.message_id(), raw.payload()).unwrap());
            }
        }
        messages
    }

    fn is_armed(&mut self) -> bool {
        step_trace(&mut self.machine, self.trace_address).unwrap().arming == Arming::Armed.number()
    }

    fn fram_holds(&self, params: &Params) -> bool {
        self.machine.read_fram(0, RECORD_LEN) == encode(params)
    }

    /// When the step that runs next has been recorded, to 20 us.
    fn end_of_next_step(&mut self) -> Ticks {
        let step_now = |bench: &mut Self| bench.machine.word(bench.trace_address).unwrap();
        let before = step_now(self);
        // 0 while a record is being written
        while [0, before].contains(&step_now(self)) {
            self.run_until(self.machine.now() + 20 * TICKS_PER_US);
        }
        self.machine.now()
    }

    /// Pulses of motor 1 within the next 0.2 s.
    fn pulses_of_motor_1(&mut self) -> Vec<Pulse> {
        self.pulses.borrow_mut().clear();
        self.run_for(200 * MILLISECOND);
        self.motor_1()
    }

    fn motor_1(&self) -> Vec<Pulse> {
        self.pulses.borrow().iter().filter(|pulse| pulse.channel == 3).copied().collect()
    }
}

fn texts(messages: &[MavMessage]) -> Vec<&str> {
    let text = messages.iter().filter_map(|message| match message {
        MavMessage::STATUSTEXT(data) => data.text.to_str().ok(),
        _ => None,
    });
    text.collect()
}

fn values(messages: &[MavMessage]) -> Vec<(&str, f32)> {
    let value = messages.iter().filter_map(|message| match message {
        MavMessage::PARAM_VALUE(data) => Some((data.param_id.to_str().ok()?, data.param_value)),
        _ => None,
    });
    value.collect()
}

fn acknowledged(messages: &[MavMessage]) -> Option<MavResult> {
    messages.iter().find_map(|message| match message {
        MavMessage::COMMAND_ACK(data) => Some(data.result),
        _ => None,
    })
}

#[test]
fn a_damaged_record_gives_the_defaults_and_blocks_arming_until_they_are_confirmed() {
    let chosen = Params { pulses: PulseKind::OneShot125, ..Params::DEFAULT };
    let mut damaged = encode(&chosen);
    damaged[13] ^= 4;
    let mut bench = Bench::new(&damaged);
    bench.run_for(START);
    assert!(texts(&bench.said()).contains(&"configuration: damaged"));
    let refused = bench.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    assert_eq!(texts(&refused), ["refused: configuration was bad, confirm defaults"]);
    assert_eq!(acknowledged(&refused), Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED));
    // nor can one good field stand for the rest
    let refused = bench.set("PULSES", 1.0);
    assert_eq!(texts(&refused), ["refused: configuration was bad, confirm defaults"]);
    assert_eq!(values(&refused), [("PULSES", 0.0)]);
    assert_eq!(bench.machine.read_fram(0, RECORD_LEN), damaged);
    let confirmed = bench.command(MavCmd::MAV_CMD_PREFLIGHT_STORAGE, 1.0);
    assert_eq!(texts(&confirmed), ["configuration stored"]);
    assert!(bench.fram_holds(&Params::DEFAULT));
    bench.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    assert!(bench.is_armed());
}

#[test]
fn what_sets_up_a_timer_is_stored_at_once_and_counts_after_a_restart() {
    let mut bench = Bench::new(&encode(&Params::DEFAULT));
    bench.run_for(START);
    let mut all = bench.ask(&PARAM_REQUEST_LIST_DATA { target_system: 1, target_component: 1 });
    // a value in each hundredth of a second in which nothing else has filled the line
    bench.run_for(1_200 * MILLISECOND);
    all.extend(bench.said());
    assert_eq!(values(&all).len(), Field::ALL.len());
    assert!(values(&all).contains(&("PWM_RATE_HZ", 400.0)));

    let set = bench.set("PWM_RATE_HZ", 50.0);
    assert_eq!(
        (values(&set), texts(&set)),
        (vec![("PWM_RATE_HZ", 50.0)], vec!["PWM_RATE_HZ stored for the next start"])
    );
    let wanted = Params { pwm_rate_hz: 50, ..Params::DEFAULT };
    assert!(bench.fram_holds(&wanted));
    assert_eq!(bench.pulses_of_motor_1().len(), 80, "nothing changes under way");
    let bad = bench.set("LOOP_RATE_HZ", 250.0);
    assert_eq!((values(&bad), texts(&bad)), (vec![("LOOP_RATE_HZ", 400.0)], vec!["bad LOOP_RATE_HZ: 100 or 400"]));
    assert!(bench.fram_holds(&wanted));

    bench.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    assert!(bench.is_armed());
    let armed = bench.set("PWM_RATE_HZ", 100.0);
    assert_eq!(
        (values(&armed), texts(&armed)),
        (vec![("PWM_RATE_HZ", 100.0)], vec!["PWM_RATE_HZ stored for the next start"])
    );
    assert!(bench.fram_holds(&Params { pwm_rate_hz: 100, ..Params::DEFAULT }));
    let restart = bench.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
    assert_eq!(acknowledged(&restart), Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED));
    assert_eq!(bench.machine.counters().resets, 0);
    bench.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);

    bench.pulses.borrow_mut().clear();
    let restart = bench.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
    assert_eq!(acknowledged(&restart), Some(MavResult::MAV_RESULT_ACCEPTED));
    assert_eq!(bench.machine.counters().resets, 1);
    let widths = bench.pulses.borrow().iter().map(|pulse| pulse.width).collect::<Vec<_>>();
    assert!(widths.iter().all(|width| *width == MILLISECOND), "the restart cut a pulse: {:?}", widths.iter().min());
    bench.run_for(START);
    assert!(texts(&bench.said()).contains(&"started by software reset"));
    assert_eq!(bench.pulses_of_motor_1().len(), 20);
    bench.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    assert!(bench.is_armed());
}

/// Where rates are related, pulses rise at one and the same time after the tick of their loop, for ever.
#[test]
fn pulses_come_as_chosen_and_in_phase_with_the_loop() {
    let pwm = |loop_rate_hz, pwm_rate_hz| Params { loop_rate_hz, pwm_rate_hz, ..Params::DEFAULT };
    let one_shot = |loop_rate_hz| Params { loop_rate_hz, pulses: PulseKind::OneShot125, ..Params::DEFAULT };
    let choices = [
        (pwm(400, 400), 400, 1000),
        (pwm(400, 50), 50, 1000),
        (pwm(100, 50), 50, 1000),
        (pwm(100, 400), 400, 1000),
        (pwm(100, 300), 300, 1000),
        (one_shot(400), 400, 125),
        (one_shot(100), 100, 125),
    ];
    for (params, rate_hz, width_us) in choices {
        let mut bench = Bench::new(&encode(&params));
        bench.run_for(700 * MILLISECOND);
        let said = bench.said();
        assert!(!texts(&said).iter().any(|text| text.contains("jitter")), "{params:?}");
        let pulses = bench.pulses_of_motor_1();
        let (step, period) = (TICKS_PER_S / u64::from(params.loop_rate_hz), TICKS_PER_S / rate_hz);
        // one more or less where the end of the 0.2 s meets the end of a pulse
        assert!((pulses.len() as u64).abs_diff(rate_hz / 5) <= 1, "{params:?}: {}", pulses.len());
        assert!(pulses.iter().all(|pulse| pulse.width == width_us * TICKS_PER_US), "{params:?}");
        assert!(pulses.windows(2).all(|two| two[1].rise - two[0].rise == period), "{params:?}");
        // a pulse rises 500 us after a tick of the loop; the step that begins there takes 50 to 340 us until it is
        // recorded, with those interrupts of the sensors that fall into it
        let step_end = bench.end_of_next_step();
        let later = (pulses[0].rise + 1000 * step.max(period) - step_end) % step.min(period);
        assert!((160..450).contains(&(later / TICKS_PER_US)), "{params:?}: {} us", later / TICKS_PER_US);
    }
}

#[test]
fn unrelated_rates_are_said_to_jitter() {
    let params = Params { pwm_rate_hz: 490, ..Params::DEFAULT };
    let mut bench = Bench::new(&encode(&params));
    bench.run_for(1000 * MILLISECOND);
    assert!(texts(&bench.said()).contains(&"PWM_RATE_HZ and LOOP_RATE_HZ unrelated: jitter"));
    let pulses = bench.pulses_of_motor_1();
    assert_eq!(pulses.len(), 98);
    assert!(pulses.iter().all(|pulse| pulse.width == MILLISECOND));
}
