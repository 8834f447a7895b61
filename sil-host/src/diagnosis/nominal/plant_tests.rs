//! The prediction against the plant: logs flown by the plant itself under a small stabilising law, with sensor noise
//! added.

use super::*;
use crate::axis::Axis;
use crate::effects::Effect;
use crate::model::{Rig, VehicleModel};
use crate::plant::Plant;
use crate::statistics::noise_source::NoiseSource;

/// Which way each motor turns the vehicle about (x, y, z), as docs/rig.md has it; the prediction's own table is not
/// used.
const SIGNS: [[f64; 3]; 4] = [[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0], [-1.0, -1.0, -1.0]];

/// 20 s at 250 Hz, see [`flown_at`].
fn flown(model: &VehicleModel, seed: u64) -> Log {
    flown_at(model, seed, 20.0, 0.004, 1)
}

/// Angles follow slow references of up to 30 degrees by what the noisy sensors measure; on the gimbal yaw is not
/// controlled. Each row of the log stands for so many steps of the controller.
fn flown_at(model: &VehicleModel, seed: u64, duration_s: f64, control_step_s: f64, steps_per_row: usize) -> Log {
    let mut noise = NoiseSource::new(seed);
    let mut plant = Plant::new(model);
    let mut log = Log { axes: [true; 3], ..Log::default() };
    let [mut angles, mut rates] = [const { [const { Vec::new() }; 3] }; 2];
    let mut motors = [const { Vec::new() }; 4];
    for step in 0..(duration_s / control_step_s) as usize {
        let time_s = control_step_s * step as f64;
        let truth = plant.truth();
        let angle = [truth.roll_rad, truth.pitch_rad, truth.yaw_rad].map(|angle| angle + 0.002 * noise.normal());
        let rate = truth.rate_body_rad_s.map(|rate| rate + 0.01 * noise.normal());
        let wanted = [0.5 * libm::sin(2.1 * time_s), 0.5 * libm::sin(1.3 * time_s), 0.0];
        let gains = if model.rig() == Rig::Gimbal { [0.3, 0.6, 0.0] } else { [0.3, 0.3, 0.1] };
        let torque = [0, 1, 2].map(|i| gains[i] * (wanted[i] - angle[i] - 0.2 * rate[i]));
        let command = |motor: usize| {
            let turn: f64 = (0..3).map(|axis| SIGNS[motor][axis] * torque[axis]).sum();
            (model.base_command + turn).clamp(0.0, 1.0)
        };
        let commands = [0, 1, 2, 3].map(command);
        plant.set_commands(commands);
        plant.advance(control_step_s);
        if step % steps_per_row != 0 {
            continue;
        }
        log.time_s.push(time_s);
        for axis in 0..3 {
            angles[axis].push(angle[axis]);
            rates[axis].push(rate[axis]);
        }
        for (column, command) in motors.iter_mut().zip(commands) {
            column.push(command);
        }
    }
    log.angle_rad = angles.map(Some);
    log.rate_rad_s = rates.map(Some);
    log.motor_command = motors.map(Some);
    log
}

fn predicted(log: &Log, model: &VehicleModel) -> PredictedLog {
    nominal_prediction(log, &Subject::Vehicle(model), None).unwrap().predicted
}

/// RMSE over noise floor of roll, pitch, p, q.
fn ratios(predicted: &PredictedLog) -> [f64; 4] {
    let channels = [Axis::Roll, Axis::Pitch].map(|axis| [Channel::Angle(axis), Channel::Rate(axis)]);
    let ratio = |channel| predicted.error(channel).unwrap().ratio();
    let [[roll, p], [pitch, q]] = channels.map(|of_axis| of_axis.map(ratio));
    [roll, pitch, p, q]
}

#[test]
fn the_true_model_misses_by_the_noise_floor_on_both_rigs() {
    for rig in [Rig::Gimbal, Rig::Free] {
        let model = VehicleModel::nominal(rig);
        let predicted = predicted(&flown(&model, 5), &model);
        assert_eq!(predicted.windows().count(), 39);
        for ratio in ratios(&predicted) {
            assert!((0.85..1.15).contains(&ratio), "{rig:?}: {:?}", ratios(&predicted));
        }
    }
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn commands_between_the_rows_are_in_the_floor_if_there_were_any() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    for (control_step_s, steps_per_row) in [(0.01, 1), (0.0025, 4), (0.0025, 2)] {
        let log = flown_at(&model, 9, 40.0, control_step_s, steps_per_row);
        let known = nominal_prediction(&log, &Subject::Vehicle(&model), Some(1.0 / control_step_s)).unwrap().predicted;
        assert_eq!(known.commands_are_lost, steps_per_row > 1);
        // commands that hardly change from step to step are the same to the log whether they were held or not
        for predicted in [known, predicted(&log, &model)] {
            for ratio in ratios(&predicted) {
                // the estimate of what nobody logged is good to some 20 %
                assert!((0.75..1.25).contains(&ratio), "{steps_per_row}: {:?}", ratios(&predicted));
            }
        }
    }
}

#[test]
fn on_the_gimbal_the_yaw_rate_is_not_needed() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let mut log = flown(&model, 6);
    log.rate_rad_s[2] = None;
    log.angle_rad[2] = None;
    log.axes[2] = false;
    for ratio in ratios(&predicted(&log, &model)) {
        assert!((0.85..1.15).contains(&ratio), "{ratio}");
    }
}

#[test]
fn an_offset_centre_of_gravity_on_pitch_shows_on_pitch_alone() {
    let nominal = VehicleModel::nominal(Rig::Gimbal);
    let mut heavy = nominal.clone();
    heavy.effects = vec![Effect::parse("cg_offset:axis=pitch,cos_moment_nm=0.1", Rig::Gimbal).unwrap()];
    let log = flown(&heavy, 7);
    let missed = predicted(&log, &nominal);
    let [roll, pitch, p, q] = ratios(&missed);
    // 0.1 N m on 0.0366 kg m^2 is 2.7 rad/s^2: 0.34 rad and 1.4 rad/s at the end of a window
    assert!(pitch > 20.0 && q > 20.0, "{pitch} {q}");
    // the wrong pitch rate reaches roll through J'(phi) theta'^2 / 2: 0.2 rad/s^2 at 30 degrees of roll
    assert!(roll < 7.0 && p < 7.0, "{roll} {p}");
    let deviation: f64 = missed.samples(Channel::Angle(Axis::Pitch)).iter().map(|sample| sample.error).sum();
    assert!(deviation < 0.0, "the moment pulls the nose down");
    let exact = ratios(&predicted(&log, &heavy));
    assert!(exact.iter().all(|ratio| (0.85..1.15).contains(ratio)), "{exact:?}");
}

#[test]
fn a_prediction_is_the_same_each_time() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let log = flown_at(&model, 8, 8.0, 0.004, 1);
    assert!(predicted(&log, &model) == predicted(&log, &model));
}
