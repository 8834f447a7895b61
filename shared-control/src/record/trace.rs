//! One step as plain words: what a running image shows of itself, so that a host can repeat the step and compare bits.

use super::input_words::{
    batch_of_words, blocks_of_words, halves, link_of_words, plan_of_words, record_batch, request_of_words,
    setpoint_of_words, whole, words_of_blocks, words_of_plan, words_of_request, words_of_setpoint,
};
use super::state_words::STATE_WORDS;
use crate::flight_core::{State, StepOutput};
use crate::signals::{IMU_SAMPLES_MAX, StepInput};

/// Input and output of a step. All words are `u32`, so that every target lays it out alike; `f32` as bits, 64-bit times
/// low word first, enums as their `number()`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepTrace {
    /// Number of the step; whoever publishes a trace writes it last.
    pub step: u32,
    /// Time of the step, µs.
    pub time_us: [u32; 2],
    /// IMU samples in this step.
    pub samples: u32,
    /// Per sample its time (2 words), gyro x, y, z and accelerometer x, y, z, sign-extended.
    pub sample: [[u32; 8]; IMU_SAMPLES_MAX],
    /// Samples of the second IMU in this step.
    pub samples_second: u32,
    /// They themselves.
    pub sample_second: [[u32; 8]; IMU_SAMPLES_MAX],
    /// Roll, pitch, yaw rate, throttle; 1 in acro, and its rates.
    pub setpoint: [u32; 8],
    /// 0 none, 1 arm, 2 disarm, 3 motor test, 4 calibrate ESCs, 5 kill, 6 disarm if landed; then a test's motor,
    /// percent and ms.
    pub arming_request: [u32; 4],
    /// 1 if there is a link, and its age, µs.
    pub link_age: [u32; 3],
    /// 1 each: fault record unread, configuration unconfirmed, set to calibrate ESCs, safety on, kill switch on, radio
    /// unusable, vehicle's numbers unusable, parameters not in use yet.
    pub blocks: [u32; 8],
    /// 1 if a battery voltage is there, and the voltage.
    pub battery: [u32; 2],
    /// 1 if a plan is there, its step, status, iterations, duration, µs, and three torques.
    pub plan: [u32; 8],
    /// Exchanges of the configuration before the step.
    pub exchanges: u32,
    /// How often what was learnt had been taken, and after which step the last lesson was.
    pub taught: [u32; 2],
    /// Compare values of motors 1 to 4.
    pub compare_counts: [u32; 4],
    /// [`Arming::number`](crate::supervisor::Arming::number).
    pub arming: u32,
    /// IMU in use: [`ImuUnit::number`](crate::sensing::imu_select::ImuUnit::number).
    pub imu_unit: u32,
    /// Of the IMU in use: [`ImuHealth::number`](crate::sensing::imu_health::ImuHealth::number).
    pub imu_health: u32,
    /// The same of the other.
    pub standby_health: u32,
    /// Who made the torque: [`TorqueSource::number`](crate::flight_core::TorqueSource::number).
    pub source: u32,
    /// Commands of motors 1 to 4.
    pub commands: [u32; 4],
    /// Torque that the mixer could not deliver, N m.
    pub unmet_torque_nm: [u32; 3],
    /// Lift per motor, N, and torque, N m.
    pub wrench: [u32; 4],
    /// Attitude: w, i, j, k.
    pub attitude: [u32; 4],
    /// Body rate, rad/s.
    pub rate: [u32; 3],
    /// Gyro bias, rad/s.
    pub bias: [u32; 3],
    /// Rate requested, rad/s.
    pub rate_target: [u32; 3],
    /// The whole state after the step, `follow` included.
    pub state: [u32; STATE_WORDS],
}

