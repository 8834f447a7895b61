//! The chain from command to lift: each link alone against its definition, and their order.

use super::{close, with_effects};
use crate::model::{Rig, VehicleModel};
use crate::plant::Plant;
use crate::vehicle::propulsion::{FlyingBox, Propulsion};

const LEVER_M: f64 = 0.226 * core::f64::consts::FRAC_1_SQRT_2;

/// A vehicle whose lift is two newton times the command, without lag of its own.
fn linear(rig: Rig) -> VehicleModel {
    let mut model = VehicleModel::nominal(rig);
    model.propulsion = Propulsion::Box(FlyingBox {
        lift_offset_n: 0.0,
        lift_slope_n: 2.0,
        reaction_torque_per_lift_m: 0.05,
        battery_v: None,
    });
    model
}

#[test]
fn a_lag_lets_the_command_arrive_exponentially() {
    let mut plant = with_effects(linear(Rig::Gimbal), &["motor_lag:time_constant_s=0.03"]);
    plant.set_commands([0.4, 0.6, 0.6, 0.4]);
    let (lift_n, time_s) = (0.2, 0.0513);
    plant.advance(time_s);
    let left = libm::exp(-time_s / 0.03);
    for (motor, sign) in [-1.0, 1.0, 1.0, -1.0].into_iter().enumerate() {
        assert!(close(plant.lifts_n()[motor], 1.0 + sign * lift_n * (1.0 - left), 1e-12));
    }
    // integral of 1 - e^(-t/T): t - T (1 - e^(-t/T))
    let rate = 4.0 * LEVER_M * lift_n / 0.0115118 * (time_s - 0.03 * (1.0 - left));
    assert!(close(plant.rate_body_rad_s()[0], rate, 1e-10), "{} {rate}", plant.rate_body_rad_s()[0]);
}

/// The lag stands before the speed controller's map, and the motors of the nominal model follow behind: the same as a
/// nominal motor whose command is changed in fine stairs along the exponential.
#[test]
fn a_lag_stands_before_the_speed_controllers_map() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let mut lagging = with_effects(model.clone(), &["motor_lag:time_constant_s=0.02"]);
    lagging.set_commands([0.7; 4]);
    lagging.advance(0.03);
    let mut stairs = with_effects(model, &[]);
    const STEPS: i32 = 30_000;
    for step in 0..STEPS {
        let middle_s = 0.03 * (f64::from(step) + 0.5) / f64::from(STEPS);
        stairs.set_commands([0.7 - 0.2 * libm::exp(-middle_s / 0.02); 4]);
        stairs.advance(0.03 / f64::from(STEPS));
    }
    let (ours, expected) = (lagging.motor_speed_rad_s()[0], stairs.motor_speed_rad_s()[0]);
    // stairs of 1 us err by their square; 1e-7 of the speed is far below the change, 13 %
    assert!((ours / expected - 1.0).abs() < 1e-7, "{ours} {expected}");
}

/// Commands every 2.5 ms with a delay that is no multiple of it, five of them under way at a time.
#[test]
fn a_delay_shifts_the_response_by_exactly_the_delay() {
    for adaptive in [false, true] {
        let delay_s = 0.01137;
        let mut model = VehicleModel::nominal(Rig::Gimbal);
        let started = |model: &VehicleModel| {
            let mut plant = Plant::new(model);
            if adaptive {
                plant.integrate_adaptively(1e-12);
            }
            plant
        };
        let commands = |step: u32| {
            let turn = 0.005 + 0.02 * libm::sin(f64::from(step) * 0.7);
            [0.5 - turn, 0.5 + turn, 0.5 + turn, 0.5 - 0.9 * turn]
        };
        let mut prompt = started(&model);
        model.effects = vec![crate::effects::Effect::parse("actuation_delay:delay_s=0.01137", Rig::Gimbal).unwrap()];
        let mut late = started(&model);
        for step in 0..40 {
            prompt.set_commands(commands(step));
            late.set_commands(commands(step));
            prompt.advance(2.5e-3);
            late.advance(2.5e-3);
        }
        late.advance(delay_s);
        let (prompt, late) = (prompt.truth(), late.truth());
        assert!(prompt.roll_rad.abs() > 1e-3);
        // the same motion later; steps are cut elsewhere, which moves the fixed method by its own error, 1e-5 of it
        let tolerance = if adaptive { 1e-11 } else { 2e-5 * prompt.roll_rad.abs() };
        assert!(close(prompt.roll_rad, late.roll_rad, tolerance), "{} {}", prompt.roll_rad, late.roll_rad);
        assert!(close(prompt.pitch_rad, late.pitch_rad, tolerance));
    }
}

