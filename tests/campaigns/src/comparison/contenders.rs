//! Who takes part: the controllers that were tuned, as their files are kept, and what is left of the MPC without one of
//! its parts.

use sil_host::controller_file::{AlertName, ReferenceName};
use sil_host::model::Rig;

use super::contender::{Contender, StandIn};
use super::tuning::{Form, Parameter, Tunable};

/// The file of the cascade, as chosen from its front.
pub const CASCADE_FILE: &str = include_str!("../../comparison/cascade.toml");
/// The file of the MPC, as chosen from its front.
pub const MPC_FILE: &str = include_str!("../../comparison/mpc.toml");
/// The file of the cascade in free flight, as chosen from its front there.
pub const CASCADE_FREE_FILE: &str = include_str!("../../comparison/cascade-free.toml");
/// The file of the MPC in free flight, as chosen from its front there.
pub const MPC_FREE_FILE: &str = include_str!("../../comparison/mpc-free.toml");
/// The file of the cascade, as tuned for RMS and overshoot alone.
pub const CASCADE_FOR_RMS_FILE: &str = include_str!("../../comparison/cascade-for-rms.toml");
/// The file of the MPC, as tuned for RMS and overshoot alone.
pub const MPC_FOR_RMS_FILE: &str = include_str!("../../comparison/mpc-for-rms.toml");
/// The file of the INDI, as tuned for RMS and overshoot alone.
pub const INDI_FILE: &str = include_str!("../../comparison/indi.toml");

/// Squared ratio of the axes' input gains: what makes an increment of the torque as dear about pitch, measured by the
/// acceleration that it gives, as about roll. (0.0115118 / 0.0365651)^2
const PITCH_WEIGHT: f64 = 0.0991;

/// The shaping of both controllers' reference: how fast it closes in, 1/s, and which share it uses of the acceleration
/// that roll and pitch can both have at the same time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaping {
    /// Gain, 1/s.
    pub gain_1_s: f64,
    /// Share.
    pub acceleration_share: f64,
}

/// The one that was chosen: see docs/mpc-against-cascade.md.
pub const SHAPING: Shaping = Shaping { gain_1_s: 9.0, acceleration_share: 1.6 };

/// How fast a reference may turn, whatever shapes it.
pub(super) const RATE_MAX: &str = "rate_max_rad_s = [8.0, 8.0, 2.0]\n";

impl Shaping {
    fn lines(&self) -> String {
        let Self { gain_1_s, acceleration_share } = self;
        format!(
            "shaping_gain_1_s = [{gain_1_s:?}, {gain_1_s:?}, 3.0]\nacceleration_share = {acceleration_share:?}\n\
             {RATE_MAX}"
        )
    }
}

/// Bandwidth of the disturbance's estimate in calm, rad/s: the greatest that leaves a peak sensitivity of 2.0 with
/// alerts as often as they may be (docs/tuning.md).
pub(super) const CALM_BANDWIDTH_RAD_S: f64 = 10.0;
/// Delay of the gyro's low-pass at 96 Hz, s.
pub(super) const GYRO_DELAY_S: f64 = 0.00234;
/// What the bandwidth of the disturbance's estimate was tuned to by a cost without disturbances, rad/s.
const ONE_BANDWIDTH_RAD_S: f32 = 3.225;

/// The cascade before it is tuned.
pub fn cascade(shaping: &Shaping) -> Tunable<6> {
    let tilt = |yaw| Form::Tilt { pitch: 1.0, yaw };
    Tunable {
        name: "cascade",
        stand_in: None,
        rig: Rig::Gimbal,
        fixed: format!("controller = \"pid\"\n[tuning]\n{}", shaping.lines()),
        parameters: [
            Parameter { field: "angle_gain_1_s", form: tilt(3.0), start: 22.0 },
            Parameter { field: "rate_proportional_1_s", form: tilt(9.0), start: 27.0 },
            Parameter { field: "rate_integral_1_s2", form: tilt(9.0), start: 33.0 },
            Parameter { field: "rate_derivative", form: tilt(0.0), start: 1.2 },
            Parameter { field: "rate_derivative_cutoff_hz", form: Form::Number, start: 14.0 },
            Parameter { field: "acceleration_feed_forward", form: Form::Number, start: 0.75 },
        ],
    }
}

/// What every MPC's file begins with: horizon, these lines about its reference, motors' limits, alerts.
pub(super) fn mpc_head(reference: &str) -> String {
    format!(
        "controller = \"mpc\"\ncontrol_horizon = 10\n[tuning]\n{reference}mpc_motor_limits = true\n\
         mpc_torque_reserve = 0.5\nmpc_linearisations = 3\nmpc_disturbance_alert = \"significant\"\n"
    )
}

/// Its parameters but for what filters: increments' weight, lead and prediction step, and where they begin.
pub(super) const fn mpc_plan([weight, lead_s, step_s]: [f64; 3]) -> [Parameter; 3] {
    [
        Parameter {
            field: "mpc_increment_weight",
            form: Form::Tilt { pitch: PITCH_WEIGHT, yaw: 3000.0 },
            start: weight,
        },
        Parameter { field: "mpc_lead_s", form: Form::Tilt { pitch: 1.0, yaw: 0.1 }, start: lead_s },
        Parameter { field: "mpc_prediction_step_s", form: Form::Number, start: step_s },
    ]
}

/// The MPC before it is tuned.
pub fn mpc(shaping: &Shaping) -> Tunable<4> {
    let [weight, lead, step] = mpc_plan([0.1, 0.05, 0.01]);
    Tunable {
        name: "MPC",
        stand_in: None,
        rig: Rig::Gimbal,
        fixed: mpc_head(&shaping.lines())
            + &format!(
                "mpc_disturbance_bandwidth_rad_s = {CALM_BANDWIDTH_RAD_S:?}\nmpc_gyro_delay_s = {GYRO_DELAY_S:?}\n"
            ),
        parameters: [weight, lead, step, Parameter { field: "gyro_cutoff_hz", form: Form::Number, start: 100.0 }],
    }
}

