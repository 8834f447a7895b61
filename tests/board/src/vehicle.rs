//! The simulated F450 around the board: the plant and the sensors that `sil` flies, driven by the board's own clocks.

use std::cell::RefCell;
use std::rc::Rc;

use shared_control::output::PulseKind;
use sil_host::model::VehicleModel;
use sil_host::plant::{Plant, Truth};
use sil_host::sensors::Sensors;

use crate::delays::Delays;
use crate::devices::esc::{Esc, Traits as EscTraits};
use crate::devices::{Counts, SecondGyro};
use crate::peripherals::timer::Pulse;
use crate::pulses::Pulses;
use crate::seat::Seat;
use crate::second_imu::SecondImu;
use crate::standing::{Standing, TouchDown};
use crate::time::{TICKS_PER_US, Ticks, seconds};
use crate::world::World;

/// Motor (0 to 3) on each channel of TIM1: AUX 1 to 4 are channels 4 to 1.
const MOTOR_OF_CHANNEL: [usize; 4] = [3, 2, 1, 0];

/// Longer than any pulse that is meant.
const LONG_PULSE: Ticks = 2500 * TICKS_PER_US;

/// From one attitude to the other.
const TURN_S: f64 = 0.5;

/// Yaw torque of the air over the rate of a spin, N m s/rad: Mueller and D'Andrea (ICRA 2014) measured 2.75e-3 on a
/// vehicle of 0.5 kg and 0.17 m of arm; in proportion to mass and the arm's square.
const YAW_DRAG_NM_S: f64 = 0.0117;

/// On its way to lie somewhere, or in somebody's hand: roll and pitch.
#[derive(Clone)]
struct Turn {
    begins: Ticks,
    from_rad: [f64; 2],
    to_rad: [f64; 2],
}

/// The vehicle on its rig, which holds it until it is let go.
#[derive(Clone)]
pub struct Vehicle {
    plant: Plant,
    sensors: Sensors,
    second_imu: SecondImu,
    /// Of the first and the second IMU.
    seats: [Seat; 2],
    /// Of the first IMU's accelerometer, body axes, m/s^2.
    accel_offset_m_s2: [f64; 3],
    /// Time up to which the plant has moved.
    moved_to: Ticks,
    held: bool,
    /// Where nothing holds it but the ground.
    standing: Option<Standing>,
    turn: Option<Turn>,
    commands: [f64; 4],
    /// Of whoever pushes, N m.
    pushed_nm: [f64; 3],
    /// Motor without its propeller, 0 to 3.
    lost_propeller: Option<usize>,
    pulses: Pulses,
    recorded: Option<Vec<Pulse>>,
    /// On the lines behind the level shifters.
    line_recorded: Vec<Pulse>,
    escs: [Esc; 4],
    delays: Delays,
}

impl Vehicle {
    /// Held at rest, with the model's sensor noise and ESCs for PWM; the second IMU's gyro is an L3GD20.
    pub fn new(model: &VehicleModel, seed: u64) -> Rc<RefCell<Self>> {
        Self::with_second_gyro(model, SecondGyro::L3gd20, seed)
    }

    /// The same with this variant of that gyro.
    pub fn with_second_gyro(model: &VehicleModel, gyro: SecondGyro, seed: u64) -> Rc<RefCell<Self>> {
        Rc::new(RefCell::new(Self {
            plant: Plant::new(model),
            sensors: Sensors::new(&model.noise, seed).with_effects(&model.effects),
            second_imu: SecondImu::new(gyro, &model.noise, seed),
            seats: [Seat::default(); 2],
            accel_offset_m_s2: [0.0; 3],
            moved_to: 0,
            held: true,
            standing: Plant::new(model).flies_free().then(|| Standing::new(model)),
            turn: None,
            commands: [0.0; 4],
            pushed_nm: [0.0; 3],
            lost_propeller: None,
            pulses: Pulses::new(PulseKind::Pwm),
            recorded: None,
            line_recorded: Vec::new(),
            escs: std::array::from_fn(|_| Esc::new(EscTraits::CAREFUL, 0)),
            delays: Delays::default(),
        }))
    }

    /// Fits ESCs for this kind of pulse.
    pub fn fit_escs(&mut self, pulses: PulseKind) {
        self.pulses = Pulses::new(pulses);
    }

    /// How the first and the second IMU sit from now on; straight at first.
    pub fn seat_imus(&mut self, seats: [Seat; 2]) {
        self.seats = seats;
    }

    /// Where the first IMU sits from now on, from the centre of gravity, body axes, m; in it at first.
    pub fn place_first_imu(&mut self, at_m: [f64; 3]) {
        self.sensors = self.sensors.clone().with_imu_at(at_m);
    }

