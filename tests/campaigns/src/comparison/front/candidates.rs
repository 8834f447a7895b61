//! What the study may change of each controller: all that its search for one column may, the shaping of its reference,
//! and of the MPC the bandwidth of its observer. The gyro's low-pass, and with it its delay, stays as it was tuned.
//!
//! In free flight both begin where a study in still air ended, of 125 points each, and the MPC with an observer that is
//! faster in calm.

use shared_control::config::Tuning;
use sil_host::control_setup::vehicle_parameters;
use sil_host::controller_file::TuningChange;
use sil_host::model::{Rig, VehicleModel};

use crate::comparison::contenders::{self, CALM_BANDWIDTH_RAD_S, GYRO_DELAY_S, RATE_MAX, SHAPING};
use crate::comparison::tuning::{Form, Parameter, Tunable, rounded};

const CASCADE_IN_FREE_FLIGHT: [f64; 8] = [11.46, 3.5, 26.26, 34.58, 38.36, 1.762, 30.44, 0.2244];
const MPC_IN_FREE_FLIGHT: [f64; 6] = [69.32, 0.6391, 0.04879, 0.1098, 0.003432, 4.0];

fn shaping() -> [Parameter; 2] {
    [
        Parameter { field: "shaping_gain_1_s", form: Form::Tilt { pitch: 1.0, yaw: 3.0 }, start: SHAPING.gain_1_s },
        Parameter { field: "acceleration_share", form: Form::Number, start: SHAPING.acceleration_share },
    ]
}

/// The cascade, on the gimbal from where its search for one column begins: it keeps the limits there, tuned for RMS it
/// does not.
pub fn cascade(rig: Rig) -> Tunable<8> {
    let for_rms = contenders::cascade(&SHAPING);
    let [gain, share] = shaping();
    let [angle, proportional, integral, derivative, cutoff, ahead] = for_rms.parameters;
    let on_gimbal = Tunable {
        name: for_rms.name,
        stand_in: None,
        rig: Rig::Gimbal,
        fixed: format!("controller = \"pid\"\n[tuning]\n{RATE_MAX}"),
        parameters: [gain, share, angle, proportional, integral, derivative, cutoff, ahead],
    };
    match rig {
        Rig::Gimbal => on_gimbal,
        Rig::Free => in_free_flight(on_gimbal, CASCADE_IN_FREE_FLIGHT),
    }
}

/// The MPC, on the gimbal from where it was tuned for RMS.
pub fn mpc(rig: Rig) -> Tunable<6> {
    let [gain, share] = shaping();
    let [weight, lead, step] = contenders::mpc_plan([0.04789, 0.07725, 0.007659]);
    let calm = Parameter { field: "mpc_disturbance_bandwidth_rad_s", form: Form::Number, start: CALM_BANDWIDTH_RAD_S };
    let on_gimbal = Tunable {
        name: "MPC",
        stand_in: None,
        rig: Rig::Gimbal,
        fixed: contenders::mpc_head(RATE_MAX)
            + &format!("mpc_gyro_delay_s = {GYRO_DELAY_S:?}\ngyro_cutoff_hz = 96.26\n"),
        parameters: [gain, share, weight, lead, step, calm],
    };
    match rig {
        Rig::Gimbal => on_gimbal,
        Rig::Free => in_free_flight(on_gimbal, MPC_IN_FREE_FLIGHT),
    }
}

/// From other starts; roll and pitch alike, and yaw, which no rig locks there, as it follows from the vehicle.
fn in_free_flight<const N: usize>(on_gimbal: Tunable<N>, starts: [f64; N]) -> Tunable<N> {
    let shipped = Tuning::for_vehicle(&vehicle_parameters(&VehicleModel::nominal(Rig::Free)));
    let shipped = serde_json::to_value(TuningChange::all_of(&shipped)).unwrap_or_default();
    let yaw_of = |field: &str| shipped.get(field)?.get(2)?.as_f64().map(rounded);
    let mut start = starts.into_iter();
    let parameters = on_gimbal.parameters.map(|parameter| {
        let form = match parameter.form {
            Form::Number => Form::Number,
            Form::Tilt { yaw, .. } => Form::Tilt { pitch: 1.0, yaw: yaw_of(parameter.field).unwrap_or(yaw) },
        };
        Parameter { form, start: start.next().unwrap_or(parameter.start), ..parameter }
    });
    Tunable { rig: Rig::Free, parameters, ..on_gimbal }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both can be flown from where they begin, and yaw is what ships.
    #[test]
    fn in_free_flight_yaw_is_as_it_ships() {
        let shipped = Tuning::for_vehicle(&vehicle_parameters(&VehicleModel::nominal(Rig::Free)));
        let (mpc, cascade) = (mpc(Rig::Free), cascade(Rig::Free));
        let [mpc, cascade] = [mpc.contender(&mpc.start()), cascade.contender(&cascade.start())];
        assert!(mpc.can_fly() && cascade.can_fly());
        let weight = mpc.choice.tuning.mpc_increment_weight.unwrap();
        assert!(weight[0] == weight[1] && (weight[2] / shipped.mpc_increment_weight[2] - 1.0).abs() < 1e-3);
        let angle = cascade.choice.tuning.angle_gain_1_s.unwrap();
        assert!(angle[0] == 26.26 && angle[1] == 26.26 && (angle[2] / shipped.angle_gain_1_s[2] - 1.0).abs() < 1e-3);
    }
}
