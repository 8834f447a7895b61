//! The control core as an FMU: `sil-host`'s control side, stepped at its own clock with what the inputs hold.

use shared_control::frames::euler_from_q;
use shared_control::signals::ArmingRequest;
use shared_control::supervisor::Arming;
use sil_host::controller_file::ControllerChoice;
use sil_host::cosim::clock::Clock;
use sil_host::cosim::contract::{DesignParameters, Events, Monitored};
use sil_host::cosim::control_side::ControlSide;
use sil_host::flight::FlightSetup;
use sil_host::model::VehicleModel;
use sil_host::scenario::{Scenario, Waypoint};
use sil_host::sensors::imu;

use crate::behaviour::{Behaviour, Refusal, SAME_TIME_S, START_MAX_S, check_step};
use crate::variable::{Value, Variable};
use crate::vehicle_variables::{SAMPLES, sample_names, which_sample};

/// A controller, and what was chosen for it.
#[derive(Clone)]
pub struct Controller {
    model: VehicleModel,
    places: Vec<Place>,
    choice: String,
    samples_per_step: u64,
    inputs: Inputs,
    start_s: f64,
    /// None until something wants to know, and after every change before the start.
    running: Option<Running>,
}

#[derive(Clone, Copy)]
struct Inputs {
    /// Rate (rad/s) and specific force (m/s²), body axes, the newest first.
    samples: [([f64; 3], [f64; 3]); SAMPLES],
    roll_rad: f64,
    pitch_rad: f64,
    yaw_rate_rad_s: f64,
    throttle: f64,
    arm: bool,
}

#[derive(Clone)]
struct Running {
    control: ControlSide,
    parameters: DesignParameters,
    /// Steps of the core since time 0.
    step: u64,
    time_s: f64,
    outputs: Outputs,
}

#[derive(Clone, Copy, Default)]
struct Outputs {
    commands: [f64; 4],
    is_armed: bool,
    /// As the core believes.
    roll_pitch_rad: [f64; 2],
}

/// What a variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Choice,
    SamplesPerStep,
    Gyro(usize, usize),
    Accelerometer(usize, usize),
    Roll,
    Pitch,
    YawRate,
    Throttle,
    Arm,
    Command(usize),
    Armed,
    Estimate(usize),
}

impl Controller {
    pub(crate) fn new(model: VehicleModel) -> (Self, Vec<Variable>) {
        let at_rest = ([0.0; 3], [0.0, 0.0, -model.gravity_m_s2]);
        let inputs = Inputs {
            samples: [at_rest; SAMPLES],
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rate_rad_s: 0.0,
            throttle: 0.0,
            arm: false,
        };
        let (places, variables) = entries(&inputs).into_iter().unzip();
        let samples_per_step = SAMPLES as u64;
        let choice = "pid".into();
        (Self { model, places, choice, samples_per_step, inputs, start_s: 0.0, running: None }, variables)
    }

    fn running(&mut self) -> Result<&mut Running, Refusal> {
        let running = match self.running.take() {
            Some(running) => running,
            None => self.begin()?,
        };
        Ok(self.running.insert(running))
    }

    fn begin(&self) -> Result<Running, Refusal> {
        if !(0.0..=START_MAX_S).contains(&self.start_s) {
            return Err(format!("start at {} s: the core's clock takes 0 to {START_MAX_S} s", self.start_s));
        }
        let samples =
            u32::try_from(self.samples_per_step).ok().filter(|samples| (1..=SAMPLES as u32).contains(samples));
        let given = self.samples_per_step;
        let samples = samples.ok_or_else(|| format!("imu_samples_per_step = {given}: expected 1 to {SAMPLES}"))?;
        let choice = ControllerChoice::from_argument_or_text(&self.choice);
        let setup = FlightSetup {
            model: self.model.clone(),
            controller_model: None,
            choice: choice.map_err(|error| error.to_string())?,
            scenario: Scenario::test_sequence(),
            seed: 0,
        };
        let own = setup.design_parameters();
        let imu_rate_hz = own.control_rate_hz.saturating_mul(samples);
        let control = setup.control_side_at(imu_rate_hz).map_err(|error| error.to_string())?;
        let step = (self.start_s * f64::from(own.control_rate_hz) - 1e-6).ceil() as u64;
        let parameters = DesignParameters { imu_rate_hz, ..own };
        Ok(Running { control, parameters, step, time_s: self.start_s, outputs: Outputs::default() })
    }
}