    /// What the first IMU's accelerometer says too much of from now on, body axes, m/s^2.
    pub fn offset_accelerometer(&mut self, offset_m_s2: [f64; 3]) {
        self.accel_offset_m_s2 = offset_m_s2;
    }

    /// Fits ESCs of another make; power comes to them now.
    pub fn watch_with(&mut self, traits: EscTraits, now: Ticks) {
        self.escs = std::array::from_fn(|_| Esc::new(traits, now));
    }

    /// The ESCs of motors 1 to 4.
    pub fn escs(&mut self) -> &mut [Esc; 4] {
        &mut self.escs
    }

    /// Pulses as the ESCs see them, since power-on: what is longer than 2.5 ms, and everything while pulses are kept.
    pub fn line_pulses(&self) -> &[Pulse] {
        &self.line_recorded
    }

    /// Lets it go, the motors settled at what the ESCs were told last.
    pub fn release(&mut self, now: Ticks) {
        let driven = std::array::from_fn(|motor| if self.escs[motor].turns(now) { self.commands[motor] } else { 0.0 });
        self.plant.set_motor_equilibrium(driven);
        self.moved_to = now;
        self.held = false;
    }

    /// Tips it over to this roll angle within half a second, whatever its motors do; there it lies until it is let go.
    pub fn tip_over(&mut self, roll_rad: f64) {
        self.turn_by_hand([roll_rad, 0.0]);
    }

    /// The same to this roll and pitch.
    pub fn turn_by_hand(&mut self, to_rad: [f64; 2]) {
        self.held = true;
        self.turn = Some(Turn { begins: self.moved_to, from_rad: self.tilt_rad(), to_rad });
    }

    fn turn_on(&mut self, now: Ticks) {
        let Some(Turn { begins, from_rad, to_rad }) = self.turn else { return };
        let share = seconds(now - begins) / TURN_S;
        let way_rad = [to_rad[0] - from_rad[0], to_rad[1] - from_rad[1]];
        let [roll_rad, pitch_rad] = [0, 1].map(|axis| from_rad[axis] + share.min(1.0) * way_rad[axis]);
        let [roll_rad_s, pitch_rad_s] = if share < 1.0 { way_rad.map(|way| way / TURN_S) } else { [0.0; 2] };
        let rate_body_rad_s = [roll_rad_s, pitch_rad_s * roll_rad.cos(), -pitch_rad_s * roll_rad.sin()];
        self.plant.set_attitude([roll_rad, pitch_rad, 0.0], rate_body_rad_s);
        if let Some(standing) = &mut self.standing {
            standing.lay([roll_rad, pitch_rad], rate_body_rad_s);
        }
        if share >= 1.0 {
            self.turn = None;
        }
    }

    /// True roll and pitch, rad.
    pub fn tilt_rad(&self) -> [f64; 2] {
        let truth = self.plant.truth();
        [truth.roll_rad, truth.pitch_rad]
    }

    /// Height of a free vehicle above where it stood, m, and its speed upwards, m/s.
    pub fn height(&self) -> (f64, f64) {
        let truth = self.plant.truth();
        (-truth.position_ned_m[2], -truth.velocity_ned_m_s[2])
    }

    /// Lifts a free vehicle to this height, as it moves.
    pub fn set_height_m(&mut self, height_m: f64) {
        self.plant.set_height_m(height_m);
    }

    /// Does it stand, or lie, or is it held?
    pub fn is_down(&self) -> bool {
        self.held
    }

    /// How a free vehicle met the ground, each time.
    pub fn touched_down(&self) -> &[TouchDown] {
        self.standing.as_ref().map_or(&[], |standing| &standing.touched_down)
    }

    /// A gust pushes: torque about the body axes from now on, N m.
    pub fn push(&mut self, torque_body_nm: [f64; 3]) {
        self.pushed_nm = torque_body_nm;
    }

    /// The propeller of a motor, 0 to 3, flies off; the air then brakes the spin.
    pub fn lose_propeller(&mut self, motor: usize) {
        self.lost_propeller = Some(motor);
        self.leave_out_what_is_lost();
    }

    fn leave_out_what_is_lost(&mut self) {
        if let Some(lost) = self.lost_propeller {
            self.plant.set_lift_left(std::array::from_fn(|motor| if motor == lost { 0.0 } else { 1.0 }));
        }
    }

    /// Rate about the vertical axis of the body, rad/s.
    pub fn spin_rad_s(&self) -> f64 {
        self.plant.truth().rate_body_rad_s[2]
    }

