//! What the core learns of its vehicle in flight, and what it makes of that, on the simulated rig.

use shared_control::learning::rehearsal::{AxisBody, AxisController, rehearse};
use shared_control::torque_observer::{DisturbanceAlert, Pace};
use shared_control::vehicle::Actuation;
use sil_host::control_setup::vehicle_parameters;
use sil_host::controller_file::ControllerChoice;
use sil_host::flight::FlightSetup;
use sil_host::model::{Rig, VehicleModel};
use sil_host::scenario::Scenario;

/// The rehearsal of a loop has the peak sensitivity that is measured on the whole of it, in calm: the simulated rig,
/// its sensors, the running core.
#[test]
fn a_rehearsed_loop_is_as_sensitive_as_the_measured_one() {
    let usual = "controller = \"mpc\"\n";
    let slower = "controller = \"mpc\"\n[tuning]\nmpc_prediction_step_s = 0.01\nmpc_lead_s = [0.15, 0.15, 0.15]\n";
    // what the rehearsal leaves out counts for more where the loop is quicker
    for (text, rig, tolerance) in
        [(usual, Rig::Gimbal, 0.04), (usual, Rig::Free, 0.06), (slower, Rig::Gimbal, 0.04), (slower, Rig::Free, 0.04)]
    {
        let setup = FlightSetup {
            model: VehicleModel::nominal(rig),
            controller_model: None,
            choice: ControllerChoice::parse(text, "c.toml").unwrap(),
            scenario: Scenario::test_sequence(),
            seed: 1,
        };
        let measured = setup.margins().unwrap().unwrap();
        let (vehicle, tuning) = (vehicle_parameters(&setup.known_model()), setup.tuning());
        let law = setup.control_side().unwrap().planner().unwrap().unconstrained_gain().unwrap();
        let actuation = Actuation { delay_s: vehicle.actuation.delay_s + 0.00225, ..vehicle.actuation };
        for axis in 0..2 {
            let pace = Pace {
                bandwidth_rad_s: tuning.mpc_disturbance_bandwidth_rad_s,
                alert: DisturbanceAlert::Never,
                step_s: 0.0025,
            };
            let inertia_kg_m2 = vehicle.inertia_kg_m2[axis];
            let controller = AxisController { law: law[axis], inertia_kg_m2, seen: actuation, pace };
            let body = AxisBody { inertia_kg_m2, actuation };
            let rehearsed = rehearse(&controller, &body, DisturbanceAlert::Never).unwrap();
            assert!(rehearsed.is_stable());
            let peak = f64::from(rehearsed.peak_sensitivity);
            // the gyro's filter is more than a delay, motors are no first-order lags, the grids of frequencies differ
            let expected = measured[axis].sensitivity_peak;
            assert!((peak / expected - 1.0).abs() < tolerance, "{rig:?}, axis {axis}: {peak}, measured {expected}");
        }
    }
}