/// The INDI before it is tuned. Its file is an MPC's, in whose place it flies; the gains are fields of the cascade's
/// with the same meaning, and the cut-off is that of the derivative.
pub fn indi(shaping: &Shaping) -> Tunable<5> {
    let tilt = |yaw| Form::Tilt { pitch: 1.0, yaw };
    Tunable {
        name: "INDI",
        stand_in: Some(StandIn::Indi),
        rig: Rig::Gimbal,
        fixed: format!(
            "controller = \"mpc\"\n[tuning]\n{}mpc_reference = \"held\"\n\
             mpc_disturbance_bandwidth_rad_s = 0.0\nmpc_gyro_delay_s = 0.0\n",
            shaping.lines()
        ),
        parameters: [
            Parameter { field: "angle_gain_1_s", form: tilt(3.0), start: 5.381 },
            Parameter { field: "rate_proportional_1_s", form: tilt(9.0), start: 13.16 },
            Parameter { field: "rate_derivative_cutoff_hz", form: Form::Number, start: 19.13 },
            Parameter { field: "acceleration_feed_forward", form: Form::Number, start: 0.7798 },
            Parameter { field: "gyro_cutoff_hz", form: Form::Number, start: 66.43 },
        ],
    }
}

/// The INDI, as tuned.
pub fn tuned_indi() -> Contender {
    Contender { stand_in: Some(StandIn::Indi), ..Contender::new("INDI", INDI_FILE) }
}

/// The two, as chosen from their fronts.
pub fn tuned() -> [Contender; 2] {
    [Contender::new("MPC", MPC_FILE), Contender::new("cascade", CASCADE_FILE)]
}

/// The two, as tuned for RMS and overshoot alone, behind one shaping of the reference.
pub fn tuned_for_rms() -> [Contender; 2] {
    [Contender::new("MPC", MPC_FOR_RMS_FILE), Contender::new("cascade", CASCADE_FOR_RMS_FILE)]
}

/// Motors' lag of the gimbal's nominal vehicle over that of the F450 in free flight, 32 ms over 53 ms.
const LAG_RATIO: f32 = 0.032 / 0.053;

/// In free flight: the two as chosen from their fronts there; the MPC's quick tuning; both as they follow from the
/// vehicle; and the INDI, for which nothing follows: its tuned gains, slower by as much as the motors are.
pub fn in_free_flight() -> Vec<Contender> {
    let of = |name, text| Contender { rig: Rig::Free, ..Contender::new(name, text) };
    let mut indi = Contender { rig: Rig::Free, ..tuned_indi() };
    let tuning = &mut indi.choice.tuning;
    for gains in [&mut tuning.angle_gain_1_s, &mut tuning.rate_proportional_1_s].into_iter().flatten() {
        *gains = gains.map(|gain_1_s| LAG_RATIO * gain_1_s);
    }
    let [mpc, cascade] = shipped(Rig::Free);
    vec![
        of("MPC", MPC_FREE_FILE),
        of("cascade", CASCADE_FREE_FILE),
        of("MPC, quick", "controller = \"mpc\"\nquick = true\n"),
        mpc,
        cascade,
        indi,
    ]
}

/// The two as they follow from the vehicle.
pub fn shipped(rig: Rig) -> [Contender; 2] {
    [("MPC as it follows", "controller = \"mpc\"\n"), ("cascade as it follows", "controller = \"pid\"\n")]
        .map(|(name, text)| Contender { rig, ..Contender::new(name, text) })
}

/// Those of the campaign that says what each part of the MPC is worth: all tuned for RMS, the MPC first.
pub fn all() -> Vec<Contender> {
    let [mpc, cascade] = tuned_for_rms();
    let changed = |name, change: fn(&mut Contender)| {
        let mut contender = Contender { name, ..mpc.clone() };
        change(&mut contender);
        contender
    };
    let variants = [
        changed("MPC, one bandwidth", |c| {
            c.choice.tuning.mpc_disturbance_alert = Some(AlertName::Never);
            c.choice.tuning.mpc_gyro_delay_s = Some(0.0);
            c.choice.tuning.mpc_disturbance_bandwidth_rad_s = Some(ONE_BANDWIDTH_RAD_S);
        }),
        changed("MPC without preview", |c| c.choice.tuning.mpc_reference = Some(ReferenceName::Held)),
        changed("MPC without disturbance", |c| c.choice.tuning.mpc_disturbance_bandwidth_rad_s = Some(0.0)),
        changed("MPC without lag", |c| c.choice.tuning.mpc_knows_actuation = Some(false)),
        changed("MPC, an axis at a time", |c| c.choice.tuning.mpc_motor_limits = Some(false)),
        changed("LQI", |c| c.stand_in = Some(StandIn::Lqi)),
    ];
    [mpc.clone(), cascade, tuned_indi()].into_iter().chain(variants).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_fly_the_same_reference_where_they_were_tuned_for_rms() {
        let [mpc, cascade] = tuned_for_rms().map(|contender| contender.choice.tuning);
        assert!(mpc.shaping_gain_1_s.is_some() && mpc.acceleration_share.is_some() && mpc.rate_max_rad_s.is_some());
        assert_eq!(mpc.shaping_gain_1_s, cascade.shaping_gain_1_s);
        assert_eq!(mpc.acceleration_share, cascade.acceleration_share);
        assert_eq!(mpc.rate_max_rad_s, cascade.rate_max_rad_s);
    }
}
