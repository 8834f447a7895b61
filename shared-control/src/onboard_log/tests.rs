//! Steps of a core at rest, armed and disarmed, and what the log says of them, read message by message.

extern crate std;

use std::string::String;
use std::vec;
use std::vec::Vec;

use super::*;
use crate::config::{Config, Controller, Tuning};
use crate::flight_core::{FlightCore, State, StepOutput};
use crate::link::Mode;
use crate::params::Params;
use crate::radio::RadioFrame;
use crate::signals::{ArmingRequest, Plan, PlanStatus, RawImuSample, Setpoint, StepInput};
use crate::supervisor::Arming;
use crate::vehicle::VehicleParameters;

const STEP_US: u64 = 2500;
/// Steps before arming, in which the gyro is calibrated.
const REST_STEPS: u64 = 402;
const RADIO: RadioFrame = RadioFrame { channels_us: [1500; 16], count: 8, heard: true };

/// A vehicle at rest that is armed and disarmed on request.
struct Bench<const N: usize> {
    config: Config,
    state: State,
    recorder: Recorder<N>,
    step: u64,
    /// What the recorder was given.
    steps: Vec<(StepInput, StepOutput)>,
}

impl<const N: usize> Bench<N> {
    fn new(controller: Controller) -> Self {
        let vehicle = VehicleParameters::F450_FREE;
        let config = Config::new(&vehicle, &Tuning::for_vehicle(&vehicle), 400.0, 1000.0, controller).unwrap();
        let mut bench = Self { config, state: State::default(), recorder: Recorder::new(), step: 0, steps: vec![] };
        for _ in 0..REST_STEPS {
            bench.step(ArmingRequest::None, 0.0);
        }
        assert_eq!((bench.recorder.stage(), bench.recorder.waiting()), (Stage::Idle, 0));
        bench.steps.clear();
        bench
    }

    /// Two samples a step, of a gyro that shakes a little; in MPC mode with a plan.
    fn step(&mut self, arming: ArmingRequest, roll_rad: f32) {
        let time_us = STEP_US * self.step;
        let sample = |time_us: u64, counts: i16| RawImuSample {
            time_us,
            gyro_counts: [counts, -counts, 0],
            accel_counts: [counts, 0, -4096],
        };
        let shaken = (self.step % 5) as i16;
        let plan = Plan {
            step: self.step as u32,
            status: PlanStatus::Solved,
            iterations: 7,
            duration_us: 300,
            ..Plan::default()
        };
        let input = StepInput {
            time_us,
            imu: [sample(time_us - time_us.min(1000), shaken), sample(time_us, 2 - shaken)].into_iter().collect(),
            arming,
            setpoint: Setpoint { roll_rad, ..Setpoint::default() },
            battery_v: Some(11.5),
            plan: (self.config.controller == Controller::Mpc).then_some(plan),
            ..StepInput::default()
        };
        let output = FlightCore::fast(&self.config, &mut self.state, &input);
        FlightCore::follow(&self.config, &mut self.state, &output);
        self.recorder.record(&self.config, &input, &output, (&RADIO, Mode::Stabilise));
        self.steps.push((input, output));
        self.step += 1;
    }

    fn fly(&mut self, steps: u64) {
        self.step(ArmingRequest::Arm, 0.0);
        assert!(matches!(self.recorder.stage(), Stage::Running { .. }));
        for step in 1..steps {
            self.step(ArmingRequest::None, if step >= steps / 2 { 0.25 } else { 0.0 });
        }
    }

    fn taken(&mut self) -> Vec<u8> {
        let mut bytes = vec![0; self.recorder.waiting()];
        assert_eq!(self.recorder.take(&mut bytes), bytes.len());
        bytes
    }
}

/// Kind and content of each message; what is cut off at the end is left out.
fn messages(mut bytes: &[u8]) -> Vec<(u8, Vec<u8>)> {
    let mut found = vec![];
    while let [low, high, kind, rest @ ..] = bytes {
        let Some(content) = rest.get(..usize::from(u16::from_le_bytes([*low, *high]))) else { break };
        found.push((*kind, content.to_vec()));
        bytes = &rest[content.len()..];
    }
    found
}

/// Content of a topic's messages without the number.
fn data(bytes: &[u8], topic: &ulog::Topic) -> Vec<Vec<u8>> {
    let number = Recorder::<0>::TOPICS.iter().position(|one| one == topic).unwrap() as u16;
    let of_topic = |(kind, content): (u8, Vec<u8>)| {
        (kind == b'D' && content[..2] == number.to_le_bytes()).then(|| content[2..].to_vec())
    };
    messages(bytes).into_iter().filter_map(of_topic).collect()
}