impl Running {
    fn step_until(&mut self, until_s: f64, inputs: &Inputs) {
        let rate_hz = u64::from(self.parameters.control_rate_hz);
        loop {
            let now_us = Clock::tick_us(self.step, rate_hz);
            if now_us as f64 * 1e-6 >= until_s - SAME_TIME_S {
                return;
            }
            self.step_core(now_us, inputs);
            self.step += 1;
        }
    }

    fn step_core(&mut self, now_us: u64, inputs: &Inputs) {
        let imu_rate_hz = u64::from(self.parameters.imu_rate_hz);
        let samples = imu_rate_hz / u64::from(self.parameters.control_rate_hz);
        let newest = self.step * samples;
        let mut monitored = Monitored::default();
        // before time 0 there were none
        for age in (0..samples).rev().filter(|age| *age <= newest) {
            let (rate_rad_s, force_m_s2) = inputs.samples[age as usize];
            let sample = imu::quantise(Clock::tick_us(newest - age, imu_rate_hz).min(now_us), rate_rad_s, force_m_s2);
            // a batch takes more than these
            let _ = monitored.imu.push(sample);
        }
        let Inputs { roll_rad, pitch_rad, yaw_rate_rad_s, throttle, .. } = *inputs;
        let waypoint = Waypoint { roll_rad, pitch_rad, yaw_rate_rad_s, ..Waypoint::level(0.0) };
        let arming = if inputs.arm { ArmingRequest::Arm } else { ArmingRequest::None };
        let events = Events::of(waypoint, throttle, arming, false);
        let (output, _) = self.control.step(now_us, &mut monitored, &events);
        let estimate = euler_from_q(&output.estimate.q_world_from_body);
        self.outputs = Outputs {
            commands: output.mix.commands.0.map(f64::from),
            is_armed: !matches!(output.arming, Arming::Disarmed(_)),
            roll_pitch_rad: [estimate.roll_rad, estimate.pitch_rad].map(f64::from),
        };
    }
}

impl Behaviour for Controller {
    fn get(&mut self, place: usize) -> Result<Value, Refusal> {
        let inputs = self.inputs;
        Ok(match self.places[place] {
            Place::Choice => Value::Text(self.choice.clone()),
            Place::SamplesPerStep => Value::Count(self.samples_per_step),
            Place::Gyro(sample, axis) => Value::Float(inputs.samples[sample].0[axis]),
            Place::Accelerometer(sample, axis) => Value::Float(inputs.samples[sample].1[axis]),
            Place::Roll => Value::Float(inputs.roll_rad),
            Place::Pitch => Value::Float(inputs.pitch_rad),
            Place::YawRate => Value::Float(inputs.yaw_rate_rad_s),
            Place::Throttle => Value::Float(inputs.throttle),
            Place::Arm => Value::Boolean(inputs.arm),
            Place::Command(motor) => Value::Float(self.running()?.outputs.commands[motor]),
            Place::Armed => Value::Boolean(self.running()?.outputs.is_armed),
            Place::Estimate(axis) => Value::Float(self.running()?.outputs.roll_pitch_rad[axis]),
        })
    }

