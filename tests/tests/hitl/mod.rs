//! `sil hitl` against a board in this process, and against boards that are not there, not ready or not well.

mod board_twin;

use std::io::{Read, Write};

use self::board_twin::BoardTwin;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, HIL_SENSOR_DATA, HilSensorUpdatedFlags, MavCmd, MavType,
};
use shared_control::config::Controller;
use shared_control::params::Params;
use shared_control::sensing::imu_health::ImuFault;
use shared_control::signals::ArmingBlocks;
use shared_control::supervisor::{Arming, DisarmedBecause};
use sil_host::controller_file::{ControllerChoice, TuningChange};
use sil_host::flight::{FlightSetup, RunSummary};
use sil_host::hitl::{self, BoardPort, HitlError, HitlFlight, HitlSetup, Patience};
use sil_host::model::{Rig, VehicleModel};
use sil_host::scenario::Scenario;

const HIL: Params = Params { hil: true, ..Params::DEFAULT };

fn setup() -> HitlSetup {
    HitlSetup { model: VehicleModel::nominal(Rig::Gimbal), seed: 3, rate_hz: 400 }
}

fn fly(stream: impl Read + Write) -> Result<HitlFlight, HitlError> {
    hitl::fly(&mut BoardPort::new(stream, Patience::NONE), &setup(), &mut |_, _| {})
}

fn board() -> BoardTwin {
    BoardTwin::new(&HIL, ArmingBlocks::default())
}

/// The board's motors never turn slower than at idle.
fn as_the_board_idles() -> TuningChange {
    let command = |percent: u8| Some(f32::from(percent) / 100.0);
    TuningChange {
        ground_idle_command: command(HIL.ground_idle_percent),
        flight_idle_command: command(HIL.flight_idle_percent),
        ..TuningChange::default()
    }
}

/// All figures but the computing time.
fn figures(summary: &RunSummary) -> impl PartialEq + std::fmt::Debug {
    (summary.duration_s, summary.axes, summary.effort, summary.saturated_pct)
}

#[test]
fn a_board_in_the_loop_flies_as_the_simulation_does() {
    let flight = fly(board()).unwrap();
    let simulated = FlightSetup {
        model: setup().model,
        controller_model: None,
        choice: ControllerChoice { tuning: as_the_board_idles(), ..ControllerChoice::nominal(Controller::Cascade) },
        scenario: Scenario::test_sequence(),
        seed: 3,
    };
    let simulated = simulated.fly().unwrap().summary;
    let hitl = &flight.summary;
    assert_eq!((hitl.controller, hitl.rate_hz, hitl.rig), ("pid", 400, "gimbal"));
    assert_eq!(hitl.duration_s, simulated.duration_s);
    println!("HITL       {:?}\nsimulation {:?}", figures(hitl), figures(&simulated));
    // what differs: one IMU sample a step instead of three, hence random numbers of its own, more noise through the
    // gyro's filter, and a bias at rest from a third of the samples: 0.01 rad/s / sqrt(600) = 4e-4 rad/s, which the
    // accelerometer leaves as a few tenths of a degree. The response to steps of 30 degrees barely sees that
    for (ours, theirs) in [(hitl.axes.roll, simulated.axes.roll), (hitl.axes.pitch, simulated.axes.pitch)] {
        let near = |a: f64, b: f64| assert!((a - b).abs() <= 0.03 * b, "{a} {b}");
        near(ours.rise_time_s.unwrap(), theirs.rise_time_s.unwrap());
        near(ours.settling_time_s.unwrap(), theirs.settling_time_s.unwrap());
        near(ours.rms_error_deg, theirs.rms_error_deg);
        assert!((ours.overshoot_pct.unwrap() - theirs.overshoot_pct.unwrap()).abs() < 1.0);
        assert!((ours.mean_abs_error_deg - theirs.mean_abs_error_deg).abs() < 0.3);
        assert!((ours.steady_error_deg.unwrap() - theirs.steady_error_deg.unwrap()).abs() < 0.4);
    }
    assert_eq!(flight.sent_again, 0);
    assert!(flight.timing.len() > 12_000);
}

