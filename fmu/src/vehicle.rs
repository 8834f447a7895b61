//! The plant as an FMU, with ideal outputs or seen by its IMU: `sil-host`'s plant and sensors behind variables.
//!
//! ```text
//! commands, disturbance --> plant --> states, outputs        (integrated by itself, or by a foreign integrator)
//!                             '--> IMU, at its own clock     (only with the plant integrating itself)
//! ```

use sil_host::cosim::clock::Clock;
use sil_host::effects::Effect;
use sil_host::model::VehicleModel;
use sil_host::plant::{Plant, Truth};
use sil_host::sensors::Sensors;
use sil_host::sensors::imu;

use crate::behaviour::{Behaviour, Refusal, SAME_TIME_S, START_MAX_S, Stop, check_step, span_s};
use crate::variable::{Value, Variable};
use crate::vehicle_variables::{Choices, Place, SAMPLES, places};

/// Samples of the IMU per second, where nobody says otherwise: three a step of the core at 400 Hz.
pub(crate) const IMU_RATE_HZ: u64 = 1200;

/// A vehicle, and what was chosen for it.
#[derive(Clone)]
pub struct Vehicle {
    model: VehicleModel,
    places: Vec<Place>,
    has_imu: bool,
    choices: Choices,
    inputs: Inputs,
    start_s: f64,
    /// States of the body that were set before the start.
    start_states: Vec<Option<f64>>,
    /// None until something wants to know, and after every change before the start.
    motion: Option<Motion>,
}

#[derive(Clone, Copy, PartialEq)]
struct Inputs {
    commands: [f64; 4],
    torque_body_nm: [f64; 3],
    force_body_n: [f64; 3],
}

/// The vehicle under way.
#[derive(Clone)]
struct Motion {
    plant: Plant,
    imu: Option<Imu>,
    time_s: f64,
    /// Of this very instant.
    truth: Option<Truth>,
    /// Those that the plant got last.
    given_commands: Option<[f64; 4]>,
    /// Has a force from outside ever acted?
    was_pushed: bool,
}

#[derive(Clone)]
struct Imu {
    sensors: Sensors,
    clock: Clock,
    gravity_m_s2: f64,
    /// Rate (rad/s) and specific force (m/s²), body axes, the newest first.
    newest: [([f64; 3], [f64; 3]); SAMPLES],
}

impl Vehicle {
    pub(crate) fn new(model: VehicleModel, has_imu: bool) -> (Self, Vec<Variable>) {
        let plant = Plant::new(&model);
        let choices = Choices { effects: String::new(), seed: 0, imu_rate_hz: IMU_RATE_HZ, released_at_s: 0.0 };
        let (places, variables) = places(&plant, &model, has_imu, &choices).into_iter().unzip();
        let commands = [model.base_command; 4];
        let vehicle = Self {
            places,
            has_imu,
            choices,
            inputs: Inputs { commands, torque_body_nm: [0.0; 3], force_body_n: [0.0; 3] },
            start_s: 0.0,
            start_states: vec![None; plant.body_state_names().len()],
            motion: None,
            model,
        };
        (vehicle, variables)
    }

    fn with_effects(&self) -> Result<VehicleModel, Refusal> {
        let mut model = self.model.clone();
        for short in self.choices.effects.split(';').filter(|short| !short.trim().is_empty()) {
            let effect = Effect::parse_for(short.trim(), model.rig(), model.inertia_kg_m2);
            model.effects.push(effect.map_err(|problem| format!("effects: {problem}"))?);
        }
        Ok(model)
    }

    fn motion(&mut self) -> Result<&mut Motion, Refusal> {
        let motion = match self.motion.take() {
            Some(motion) => motion,
            None => self.begin()?,
        };
        Ok(self.motion.insert(motion))
    }

    fn begin(&self) -> Result<Motion, Refusal> {
        let model = self.with_effects()?;
        let mut plant = Plant::new(&model);
        let mut states = plant.states();
        for (state, start) in states.iter_mut().zip(&self.start_states) {
            *state = start.unwrap_or(*state);
        }
        plant.set_states(&states);
        plant.tidy();
        if plant.states().iter().any(|state| !state.is_finite()) {
            return Err("start values: the quaternion has no length".into());
        }
        // held, its own clock stands, as in `sil fly`
        let own_s = if self.has_imu { (self.start_s - self.choices.released_at_s).max(0.0) } else { self.start_s };
        plant.set_time_s(own_s);
        let imu = if self.has_imu { Some(self.imu(&model)?) } else { None };
        let mut motion =
            Motion { plant, imu, time_s: self.start_s, truth: None, given_commands: None, was_pushed: false };
        motion.disturb(&self.inputs);
        motion.sample_until(self.start_s, &self.inputs, self.choices.released_at_s);
        Ok(motion)
    }

