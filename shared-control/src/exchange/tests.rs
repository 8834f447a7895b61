//! A core that takes another configuration, beside one that had it from the start.

extern crate std;
use super::*;
use crate::config::Controller;
use crate::elementary::{larger, magnitude};
use crate::flight_core::StepOutput;
use crate::frames::euler_from_q;
use crate::link::{Chore, Order, ParameterRequest};
use crate::mpc::{HORIZON, Mpc, MpcState};
use crate::params::level::LevelParams;
use crate::params::table::Field;
use crate::record::state_words::STATE_WORDS;
use crate::signals::{ArmingRequest, Plan, RawImuSample, Setpoint, StepInput};
use crate::supervisor::{Arming, Refusal};
use std::boxed::Box;
use std::vec::Vec;

/// 2.5 s at 400 Hz: longer than the gyro needs at rest.
const AT_REST: u64 = 1000;
/// Armed, roll asked for, readings that move.
const FLOWN: u64 = 200;

const MPC: Params = Params { controller: Controller::Mpc, control_horizon: 7, ..Params::DEFAULT };

/// A board: its core, its planner, its commander.
struct Board {
    config: Config,
    state: State,
    mpc: Box<Mpc<HORIZON>>,
    mpc_state: Box<MpcState<HORIZON>>,
    plan: Option<Plan>,
    commander: Commander,
    step: u64,
}

fn made(params: &Params) -> (Setup, Box<Mpc<HORIZON>>) {
    let setup = Setup::new(params).unwrap();
    let mpc = Mpc::prepare_shorter(params.control_horizon.into(), &setup.mpc).unwrap();
    (setup, Box::new(mpc))
}

impl Board {
    fn new(params: &Params) -> Self {
        let (setup, mpc) = made(params);
        let commander = Commander::new(&LinkSettings::of(params, 5760), ArmingBlocks::default());
        let (state, mpc_state) = (State::default(), Box::default());
        Self { config: setup.config, state, mpc, mpc_state, plan: None, commander, step: 0 }
    }

    fn take_up(&mut self, params: &Params) -> bool {
        let (setup, mpc) = made(params);
        let next = Exchange::new(params, &setup);
        let taken = next.take_up(&mut self.config, &mut self.state, &mut self.commander);
        if taken {
            self.mpc = mpc;
        }
        taken
    }

    fn step(&mut self, arming: ArmingRequest, setpoint: Setpoint, gyro: i16) -> StepOutput {
        self.step += 1;
        let time_us = 2500 * self.step;
        // the MPU6000 is mounted upside down: 1 g is 4096 counts
        let sample = RawImuSample { time_us, gyro_counts: [gyro, -gyro, 0], accel_counts: [0, 0, -4096] };
        let second = RawImuSample { gyro_counts: [0; 3], ..sample };
        let (imu, imu_second) = ([sample].into_iter().collect(), [second].into_iter().collect());
        let plan = self.plan.take();
        let input = StepInput { time_us, imu, imu_second, arming, setpoint, plan, ..StepInput::default() };
        let (output, plan) = FlightCore::step(&self.config, &self.mpc, &mut self.state, &mut self.mpc_state, &input);
        self.plan = plan;
        output
    }

    fn rest(&mut self, steps: u64) -> Option<StepOutput> {
        (0..steps).map(|_| self.step(ArmingRequest::None, Setpoint::default(), 0)).last()
    }

    /// Arms, and flies with readings that turn to and fro.
    fn fly(&mut self) -> Vec<StepOutput> {
        self.step(ArmingRequest::Arm, Setpoint::default(), 0);
        let setpoint = Setpoint { roll_rad: 0.2, throttle: 0.5, ..Setpoint::default() };
        (0..FLOWN).map(|step| self.step(ArmingRequest::None, setpoint, (step % 40) as i16 * 20 - 400)).collect()
    }

    /// All but how often it was exchanged, which stands last.
    fn words(&self) -> Vec<u32> {
        self.state.words()[..STATE_WORDS - 1].to_vec()
    }
}

