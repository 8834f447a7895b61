//! Other weights, another model, another controller in the middle of a flight: prepared aside, taken over between two
//! steps.

use shared_control::config::Controller;
use shared_control::flight_core::TorqueSource;
use sil_host::controller_file::ControllerChoice;
use sil_host::cosim::{self, contract::HELD_US, record::FlightRecord};
use sil_host::effects::Effect;
use sil_host::flight::FlightSetup;
use sil_host::model::{Rig, VehicleModel};
use sil_host::plant::Plant;
use sil_host::scenario::Scenario;
use sil_host::sensors::Sensors;

const CHANGE_S: f64 = 3.0;

/// A pitch that is held against an off-balance ring, so that there is a torque that could be lost.
fn setup(choice: ControllerChoice, known: Option<&str>) -> FlightSetup {
    let effect = |text: &str| Effect::parse(text, Rig::Gimbal).unwrap();
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    model.effects.push(effect("cg_offset:axis=pitch,cos_moment_nm=0.1"));
    let controller_model = known.map(|text| {
        let mut known = VehicleModel::nominal(Rig::Gimbal);
        known.effects.push(effect(text));
        known
    });
    let script = "duration_s = 5.0\n[[step]]\nat_s = 0.5\npitch_deg = 20\nroll_deg = -10\n";
    FlightSetup { model, controller_model, choice, scenario: Scenario::parse(script, "s.toml").unwrap(), seed: 1 }
}

fn mpc(control_horizon: usize, tuning: &str) -> ControllerChoice {
    let text = format!("controller = \"mpc\"\ncontrol_horizon = {control_horizon}\n[tuning]\n{tuning}");
    ControllerChoice::parse(&text, "c.toml").unwrap()
}

/// Flies one set-up, without noise, and another from the middle on.
fn fly(before: &FlightSetup, after: &FlightSetup) -> FlightRecord {
    let mut control = before.control_side().unwrap();
    control.change_at(HELD_US + (CHANGE_S * 1e6) as u64, after.control_side().unwrap());
    let mut plant = Plant::new(&before.model);
    cosim::fly(&before.design_parameters(), &mut plant, &mut Sensors::ideal(), &mut control, &before.scenario, None)
}

#[test]
fn nothing_jumps() {
    let nominal = || setup(mpc(5, ""), None);
    let cascade = || setup(ControllerChoice::nominal(Controller::Cascade), None);
    for (name, before, after) in [
        (
            "other weights",
            nominal(),
            setup(mpc(5, "mpc_increment_weight = [30.0, 3.0, 300.0]\nmpc_lead_s = [0.05, 0.2, 0.1]\n"), None),
        ),
        ("another horizon", nominal(), setup(mpc(30, ""), None)),
        ("fewer inputs", setup(mpc(30, ""), None), setup(mpc(1, ""), None)),
        ("a model that knows a lag", nominal(), setup(mpc(5, ""), Some("motor_lag:time_constant_s=0.02"))),
        (
            "a model that knows another inertia",
            nominal(),
            setup(mpc(5, ""), Some("inertia_error:axis=pitch,scale=0.8")),
        ),
        ("MPC to cascade", nominal(), cascade()),
        ("cascade to MPC", cascade(), nominal()),
    ] {
        let record = fly(&before, &after);
        let change = record.time_s.iter().position(|time_s| *time_s >= CHANGE_S).unwrap();
        let held_nm = record.torque_body_nm[change - 1];
        let held_rad = record.angle_rad[change - 1];
        // the moment of the ring's weight at 20 degrees of pitch
        assert!(held_nm[1].abs() > 0.08, "{name}: {held_nm:?}");
        for (row, (torque_nm, angle_rad)) in
            record.torque_body_nm.iter().zip(&record.angle_rad).enumerate().skip(change)
        {
            for axis in 0..2 {
                let (torque_nm, angle_rad) = (torque_nm[axis] - held_nm[axis], angle_rad[axis] - held_rad[axis]);
                // what is there before any change: counts of the gyro, and the end of the transient
                assert!(torque_nm.abs() < 0.006, "{name}: row {row}, axis {axis}: torque jumps by {torque_nm} N m");
                assert!(angle_rad.to_degrees().abs() < 0.25, "{name}: axis {axis}: {} deg", angle_rad.to_degrees());
            }
        }
        let flew = |row: usize| record.source[row];
        let last = record.len() - 1;
        let expected = |setup: &FlightSetup| match setup.choice.controller {
            Controller::Cascade => TorqueSource::Cascade,
            Controller::Mpc => TorqueSource::Mpc,
        };
        assert_eq!((flew(change - 1), flew(last)), (expected(&before), expected(&after)), "{name}");
        // the cascade has requested no plan, so that the first step after it has none
        let without = record.source[change..].iter().filter(|source| **source == TorqueSource::CascadeNoPlan).count();
        assert_eq!(without, usize::from(name == "cascade to MPC"), "{name}");
    }
}