    fn imu(&self, model: &VehicleModel) -> Result<Imu, Refusal> {
        if !(0.0..=START_MAX_S).contains(&self.start_s) {
            return Err(format!("start at {} s: the IMU's clock takes 0 to {START_MAX_S} s", self.start_s));
        }
        let rate_hz = u32::try_from(self.choices.imu_rate_hz).ok().filter(|rate_hz| (1..=8000).contains(rate_hz));
        let rate_hz =
            rate_hz.ok_or_else(|| format!("imu_rate_hz = {}: expected 1 to 8000", self.choices.imu_rate_hz))?;
        let mut clock = Clock::new(rate_hz);
        while clock.next_us() as f64 * 1e-6 < self.start_s - SAME_TIME_S {
            clock.tick(clock.next_us());
        }
        let sensors = Sensors::new(&model.noise, self.choices.seed).with_effects(&model.effects);
        Ok(Imu { sensors, clock, gravity_m_s2: model.gravity_m_s2, newest: [([0.0; 3], [0.0; 3]); SAMPLES] })
    }

    /// Torque and force from outside act from now on.
    fn disturb(&mut self) {
        let inputs = self.inputs;
        if let Some(motion) = &mut self.motion {
            motion.disturb(&inputs);
        }
    }

    /// How many continuous states it has.
    pub(crate) fn state_count(&self) -> usize {
        self.places.iter().filter(|place| matches!(place, Place::State(_))).count()
    }

    /// How large each state typically is.
    pub(crate) fn nominals(&self) -> Vec<f64> {
        let body = self.start_states.len();
        // a motor's speed; all else is of the order of one
        (0..self.state_count()).map(|state| if (body..body + 4).contains(&state) { 1000.0 } else { 1.0 }).collect()
    }

    /// The states, for a foreign integrator.
    pub(crate) fn states(&mut self) -> Result<Vec<f64>, Refusal> {
        Ok(self.motion()?.plant.states())
    }

    /// Takes a foreign integrator's states.
    pub(crate) fn set_states(&mut self, states: &[f64]) -> Result<(), Refusal> {
        let motion = self.motion()?;
        motion.truth = None;
        motion.plant.set_states(states);
        Ok(())
    }

    /// Their rates of change now.
    pub(crate) fn derivatives(&mut self) -> Result<Vec<f64>, Refusal> {
        let motion = self.motion()?;
        Ok(motion.plant.derivatives(motion.time_s))
    }

    /// Takes a foreign integrator's time, s.
    pub(crate) fn set_time_s(&mut self, time_s: f64) -> Result<(), Refusal> {
        let motion = self.motion()?;
        motion.truth = None;
        motion.time_s = time_s;
        Ok(())
    }

    /// Has a foreign integrator's step left something to be put right at a stop?
    pub(crate) fn wants_a_stop(&mut self) -> Result<bool, Refusal> {
        Ok(self.motion()?.plant.needs_tidying())
    }

    /// Stops a foreign integration at its time: what is due takes effect, and so do new commands.
    pub(crate) fn stop(&mut self) -> Result<Stop, Refusal> {
        let inputs = self.inputs;
        let motion = self.motion()?;
        motion.truth = None;
        motion.plant.pass_to(motion.time_s);
        let states_changed = motion.plant.needs_tidying();
        if states_changed {
            motion.plant.tidy();
        }
        if motion.given_commands != Some(inputs.commands) {
            motion.give(inputs.commands);
        }
        Ok(Stop { states_changed, next_s: motion.plant.next_event_s() })
    }
}

impl Motion {
    fn give(&mut self, commands: [f64; 4]) {
        self.plant.set_commands(commands);
        self.given_commands = Some(commands);
        self.truth = None;
    }

    /// Gives the plant the torque and the force from outside. A force of nothing is given only where one was: the plant
    /// computes without one until it has known some.
    fn disturb(&mut self, inputs: &Inputs) {
        self.truth = None;
        self.plant.set_disturbance_torque_body_nm(inputs.torque_body_nm);
        self.was_pushed |= inputs.force_body_n != [0.0; 3];
        if self.was_pushed {
            self.plant.set_disturbance_force_body_n(inputs.force_body_n);
        }
    }

    fn truth(&mut self) -> &Truth {
        let (plant, time_s) = (&self.plant, self.time_s);
        self.truth.get_or_insert_with(|| plant.truth_at(time_s))
    }

    /// Lets time pass, with the IMU's samples on the way.
    fn sample_until(&mut self, until_s: f64, inputs: &Inputs, released_at_s: f64) {
        while let Some(tick_us) = self.imu.as_ref().map(|imu| imu.clock.next_us()) {
            let tick_s = tick_us as f64 * 1e-6;
            if tick_s > until_s + SAME_TIME_S {
                break;
            }
            self.pass_to(tick_s, inputs, released_at_s);
            if let Some(imu) = &mut self.imu {
                imu.sample(&self.plant, tick_us, tick_s < released_at_s - SAME_TIME_S);
            }
        }
        self.pass_to(until_s, inputs, released_at_s);
    }

