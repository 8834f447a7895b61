//! A board in flight, with its ground, its vehicle and its twin.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use mavlink::dialects::common::{MavCmd, MavParamType, PARAM_SET_DATA};
use shared_control::params::{self, Params, RECORD_LEN};
use shared_control::record::trace::StepTrace;
use shared_control::supervisor::Arming;
use sil_host::model::{Rig, VehicleModel};

use crate::devices::SecondGyro;
use crate::ground::Ground;
use crate::image::Image;
use crate::machine::Machine;
use crate::memory::CCM;
use crate::time::{TICKS_PER_US, Ticks};
use crate::trace::step_trace;
use crate::transmitter::Transmitter;
use crate::twin::Twin;
use crate::vehicle::{Surroundings, Vehicle};

/// A millisecond.
pub const MILLISECOND: Ticks = 1000 * TICKS_PER_US;
/// How often the image's memory is looked at; the shortest step takes 2.5 ms.
pub const LOOK: Ticks = MILLISECOND / 2;
/// As ground stations do with a joystick.
const STICK_PERIOD: Ticks = 40 * MILLISECOND;
const HEARTBEAT_PERIOD: Ticks = 200 * MILLISECOND;
/// Rotors' drag over the mass, 1/s: a third less than the core takes it for.
pub const ROTOR_DRAG_1_S: f64 = 0.3;
/// cortex-m-rt's `STACK_PAINT_VALUE`.
const PAINT: [u8; 4] = [0xcc; 4];

/// All that takes part. Every step of the board is repeated by the host as it happens.
pub struct Flight {
    /// The image that runs.
    pub image: Image,
    /// The board.
    pub machine: Machine,
    /// What it flies.
    pub vehicle: Rc<RefCell<Vehicle>>,
    /// Who commands.
    pub ground: Ground,
    /// The host's core.
    pub twin: Twin,
    /// The pilot's, where there is one.
    pub transmitter: Option<Transmitter>,
    params: Params,
    trace_address: u32,
    last: StepTrace,
    resets_seen: u64,
    next_heartbeat: Ticks,
    heartbeat_period: Ticks,
    muted: bool,
    throttle_stick: Option<i16>,
    next_stick: Ticks,
    deviation_sum_rad: [f64; 2],
    deviation_steps: u32,
    largest_tilt_rad: f64,
    samples: [u32; 2],
}

impl Flight {
    /// At power-on, with the image that `cargo xtask board-test` has built.
    ///
    /// # Panics
    /// Without such an image.
    pub fn new(params: &Params, seed: u64) -> Self {
        Self::with_second_gyro(params, SecondGyro::L3gd20, seed)
    }

    /// The same with this variant of the second IMU's gyro.
    ///
    /// # Panics
    /// As [`Flight::new`].
    pub fn with_second_gyro(params: &Params, gyro: SecondGyro, seed: u64) -> Self {
        let rig = if params.rig == params::Rig::Free { Rig::Free } else { Rig::Gimbal };
        Self::of_model(params, &VehicleModel::nominal(rig).with_rotor_drag(ROTOR_DRAG_1_S), gyro, seed)
    }

    /// The same of any vehicle.
    ///
    /// # Panics
    /// As [`Flight::new`].
    pub fn of_model(params: &Params, model: &VehicleModel, gyro: SecondGyro, seed: u64) -> Self {
        let image = firmware();
        let vehicle = Vehicle::with_second_gyro(model, gyro, seed);
        vehicle.borrow_mut().fit_escs(params.pulses);
        let mut machine = Machine::new(&image, Box::new(Surroundings(Rc::clone(&vehicle))), seed).unwrap();
        machine.configure(params);
        let trace_address = image.symbol("FLIGHT_TRACE").expect("the firmware's record of its steps");
        Self {
            image,
            machine,
            vehicle,
            ground: Ground::default(),
            twin: Twin::new(params, gyro),
            transmitter: None,
            params: *params,
            trace_address,
            last: StepTrace::EMPTY,
            resets_seen: 0,
            next_heartbeat: 0,
            heartbeat_period: HEARTBEAT_PERIOD,
            muted: false,
            throttle_stick: None,
            next_stick: 0,
            deviation_sum_rad: [0.0; 2],
            deviation_steps: 0,
            largest_tilt_rad: 0.0,
            samples: [0; 2],
        }
    }

    /// The same flight once more, with a board, a vehicle and a ground of its own: from here on both go on as each of
    /// them would have alone, so that what comes before need not be flown twice.
    ///
    /// # Panics
    /// If the emulator fails.
    pub fn copy(&self) -> Self {
        let vehicle = Rc::new(RefCell::new(self.vehicle.borrow().clone()));
        let machine = self.machine.copy(Box::new(Surroundings(Rc::clone(&vehicle)))).unwrap();
        let (image, ground, twin) = (self.image.clone(), self.ground.clone(), self.twin.clone());
        Self { image, machine, vehicle, ground, twin, transmitter: self.transmitter.clone(), ..*self }
    }

