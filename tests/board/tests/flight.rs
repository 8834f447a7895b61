//! The firmware's own ELF flies the thesis' test sequence, and the host's core repeats every step of it to the bit.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Instant;

use emulated_board::time::{TICKS_PER_US, Ticks};
use emulated_board::{Image, Machine, SecondGyro, Sensor, SensorFault, Surroundings, Vehicle, step_trace};
use mavlink::MessageData;
use mavlink::dialects::common::{COMMAND_LONG_DATA, HEARTBEAT_DATA, MavCmd, MavType};
use shared_control::config::{Config, Controller, Tuning};
use shared_control::flight_core::{FlightCore, State};
use shared_control::imu::AxisMap;
use shared_control::link::frame::FrameWriter;
use shared_control::trace::StepTrace;
use shared_control::vehicle::VehicleParameters;
use sil_host::model::{Rig, VehicleModel};

const LOOP_RATE_HZ: f32 = 400.0;
const IMU_RATE_HZ: f32 = 1000.0;
const MILLISECOND: Ticks = 1000 * TICKS_PER_US;
/// How often the image's memory is looked at; a step takes 2.5 ms.
const LOOK: Ticks = MILLISECOND / 2;
const HEARTBEAT_PERIOD: Ticks = 200 * MILLISECOND;
const ARMED: u32 = 0;

/// The image that `cargo xtask board-test` has built.
fn firmware() -> Image {
    let built = std::env::var_os("FIRMWARE_ELF").map(PathBuf::from).unwrap_or_else(|| {
        let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
        workspace.join("target/thumbv7em-none-eabihf/release/firmware")
    });
    Image::load(&built).unwrap_or_else(|error| panic!("run this by `cargo xtask board-test`: {error}"))
}

/// The ground station on TELEM1.
struct Ground(FrameWriter);

impl Ground {
    fn send(&mut self, machine: &mut Machine, message: &impl MessageData) {
        let mut bytes = heapless::Vec::<u8, 128>::new();
        assert!(self.0.write(message, &mut bytes));
        machine.telem1_send(&bytes);
    }

    fn command(&mut self, machine: &mut Machine, command: MavCmd, param1: f32) {
        let (target_system, target_component) = (1, 1);
        let data = COMMAND_LONG_DATA { command, param1, target_system, target_component, ..COMMAND_LONG_DATA::DEFAULT };
        self.send(machine, &data);
    }

    fn heartbeat(&mut self, machine: &mut Machine) {
        self.send(machine, &HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT });
    }
}

/// The host's core, fed with what the board's core was fed.
struct Twin {
    config: Config,
    state: State,
    steps: u32,
}

impl Twin {
    fn new(controller: Controller, gyro: SecondGyro) -> Self {
        let tuning = Tuning::for_motor_lag(VehicleParameters::F450_GIMBAL_MOTOR_LAG_S);
        let vehicle = &VehicleParameters::F450_GIMBAL;
        let mut config = Config::new(vehicle, &tuning, LOOP_RATE_HZ, IMU_RATE_HZ, controller).unwrap();
        if gyro == SecondGyro::L3gd20h {
            config.imu_second.gyro_axes = AxisMap::PIXHAWK1_L3GD20H;
        }
        Self { config, state: State::default(), steps: 0 }
    }

    fn repeat(&mut self, board: &StepTrace) {
        let input = board.input();
        let output = FlightCore::fast(&self.config, &mut self.state, &input);
        let _ = FlightCore::follow(&self.config, &mut self.state, &output);
        let mut host = StepTrace::EMPTY;
        host.record(&input, &output);
        // samples beyond the count are left over from earlier steps on the board
        host.sample = board.sample;
        host.sample_second = board.sample_second;
        assert_eq!(&host, board, "step {}", board.step);
        self.steps += 1;
    }
}

/// A board in flight with its ground, its vehicle and its twin.
struct Flight {
    machine: Machine,
    vehicle: Rc<RefCell<Vehicle>>,
    ground: Ground,
    twin: Twin,
    trace_address: u32,
    last: StepTrace,
    next_heartbeat: Ticks,
    deviation_sum_rad: [f64; 2],
    /// Samples of both IMUs.
    samples: [u32; 2],
}

impl Flight {
    fn new(seed: u64) -> Self {
        Self::with_second_gyro(SecondGyro::L3gd20, seed)
    }

