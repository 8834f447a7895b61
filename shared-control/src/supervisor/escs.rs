//! Teaching the ESCs the ends of the pulses, with the propellers off.
//!
//! An ESC that sees full throttle when its power comes takes that for the upper end, and the low throttle after it for
//! the lower one. An ESC that has power already and is armed takes full throttle for full throttle. So the full pulse
//! is sent only to ESCs that have none: the battery must be measured (one was seen since start, so the module is
//! wired), and be absent now. The person then connects it.
//!
//! ```text
//!   CalibrateEscs -> Battery: full -- battery comes --> High: full, 4 s --> Low: low, 4 s --> Disarmed
//!                      '-- 30 s without one --> Disarmed     '--- battery goes: Disarmed ---'
//! ```

use super::{Arming, DisarmedBecause, EscStage, Findings, Refusal, link_is_lost, standing_refusal};
use crate::sensing::battery::ABSENT_BELOW_V;
use crate::signals::StepInput;

/// How long a person has to connect the battery, µs.
pub const BATTERY_WITHIN_US: u64 = 30_000_000;
/// Full throttle from the battery on, µs: BLHeli wants it for 2 to 3 s after its start, and says so by beeps.
pub const HIGH_US: u64 = 4_000_000;
/// Low throttle after it, µs.
pub const LOW_US: u64 = 4_000_000;

/// The first reason against it: any doubt that the ESCs are without power.
pub(super) fn refusal(input: &StepInput, findings: &Findings) -> Option<Refusal> {
    if !input.blocks.esc_calibration {
        return Some(Refusal::EscCalibrationNotSet);
    }
    standing_refusal(input, findings).or(match battery_is_connected(input) {
        None => Some(Refusal::BatteryUnmeasured),
        Some(true) => Some(Refusal::BatteryConnected),
        Some(false) => (!findings.battery_seen).then_some(Refusal::BatteryNeverSeen),
    })
}

pub(super) fn start(time_us: u64) -> Arming {
    Arming::EscCalibration { stage: EscStage::Battery, since_us: time_us }
}

/// The next stage, or the end.
pub(super) fn next(stage: EscStage, since_us: u64, input: &StepInput, findings: &Findings) -> Arming {
    let ended = Arming::Disarmed(DisarmedBecause::EscCalibrationEnded);
    let stays = Arming::EscCalibration { stage, since_us };
    let on_to = |stage| Arming::EscCalibration { stage, since_us: input.time_us };
    let lasted_us = input.time_us.saturating_sub(since_us);
    match (stage, battery_is_connected(input)) {
        _ if link_is_lost(input, findings) => ended,
        (EscStage::Battery, Some(true)) => on_to(EscStage::High),
        (EscStage::Battery, Some(false)) if lasted_us < BATTERY_WITHIN_US => stays,
        (EscStage::High, Some(true)) => {
            if lasted_us < HIGH_US {
                stays
            } else {
                on_to(EscStage::Low)
            }
        }
        (EscStage::Low, Some(true)) if lasted_us < LOW_US => stays,
        (EscStage::Low, Some(true)) => Arming::Disarmed(DisarmedBecause::EscsCalibrated),
        _ => ended,
    }
}

/// None where it is not measured. A voltage that is no number counts as connected.
fn battery_is_connected(input: &StepInput) -> Option<bool> {
    input.battery_v.map(|volts| volts >= ABSENT_BELOW_V || volts.is_nan())
}
