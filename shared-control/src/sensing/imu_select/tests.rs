//! Two simulated IMUs on a body that rolls to and fro, and every way in which they fail.

extern crate std;
use super::*;
use crate::config::{Config, Controller, Tuning};
use crate::flight_core::{FlightCore, State, StepOutput};
use crate::frames::{down_in_body, q_from_rotation_vector};
use crate::sensing::imu_health::ImuFault;
use crate::signals::{ArmingRequest, ImuBatch, Setpoint};
use crate::supervisor::{Arming, DisarmedBecause, Refusal};
use crate::vehicle::VehicleParameters;
use nalgebra::Vector3;
use proptest::prelude::*;

const STEP_US: u64 = 2500;
/// Steps at rest before take-off: the second that calibration takes, and two more in which what the uncalibrated gyro
/// has turned the attitude by goes away.
const REST_STEPS: u64 = 1200;
/// Sample times in us: 1 kHz and 760 Hz.
const PERIOD_US: [u64; 2] = [1000, 1316];
/// What the estimator may be off by after a second of rolling through 0.33 rad without a drag that shows it: half of it
/// is the time from sample to step, the rest what an unknown wind allows.
const TILT_ERROR_MAX_RAD: f32 = 0.03;
const BIAS_RAD_S: [[f32; 3]; 2] = [[0.02, -0.03, 0.01], [-0.1, 0.05, -0.04]];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Failure {
    Silent,
    Stuck,
    GyroStuck,
    BusLow,
    BusHigh,
    FullScale,
}

const FAILURES: [Failure; 5] = [Failure::Silent, Failure::Stuck, Failure::BusLow, Failure::BusHigh, Failure::FullScale];

/// One simulated IMU, with two digits of noise.
#[derive(Clone)]
struct Sensor {
    unit: usize,
    config: ImuConfig,
    next_us: u64,
    bias_rad_s: [f32; 3],
    /// State of the generator; none for a simulation without noise.
    noise: Option<u32>,
    failure: Option<Failure>,
    last: RawImuSample,
}

impl Sensor {
    fn digits_of_noise(&mut self) -> i16 {
        let Some(noise) = &mut self.noise else { return 0 };
        *noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*noise >> 16) as i16 % 3
    }

    fn counts(&mut self, sensor: [f32; 3], unit_per_count: f32) -> [i16; 3] {
        sensor.map(|value| (value / unit_per_count) as i16 + self.digits_of_noise())
    }

    fn sample(&mut self, rate_rad_s: [f32; 3]) -> Option<RawImuSample> {
        let config = self.config;
        let felt: [f32; 3] = core::array::from_fn(|axis| rate_rad_s[axis] + self.bias_rad_s[axis]);
        let gyro_counts = self.counts(config.gyro_axes.from_body(felt), config.gyro_rad_s_per_count);
        // a multicopter's accelerometer feels its thrust
        let accel_counts = self.counts(config.accel_axes.from_body([0.0, 0.0, -9.8]), config.accel_m_s2_per_count);
        let live = RawImuSample { time_us: self.next_us, gyro_counts, accel_counts };
        let words = |word| RawImuSample { gyro_counts: [word; 3], accel_counts: [word; 3], ..live };
        let sample = match self.failure {
            None => live,
            Some(Failure::Silent) => return None,
            Some(Failure::Stuck) => RawImuSample { time_us: live.time_us, ..self.last },
            Some(Failure::GyroStuck) => RawImuSample { gyro_counts: self.last.gyro_counts, ..live },
            Some(Failure::BusLow) => words(0),
            Some(Failure::BusHigh) => words(-1),
            Some(Failure::FullScale) => RawImuSample { gyro_counts: [i16::MAX; 3], ..live },
        };
        self.last = sample;
        Some(sample)
    }

    fn batch(&mut self, now_us: u64, rate_rad_s: [f32; 3]) -> ImuBatch {
        let mut batch = ImuBatch::new();
        while self.next_us <= now_us {
            if let Some(sample) = self.sample(rate_rad_s) {
                batch.push(sample).unwrap();
            }
            self.next_us += PERIOD_US[self.unit];
        }
        batch
    }
}

/// A vehicle with both, and the core.
#[derive(Clone)]
struct Bench {
    config: Config,
    state: State,
    sensors: [Sensor; 2],
    step: u64,
    truth: UnitQuaternion<f32>,
    request: ArmingRequest,
    /// Largest rate of its rolling, rad/s; zero on the ground.
    rolling_rad_s: f32,
    /// Rate about its z axis, rad/s.
    turning_rad_s: f32,
}