fn time_us(content: &[u8]) -> u64 {
    u64::from_le_bytes(content[..8].try_into().unwrap())
}

fn number(content: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(content[at..at + 4].try_into().unwrap())
}

#[test]
fn what_a_step_gave_out_is_in_the_log_to_the_bit() {
    let mut bench = Bench::<400_000>::new(Controller::Mpc);
    bench.fly(800);
    let log = bench.taken();
    let of_steps = |topic: &ulog::Topic| {
        let found = data(&log, topic);
        assert_eq!(found.len(), bench.steps.len(), "{}", topic.name);
        found.into_iter().zip(&bench.steps)
    };
    for (content, (input, output)) in of_steps(&topics::ANGULAR_VELOCITY) {
        assert_eq!(time_us(&content), input.time_us);
        assert_eq!([16, 20, 24].map(|at| number(&content, at)), <[f32; 3]>::from(output.estimate.rate_body_rad_s));
    }
    for (content, (_, output)) in of_steps(&topics::ATTITUDE) {
        let q = output.estimate.q_world_from_body;
        assert_eq!([16, 20, 24, 28].map(|at| number(&content, at)), [q.w, q.i, q.j, q.k]);
    }
    for (content, (_, output)) in of_steps(&topics::MOTORS) {
        assert_eq!([18, 22, 26, 30].map(|at| number(&content, at)), output.mix.commands.0);
        assert!(number(&content, 34).is_nan() && content.len() == 8 + 8 + 2 + 48);
    }
    for (content, (input, _)) in of_steps(&topics::SENSOR_COMBINED) {
        // both samples of a step together are 2 counts: the mean is one, turned about into body axes
        let one = bench.config.sensing.imu.gyro_rad_s(&RawImuSample { gyro_counts: [1, -1, 0], ..input.imu[0] });
        for (at, expected) in [8, 12, 16].into_iter().zip(one.iter()) {
            assert!((number(&content, at) - expected).abs() <= 1e-9, "{} {expected}", number(&content, at));
        }
        assert_eq!(content[20..24], 2500_u32.to_le_bytes());
    }
    for (content, (_, output)) in of_steps(&topics::MPC) {
        assert_eq!(content[20..24], 300_u32.to_le_bytes());
        assert_eq!((content[32], content[34], content[35]), (7, 0, output.source.number() as u8));
    }
    let setpoints = data(&log, &topics::ATTITUDE_SETPOINT);
    let change = setpoints.iter().find(|content| number(content, 8) != 0.0).unwrap();
    assert_eq!((time_us(change), number(change, 8)), ((REST_STEPS + 400) * STEP_US, 0.25), "when it changes");
    // half of 0.25 rad about the forward axis, at the heading of a vehicle that has not turned
    let q_d = [24, 28, 32, 36].map(|at| number(change, at));
    let expected = [0.125_f32.cos(), 0.125_f32.sin(), 0.0, 0.0];
    assert!(q_d.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-3), "{q_d:?}");
    let radio = &data(&log, &topics::RADIO)[0];
    assert_eq!((&radio[8..10], &radio[40..46]), (&[0xDC, 5][..], &[0, 0, 0, 0, 8, 0][..]));
    assert_eq!([8, 12, 16, 20].map(|at| number(&data(&log, &topics::BATTERY)[0], at)), [11.5, -1.0, -1.0, -1.0]);
    assert_eq!(data(&log, &topics::STATUS)[0][8..], [2, 15, 1, 0, 0, 0], "armed, stabilised");
}

/// The table of this module's first page, on 5 s of each controller: a ring for twice that is more than a test's stack
/// holds.
#[test]
fn a_second_of_log_is_as_long_as_the_page_says() {
    for (controller, bytes_s) in [(Controller::Cascade, 79_000), (Controller::Mpc, 95_000)] {
        let mut bench = Bench::<500_000>::new(controller);
        bench.fly(2000);
        let log = bench.taken();
        assert_eq!((log.len() / 5 + 500) / 1000 * 1000, bytes_s, "{controller:?}");
        let rows = [
            (topics::SENSOR_COMBINED, 2000, 49),
            (topics::ANGULAR_VELOCITY, 2000, 33),
            (topics::ATTITUDE, 2000, 37),
            (topics::MOTORS, 2000, 71),
            (topics::MPC, if controller == Controller::Mpc { 2000 } else { 0 }, 41),
            (topics::ATTITUDE_SETPOINT, 50, 45),
            (topics::RATES_SETPOINT, 250, 37),
            (topics::RADIO, 50, 51),
            (topics::BATTERY, 25, 29),
            (topics::STATUS, 10, 19),
        ];
        for (topic, count, bytes) in rows {
            let found = data(&log, &topic);
            assert!(found.iter().all(|content| content.len() + 5 == bytes), "{}", topic.name);
            assert_eq!(found.len(), count, "{}", topic.name);
        }
        assert_eq!(messages(&log).iter().filter(|(kind, _)| *kind == b'S').count(), 10);
    }
}