#[test]
fn the_same_seed_flies_the_same_flight_and_lost_answers_are_asked_for_again() {
    let first = fly(board()).unwrap();
    assert_eq!(figures(&fly(board()).unwrap().summary), figures(&first.summary));
    let mut lossy = board();
    lossy.loses = |step| step % 997 == 0;
    let flight = fly(lossy).unwrap();
    // 14 of some 13,000; a step that is sent again makes another step of the board at the same time
    assert!((10..20).contains(&flight.sent_again), "{}", flight.sent_again);
    let (with, without) = (flight.summary.axes.roll.rms_error_deg, first.summary.axes.roll.rms_error_deg);
    assert!((with / without - 1.0).abs() < 0.01, "{with} {without}");
}

/// A stream on which this arrives, and then nothing.
struct Noise(&'static [u8]);

impl Read for Noise {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.0.read(buffer)
    }
}

impl Write for Noise {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn what_is_wrong_is_said() {
    assert!(matches!(fly(Noise(&[])), Err(HitlError::Silent { .. })));
    assert!(matches!(fly(Noise(&[0x55; 300])), Err(HitlError::Garbage { bytes: 300 })));
    let flying_board = BoardTwin::new(&Params::DEFAULT, ArmingBlocks::default());
    assert!(matches!(fly(flying_board), Err(HitlError::NotInHil)));
    let blocks = ArmingBlocks { fault_record_unread: true, ..ArmingBlocks::default() };
    match fly(BoardTwin::new(&HIL, blocks)) {
        Err(HitlError::NotArmed { words }) => assert!(words.contains("fault record"), "{words}"),
        other => panic!("{other:?}"),
    }
    let mut mute = board();
    mute.loses = |_| true;
    assert!(matches!(fly(mute), Err(HitlError::NoAnswer { .. })));
    let mut dies = board();
    // some seconds into the flight
    dies.loses = |step| step > 3000;
    match fly(dies) {
        Err(HitlError::Lost { flown_s, .. }) => assert!((5.0..7.0).contains(&flown_s), "{flown_s}"),
        other => panic!("{other:?}"),
    }
}

/// The ground's end of a bench without a plant: messages written by hand.
struct Bench {
    port: BoardPort<BoardTwin>,
    time_us: u64,
}

impl Bench {
    fn step(&mut self, change: fn(&mut HIL_SENSOR_DATA)) {
        self.time_us += 2500;
        let mut data = HIL_SENSOR_DATA {
            time_usec: self.time_us,
            zacc: -9.81,
            fields_updated: HilSensorUpdatedFlags::all(),
            ..HIL_SENSOR_DATA::DEFAULT
        };
        change(&mut data);
        self.port.send(&HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT }).unwrap();
        self.port.send(&data).unwrap();
    }

    fn armed() -> Self {
        let mut bench = Self { port: BoardPort::new(board(), Patience::NONE), time_us: 0 };
        for _ in 0..800 {
            bench.step(|_| {});
        }
        let arm = COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
            param1: 1.0,
            ..COMMAND_LONG_DATA::DEFAULT
        };
        bench.port.send(&arm).unwrap();
        bench.step(|_| {});
        assert_eq!(bench.port.stream().status.arming, Arming::Armed);
        bench
    }
}

type Change = fn(&mut HIL_SENSOR_DATA);

#[test]
fn input_that_no_imu_could_send_disarms_within_five_steps() {
    let cases: [(Change, ImuFault); 4] = [
        (|data| data.xgyro = f32::NAN, ImuFault::Stale),
        (|data| data.zacc = f32::INFINITY, ImuFault::Stale),
        (|data| data.fields_updated = HilSensorUpdatedFlags::empty(), ImuFault::Stale),
        (|data| data.yacc = -1e30, ImuFault::OutOfRange),
    ];
    for (change, fault) in cases {
        let mut bench = Bench::armed();
        for _ in 0..5 {
            bench.step(change);
        }
        let disarmed = Arming::Disarmed(DisarmedBecause::ImuFailed(fault));
        assert_eq!(bench.port.stream().status.arming, disarmed);
    }
}

#[test]
fn a_clock_that_stands_still_or_goes_back_disarms_within_five_steps() {
    for back_us in [2500, 1_000_000] {
        let mut bench = Bench::armed();
        for _ in 0..5 {
            bench.time_us -= back_us.min(bench.time_us - 2500);
            bench.step(|_| {});
        }
        assert_ne!(bench.port.stream().status.arming, Arming::Armed, "{back_us}");
    }
}
