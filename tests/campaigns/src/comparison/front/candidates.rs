//! What the study may change of each controller: all that its search for one column may, the shaping of its reference,
//! and of the MPC the bandwidth of its observer. The gyro's low-pass, and with it its delay, stays as it was tuned.

use crate::comparison::contenders::{self, CALM_BANDWIDTH_RAD_S, GYRO_DELAY_S, RATE_MAX, SHAPING};
use crate::comparison::tuning::{Form, Parameter, Tunable};

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
    let [weight, lead, step] = contenders::mpc_plan([0.04789, 0.07725, 0.007659]);
    let calm = Parameter { field: "mpc_disturbance_bandwidth_rad_s", form: Form::Number, start: CALM_BANDWIDTH_RAD_S };
    Tunable {
        name: "MPC",
        stand_in: None,
        fixed: contenders::mpc_head(RATE_MAX)
            + &format!("mpc_gyro_delay_s = {GYRO_DELAY_S:?}\ngyro_cutoff_hz = 96.26\n"),
        parameters: [gain, share, weight, lead, step, calm],
    }
}