    /// Before the release what holds the vehicle keeps it where it is.
    fn pass_to(&mut self, until_s: f64, inputs: &Inputs, released_at_s: f64) {
        let free_from_s = self.time_s.max(released_at_s);
        if until_s > free_from_s {
            if self.given_commands.is_none() {
                self.give(inputs.commands);
            }
            self.plant.advance(span_s(free_from_s, until_s));
        }
        self.time_s = until_s;
        self.truth = None;
    }
}

impl Imu {
    fn sample(&mut self, plant: &Plant, tick_us: u64, is_held: bool) {
        let sample = match is_held {
            true => self.sensors.imu_at_rest(self.gravity_m_s2, tick_us),
            false => self.sensors.imu(plant, tick_us),
        };
        self.newest.rotate_right(1);
        self.newest[0] = imu::reading(&sample);
        self.clock.tick(tick_us);
    }
}

impl Behaviour for Vehicle {
    fn get(&mut self, place: usize) -> Result<Value, Refusal> {
        let (place, inputs) = (self.places[place], self.inputs);
        let motion = match place {
            Place::Effects => return Ok(Value::Text(self.choices.effects.clone())),
            Place::Seed => return Ok(Value::Count(self.choices.seed)),
            Place::ImuRate => return Ok(Value::Count(self.choices.imu_rate_hz)),
            Place::Release => return Ok(Value::Float(self.choices.released_at_s)),
            Place::Command(motor) => return Ok(Value::Float(inputs.commands[motor])),
            Place::Torque(axis) => return Ok(Value::Float(inputs.torque_body_nm[axis])),
            Place::Force(axis) => return Ok(Value::Float(inputs.force_body_n[axis])),
            _ => self.motion()?,
        };
        let none = ([f64::NAN; 3], [f64::NAN; 3]);
        let newest = |sample: usize| motion.imu.as_ref().map_or(none, |imu| imu.newest[sample]);
        let value = match place {
            Place::State(state) => motion.plant.states()[state],
            Place::Derivative(state) => motion.plant.derivatives(motion.time_s)[state],
            Place::Gyro(sample, axis) => newest(sample).0[axis],
            Place::Accelerometer(sample, axis) => newest(sample).1[axis],
            Place::Battery => motion.plant.at(motion.time_s).battery_v(),
            of_truth => of_truth.of(motion.truth()),
        };
        Ok(Value::Float(value))
    }

    fn set(&mut self, place: usize, value: Value) -> Result<(), Refusal> {
        match (self.places[place], value) {
            (Place::Effects, Value::Text(text)) => self.choices.effects = text,
            (Place::Seed, Value::Count(seed)) => self.choices.seed = seed,
            (Place::ImuRate, Value::Count(rate_hz)) => self.choices.imu_rate_hz = rate_hz,
            (Place::Release, Value::Float(time_s)) if !time_s.is_nan() => self.choices.released_at_s = time_s,
            (Place::State(state), Value::Float(start)) if start.is_finite() => self.start_states[state] = Some(start),
            (Place::Command(motor), Value::Float(command)) => {
                self.inputs.commands[motor] = command;
                return Ok(());
            }
            (Place::Torque(axis), Value::Float(nm)) if nm.is_finite() => {
                self.inputs.torque_body_nm[axis] = nm;
                self.disturb();
                return Ok(());
            }
            (Place::Force(axis), Value::Float(n)) if n.is_finite() => {
                self.inputs.force_body_n[axis] = n;
                self.disturb();
                return Ok(());
            }
            (_, value) => return Err(format!("{value:?} is no value for it")),
        }
        // what was made of other parameters and start values is of no use any more
        self.motion = None;
        Ok(())
    }

    fn start_at(&mut self, start_s: f64) -> Result<(), Refusal> {
        if !start_s.is_finite() {
            return Err(format!("start at {start_s} s"));
        }
        self.start_s = start_s;
        self.motion = None;
        Ok(())
    }

    fn prepare(&mut self) -> Result<(), Refusal> {
        self.motion().map(drop)
    }

    fn step(&mut self, from_s: f64, duration_s: f64) -> Result<(), Refusal> {
        let (inputs, released_at_s) = (self.inputs, self.choices.released_at_s);
        let motion = self.motion()?;
        check_step(motion.time_s, from_s, duration_s)?;
        // every communication point is one at which commands are given
        motion.given_commands = None;
        motion.sample_until(from_s + duration_s, &inputs, released_at_s);
        let truth = motion.truth();
        if truth.rate_body_rad_s.iter().chain(&truth.position_ned_m).any(|value| !value.is_finite()) {
            return Err(format!("the motion has left the numbers at {} s", motion.time_s));
        }
        Ok(())
    }
}
