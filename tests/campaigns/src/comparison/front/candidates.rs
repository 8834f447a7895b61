//! What the study may change of each controller: all that its search for one column may, the shaping of its reference,
//! and of the MPC the bandwidth of its observer. The gyro's low-pass, and with it its delay, stays as it was tuned.

use crate::comparison::contenders::{self, PITCH_WEIGHT, SHAPING};
use crate::comparison::tuning::{Form, Parameter, Tunable};

const RATE_MAX: &str = "rate_max_rad_s = [8.0, 8.0, 2.0]\n";

fn shaping() -> [Parameter; 2] {
    [
        Parameter { field: "shaping_gain_1_s", form: Form::Tilt { pitch: 1.0, yaw: 3.0 }, start: SHAPING.gain_1_s },
        Parameter { field: "acceleration_share", form: Form::Number, start: SHAPING.acceleration_share },
    ]
}

/// The cascade, from where its search for one column begins: it keeps the limits there, tuned for RMS it does not.
pub fn cascade() -> Tunable<8> {
    let for_rms = contenders::cascade(&SHAPING);
    let [gain, share] = shaping();
    let [angle, proportional, integral, derivative, cutoff, ahead] = for_rms.parameters;
    Tunable {
        name: for_rms.name,
        stand_in: None,
        fixed: format!("controller = \"pid\"\n[tuning]\n{RATE_MAX}"),
        parameters: [gain, share, angle, proportional, integral, derivative, cutoff, ahead],
    }
}

/// The MPC, from where it was tuned for RMS.
pub fn mpc() -> Tunable<6> {
    let [gain, share] = shaping();
    Tunable {
        name: "MPC",
        stand_in: None,
        fixed: format!(
            "controller = \"mpc\"\ncontrol_horizon = 10\n[tuning]\n{RATE_MAX}mpc_motor_limits = true\n\
             mpc_torque_reserve = 0.5\nmpc_linearisations = 3\nmpc_disturbance_alert = \"significant\"\n\
             mpc_gyro_delay_s = 0.00234\ngyro_cutoff_hz = 96.26\n"
        ),
        parameters: [
            gain,
            share,
            Parameter {
                field: "mpc_increment_weight",
                form: Form::Tilt { pitch: PITCH_WEIGHT, yaw: 3000.0 },
                start: 0.04789,
            },
            Parameter { field: "mpc_lead_s", form: Form::Tilt { pitch: 1.0, yaw: 0.1 }, start: 0.07725 },
            Parameter { field: "mpc_prediction_step_s", form: Form::Number, start: 0.007659 },
            Parameter { field: "mpc_disturbance_bandwidth_rad_s", form: Form::Number, start: 10.0 },
        ],
    }
}