    fn with_second_gyro(gyro: SecondGyro, seed: u64) -> Self {
        let image = firmware();
        let vehicle = Vehicle::with_second_gyro(&VehicleModel::nominal(Rig::Gimbal), gyro, seed);
        let machine = Machine::new(&image, Box::new(Surroundings(Rc::clone(&vehicle))), seed).unwrap();
        Self {
            machine,
            vehicle,
            ground: Ground(FrameWriter::new(255, 190)),
            twin: Twin::new(Controller::Cascade, gyro),
            trace_address: image.symbol("FLIGHT_TRACE").expect("the firmware's record of its steps"),
            last: StepTrace::EMPTY,
            next_heartbeat: 0,
            deviation_sum_rad: [0.0; 2],
            samples: [0; 2],
        }
    }

    /// Runs for a while, heartbeats going in, every step repeated by the twin.
    fn run_for(&mut self, duration: Ticks) {
        let end = self.machine.now() + duration;
        while self.machine.now() < end {
            if self.machine.now() >= self.next_heartbeat {
                self.next_heartbeat += HEARTBEAT_PERIOD;
                self.ground.heartbeat(&mut self.machine);
            }
            let until = self.machine.now() + LOOK;
            self.machine.run_until(until).unwrap_or_else(|stop| panic!("{stop}"));
            self.look();
        }
    }

    fn look(&mut self) {
        let step = self.machine.word(self.trace_address).unwrap();
        // RAM is noise until the image has started; 0 while a record is being written
        if step == 0 || step == self.last.step || self.machine.counters().exceptions == 0 {
            return;
        }
        let trace = step_trace(&mut self.machine, self.trace_address).unwrap();
        assert_eq!(trace.step, self.last.step + 1, "a step was missed");
        self.twin.repeat(&trace);
        self.last = trace;
        self.samples[0] += trace.samples;
        self.samples[1] += trace.samples_second;
        let [roll, pitch, ..] = trace.setpoint.map(f32::from_bits);
        let tilt_rad = self.vehicle.borrow().tilt_rad();
        for (sum, (wanted, is)) in self.deviation_sum_rad.iter_mut().zip([roll, pitch].into_iter().zip(tilt_rad)) {
            *sum += (f64::from(wanted) - is).abs();
        }
    }
}

/// Boots, calibrates, arms, starts the sequence and lets the vehicle go.
fn in_flight(seed: u64) -> Flight {
    take_off(Flight::new(seed))
}