    /// What the ESCs were told last, motors 1 to 4, 0..1.
    pub fn commands(&self) -> [f64; 4] {
        self.commands
    }

    /// What came on the motor outputs.
    pub fn pulses(&self) -> &Pulses {
        &self.pulses
    }

    /// Keeps every pulse that ends from now on.
    pub fn record_pulses(&mut self) {
        self.recorded = Some(Vec::new());
    }

    /// What was kept, in the order of their ends.
    pub fn recorded_pulses(&self) -> &[Pulse] {
        self.recorded.as_deref().unwrap_or_default()
    }

    /// From the ticks of the image's loop to the pulses that follow.
    pub fn delays(&self) -> &Delays {
        &self.delays
    }

    fn move_to(&mut self, now: Ticks) {
        if !self.held && now > self.moved_to {
            let mut torque_nm = self.pushed_nm;
            if self.lost_propeller.is_some() {
                torque_nm[2] -= YAW_DRAG_NM_S * self.plant.rate_body_rad_s()[2];
            }
            self.plant.set_disturbance_torque_body_nm(torque_nm);
            self.plant.advance(seconds(now - self.moved_to));
            if let Some(landed) = self.standing.as_mut().and_then(|standing| standing.meet(&self.plant)) {
                (self.plant, self.held) = (landed, true);
                self.leave_out_what_is_lost();
            }
        }
        self.turn_on(now);
        self.moved_to = now;
    }

    /// What the first or the second IMU feels as it sits: of the air, or of the ground on which it stands.
    fn felt_by(&self, imu: usize) -> Truth {
        let grounded = self.standing.as_ref().filter(|_| self.held);
        let mut truth = grounded.map_or(&self.plant, Standing::rest).truth();
        truth.rate_body_rad_s = self.seats[imu].felt(truth.rate_body_rad_s);
        truth.specific_force_body_m_s2 = self.seats[imu].felt(truth.specific_force_body_m_s2);
        truth
    }
}

/// The vehicle as the board's world; whoever keeps another handle can look at it meanwhile.
pub struct Surroundings(pub Rc<RefCell<Vehicle>>);

impl World for Surroundings {
    fn imu(&mut self, now: Ticks) -> Counts {
        let mut vehicle = self.0.borrow_mut();
        vehicle.move_to(now);
        let mut truth = vehicle.felt_by(0);
        for (force, offset) in truth.specific_force_body_m_s2.iter_mut().zip(vehicle.accel_offset_m_s2) {
            *force += offset;
        }
        let sample = vehicle.sensors.imu_of(&truth);
        Counts { gyro: sample.gyro_counts, accel: sample.accel_counts }
    }

    fn second_gyro(&self) -> Option<SecondGyro> {
        Some(self.0.borrow().second_imu.gyro)
    }

    fn second_imu(&mut self, now: Ticks) -> Counts {
        let mut vehicle = self.0.borrow_mut();
        vehicle.move_to(now);
        let truth = vehicle.felt_by(1);
        vehicle.second_imu.measure(&truth)
    }

    /// An ESC knows its command when the pulse ends.
    fn pulse(&mut self, pulse: Pulse) {
        let mut vehicle = self.0.borrow_mut();
        let (motor, end) = (MOTOR_OF_CHANNEL[pulse.channel], pulse.rise + pulse.width);
        vehicle.move_to(end);
        vehicle.commands[motor] = vehicle.pulses.take(motor, pulse);
        vehicle.delays.pulse(pulse);
        if let Some(recorded) = &mut vehicle.recorded {
            recorded.push(pulse);
        }
        // a motor follows its command while its ESC lets it
        let Vehicle { plant, escs, commands, standing, held, turn, .. } = &mut *vehicle;
        let driven = std::array::from_fn(|motor| if escs[motor].turns(end) { commands[motor] } else { 0.0 });
        if let (true, Some(standing)) = (*held && turn.is_none(), standing) {
            plant.set_motor_equilibrium(driven);
            *held = !standing.leaves(plant);
        }
        plant.set_commands(driven);
    }

    fn line_pulse(&mut self, pulse: Pulse) {
        let mut vehicle = self.0.borrow_mut();
        let width_as_pwm = pulse.width * vehicle.pulses.parts_of_pwm();
        vehicle.escs[MOTOR_OF_CHANNEL[pulse.channel]].pulse(pulse.rise + pulse.width, width_as_pwm);
        if vehicle.recorded.is_some() || pulse.width > LONG_PULSE {
            vehicle.line_recorded.push(pulse);
        }
    }

    fn loop_tick(&mut self, at: Ticks) {
        self.0.borrow_mut().delays.tick(at);
    }
}