impl StepTrace {
    /// Before any step.
    pub const EMPTY: Self = Self {
        step: 0,
        time_us: [0; 2],
        samples: 0,
        sample: [[0; 8]; IMU_SAMPLES_MAX],
        samples_second: 0,
        sample_second: [[0; 8]; IMU_SAMPLES_MAX],
        setpoint: [0; 8],
        arming_request: [0; 4],
        link_age: [0; 3],
        blocks: [0; 8],
        battery: [0; 2],
        plan: [0; 8],
        exchanges: 0,
        taught: [0; 2],
        compare_counts: [0; 4],
        arming: 0,
        imu_unit: 0,
        imu_health: 0,
        standby_health: 0,
        source: 0,
        commands: [0; 4],
        unmet_torque_nm: [0; 3],
        wrench: [0; 4],
        attitude: [0; 4],
        rate: [0; 3],
        bias: [0; 3],
        rate_target: [0; 3],
        state: [0; STATE_WORDS],
    };

    /// A step's words: its input, its output, and the state that it leaves.
    pub fn record(&mut self, input: &StepInput, output: &StepOutput, state: &State) {
        self.step = output.step;
        self.time_us = halves(input.time_us);
        self.samples = record_batch(&mut self.sample, &input.imu);
        self.samples_second = record_batch(&mut self.sample_second, &input.imu_second);
        self.setpoint = words_of_setpoint(&input.setpoint);
        self.arming_request = words_of_request(&input.arming);
        self.link_age = input.link_age_us.map_or([0; 3], |age_us| {
            let [low, high] = halves(age_us);
            [1, low, high]
        });
        self.blocks = words_of_blocks(&input.blocks);
        self.battery = input.battery_v.map_or([0; 2], |volts| [1, volts.to_bits()]);
        self.plan = input.plan.as_ref().map_or([0; 8], words_of_plan);
        self.exchanges = state.exchanges();
        self.taught = state.taught();
        self.record_output(output);
        self.state = state.words();
    }

    fn record_output(&mut self, output: &StepOutput) {
        let estimate = &output.estimate;
        let [torque_x, torque_y, torque_z] = output.wrench.torque_body_nm;
        let q = &estimate.q_world_from_body;
        self.compare_counts = output.compare_counts.map(u32::from);
        self.arming = output.arming.number();
        self.imu_unit = output.imu_unit.number();
        self.imu_health = output.imu_health.number();
        self.standby_health = output.standby_health.number();
        self.source = output.source.number();
        self.commands = output.mix.commands.0.map(f32::to_bits);
        self.unmet_torque_nm = output.mix.unmet_torque_nm.map(f32::to_bits);
        self.wrench = [output.wrench.lift_per_motor_n, torque_x, torque_y, torque_z].map(f32::to_bits);
        self.attitude = [q.w, q.i, q.j, q.k].map(f32::to_bits);
        self.rate = [0, 1, 2].map(|axis| estimate.rate_body_rad_s[axis].to_bits());
        self.bias = [0, 1, 2].map(|axis| estimate.gyro_bias_rad_s[axis].to_bits());
        self.rate_target = [0, 1, 2].map(|axis| output.rate_target_rad_s[axis].to_bits());
    }

