//! From the owner's choices to everything that flies: the vehicle, its tuning, the configuration of the core, the MPC's
//! problem and the two timers.

use crate::config::{self, Config, ConfigError, Controller, Tuning};
use crate::mpc::MpcSettings;
use crate::mpc::motor_limits::COUPLED_INPUTS_MAX;
use crate::output::{LOOP_TIMER_HZ, OutputConfig, PULSE_TIMER_HZ, PulseKind, TimerPeriod};
use crate::params::table::Field;
use crate::params::vehicle::{FlownVehicle, VehicleFault};
use crate::params::{Params, Rig};
use crate::radio::{RadioFault, RadioSetup};
use crate::sensing::imu::L3GD20_RATE_HZ;
use crate::sensing::rotor_notches::NotchesConfig;
use crate::supervisor::SupervisorConfig;
use crate::supervisor::battery_watch::BatteryLimits;
use crate::supervisor::touchdown::LOST_TO_DIPS;
use crate::vehicle::VehicleParameters;

/// Samples of the board's IMU per second.
pub const IMU_RATE_HZ: u32 = 1000;

/// Mean share of the hovering lift with which a vehicle that lost its link comes down.
const SINK_LIFT_SHARE: f32 = 0.9;

/// Work that the board has a second for plans of the motors' limits, in units of [`crate::qp::Settings::work_limit`]:
/// with the rest of the dearest plan it is two thirds of a step at 400 Hz (`docs/solver.md`).
pub const COUPLED_WORK_PER_S: usize = 8_000_000;

/// What a set of choices means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// What the controllers know of the vehicle.
    pub vehicle: VehicleParameters,
    /// Gains.
    pub tuning: Tuning,
    /// Configuration of the core.
    pub config: Config,
    /// The MPC's problem; its control horizon is in the choices.
    pub mpc: MpcSettings,
    /// The loop's timer, which counts [`LOOP_TIMER_HZ`].
    pub loop_timer: TimerPeriod,
    /// The pulses' timer, which counts [`PULSE_TIMER_HZ`].
    pub pulse_timer: TimerPeriod,
    /// The radio, where it flies; or what makes no sense about its calibration.
    pub radio: Result<Option<RadioSetup>, RadioFault>,
    /// What makes no sense about the owner's vehicle, or is missing of it; the F450 then stands in for it, and nothing
    /// may arm.
    pub vehicle_fault: Option<VehicleFault>,
}

impl Setup {
    /// What these choices mean. The pilot's part, the throttle for hovering, goes to the link
    /// ([`crate::link::LinkSettings`]).
    ///
    /// # Errors
    /// Names a value out of its range. Choices out of a record ([`crate::params::decode`]) have none.
    pub fn new(params: &Params) -> Result<Setup, ConfigError> {
        let loop_rate_hz = f32::from(params.loop_rate_hz);
        // with hardware in the loop every step brings its one sample
        let imu_rate_hz = if params.hil { loop_rate_hz } else { IMU_RATE_HZ as f32 };
        let mut setup = Self::at_rates(params, loop_rate_hz, imu_rate_hz)?;
        // at 100 Hz ten samples a step of each IMU would take the time until the pulses
        if params.gyro_notches && !params.hil && params.loop_rate_hz == 400 {
            setup.config.sensing.imu.gyro_notches = Some(NotchesConfig::new(imu_rate_hz));
            setup.config.sensing.imu_second.gyro_notches = Some(NotchesConfig::new(L3GD20_RATE_HZ));
        }
        Ok(setup)
    }