fn take_off(mut flight: Flight) -> Flight {
    // boot with its sensor power sequence, and gyro calibration at rest
    flight.run_for(3500 * MILLISECOND);
    assert!(flight.twin.steps > 800, "the loop does not run: {} steps", flight.twin.steps);
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
    flight.ground.command(&mut flight.machine, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(100 * MILLISECOND);
    assert_eq!(flight.last.arming, ARMED, "not armed: {:?}", flight.last);
    flight.ground.command(&mut flight.machine, MavCmd::MAV_CMD_MISSION_START, 0.0);
    flight.run_for(60 * MILLISECOND);
    let now = flight.machine.now();
    flight.vehicle.borrow_mut().release(now);
    flight.deviation_sum_rad = [0.0; 2];
    flight.samples = [0; 2];
    flight
}

#[test]
fn the_image_flies_the_test_sequence_as_the_host_does() {
    let mut flight = in_flight(1);
    let (start, steps_before, instructions_before) =
        (Instant::now(), flight.twin.steps, flight.machine.counters().instructions);
    let mut largest_tilt_rad: f64 = 0.0;
    for _ in 0..297 {
        flight.run_for(100 * MILLISECOND);
        largest_tilt_rad = flight.vehicle.borrow().tilt_rad().into_iter().fold(largest_tilt_rad, |m, a| m.max(a.abs()));
    }
    let steps = flight.twin.steps - steps_before;
    let deviation_deg = flight.deviation_sum_rad.map(|sum| (sum / f64::from(steps)).to_degrees());
    let (flown_s, elapsed_s) = (29.7, start.elapsed().as_secs_f64());
    let instructions = (flight.machine.counters().instructions - instructions_before) / u64::from(steps);
    println!("PID: {} steps repeated by the host, 0 bits of difference", flight.twin.steps);
    println!(
        "PID: mean |set-point - angle| {deviation_deg:.2?} deg, {instructions} instructions a step, all tasks together"
    );
    println!("PID: {flown_s} s in {elapsed_s:.1} s, {:.1} times real time", flown_s / elapsed_s);
    // it went to all positions of 30 degrees and stayed near what was asked for; steps of 30 degrees make up most of the mean
    assert!((25.0..45.0).contains(&largest_tilt_rad.to_degrees()), "{}", largest_tilt_rad.to_degrees());
    assert!(deviation_deg.iter().all(|mean| *mean < 5.0), "{deviation_deg:?}");
    // they share a bus and lose nothing: 1000 and 760 samples a second, but for one at each end
    let [first, second] = flight.samples;
    assert!(first.abs_diff(29_700) <= 2 && second.abs_diff(22_572) <= 2, "{first}, {second}");
    // over, hence disarmed
    flight.run_for(250 * MILLISECOND);
    assert_ne!(flight.last.arming, ARMED);
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
    assert_eq!(flight.machine.counters().resets, 0);
}

#[test]
fn a_failing_supply_ends_the_pulses_and_the_board_comes_back_disarmed() {
    let mut flight = in_flight(2);
    flight.run_for(500 * MILLISECOND);
    assert!(flight.vehicle.borrow().commands().iter().all(|command| *command > 0.3));
    let failure = flight.machine.now();
    flight.machine.set_supply_v(2.7);
    flight.machine.run_until(failure + 20 * MILLISECOND).unwrap();
    flight.machine.set_supply_v(3.3);
    // the pulse under way may end, cut or whole; none follows, where a healthy board would have sent seven more
    assert!(flight.vehicle.borrow().last_pulse_end() < failure + 5 * MILLISECOND / 2);
    assert!(flight.machine.counters().resets >= 1);
    // it comes back, disarmed, and does not arm: the record of the fault is unread
    let end = flight.machine.now() + 3000 * MILLISECOND;
    flight.machine.run_until(end).unwrap();
    flight.ground.command(&mut flight.machine, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    let end = flight.machine.now() + 100 * MILLISECOND;
    flight.machine.run_until(end).unwrap();
    let trace = step_trace(&mut flight.machine, flight.trace_address).unwrap();
    assert!(trace.step > 100 && trace.arming != ARMED, "{trace:?}");
    assert_eq!(trace.blocks[0], 1);
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
}

/// How long the loop may take to notice a fault: five steps, and the look at it.
const NOTICED_WITHIN: Ticks = 5 * (5 * MILLISECOND / 2) + LOOK;

#[test]
fn the_second_imu_takes_over_in_flight_and_without_it_the_motors_stop() {
    let faults = [SensorFault::Removed(0xff), SensorFault::DeadBus(0), SensorFault::Frozen, SensorFault::NoDataReady];
    let second = [Sensor::L3gd20, Sensor::Lsm303d, Sensor::L3gd20, Sensor::L3gd20];
    for (seed, (fault, second)) in (3..).zip(faults.into_iter().zip(second)) {
        let mut flight = in_flight(seed);
        flight.run_for(1500 * MILLISECOND);
        assert_eq!((flight.last.imu_unit, flight.last.standby_health), (0, 0));
        flight.machine.break_sensor(Sensor::Mpu6000, fault);
        flight.run_for(NOTICED_WITHIN);
        assert_eq!((flight.last.imu_unit, flight.last.arming), (1, ARMED), "{fault:?}");
        flight.deviation_sum_rad = [0.0; 2];
        let steps_before = flight.twin.steps;
        flight.run_for(3000 * MILLISECOND);
        assert_eq!((flight.last.imu_unit, flight.last.arming), (1, ARMED), "{fault:?}");
        let steps = f64::from(flight.twin.steps - steps_before);
        let deviation_deg = flight.deviation_sum_rad.map(|sum| (sum / steps).to_degrees());
        println!("second IMU after {fault:?}: mean |set-point - angle| {deviation_deg:.2?} deg");
        assert!(deviation_deg.iter().all(|mean| *mean < 5.0), "{fault:?}: {deviation_deg:?}");

        flight.machine.break_sensor(second, fault);
        flight.run_for(NOTICED_WITHIN);
        assert_ne!(flight.last.arming, ARMED, "{fault:?} of {second:?}");
        flight.run_for(5 * MILLISECOND);
        assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
        assert_eq!(flight.machine.counters().resets, 0);
    }
}

#[test]
fn either_second_gyro_flies_alone_when_the_first_imu_is_dead_at_boot() {
    for gyro in [SecondGyro::L3gd20, SecondGyro::L3gd20h] {
        let mut flight = Flight::with_second_gyro(gyro, 11);
        flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0xff));
        let mut flight = take_off(flight);
        flight.run_for(4000 * MILLISECOND);
        assert_eq!((flight.last.imu_unit, flight.last.arming), (1, ARMED), "{gyro:?}");
        let deviation_deg = flight.deviation_sum_rad.map(|sum| (sum / 1600.0).to_degrees());
        println!("{gyro:?} alone: mean |set-point - angle| {deviation_deg:.2?} deg");
        assert!(deviation_deg.iter().all(|mean| *mean < 5.0), "{gyro:?}: {deviation_deg:?}");
    }
}