/// A ring that is emptied too slowly: what is there is whole steps, and what is not is counted and has its time.
#[test]
fn a_full_ring_leaves_out_whole_steps_and_says_for_how_long() {
    let mut bench = Bench::<3000>::new(Controller::Cascade);
    let mut log = vec![];
    for round in 0..400 {
        bench.step(if round == 0 { ArmingRequest::Arm } else { ArmingRequest::None }, 0.0);
        // a memory that rests for 0.4 s, twice
        if !(100..260).contains(&round) && !(300..380).contains(&round) {
            log.extend(bench.taken());
        }
    }
    log.extend(bench.taken());
    let dropped = bench.recorder.steps_dropped as usize;
    assert!(dropped > 200, "{dropped}");
    for topic in [topics::SENSOR_COMBINED, topics::ANGULAR_VELOCITY, topics::ATTITUDE, topics::MOTORS] {
        assert_eq!(data(&log, &topic).len() + dropped, 400, "{}", topic.name);
    }
    let dropout_ms = |(kind, content): (u8, Vec<u8>)| {
        (kind == b'O').then(|| usize::from(u16::from_le_bytes([content[0], content[1]])))
    };
    let dropouts: Vec<usize> = messages(&log).into_iter().filter_map(dropout_ms).collect();
    // each is cut to whole milliseconds
    let missing_ms = dropped * 25 / 10;
    assert!(dropouts.len() >= 2);
    let said_ms: usize = dropouts.iter().sum();
    assert!(said_ms.abs_diff(missing_ms) <= dropouts.len(), "{dropouts:?} {missing_ms}");
}

#[test]
fn a_log_lasts_from_arming_until_a_second_after_disarming() {
    let mut bench = Bench::<400_000>::new(Controller::Cascade);
    bench.fly(100);
    bench.step(ArmingRequest::Disarm, 0.0);
    let disarmed = bench.step;
    for _ in 0..200 {
        bench.step(ArmingRequest::None, 0.0);
    }
    assert!(matches!(bench.recorder.stage(), Stage::Running { .. }), "half a second later it goes on");
    while bench.recorder.stage() != Stage::Ended {
        bench.step(ArmingRequest::None, 0.0);
    }
    // with the step that disarmed
    assert_eq!(bench.step - disarmed, 399);
    let waiting = bench.recorder.waiting();
    for _ in 0..200 {
        bench.step(ArmingRequest::None, 0.0);
    }
    assert_eq!(bench.recorder.waiting(), waiting, "nothing more is recorded");
    // nobody has closed the file yet: armed again it goes on
    bench.fly(10);
    assert!(bench.recorder.waiting() > waiting);
    bench.recorder.close();
    assert_eq!((bench.recorder.stage(), bench.recorder.waiting()), (Stage::Idle, 0));
}

/// Whatever was written when the supply failed: what is there is the beginning of the whole.
#[test]
fn a_file_cut_off_at_any_byte_is_readable_to_there() {
    let mut file = vec![];
    let params = Params::DEFAULT;
    head(5_000_000, Recorder::<0>::TOPICS, &[("sys_name", "test")], Some(&params), &mut |more: &[u8]| {
        file.extend_from_slice(more);
    });
    let mut bench = Bench::<10_000>::new(Controller::Cascade);
    bench.fly(20);
    file.extend(bench.taken());
    assert_eq!((&file[..8], &file[8..16]), (&b"ULog\x01\x12\x35\x01"[..], &5_000_000_u64.to_le_bytes()[..]));
    let whole = messages(&file[16..]);
    for length in 16..file.len() {
        let found = messages(&file[16..length]);
        let bytes: usize = found.iter().map(|(_, content)| content.len() + 3).sum();
        assert_eq!(found, whole[..found.len()]);
        assert!(found.len() == whole.len() || length - 16 - bytes < 3 + whole[found.len()].1.len());
    }
    let has = |kind: u8, content: &[u8]| whole.iter().any(|message| message.0 == kind && message.1 == content);
    assert!(has(b'F', b"vehicle_attitude:uint64_t timestamp;uint64_t timestamp_sample;float[4] q;"));
    assert!(has(b'A', b"\0\x03\0actuator_motors") && has(b'I', b"\x10char[4] sys_nametest"));
    assert!(has(b'P', b"\x14int32_t LOOP_RATE_HZ\x90\x01\0\0"));
    // motor 3: front left, clockwise
    for (name, value) in [("PX", 1.0), ("PY", -1.0), ("KM", -0.05)] {
        let key: String = std::format!("float CA_ROTOR2_{name}");
        assert!(has(b'P', &[&[key.len() as u8], key.as_bytes(), &f32::to_le_bytes(value)].concat()), "{name}");
    }
}