/// The larger of the differences in roll and pitch.
fn apart_rad(one: &StepOutput, other: &StepOutput) -> f32 {
    let [one, other] = [one, other].map(|output| euler_from_q(&output.estimate.q_world_from_body));
    larger(magnitude(one.roll_rad - other.roll_rad), magnitude(one.pitch_rad - other.pitch_rad))
}

/// Bit for bit: nothing of the old configuration is left, and nothing of the new one is missing.
#[test]
fn what_is_taken_on_the_ground_flies_as_if_it_had_been_there_from_the_start() {
    use crate::params::vehicle::VehicleNumbers;
    let heavier = VehicleNumbers { inertia_e5_kg_m2: [2000, 2000, 3000], ..VehicleNumbers::DEFAULT };
    let own = VehicleNumbers { flown: crate::params::vehicle::FlownVehicle::Own, ..heavier };
    let choices = [
        MPC,
        Params { vehicle: own, ..Params::DEFAULT },
        Params { flight_idle_percent: 5, ..MPC },
        Params { motor_limits: true, linearisations: 4, vehicle: own, ..MPC },
        Params::DEFAULT,
    ];
    for (from, to) in choices.iter().flat_map(|from| choices.iter().map(move |to| (from, to))) {
        let (mut exchanged, mut from_the_start) = (Board::new(from), Board::new(to));
        exchanged.rest(AT_REST);
        from_the_start.rest(AT_REST);
        assert!(exchanged.take_up(to));
        // what was planned for the old one does not fly either
        let flown = exchanged.fly();
        assert!(flown.iter().any(|output| output.mix.commands.0[0] > 0.2), "it flies");
        let same = from_the_start.fly();
        // plans are those of the step before, and the first was asked for under the old one
        for (step, (one, other)) in flown.iter().zip(&same).enumerate() {
            assert_eq!((one.mix, one.source), (other.mix, other.source), "step {step}: {from:?} {to:?}");
            assert_eq!(one.compare_counts, other.compare_counts);
        }
        assert_eq!(exchanged.state.exchanges(), 1);
        if from.controller == to.controller {
            assert_eq!(exchanged.words(), from_the_start.words(), "{from:?} {to:?}");
        }
    }
}

/// The words of the state are compared whole where the plans' counters agree, so a gain that got lost would show.
#[test]
fn another_vehicle_flies_otherwise() {
    use crate::params::vehicle::{FlownVehicle, VehicleNumbers};
    let numbers = VehicleNumbers { inertia_e5_kg_m2: [2000, 2000, 3000], ..VehicleNumbers::DEFAULT };
    let own = Params { vehicle: VehicleNumbers { flown: FlownVehicle::Own, ..numbers }, ..Params::DEFAULT };
    let [one, other] = [&Params::DEFAULT, &own].map(|params| {
        let mut board = Board::new(params);
        board.rest(AT_REST);
        board.fly()
    });
    assert!(one.iter().zip(&other).any(|(one, other)| one.mix != other.mix));
}

#[test]
fn attitude_and_bias_stay_where_the_sensors_are_the_same() {
    let mut board = Board::new(&Params::DEFAULT);
    let before = board.rest(AT_REST).unwrap();
    assert!(before.arming_refusal.is_none() && before.estimate.valid);
    assert!(board.take_up(&Params { rotor_drag_permille_1_s: 300, ..MPC }));
    let after = board.rest(1).unwrap();
    assert!(after.estimate.valid && after.arming_refusal.is_none(), "{:?}", after.arming_refusal);
    let turned_rad = apart_rad(&before, &after);
    assert!(turned_rad < 1e-5, "{turned_rad} rad");
}

/// An IMU that is now known to sit otherwise has no attitude until it has stood still.
#[test]
fn sensors_that_are_read_otherwise_stand_still_first() {
    let mut board = Board::new(&Params::DEFAULT);
    board.rest(AT_REST);
    let [first, second] = Params::DEFAULT.level;
    let level = [LevelParams { roll_cdeg: 500, ..first }, second];
    assert!(board.take_up(&Params { level, ..Params::DEFAULT }));
    assert_eq!(board.rest(1).unwrap().arming_refusal, Some(Refusal::GyroNotCalibrated));
    let after = board.rest(AT_REST).unwrap();
    let mut from_the_start = Board::new(&Params { level, ..Params::DEFAULT });
    let same = from_the_start.rest(AT_REST).unwrap();
    assert_eq!((after.arming_refusal, same.arming_refusal), (None, None));
    let apart_rad = apart_rad(&after, &same);
    assert!(apart_rad < 1e-4, "{apart_rad} rad");
}