    /// The input that was recorded, to the bit.
    pub fn input(&self) -> StepInput {
        let [battery_known, battery] = self.battery;
        StepInput {
            time_us: whole(self.time_us),
            imu: batch_of_words(&self.sample, self.samples),
            imu_second: batch_of_words(&self.sample_second, self.samples_second),
            setpoint: setpoint_of_words(&self.setpoint),
            arming: request_of_words(&self.arming_request),
            link_age_us: link_of_words(self.link_age),
            blocks: blocks_of_words(&self.blocks),
            battery_v: (battery_known == 1).then_some(f32::from_bits(battery)),
            plan: plan_of_words(&self.plan),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Config, Controller, Tuning};
    use crate::flight_core::FlightCore;
    use crate::signals::{ArmingRequest, MotorTest, Plan, PlanStatus, RawImuSample, Setpoint};
    use crate::vehicle::VehicleParameters;
    use proptest::prelude::*;

    fn any_sample() -> impl Strategy<Value = RawImuSample> {
        (any::<u64>(), any::<[i16; 3]>(), any::<[i16; 3]>())
            .prop_map(|(time_us, gyro_counts, accel_counts)| RawImuSample { time_us, gyro_counts, accel_counts })
    }

    fn any_request() -> impl Strategy<Value = ArmingRequest> {
        let test = any::<(u8, u8, u16)>().prop_map(|(motor, throttle_percent, duration_ms)| {
            ArmingRequest::MotorTest(MotorTest { motor, throttle_percent, duration_ms })
        });
        let escs = Just(ArmingRequest::CalibrateEscs);
        let radio = prop_oneof![Just(ArmingRequest::Kill), Just(ArmingRequest::DisarmLanded)];
        prop_oneof![Just(ArmingRequest::None), Just(ArmingRequest::Arm), Just(ArmingRequest::Disarm), test, escs, radio]
    }

    fn any_plan() -> impl Strategy<Value = Plan> {
        (any::<u32>(), -9f32..9.0, 0u32..4, any::<u16>()).prop_map(|(step, torque_nm, status, iterations)| Plan {
            step,
            torque_nm: [torque_nm, -torque_nm, 0.5 * torque_nm],
            status: PlanStatus::of_number(status),
            iterations,
            duration_us: u32::from(iterations) << 9,
        })
    }

    proptest! {
        #[test]
        fn an_input_comes_back_to_the_bit(
            time_us in any::<u64>(),
            samples in proptest::collection::vec(any_sample(), 0..=IMU_SAMPLES_MAX),
            samples_second in proptest::collection::vec(any_sample(), 0..=IMU_SAMPLES_MAX),
            angle in -3f32..3.0,
            acro_rad_s in proptest::option::of(any::<[u8; 3]>()),
            request in any_request(),
            link_age_us in proptest::option::of(any::<u64>()),
            blocks in any::<[bool; 8]>(),
            battery_v in proptest::option::of(0f32..20.0),
            plan in proptest::option::of(any_plan()),
        ) {
            let blocks = blocks_of_words(&blocks.map(u32::from));
            let acro_rad_s = acro_rad_s.map(|rates| rates.map(f32::from));
            let (roll_rad, pitch_rad) = (angle, -angle);
            let setpoint = Setpoint { roll_rad, pitch_rad, yaw_rate_rad_s: 2.0 * angle, throttle: 0.5, acro_rad_s };
            let (imu, imu_second) = (samples.into_iter().collect(), samples_second.into_iter().collect());
            let arming = request;
            let input =
                StepInput { time_us, imu, imu_second, setpoint, arming, battery_v, link_age_us, blocks, plan };
            let vehicle = &VehicleParameters::F450_GIMBAL;
            let config = Config::new(vehicle, &Tuning::for_motor_lag(0.0), 400.0, 1000.0, Controller::Cascade).unwrap();
            let mut state = State::default();
            let output = FlightCore::fast(&config, &mut state, &input);
            let mut trace = StepTrace::EMPTY;
            trace.record(&input, &output, &state);
            prop_assert_eq!(trace.input(), input);
            prop_assert_eq!(trace.step, output.step);
            prop_assert_eq!(trace.compare_counts, output.compare_counts.map(u32::from));
            let numbers = [output.arming.number(), output.imu_unit.number(), output.imu_health.number()];
            prop_assert_eq!([trace.arming, trace.imu_unit, trace.imu_health], numbers);
            prop_assert_eq!(
                [trace.standby_health, trace.source],
                [output.standby_health.number(), output.source.number()]
            );
            let q = output.estimate.q_world_from_body;
            prop_assert_eq!(trace.attitude.map(f32::from_bits), [q.w, q.i, q.j, q.k]);
            prop_assert_eq!(trace.state, state.words());
        }
    }

    #[test]
    fn its_size_is_the_sum_of_its_words() {
        // step, time: 3; counts and 16 * 8 for samples, twice; set-point 8, requests 15, battery 2, plan 8; exchanges
        // 1, taught 2; outputs 33; state; no padding
        assert_eq!(size_of::<StepTrace>(), 4 * (3 + 2 * 129 + 33 + 3 + 33 + STATE_WORDS));
    }
}