impl Bench {
    fn new() -> Self {
        let tuning = Tuning::for_motor_lag(0.0);
        let config = Config::new(&VehicleParameters::F450_FREE, &tuning, 400.0, 1000.0, Controller::Cascade).unwrap();
        let sensor = |unit: usize, config| Sensor {
            unit,
            config,
            next_us: 0,
            bias_rad_s: BIAS_RAD_S[unit],
            noise: Some(7 + unit as u32),
            failure: None,
            last: RawImuSample::default(),
        };
        Self {
            config,
            state: State::default(),
            sensors: [sensor(0, config.sensing.imu), sensor(1, config.sensing.imu_second)],
            step: 0,
            truth: UnitQuaternion::identity(),
            request: ArmingRequest::None,
            rolling_rad_s: 0.0,
            turning_rad_s: 0.0,
        }
    }

    /// Armed and rolling, after a rest.
    fn flying() -> Self {
        let mut bench = Self::new();
        bench.take_off();
        bench
    }

    fn take_off(&mut self) {
        for _ in 0..REST_STEPS {
            self.advance();
        }
        self.request = ArmingRequest::Arm;
        assert_eq!(self.advance().arming, Arming::Armed);
        self.request = ArmingRequest::None;
        self.rolling_rad_s = 2.0;
        for _ in 0..37 {
            self.advance();
        }
    }

    fn advance(&mut self) -> StepOutput {
        let time_us = self.step * STEP_US;
        // to and fro twice a second
        let phase = (self.step % 200) as f32 / 200.0;
        let shape = if phase < 0.5 {
            1.0 - 8.0 * (phase - 0.25) * (phase - 0.25)
        } else {
            8.0 * (phase - 0.75) * (phase - 0.75) - 1.0
        };
        let rate_rad_s = [self.rolling_rad_s * shape, -0.3 * self.rolling_rad_s * shape, self.turning_rad_s];
        if self.step > 0 {
            let turned = q_from_rotation_vector(&(Vector3::from(rate_rad_s) * (STEP_US as f32 * 1e-6)));
            self.truth *= turned;
        }
        let [first, second] = &mut self.sensors;
        let throttle = if self.rolling_rad_s > 0.0 { 0.5 } else { 0.0 };
        let input = StepInput {
            time_us,
            imu: first.batch(time_us, rate_rad_s),
            imu_second: second.batch(time_us, rate_rad_s),
            setpoint: Setpoint { throttle, ..Setpoint::default() },
            arming: self.request,
            ..StepInput::default()
        };
        self.step += 1;
        let output = FlightCore::fast(&self.config, &mut self.state, &input);
        FlightCore::follow(&self.config, &mut self.state, &output);
        output
    }

    /// Angle between where down is and where the core has it, rad.
    fn tilt_error(&self, output: &StepOutput) -> f32 {
        let (truth, known) = (down_in_body(&self.truth), down_in_body(&output.estimate.q_world_from_body));
        truth.cross(&known).norm()
    }

    /// Steps until the first output that satisfies this, with that output.
    fn until(&mut self, steps_max: usize, wanted: impl Fn(&StepOutput) -> bool) -> (usize, StepOutput) {
        for k in 1..=steps_max {
            let output = self.advance();
            if wanted(&output) {
                return (k, output);
            }
        }
        panic!("not within {steps_max} steps");
    }
}

/// Most steps from a fault to the motors' end: five for wrong samples; missing ones are bridged for 40 ms.
fn steps_to_disarm(failure: Failure) -> usize {
    if failure == Failure::Silent { 17 } else { 5 }
}

fn disarmed_by_imu(output: &StepOutput) -> bool {
    matches!(output.arming, Arming::Disarmed(DisarmedBecause::ImuFailed(_)))
}

#[test]
fn each_fault_of_the_first_in_flight_gives_the_second_in_the_same_step() {
    for failure in FAILURES {
        let mut bench = Bench::flying();
        let before = bench.advance();
        assert!(before.imu_unit == ImuUnit::First && bench.tilt_error(&before) < 0.01);
        bench.sensors[0].failure = Some(failure);
        let (steps, switched) = bench.until(5, |output| output.imu_unit == ImuUnit::Second);
        assert!(switched.standby_health != ImuHealth::Good && switched.imu_health == ImuHealth::Good);
        assert_eq!(switched.arming, Arming::Armed, "{failure:?} after {steps} steps");
        // the second's own bias, no trace of the faulty samples
        let bias_error = switched.estimate.gyro_bias_rad_s - Vector3::from(BIAS_RAD_S[1]);
        assert!(bias_error.norm() < 2e-3, "{failure:?}: {bias_error}");
        assert!(bench.tilt_error(&switched) < 0.015, "{failure:?}: {}", bench.tilt_error(&switched));
        for _ in 0..400 {
            let output = bench.advance();
            assert_eq!((output.imu_unit, output.arming), (ImuUnit::Second, Arming::Armed));
            assert!(bench.tilt_error(&output) < TILT_ERROR_MAX_RAD, "{failure:?}: {}", bench.tilt_error(&output));
        }
    }
}