    /// Boots, calibrates, arms, starts the sequence and lets the vehicle go.
    ///
    /// # Panics
    /// If any of it fails.
    pub fn in_the_air(params: &Params, seed: u64) -> Self {
        let mut flight = Self::new(params, seed);
        flight.take_off();
        flight
    }

    /// The same from power-on.
    ///
    /// # Panics
    /// If any of it fails.
    pub fn take_off(&mut self) {
        // boot with its sensor power sequence, and gyro calibration at rest
        self.run_for(3500 * MILLISECOND);
        let steps = self.twin.steps();
        assert!(steps > 2 * u64::from(self.params.loop_rate_hz), "the loop does not run: {steps} steps");
        assert_eq!(self.vehicle.borrow().commands(), [0.0; 4]);
        self.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        // motors need their time to start
        self.run_for(400 * MILLISECOND);
        assert!(self.is_armed(), "not armed: {:?}, {:?}", self.ground.texts(), self.last);
        self.command(MavCmd::MAV_CMD_MISSION_START, 0.0);
        self.run_for(60 * MILLISECOND);
        let now = self.machine.now();
        self.vehicle.borrow_mut().release(now);
        self.measure_anew();
        self.machine.restart_profile();
    }

    /// From power-on by radio: armed by the sticks, half throttle, let go.
    ///
    /// # Panics
    /// If any of it fails, or there is no transmitter.
    pub fn take_off_by_radio(&mut self) {
        const THROTTLE: usize = 3;
        const YAW: usize = 4;
        self.run_for(3500 * MILLISECOND);
        self.set_stick(YAW, 2000);
        self.run_for(1500 * MILLISECOND);
        assert!(self.is_armed(), "not armed: {:?}, {:?}", self.ground.texts(), self.last);
        self.set_stick(YAW, 1500);
        self.set_stick(THROTTLE, 1500);
        self.run_for(60 * MILLISECOND);
        let now = self.machine.now();
        self.vehicle.borrow_mut().release(now);
        self.measure_anew();
        self.machine.restart_profile();
    }

    /// Moves a stick or a switch of the transmitter; channels count from 1.
    ///
    /// # Panics
    /// If there is no transmitter.
    pub fn set_stick(&mut self, channel: usize, pulse_us: u16) {
        self.transmitter.as_mut().expect("a transmitter").set(channel, pulse_us);
    }

    /// The ground sends a command.
    pub fn command(&mut self, command: MavCmd, param1: f32) {
        self.ground.command(&mut self.machine, command, param1);
    }

    /// The record in the board's memory.
    fn stored(&self) -> [u8; RECORD_LEN] {
        let mut record = [0; RECORD_LEN];
        record.copy_from_slice(&self.machine.read_fram(0, RECORD_LEN));
        record
    }

    /// Other choices in the memory of a board that has not run yet.
    ///
    /// # Panics
    /// If they can't be flown with.
    pub fn configure(&mut self, params: &Params) {
        self.machine.configure(params);
        self.params = *params;
        self.twin.restart(params);
    }

    /// What the board flies with now.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// The ground sets a parameter and is told its value.
    ///
    /// # Panics
    /// If the board says another value, or none.
    pub fn set_parameter(&mut self, name: &str, param_value: f32) {
        let (param_id, param_type) = (name.into(), MavParamType::MAV_PARAM_TYPE_REAL32);
        let data = PARAM_SET_DATA { param_value, target_system: 1, target_component: 1, param_id, param_type };
        self.ground.send(&mut self.machine, &data);
        self.run_for(100 * MILLISECOND);
        assert_eq!(self.ground.parameter(name), Some(param_value), "{name}: {:?}", self.ground.texts());
    }

    /// The ground has the board start anew; back with its gyro calibrated.
    ///
    /// # Panics
    /// If it does not start once.
    pub fn restart_board(&mut self) {
        let resets = self.machine.counters().resets;
        self.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
        self.run_for(3500 * MILLISECOND);
        assert_eq!(self.machine.counters().resets, resets + 1, "{:?}", self.ground.texts());
    }

    /// The ground goes away without a word.
    pub fn mute(&mut self) {
        self.muted = true;
    }

    /// And comes back.
    pub fn unmute(&mut self) {
        self.muted = false;
    }

    /// Somebody holds the throttle stick there from now on, 0 to 1000, the others in their middle.
    pub fn hold_throttle(&mut self, throttle: i16) {
        self.throttle_stick = Some(throttle);
    }