#[test]
fn clipped_commands_do_what_the_limits_do() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let mut clipped = with_effects(model.clone(), &["command_clipping:min=0.3,max=0.7"]);
    let mut limited = with_effects(model, &[]);
    clipped.set_commands([0.1, 0.9, 0.5, 0.3]);
    limited.set_commands([0.3, 0.7, 0.5, 0.3]);
    clipped.advance(0.05);
    limited.advance(0.05);
    assert_eq!(clipped.motor_speed_rad_s(), limited.motor_speed_rad_s());
    assert_eq!(clipped.truth().roll_rad, limited.truth().roll_rad);
}

/// Clipping before the lag: the lag moves towards the limit, not towards the command.
#[test]
fn the_chain_clips_before_it_lags() {
    let effects = ["motor_lag:time_constant_s=0.03", "command_clipping:max=0.6"];
    let mut plant = with_effects(linear(Rig::Gimbal), &effects);
    plant.set_commands([1.0; 4]);
    plant.advance(0.03);
    let expected = 2.0 * (0.6 - 0.1 * libm::exp(-1.0));
    assert!(close(plant.lifts_n()[0], expected, 1e-12), "{:?}", plant.lifts_n());
}

#[test]
fn weaker_motors_lift_less_at_the_same_speed() {
    let model = VehicleModel::nominal(Rig::Free);
    let nominal = with_effects(model.clone(), &[]);
    let all = with_effects(model.clone(), &["thrust_scale:scale=0.9"]);
    let mut one = with_effects(model, &["weak_motor:motor=3,scale=0.8"]);
    assert_eq!(nominal.motor_speed_rad_s(), all.motor_speed_rad_s());
    let lift_n = nominal.lifts_n()[0];
    assert_eq!(all.lifts_n(), [0.9 * lift_n; 4]);
    assert_eq!(one.lifts_n(), [lift_n, lift_n, 0.8 * lift_n, lift_n]);
    // front left, clockwise: right side up, nose down, and its reaction turns the body less to the left
    one.advance(1e-4);
    let [p, q, r] = one.rate_body_rad_s();
    let lost_n = 0.2 * lift_n;
    let reaction_m = 1.779e-7 / 1.105e-5;
    assert!(close(p, -LEVER_M * lost_n / 0.0115118 * 1e-4, 1e-9), "{p}");
    assert!(close(q, -LEVER_M * lost_n / 0.0115118 * 1e-4, 1e-9), "{q}");
    assert!(close(r, reaction_m * lost_n / 0.020 * 1e-4, 1e-9), "{r}");
}

#[test]
fn lift_falls_with_time_or_with_the_batterys_voltage() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let lift_n = with_effects(model.clone(), &[]).lifts_n()[0];
    let mut by_time = with_effects(model.clone(), &["battery_sag:per_s=0.01"]);
    by_time.advance(7.0);
    assert!(close(by_time.lifts_n()[2], lift_n * 0.93, 1e-9));

    let mut by_volt = with_effects(model, &["battery_sag:per_volt=0.1,fall_v_s=0.05"]);
    let first_second = (0..1000).map(|_| {
        by_volt.advance(1e-3);
        by_volt.battery_v()
    });
    let mean_v = first_second.sum::<f64>() / 1000.0;
    by_volt.advance(9.0);
    assert!(close(by_volt.battery_v(), 12.0 - 0.5, 1e-9));
    // the mean of a thousand samples, each at the end of its millisecond, is half a millisecond late: 2.5e-5 V
    assert!(close(by_volt.lifts_n()[0], lift_n * (1.0 - 0.1 * (mean_v - by_volt.battery_v())), 5e-6 * lift_n));
    by_volt.set_battery_drop_v(2.0);
    assert!(close(by_volt.lifts_n()[0], lift_n * 0.8, 1e-12));
}