/// While the first is suspect the attitude goes on by the second's gyro, less the second's own bias, however large.
#[test]
fn the_attitude_at_the_switch_holds_nothing_of_the_seconds_bias() {
    let mut bench = Bench::new();
    bench.sensors[1].bias_rad_s = [0.5, -0.4, 0.2];
    bench.take_off();
    // all but still, so that the time from sample to step turns nothing
    bench.rolling_rad_s = 1e-3;
    let before = bench.advance();
    bench.sensors[0].failure = Some(Failure::Silent);
    let (_, after) = bench.until(5, |output| output.imu_unit == ImuUnit::Second);
    let turned = before.estimate.q_world_from_body.inverse() * after.estimate.q_world_from_body;
    // four steps of two digits of noise make 1e-5 rad; the bias would have made 7e-3
    assert!(turned.imag().norm() < 5e-4, "{turned}");
}

/// A slow turn looks like rest, and its rate like a bias; with motors turning neither is believed, of the standby
/// either.
#[test]
fn a_slow_turn_in_flight_is_not_taken_for_the_standbys_bias() {
    let mut bench = Bench::flying();
    (bench.rolling_rad_s, bench.turning_rad_s) = (1e-3, 0.06);
    // longer than the second that would settle it
    for _ in 0..1200 {
        bench.advance();
    }
    bench.sensors[0].failure = Some(Failure::Silent);
    let (_, switched) = bench.until(5, |output| output.imu_unit == ImuUnit::Second);
    let bias_error = switched.estimate.gyro_bias_rad_s - Vector3::from(BIAS_RAD_S[1]);
    assert!(bias_error.norm() < 2e-3, "{bias_error}");
}

/// Words that change while the vehicle is carried about are no noise: without it a sensor at rest repeats itself.
#[test]
fn a_sensor_without_noise_is_not_stuck_after_it_was_carried_about() {
    let mut bench = Bench::new();
    bench.sensors.iter_mut().for_each(|sensor| sensor.noise = None);
    for rolling_rad_s in [0.0, 2.0, 0.0] {
        bench.rolling_rad_s = rolling_rad_s;
        for _ in 0..400 {
            let output = bench.advance();
            assert_eq!((output.imu_unit, output.imu_health), (ImuUnit::First, ImuHealth::Good));
        }
    }
}

#[test]
fn a_second_that_fails_too_leaves_nothing_to_fly_with() {
    for first in FAILURES {
        for second in FAILURES.into_iter().chain([Failure::GyroStuck]) {
            let mut bench = Bench::flying();
            bench.sensors[0].failure = Some(first);
            for _ in 0..50 {
                assert_eq!(bench.advance().arming, Arming::Armed);
            }
            bench.sensors[1].failure = Some(second);
            let (_, output) = bench.until(steps_to_disarm(second), disarmed_by_imu);
            assert_eq!(output.compare_counts, [24_000; 4], "{first:?}, {second:?}");
        }
    }
}

#[test]
fn both_failing_at_once_disarm() {
    for failure in FAILURES {
        let mut bench = Bench::flying();
        for sensor in &mut bench.sensors {
            sensor.failure = Some(failure);
        }
        bench.until(steps_to_disarm(failure), disarmed_by_imu);
    }
}

#[test]
fn a_second_that_is_not_calibrated_is_not_flown_with() {
    let mut bench = Bench::new();
    bench.sensors[1].failure = Some(Failure::Silent);
    bench.take_off();
    bench.sensors[1].failure = None;
    for _ in 0..400 {
        assert_eq!(bench.advance().imu_unit, ImuUnit::First);
    }
    bench.sensors[0].failure = Some(Failure::Silent);
    let (_, output) = bench.until(steps_to_disarm(Failure::Silent), disarmed_by_imu);
    // on the ground again it may be looked at
    assert_eq!(output.imu_unit, ImuUnit::First);
    assert_eq!(bench.advance().imu_unit, ImuUnit::Second);
}