    /// The ground sends a heartbeat so often; every 0.2 s at first.
    pub fn set_heartbeat_period(&mut self, period: Ticks) {
        self.heartbeat_period = period;
    }

    /// Runs for a while, heartbeats going in, every step repeated by the twin.
    ///
    /// # Panics
    /// If the board stops, or a bit differs.
    pub fn run_for(&mut self, duration: Ticks) {
        let end = self.machine.now() + duration;
        while self.machine.now() < end {
            if !self.muted && self.machine.now() >= self.next_heartbeat {
                self.next_heartbeat = self.machine.now() + self.heartbeat_period;
                self.ground.heartbeat(&mut self.machine);
            }
            if let (false, Some(throttle)) = (self.muted, self.throttle_stick)
                && self.machine.now() >= self.next_stick
            {
                self.next_stick = self.machine.now() + STICK_PERIOD;
                self.ground.sticks(&mut self.machine, throttle);
            }
            if let Some(transmitter) = &mut self.transmitter {
                transmitter.send(&mut self.machine);
            }
            let until = (self.machine.now() + LOOK).min(end);
            self.machine.run_until(until).unwrap_or_else(|stop| panic!("{stop}"));
            self.ground.listen(&mut self.machine);
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
        let resets = self.machine.counters().resets;
        if resets != self.resets_seen && trace.step == 1 {
            self.resets_seen = resets;
            self.params = params::load(&self.stored()).0;
            self.twin.restart(&self.params);
        } else {
            assert_eq!(trace.step, self.last.step + 1, "a step was missed");
            if trace.exchanges != self.last.exchanges {
                self.params = self.params.with_what_counts_of(&params::load(&self.stored()).0);
                self.twin.take_up(&self.params);
            }
            let ([times, step], [before, _]) = (trace.taught, self.last.taught);
            if times != before {
                self.twin.learn(step);
            }
        }
        self.twin.repeat(&trace);
        self.last = trace;
        self.measure();
    }

    fn measure(&mut self) {
        let [roll, pitch, ..] = self.last.setpoint.map(f32::from_bits);
        let tilt_rad = self.vehicle.borrow().tilt_rad();
        for (sum, (wanted, is)) in self.deviation_sum_rad.iter_mut().zip([roll, pitch].into_iter().zip(tilt_rad)) {
            *sum += (f64::from(wanted) - is).abs();
            self.largest_tilt_rad = self.largest_tilt_rad.max(is.abs());
        }
        self.deviation_steps += 1;
        self.samples[0] += self.last.samples;
        self.samples[1] += self.last.samples_second;
    }

    /// Starts [`Flight::deviation_deg`] and [`Flight::samples`] again.
    pub fn measure_anew(&mut self) {
        (self.deviation_sum_rad, self.deviation_steps, self.samples) = ([0.0; 2], 0, [0; 2]);
    }

    /// Samples of the first and the second IMU since the vehicle was let go.
    pub fn samples(&self) -> [u32; 2] {
        self.samples
    }

    /// The last step that was repeated.
    pub fn last(&self) -> &StepTrace {
        &self.last
    }

    /// Did the last step leave the motors to the controllers?
    pub fn is_armed(&self) -> bool {
        self.last.arming == Arming::Armed.number()
    }

    /// Mean difference between set-point and true angle since the vehicle was let go, roll and pitch, degrees.
    pub fn deviation_deg(&self) -> [f64; 2] {
        self.deviation_sum_rad.map(|sum| (sum / f64::from(self.deviation_steps)).to_degrees())
    }

    /// Largest roll or pitch so far, degrees.
    pub fn largest_tilt_deg(&self) -> f64 {
        self.largest_tilt_rad.to_degrees()
    }

    /// Most bytes of stack that were ever in use, by the paint that the image's start leaves over all of it.
    ///
    /// # Panics
    /// Never: the memory is there.
    pub fn stack_used_bytes(&mut self) -> usize {
        let stack = self.machine.bytes(CCM.start, CCM.size as usize).unwrap();
        let painted = stack.chunks_exact(4).take_while(|word| **word == PAINT).count();
        stack.len() - 4 * painted
    }

    /// A counter of the image, by the name of its static.
    ///
    /// # Panics
    /// If it has none of that name.
    pub fn counter(&mut self, name: &str) -> u32 {
        let address = self.image.symbol_that_contains(name).unwrap_or_else(|| panic!("no static {name}"));
        self.machine.word(address).unwrap()
    }
}

fn firmware() -> Image {
    let built = std::env::var_os("FIRMWARE_ELF").map(PathBuf::from).unwrap_or_else(|| {
        let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
        workspace.join("target/thumbv7em-none-eabihf/release/firmware")
    });
    Image::load(&built).unwrap_or_else(|error| panic!("run this by `cargo xtask board-test`: {error}"))
}
