//! A step's input as words, and back.

use crate::signals::{
    ArmingBlocks, ArmingRequest, IMU_SAMPLES_MAX, ImuBatch, MotorTest, Plan, PlanStatus, RawImuSample, Setpoint,
};

pub(super) fn halves(value: u64) -> [u32; 2] {
    [value as u32, (value >> 32) as u32]
}

pub(super) fn whole([low, high]: [u32; 2]) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}

/// Returns their number.
pub(super) fn record_batch(words: &mut [[u32; 8]; IMU_SAMPLES_MAX], batch: &ImuBatch) -> u32 {
    for (words, sample) in words.iter_mut().zip(batch) {
        *words = words_of_sample(sample);
    }
    batch.len() as u32
}

pub(super) fn batch_of_words(words: &[[u32; 8]; IMU_SAMPLES_MAX], samples: u32) -> ImuBatch {
    words.iter().take(samples as usize).map(sample_of_words).collect()
}

fn words_of_sample(sample: &RawImuSample) -> [u32; 8] {
    let [low, high] = halves(sample.time_us);
    let [gx, gy, gz] = sample.gyro_counts.map(|count| i32::from(count) as u32);
    let [ax, ay, az] = sample.accel_counts.map(|count| i32::from(count) as u32);
    [low, high, gx, gy, gz, ax, ay, az]
}

fn sample_of_words(words: &[u32; 8]) -> RawImuSample {
    let [low, high, gyro @ .., ax, ay, az] = *words;
    let gyro: [u32; 3] = gyro;
    RawImuSample {
        time_us: whole([low, high]),
        gyro_counts: gyro.map(|word| word as i16),
        accel_counts: [ax, ay, az].map(|word| word as i16),
    }
}

pub(super) fn words_of_setpoint(setpoint: &Setpoint) -> [u32; 8] {
    let Setpoint { roll_rad, pitch_rad, yaw_rate_rad_s, throttle, acro_rad_s } = *setpoint;
    let [roll, pitch, yaw_rate, throttle] = [roll_rad, pitch_rad, yaw_rate_rad_s, throttle].map(f32::to_bits);
    let [about_x, about_y, about_z] = acro_rad_s.unwrap_or_default().map(f32::to_bits);
    [roll, pitch, yaw_rate, throttle, u32::from(acro_rad_s.is_some()), about_x, about_y, about_z]
}

pub(super) fn setpoint_of_words(words: &[u32; 8]) -> Setpoint {
    let [roll, pitch, yaw_rate, throttle, acro, rates @ ..] = *words;
    let [roll_rad, pitch_rad, yaw_rate_rad_s, throttle] = [roll, pitch, yaw_rate, throttle].map(f32::from_bits);
    let acro_rad_s = (acro == 1).then_some(rates.map(f32::from_bits));
    Setpoint { roll_rad, pitch_rad, yaw_rate_rad_s, throttle, acro_rad_s }
}

pub(super) fn words_of_request(request: &ArmingRequest) -> [u32; 4] {
    match *request {
        ArmingRequest::None => [0; 4],
        ArmingRequest::Arm => [1, 0, 0, 0],
        ArmingRequest::Disarm => [2, 0, 0, 0],
        ArmingRequest::CalibrateEscs => [4, 0, 0, 0],
        ArmingRequest::Kill => [5, 0, 0, 0],
        ArmingRequest::DisarmLanded => [6, 0, 0, 0],
        ArmingRequest::MotorTest(MotorTest { motor, throttle_percent, duration_ms }) => {
            [3, u32::from(motor), u32::from(throttle_percent), u32::from(duration_ms)]
        }
    }
}

pub(super) fn request_of_words(words: &[u32; 4]) -> ArmingRequest {
    match *words {
        [0, ..] => ArmingRequest::None,
        [1, ..] => ArmingRequest::Arm,
        [2, ..] => ArmingRequest::Disarm,
        [4, ..] => ArmingRequest::CalibrateEscs,
        [5, ..] => ArmingRequest::Kill,
        [6, ..] => ArmingRequest::DisarmLanded,
        [_, motor, percent, ms] => ArmingRequest::MotorTest(MotorTest {
            motor: motor as u8,
            throttle_percent: percent as u8,
            duration_ms: ms as u16,
        }),
    }
}

pub(super) fn link_of_words([known, low, high]: [u32; 3]) -> Option<u64> {
    (known == 1).then_some(whole([low, high]))
}

pub(super) fn words_of_plan(plan: &Plan) -> [u32; 8] {
    let [roll, pitch, yaw] = plan.torque_nm.map(f32::to_bits);
    let (status, iterations) = (plan.status.number(), u32::from(plan.iterations));
    [1, plan.step, status, iterations, plan.duration_us, roll, pitch, yaw]
}

pub(super) fn plan_of_words(words: &[u32; 8]) -> Option<Plan> {
    let [known, step, status, iterations, duration_us, torque @ ..] = *words;
    (known == 1).then_some(Plan {
        step,
        torque_nm: torque.map(f32::from_bits),
        status: PlanStatus::of_number(status),
        iterations: iterations as u16,
        duration_us,
    })
}

pub(super) fn words_of_blocks(blocks: &ArmingBlocks) -> [u32; 8] {
    let ArmingBlocks {
        fault_record_unread,
        configuration_unconfirmed,
        esc_calibration,
        safety_on,
        kill_switch,
        radio_unusable,
        vehicle_unusable,
        parameters_waiting,
    } = *blocks;
    #[rustfmt::skip]
    let all = [
        fault_record_unread, configuration_unconfirmed, esc_calibration, safety_on, kill_switch, radio_unusable,
        vehicle_unusable, parameters_waiting,
    ];
    all.map(u32::from)
}

pub(super) fn blocks_of_words(words: &[u32; 8]) -> ArmingBlocks {
    #[rustfmt::skip]
    let [
        fault_record_unread, configuration_unconfirmed, esc_calibration, safety_on, kill_switch, radio_unusable,
        vehicle_unusable, parameters_waiting,
    ] = words.map(|word| word == 1);
    ArmingBlocks {
        fault_record_unread,
        configuration_unconfirmed,
        esc_calibration,
        safety_on,
        kill_switch,
        radio_unusable,
        vehicle_unusable,
        parameters_waiting,
    }
}