    fn set(&mut self, place: usize, value: Value) -> Result<(), Refusal> {
        let inputs = &mut self.inputs;
        match (self.places[place], value) {
            (Place::Choice, Value::Text(choice)) => (self.choice, self.running) = (choice, None),
            (Place::SamplesPerStep, Value::Count(samples)) => (self.samples_per_step, self.running) = (samples, None),
            (Place::Gyro(sample, axis), Value::Float(rate)) => inputs.samples[sample].0[axis] = rate,
            (Place::Accelerometer(sample, axis), Value::Float(force)) => inputs.samples[sample].1[axis] = force,
            (Place::Roll, Value::Float(roll_rad)) => inputs.roll_rad = roll_rad,
            (Place::Pitch, Value::Float(pitch_rad)) => inputs.pitch_rad = pitch_rad,
            (Place::YawRate, Value::Float(rate)) => inputs.yaw_rate_rad_s = rate,
            (Place::Throttle, Value::Float(throttle)) => inputs.throttle = throttle,
            (Place::Arm, Value::Boolean(arm)) => inputs.arm = arm,
            (_, value) => return Err(format!("{value:?} is no value for it")),
        }
        Ok(())
    }

    fn start_at(&mut self, start_s: f64) -> Result<(), Refusal> {
        (self.start_s, self.running) = (start_s, None);
        Ok(())
    }

    fn prepare(&mut self) -> Result<(), Refusal> {
        self.running().map(drop)
    }

    fn step(&mut self, from_s: f64, duration_s: f64) -> Result<(), Refusal> {
        let inputs = self.inputs;
        let running = self.running()?;
        check_step(running.time_s, from_s, duration_s)?;
        running.time_s = from_s + duration_s;
        running.step_until(running.time_s, &inputs);
        Ok(())
    }
}

fn entries(inputs: &Inputs) -> Vec<(Place, Variable)> {
    let choice = "pid, mpc, the path of a controller file, or the text of one (docs/commands.md)";
    let samples = "samples of the IMU that the core gets at each of its steps, 1 to 3";
    let samples_start = Value::Count(SAMPLES as u64);
    let mut entries = vec![
        (Place::Choice, Variable::parameter("controller", "", choice, Value::Text("pid".into()))),
        (Place::SamplesPerStep, Variable::parameter("imu_samples_per_step", "", samples, samples_start)),
    ];
    for sample in 0..SAMPLES {
        for (axis, [gyro, accelerometer]) in sample_names(sample).into_iter().enumerate() {
            let (which, (rate, force)) = (which_sample(sample), inputs.samples[sample]);
            let gyro = Variable::input(gyro, "rad/s", &format!("gyro, {which}"), rate[axis]);
            let accelerometer = Variable::input(accelerometer, "m/s2", &format!("accelerometer, {which}"), force[axis]);
            entries.push((Place::Gyro(sample, axis), gyro.discrete()));
            entries.push((Place::Accelerometer(sample, axis), accelerometer.discrete()));
        }
    }
    let setpoints = [
        (Place::Roll, "roll_reference_rad", "rad", "roll to take"),
        (Place::Pitch, "pitch_reference_rad", "rad", "pitch to take"),
        (Place::YawRate, "yaw_rate_reference_rad_s", "rad/s", "yaw rate to take"),
        (Place::Throttle, "throttle", "", "mean command of the motors, 0 to 1"),
    ];
    for (place, name, unit, what) in setpoints {
        entries.push((place, Variable::input(name.into(), unit, what, 0.0).discrete()));
    }
    let arm = "request to arm: at rest for a second, and at zero throttle, it does";
    let arm = Variable { start: Value::Boolean(false), ..Variable::input("arm".into(), "", arm, 0.0).discrete() };
    entries.push((Place::Arm, arm));
    for motor in 0..4 {
        let what = format!("command to motor {}, 0 to 1", motor + 1);
        let command = Variable::output(format!("motor{}_command", motor + 1), "", &what);
        entries.push((Place::Command(motor), command.discrete()));
    }
    let armed = Variable::output("is_armed".into(), "", "true while the motors may turn").discrete();
    entries.push((Place::Armed, Variable { start: Value::Boolean(false), ..armed }));
    for (axis, angle) in ["roll", "pitch"].into_iter().enumerate() {
        let what = format!("{angle} as the core estimates it");
        let output = Variable::output(format!("{angle}_estimate_rad"), "rad", &what);
        entries.push((Place::Estimate(axis), output.discrete()));
    }
    entries
}