    /// The same for a core that somebody else gives the time, as a simulator does: `loop_rate_hz` in place of the
    /// choices' own, with so many samples of the IMU a second, and without notches. The timers are the choices'.
    ///
    /// # Errors
    /// As [`Setup::new`], and for rates that the core cannot keep ([`Config::new`]).
    pub fn at_rates(params: &Params, loop_rate_hz: f32, imu_rate_hz: f32) -> Result<Setup, ConfigError> {
        for field in Field::ALL {
            let row = field.row();
            if !row.allowed.contains(params.get(field)) {
                return Err(ConfigError::OutOfRange(row.name));
            }
        }
        let (vehicle, vehicle_fault) = vehicle(params);
        let tuning = tuning(params, &vehicle);
        let loop_timer = TimerPeriod::new(LOOP_TIMER_HZ, params.loop_rate_hz.into());
        let pulse_timer = TimerPeriod::new(PULSE_TIMER_HZ, pulse_rate_hz(params).into());
        let mut core = Config::new(&vehicle, &tuning, loop_rate_hz, imu_rate_hz, params.controller)?;
        let [first, second] = params.level.map(|level| level.trim().mounting());
        (core.sensing.imu.mounting, core.sensing.imu_second.mounting) = (first, second);
        core.sensing.estimator.levelling.rotor_drag_1_s = f32::from(params.rotor_drag_permille_1_s) / 1000.0;
        let config = Config {
            output: OutputConfig::new(params.pulses, PULSE_TIMER_HZ, &pulse_timer),
            supervisor: SupervisorConfig {
                battery_arming_min_v: f32::from(params.battery.arming_min_mv) / 1000.0,
                battery: BatteryLimits {
                    low_v: f32::from(params.battery.low_mv) / 1000.0,
                    critical_v: f32::from(params.battery.critical_mv) / 1000.0,
                    after_us: u64::from(params.battery.timer_s) * 1_000_000,
                },
                sink_throttle: sink_throttle(params, &vehicle),
                ..SupervisorConfig::NOMINAL
            },
            touchdown: core.touchdown.hovering_with(hover_lift_n(params, &vehicle)),
            ..core
        };
        let mpc = config::mpc_settings(&vehicle, &tuning, loop_rate_hz);
        let radio = if params.radio.flies { RadioSetup::new(&params.radio).map(Some) } else { Ok(None) };
        Ok(Setup { vehicle, tuning, config, mpc, loop_timer, pulse_timer, radio, vehicle_fault })
    }

    /// Does every pulse begin at the same time after the step that computed it? Where one of the two rates is a whole
    /// multiple of the other; else the delay goes through all values from nothing to a whole period of the pulses.
    pub fn pulses_keep_phase(&self) -> bool {
        let cycles_per_count = PULSE_TIMER_HZ / LOOP_TIMER_HZ;
        let (step, pulse) = (cycles_per_count * self.loop_timer.cycles(), self.pulse_timer.cycles());
        step.is_multiple_of(pulse) || pulse.is_multiple_of(step)
    }
}

/// The tuning for a vehicle by these choices: for the one that they name, or for the same as flights have corrected it
/// ([`Proposal`](crate::learning::proposal::Proposal)).
pub fn tuning(params: &Params, vehicle: &VehicleParameters) -> Tuning {
    Tuning {
        mpc_motor_limits: params.motor_limits && usize::from(params.control_horizon) <= COUPLED_INPUTS_MAX,
        mpc_work_limit: COUPLED_WORK_PER_S / usize::from(params.loop_rate_hz.max(1)),
        mpc_linearisations: params.linearisations.into(),
        motor_loss: params.motor_loss,
        learning: params.learning && params.controller == Controller::Mpc,
        ground_idle_command: f32::from(params.ground_idle_percent) / 100.0,
        flight_idle_command: f32::from(params.flight_idle_percent) / 100.0,
        ..Tuning::for_flight(vehicle, params.controller, params.mpc_quick)
    }
}

/// The vehicle that these choices name, or the one that stands in for it.
pub fn flown_vehicle(params: &Params) -> VehicleParameters {
    vehicle(params).0
}

/// The owner's vehicle, if it is to be flown and makes sense; else the F450 on its rig, and what does not.
fn vehicle(params: &Params) -> (VehicleParameters, Option<VehicleFault>) {
    let f450 = match params.rig {
        Rig::Gimbal => VehicleParameters::F450_GIMBAL,
        Rig::Free => VehicleParameters::F450_FREE,
    };
    match params.vehicle.flown {
        FlownVehicle::F450 => return (f450, None),
        // a simulated vehicle hurts nobody
        FlownVehicle::Unnamed if params.rig == Rig::Gimbal || params.hil => return (f450, None),
        FlownVehicle::Unnamed => return (f450, Some(VehicleFault::Missing)),
        FlownVehicle::Own => {}
    }
    match params.vehicle.vehicle(params.rig, f32::from(params.hover_throttle_permille) / 1000.0) {
        Ok(vehicle) => (vehicle, None),
        Err(fault) => (f450, Some(fault)),
    }
}

