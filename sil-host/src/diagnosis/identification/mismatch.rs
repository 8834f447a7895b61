//! Whether a model can be that of a log at all: on the same rig, and within a factor of what the log shows without any
//! model. A diagnosis against another vehicle's model is confident and wrong.

use super::effectiveness_rad_s2;
use crate::axis::Axis;
use crate::diagnosis::baseline::steady_collective;
use crate::log::{Log, sanity};
use crate::model::{Rig, VehicleModel};

/// What is a mistake of the model's numbers is for the diagnosis; a vehicle that answers by so many times more or less
/// is another one. The regression sees an answer behind a lag too small by some tens of percent.
const OTHER_VEHICLE: f64 = 3.0;

/// Why a model can't be that of a log's vehicle, in words; `None` where nothing speaks against it.
pub fn mismatch(log: &Log, model: &VehicleModel) -> Option<String> {
    rig(log, model).or_else(|| answers(log, model))
}

fn rig(log: &Log, model: &VehicleModel) -> Option<String> {
    let shown = log.rig_shown()?;
    let (flew, by) = (shown.is_free, shown.by);
    match model.rig() {
        Rig::Gimbal if flew => {
            Some(format!("the log is of a free flight (by {by}), the model of a vehicle on the gimbal"))
        }
        Rig::Free if !flew => Some(format!("a rig held the vehicle (by {by}), the model is of a free vehicle")),
        _ => None,
    }
}

fn answers(log: &Log, model: &VehicleModel) -> Option<String> {
    log.motors()?;
    let command = steady_collective(log).ok().flatten()?;
    let of_model = effectiveness_rad_s2(model, command);
    let shown = sanity::accelerations_per_command(log);
    let turns = |axis: &Axis| model.rig() == Rig::Free || *axis != Axis::Yaw;
    let differs = |axis: Axis| {
        let shown = shown[axis.index()].filter(|answer| answer.is_sure && answer.value > 0.0)?.value;
        let expected = 0.25 * of_model.iter().map(|of| of[axis.index()].abs()).sum::<f64>();
        let times = shown / expected;
        (!(1.0 / OTHER_VEHICLE..=OTHER_VEHICLE).contains(&times)).then(|| {
            let name = axis.name();
            format!("{name} answers to a motor's command with about {shown:.0} rad/s2, in the model with {expected:.0}")
        })
    };
    let all: Vec<String> = Axis::ALL.into_iter().filter(turns).filter_map(differs).collect();
    (!all.is_empty()).then(|| all.join("; "))
}