#[test]
fn in_the_air_nothing_is_taken() {
    let mut board = Board::new(&Params::DEFAULT);
    board.rest(AT_REST);
    board.fly();
    let (config, words) = (board.config, board.state.words());
    assert!(!board.take_up(&MPC));
    assert_eq!((board.config, board.state.words()), (config, words));
    board.step(ArmingRequest::Disarm, Setpoint::default(), 0);
    assert!(board.take_up(&MPC));
    assert_eq!(board.config.controller, Controller::Mpc);
}

/// From the order on, which is before anything is stored, until it is reported settled.
#[test]
fn arming_waits_for_what_was_set_before_it() {
    let mut commander = Commander::new(&LinkSettings::NOMINAL, ArmingBlocks::default());
    let set = Order::Parameters(ParameterRequest::Set { field: Field::ControlHorizon, value: 7.0 });
    let read = Order::Parameters(ParameterRequest::Read(Field::ControlHorizon));
    let (_, Some(chore)) = commander.order(&read, 0) else { panic!("a chore") };
    assert!(!chore.changes_parameters());
    for order in [set, Order::CalibrateLevel] {
        let (_, Some(chore)) = commander.order(&order, 0) else { panic!("a chore") };
        assert!(chore.changes_parameters());
        commander.await_change();
    }
    assert!(commander.commands(0).blocks.parameters_waiting);
    commander.settle(1);
    assert!(commander.commands(0).blocks.parameters_waiting, "one of two");
    commander.settle(2);
    assert!(!commander.commands(0).blocks.parameters_waiting);
    // a script sets and arms
    commander.await_change();
    commander.order(&Order::Arm, 0);
    assert_eq!(commander.commands(0).arming, ArmingRequest::None, "it waits");
    commander.settle(3);
    assert_eq!(commander.commands(400_000).arming, ArmingRequest::Arm);
    commander.answer(&Arming::default());
    // and is refused where nothing comes of what was set
    commander.await_change();
    commander.order(&Order::Arm, 500_000);
    assert_eq!(commander.commands(500_000).arming, ArmingRequest::None);
    let after = commander.commands(1_500_000);
    assert!(after.arming == ArmingRequest::Arm && after.blocks.parameters_waiting);
    // armed: it is handed on, and the supervisor has nothing to refuse
    commander.answer(&Arming::Armed);
    assert!(matches!(commander.order(&set, 0), (None, Some(Chore::Parameters(_)))));
}

#[test]
fn a_board_without_radio_and_button_takes_none() {
    use crate::params::radio::RadioParams;
    let params =
        Params { safety_button: true, radio: RadioParams { flies: true, ..RadioParams::DEFAULT }, ..Params::DEFAULT };
    let setup = Setup::new(&params).unwrap();
    for (next, has_one) in
        [(Exchange::new(&params, &setup), true), (Exchange::new(&params, &setup).without_io_chip(), false)]
    {
        let mut commander = Commander::new(&LinkSettings::NOMINAL, ArmingBlocks::default());
        let (mut config, mut state) = (setup.config, State::default());
        assert!(next.take_up(&mut config, &mut state, &mut commander));
        assert_eq!((commander.radio_flies(), commander.commands(0).blocks.safety_on), (has_one, has_one));
    }
}

#[test]
fn what_makes_no_sense_stands_against_arming_until_it_is_mended() {
    use crate::params::Rig;
    use crate::params::vehicle::VehicleNumbers;
    let nameless = Params { rig: Rig::Free, ..Params::DEFAULT };
    let named = Params { vehicle: VehicleNumbers::F450, hover_throttle_permille: 540, ..nameless };
    let mut board = Board::new(&Params::DEFAULT);
    for (params, is_blocked) in [(nameless, true), (named, false)] {
        assert!(board.take_up(&params));
        assert_eq!(board.commander.commands(0).blocks.vehicle_unusable, is_blocked);
    }
}
