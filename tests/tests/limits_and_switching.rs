//! What the motors' limits and several linearisations are for, in whole flights; docs/motor-limits.md and
//! docs/switching-mpc.md have more of them.

use campaigns::limits_and_switching::{Flown, route};
use sil_host::controller_file::{ReferenceName, TuningChange};
use sil_host::model::{Rig, VehicleModel};
use sil_host::scenario::Scenario;

fn gimbal(tuning: TuningChange, scenario: &Scenario) -> Flown {
    Flown::mean(&VehicleModel::nominal(Rig::Gimbal), tuning, scenario, 1)
}

#[test]
fn rolled_the_linearisation_of_that_roll_flies_better_and_level_nothing_changes() {
    let with = |linearisations| TuningChange { mpc_linearisations: Some(linearisations), ..TuningChange::default() };
    let rolled = route(&[(60.0, 0.0), (60.0, 60.0), (60.0, 0.0), (60.0, -60.0)], None);
    let (single, several) = (gimbal(with(1), &rolled), gimbal(with(4), &rolled));
    assert!(several.overshoot_pct[1] < 0.5 * single.overshoot_pct[1], "{single:?} {several:?}");
    assert!(several.rms_deg[1] < single.rms_deg[1], "{single:?} {several:?}");
    assert!(several.effort < 0.9 * single.effort, "{single:?} {several:?}");
    let small = route(&[(10.0, 10.0), (0.0, 0.0)], None);
    let (single, several) = (gimbal(with(1), &small), gimbal(with(4), &small));
    assert!((several.rms_deg[1] / single.rms_deg[1] - 1.0).abs() < 0.005, "{single:?} {several:?}");
}

/// Raw steps of both axes together, which request all that the motors have.
#[test]
fn the_motors_limits_give_both_axes_more_than_boxes_or_keep_the_lift() {
    let corner = route(&[(60.0, 60.0), (0.0, 0.0), (-60.0, 60.0), (0.0, 0.0)], Some(0.5));
    let tuning = TuningChange {
        mpc_reference: Some(ReferenceName::Setpoint),
        mpc_linearisations: Some(4),
        ..TuningChange::default()
    };
    let boxes = gimbal(tuning, &corner);
    let limits = |reserve| TuningChange { mpc_motor_limits: Some(true), mpc_torque_reserve: Some(reserve), ..tuning };
    let (reserved, kept) = (gimbal(limits(0.5), &corner), gimbal(limits(0.0), &corner));
    for axis in 0..2 {
        assert!(reserved.rms_deg[axis] < 0.98 * boxes.rms_deg[axis], "{boxes:?} {reserved:?}");
    }
    assert!(reserved.aside_deg < boxes.aside_deg, "{boxes:?} {reserved:?}");
    assert!(boxes.lift_changed_pct > 3.0 && kept.lift_changed_pct < 0.5, "{boxes:?} {kept:?}");
}