#[test]
fn there_is_no_way_back_in_flight_but_on_the_ground() {
    let mut bench = Bench::flying();
    bench.sensors[0].failure = Some(Failure::Silent);
    bench.until(5, |output| output.imu_unit == ImuUnit::Second);
    bench.sensors[0].failure = None;
    for _ in 0..400 {
        let output = bench.advance();
        assert_eq!((output.imu_unit, output.arming), (ImuUnit::Second, Arming::Armed));
    }
    bench.request = ArmingRequest::Disarm;
    bench.rolling_rad_s = 0.0;
    bench.advance();
    bench.request = ArmingRequest::Arm;
    let output = bench.advance();
    assert_eq!(output.imu_unit, ImuUnit::First);
    assert_eq!(output.arming, Arming::Disarmed(DisarmedBecause::Refused(Refusal::GyroNotCalibrated)));
    let (steps, _) = bench.until(500, |output| output.arming == Arming::Armed);
    assert!(steps >= 398, "{steps}");
}

#[test]
fn a_first_that_is_dead_from_the_start_leaves_the_second_to_arm_and_fly_with() {
    let mut bench = Bench::new();
    bench.sensors[0].failure = Some(Failure::Silent);
    bench.request = ArmingRequest::Arm;
    let (steps, output) = bench.until(500, |output| output.arming == Arming::Armed);
    assert_eq!(output.imu_unit, ImuUnit::Second);
    // a second of rest is 400 steps, of which the samples cover all but the time before the first
    assert!((398..=404).contains(&steps), "{steps}");

    let mut bench = Bench::new();
    bench.sensors[0].failure = Some(Failure::Silent);
    bench.take_off();
    for _ in 0..400 {
        let output = bench.advance();
        assert_eq!((output.imu_unit, output.arming), (ImuUnit::Second, Arming::Armed));
        assert!(bench.tilt_error(&output) < TILT_ERROR_MAX_RAD, "{}", bench.tilt_error(&output));
    }
}

/// A standby is looked at, and changes nothing.
#[test]
fn with_a_good_first_the_second_makes_no_difference_of_a_bit() {
    let (mut with, mut without) = (Bench::new(), Bench::new());
    without.sensors[1].failure = Some(Failure::Silent);
    for k in 0..REST_STEPS + 800 {
        let arming = if k == REST_STEPS { ArmingRequest::Arm } else { ArmingRequest::None };
        for bench in [&mut with, &mut without] {
            bench.request = arming;
            bench.rolling_rad_s = if k > REST_STEPS { 2.0 } else { 0.0 };
        }
        let (a, b) = (with.advance(), without.advance());
        assert_eq!(StepOutput { standby_health: b.standby_health, ..a }, b);
        assert_eq!(b.standby_health, ImuHealth::Bad(ImuFault::Stale));
    }
}

#[test]
fn the_later_gyro_has_other_axes() {
    let mut bench = Bench::new();
    let axes = crate::sensing::imu::AxisMap::PIXHAWK1_L3GD20H;
    bench.config.sensing.imu_second.gyro_axes = axes;
    bench.sensors[1].config.gyro_axes = axes;
    bench.take_off();
    bench.sensors[0].failure = Some(Failure::Silent);
    for _ in 0..200 {
        let output = bench.advance();
        assert!(bench.tilt_error(&output) < TILT_ERROR_MAX_RAD);
    }
}

fn any_failure() -> impl Strategy<Value = Option<Failure>> {
    let all = std::vec![
        Failure::Silent,
        Failure::Stuck,
        Failure::GyroStuck,
        Failure::BusLow,
        Failure::BusHigh,
        Failure::FullScale
    ];
    proptest::option::of(proptest::sample::select(all))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever comes and goes: while armed there is a good unit, changes lead from the first to the second only, and
    /// everything stays finite.
    #[test]
    fn no_unit_is_flown_with_that_is_not_good(
        changes in proptest::collection::vec((any_failure(), any_failure(), 1usize..60), 1..20),
    ) {
        let mut bench = Bench::flying();
        let mut unit = ImuUnit::First;
        for (first, second, steps) in changes {
            bench.sensors[0].failure = first;
            bench.sensors[1].failure = second;
            for _ in 0..steps {
                let output = bench.advance();
                prop_assert!(output.estimate.q_world_from_body.coords.iter().all(|part| part.is_finite()));
                prop_assert!(output.mix.commands.0.iter().all(|command| (0.0..=1.0).contains(command)));
                if output.arming == Arming::Armed {
                    // or the model stands in for what does not come
                    let flown_with = [ImuHealth::Good, ImuHealth::Bad(ImuFault::Stale)];
                    prop_assert!(flown_with.contains(&output.imu_health));
                    prop_assert!(unit == ImuUnit::First || output.imu_unit == ImuUnit::Second);
                    unit = output.imu_unit;
                }
            }
        }
    }
}