/// Throttle at which the vehicle loses height slowly: in the mean, dips included, nine tenths of the lift that holds
/// it. A rotor that sinks gives more lift at the same speed (Leishman, Principles of Helicopter Aerodynamics, 2nd ed.,
/// 2.13 and 3.3: blade elements and momentum), so that a tenth too little ends as a steady 2 m/s for rotors of 10
/// inches, not as a fall. 0 on a rig.
fn sink_throttle(params: &Params, vehicle: &VehicleParameters) -> f32 {
    let share = SINK_LIFT_SHARE / (1.0 - LOST_TO_DIPS);
    vehicle.lift_curve.command(share * hover_lift_n(params, vehicle))
}

/// Lift of each motor that holds the vehicle in the air, N; none does on a rig.
fn hover_lift_n(params: &Params, vehicle: &VehicleParameters) -> f32 {
    match params.rig {
        Rig::Gimbal => 0.0,
        Rig::Free => vehicle.lift_curve.lift(f32::from(params.hover_throttle_permille) / 1000.0),
    }
}

/// Pulses per second and motor.
fn pulse_rate_hz(params: &Params) -> u16 {
    match params.pulses {
        PulseKind::Pwm => params.pwm_rate_hz,
        PulseKind::OneShot125 => params.loop_rate_hz,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpc::{HORIZON, Mpc};
    use crate::params::tests::any_params;
    use proptest::prelude::*;

    proptest! {
        /// The board depends on it: nobody sees a message when it starts.
        #[test]
        fn all_choices_that_a_record_can_hold_can_be_flown(params in any_params()) {
            let setup = Setup::new(&params).unwrap();
            prop_assert_eq!(setup.config.controller, params.controller);
            prop_assert_eq!(setup.config.loop_rate_hz, f32::from(params.loop_rate_hz));
            prop_assert_eq!(setup.config.output.kind, params.pulses);
            let drag_1_s = setup.config.sensing.estimator.levelling.rotor_drag_1_s;
            prop_assert!((drag_1_s * 1000.0 - f32::from(params.rotor_drag_permille_1_s)).abs() < 0.01);
            let minimum_mv = setup.config.supervisor.battery_arming_min_v * 1000.0;
            prop_assert!((minimum_mv - f32::from(params.battery.arming_min_mv)).abs() < 0.01);
            let battery = setup.config.supervisor.battery;
            prop_assert!((battery.critical_v * 1000.0 - f32::from(params.battery.critical_mv)).abs() < 0.01);
            prop_assert_eq!(battery.after_us, u64::from(params.battery.timer_s) * 1_000_000);
            let free = params.rig == Rig::Free;
            prop_assert_eq!((setup.vehicle.yaw_locked, setup.config.angle.yaw_locked), (!free, !free));
        }
    }

    /// The two ends of what the guards let pass, on both rigs: the controllers can be made, too.
    #[test]
    fn every_vehicle_that_makes_sense_can_be_prepared() {
        use crate::params::vehicle::VehicleNumbers;
        let own = VehicleNumbers { flown: FlownVehicle::Own, ..VehicleNumbers::DEFAULT };
        let heavy = VehicleNumbers { mass_g: 3300, inertia_e5_kg_m2: [33_000, 33_000, 36_000], arm_mm: 226, ..own };
        let light = VehicleNumbers { inertia_e5_kg_m2: [150, 150, 250], ..own };
        let slow = VehicleNumbers { lag_e4_s: 2000, delay_e4_s: 300, ..own };
        for (numbers, rig) in [(own, Rig::Free), (heavy, Rig::Gimbal), (light, Rig::Free), (slow, Rig::Free)] {
            let params = Params { vehicle: numbers, rig, hover_throttle_permille: 540, ..Params::DEFAULT };
            let setup = Setup::new(&params).unwrap();
            assert_eq!(setup.vehicle_fault, None, "{numbers:?}");
            assert_eq!(setup.vehicle, numbers.vehicle(rig, 0.54).unwrap());
            assert!(Mpc::<HORIZON>::prepare_shorter(5, &setup.mpc).is_ok(), "{numbers:?}");
        }
        let senseless = VehicleNumbers { mass_g: 9000, ..own };
        let setup = Setup::new(&Params { vehicle: senseless, rig: Rig::Free, ..Params::DEFAULT }).unwrap();
        assert_eq!((setup.vehicle_fault, setup.vehicle), (Some(VehicleFault::TooWeak), VehicleParameters::F450_FREE));
    }

    /// Another vehicle must not leave the ground with the F450's gains because nobody has said which it is.
    #[test]
    fn a_free_vehicle_that_nobody_has_named_does_not_arm() {
        use crate::params::vehicle::VehicleNumbers;
        let fault = |params: &Params| Setup::new(params).unwrap().vehicle_fault;
        let free = Params { rig: Rig::Free, ..Params::DEFAULT };
        assert_eq!(fault(&free), Some(VehicleFault::Missing));
        assert_eq!(fault(&Params { vehicle: VehicleNumbers::F450, ..free }), None);
        assert_eq!(fault(&Params { hil: true, ..free }), None);
        assert_eq!(fault(&Params::DEFAULT), None);
    }

    /// What a bench of host code flies, with the idle commands of motors that have a dead band.
    #[test]
    fn the_defaults_are_what_the_core_flies_on_the_host_but_for_idling_and_notches() {
        let vehicle = VehicleParameters::F450_GIMBAL;
        let tuning = Tuning { ground_idle_command: 0.1, flight_idle_command: 0.15, ..Tuning::for_vehicle(&vehicle) };
        let config = Config::new(&vehicle, &tuning, 400.0, 1000.0, Controller::Cascade).unwrap();
        let has_notches = |params: &Params| Setup::new(params).unwrap().config.sensing.imu.gyro_notches.is_some();
        assert!(has_notches(&Params::DEFAULT) && !has_notches(&Params { loop_rate_hz: 100, ..Params::DEFAULT }));
        assert!(!has_notches(&Params { hil: true, ..Params::DEFAULT }));
        let setup = Setup::new(&Params { gyro_notches: false, ..Params::DEFAULT }).unwrap();
        assert_eq!(setup.config, config);
        assert_eq!(setup.mpc, config::mpc_settings(&vehicle, &tuning, 400.0));
        assert!((setup.config.mixer.lift_curve.command_at[0] - 0.15).abs() < 1e-6);
    }

    /// The rig holds its vehicle; the free one sinks with nine tenths of what holds it, to what the table of the
    /// lift curve rounds.
    #[test]
    fn only_a_vehicle_that_could_fall_sinks() {
        let throttle = |rig| {
            let params = Params { rig, hover_throttle_permille: 540, ..Params::DEFAULT };
            Setup::new(&params).unwrap().config.supervisor.sink_throttle
        };
        assert_eq!(throttle(Rig::Gimbal), 0.0);
        let curve = VehicleParameters::F450_FREE.lift_curve;
        let sinks = curve.lift(throttle(Rig::Free)) / curve.lift(0.54);
        assert!((sinks * (1.0 - LOST_TO_DIPS) - SINK_LIFT_SHARE).abs() < 1e-4, "{sinks}");
    }

    /// The parameter is the quick tuning, with the owner's choices beside it, and leaves the cascade as it is.
    #[test]
    fn quick_is_of_the_mpc() {
        let of = |controller, mpc_quick| {
            let params = Params { controller, mpc_quick, linearisations: 3, ..Params::DEFAULT };
            Setup::new(&params).unwrap()
        };
        let (usual, quick) = (of(Controller::Mpc, false), of(Controller::Mpc, true));
        assert_eq!(quick.tuning, usual.tuning.quick(&usual.vehicle));
        assert_eq!(quick.config.rate, usual.config.rate);
        assert_ne!(quick.config.angle, usual.config.angle);
        assert_eq!(of(Controller::Cascade, true).config, of(Controller::Cascade, false).config);
    }

    /// The parameter is the tuning's, and the cascade, which has no rehearsal, learns nothing.
    #[test]
    fn learning_is_of_the_mpc() {
        let of = |controller, learning| Setup::new(&Params { controller, learning, ..Params::DEFAULT }).unwrap().config;
        let (learns, not) = (of(Controller::Mpc, true), of(Controller::Mpc, false));
        assert!(learns.learning.is_some());
        assert_eq!(Config { learning: None, ..learns }, not);
        assert_eq!(of(Controller::Cascade, true), of(Controller::Cascade, false));
    }

    /// The parameter and a controller file's `motor_loss` end in the same configuration; the rig needs none.
    #[test]
    fn the_loss_of_a_motor_is_flown_where_it_is_chosen_and_nothing_holds_the_vehicle() {
        use crate::params::vehicle::VehicleNumbers;
        let chosen = |motor_loss, rig| {
            let params = Params { motor_loss, rig, vehicle: VehicleNumbers::F450, ..Params::DEFAULT };
            Setup::new(&params).unwrap().config.motor_loss
        };
        let vehicle = VehicleParameters::F450_FREE;
        // what the parameters' idle commands are, too
        let idle = Tuning { ground_idle_command: 0.1, flight_idle_command: 0.15, ..Tuning::for_vehicle(&vehicle) };
        let tuning = Tuning { motor_loss: true, ..idle };
        let by_tuning = Config::new(&vehicle, &tuning, 400.0, 1000.0, Controller::Cascade).unwrap().motor_loss;
        assert!(by_tuning.is_some());
        assert_eq!(chosen(true, Rig::Free), by_tuning);
        assert_eq!((chosen(false, Rig::Free), chosen(true, Rig::Gimbal)), (None, None));
    }

    #[test]
    fn every_mpc_that_can_be_chosen_can_be_prepared() {
        for (rig, motor_limits, linearisations) in [(Rig::Gimbal, false, 1), (Rig::Free, true, 4)] {
            for control_horizon in 1..=HORIZON as u8 {
                let params = Params { rig, control_horizon, motor_limits, linearisations, ..Params::DEFAULT };
                let settings = Setup::new(&params).unwrap().mpc;
                assert_eq!(settings.motors.is_some(), motor_limits && control_horizon <= 10);
                assert!(settings.motors.is_none_or(|motors| motors.work_limit == 20_000), "2.5 ms a plan");
                let prepared = Mpc::<HORIZON>::prepare_shorter(control_horizon.into(), &settings);
                assert!(prepared.is_ok(), "{params:?}");
            }
        }
    }

    /// All rates that can be chosen: related rates stay in phase for ever, since their periods are exact multiples in
    /// cycles of the one oscillator, and no others do.
    #[test]
    fn related_rates_keep_their_phase() {
        for (loop_rate_hz, pwm_rate_hz) in [100u16, 400].into_iter().flat_map(|l| (50..=490).map(move |p| (l, p))) {
            let setup = Setup::new(&Params { loop_rate_hz, pwm_rate_hz, ..Params::DEFAULT }).unwrap();
            let related = loop_rate_hz.is_multiple_of(pwm_rate_hz) || pwm_rate_hz.is_multiple_of(loop_rate_hz);
            assert_eq!(setup.pulses_keep_phase(), related, "{loop_rate_hz} {pwm_rate_hz}");
        }
        for loop_rate_hz in [100, 400] {
            let params = Params { loop_rate_hz, pulses: PulseKind::OneShot125, pwm_rate_hz: 333, ..Params::DEFAULT };
            let setup = Setup::new(&params).unwrap();
            assert!(setup.pulses_keep_phase());
            assert_eq!(setup.pulse_timer.cycles(), PULSE_TIMER_HZ / u32::from(loop_rate_hz));
        }
    }

    /// A simulator's rates change what is made for a rate, and nothing else.
    #[test]
    fn a_core_that_is_given_the_time_is_made_for_it() {
        let params = Params { gyro_notches: false, ..Params::DEFAULT };
        assert_eq!(Setup::at_rates(&params, 400.0, 1000.0), Setup::new(&params));
        let setup = Setup::at_rates(&Params::DEFAULT, 250.0, 250.0).unwrap();
        assert_eq!((setup.config.loop_rate_hz, setup.mpc.preview.control_step_s), (250.0, 0.004));
        assert!(setup.config.sensing.imu.gyro_notches.is_none());
        // fewer samples than steps
        assert!(Setup::at_rates(&params, 400.0, 250.0).is_err());
    }

    #[test]
    fn what_no_record_can_hold_is_refused_by_name() {
        let refused = |params| Setup::new(&params).unwrap_err();
        let out_of_range = |name| ConfigError::OutOfRange(name);
        assert_eq!(refused(Params { loop_rate_hz: 0, ..Params::DEFAULT }), out_of_range("LOOP_RATE_HZ"));
        assert_eq!(refused(Params { control_horizon: 31, ..Params::DEFAULT }), out_of_range("CONTROL_HORIZON"));
    }
}