/// Where somebody looks for failures of motors, and with motor 3 as bit 2; where nobody does there is no such topic.
#[test]
fn a_lost_motor_is_in_the_log_where_somebody_looks_for_it() {
    use crate::motor_loss::{MotorReport, Verdict};
    let vehicle = VehicleParameters::F450_FREE;
    let mut bench = Bench::<100_000>::new(Controller::Cascade);
    bench.fly(400);
    assert!(data(&bench.taken(), &topics::FAILURES).is_empty());
    let tuning = Tuning { motor_loss: true, ..Tuning::for_vehicle(&vehicle) };
    let config = Config::new(&vehicle, &tuning, 400.0, 1000.0, Controller::Cascade).unwrap();
    let lost = MotorReport { verdict: Verdict::Lost, motor: 3, lacks_permille: 900 };
    let mut recorder = Recorder::<100_000>::new();
    for (number, (input, output)) in bench.steps.iter().enumerate() {
        let motors = if number < 50 { MotorReport::default() } else { lost };
        recorder.record(&config, input, &StepOutput { motors, ..*output }, (&RADIO, Mode::Stabilise));
    }
    let mut log = vec![0; recorder.waiting()];
    recorder.take(&mut log);
    let found: Vec<Vec<u8>> = data(&log, &topics::FAILURES).iter().map(|content| content[8..].to_vec()).collect();
    // at the start, when it changes, and once in each of the two halves of a second
    assert_eq!(found, [vec![0, 0, 0], vec![1, 4, 0], vec![1, 4, 0]]);
}

/// What was learnt stands in the log from the step on that is flown with it, and again where another log begins; before
/// there is nothing.
#[test]
fn a_learnt_model_is_in_the_log_from_its_first_step_on() {
    use crate::learning::adoption::LearntModel;
    let mut bench = Bench::<100_000>::new(Controller::Mpc);
    bench.fly(400);
    assert!(data(&bench.taken(), &topics::LEARNT_MODEL).is_empty());
    let models = [1.37, 1.4].map(|roll| LearntModel { gain: [roll, 1.0], lag_s: 0.0065 });
    let mut recorder = Recorder::<300_000>::new();
    for (number, (input, output)) in bench.steps.iter().enumerate() {
        let learnt_model = if number < 50 { None } else { Some(models[usize::from(number >= 60)]) };
        recorder.record(&bench.config, input, &StepOutput { learnt_model, ..*output }, (&RADIO, Mode::Stabilise));
    }
    let mut log = vec![0; recorder.waiting()];
    recorder.take(&mut log);
    let found = data(&log, &topics::LEARNT_MODEL);
    let first_us = bench.steps[0].0.time_us;
    let told: Vec<(u64, f32, f32)> = found
        .iter()
        .map(|content| ((time_us(content) - first_us) / STEP_US, number(content, 8), number(content, 16)))
        .collect();
    // when it is flown first, when it changes, and half a second after the first
    assert_eq!(told, [(50, 1.37, 0.0065), (60, 1.4, 0.0065), (250, 1.4, 0.0065)]);
    assert!(found.iter().all(|content| content.len() + 5 == 25));
}

/// As PX4 numbers them: a vehicle that comes down by itself is in a failsafe, whatever its mode.
#[test]
fn the_status_has_mode_and_failsafe() {
    let status = |arming, mode| {
        let mut bytes = vec![];
        ulog::data(0, 0, &topics::status(&arming, mode), &mut |more: &[u8]| bytes.extend_from_slice(more));
        bytes[13..].to_vec()
    };
    assert_eq!(status(Arming::default(), Mode::Stabilise), [1, 15, 1, 0, 0, 0]);
    assert_eq!(status(Arming::Armed, Mode::Acro), [2, 10, 1, 0, 0, 0]);
    assert_eq!(status(Arming::Armed, Mode::Offboard), [2, 14, 1, 0, 0, 0]);
    assert_eq!(status(Arming::LinkLost { since_us: 1 }, Mode::Offboard), [2, 12, 1, 0, 1, 0]);
}
