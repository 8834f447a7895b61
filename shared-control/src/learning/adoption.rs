//! From what was learnt to another model, and whether it may fly.
//!
//! A model that differs from the one that flies is proposed when the data tell gain and lag well enough and what flies
//! is not among what they allow. It is flown only if its controller, rehearsed with every corner of what they allow, is
//! stable and keeps its peak sensitivity, in the calm observer and in the alert one. Else it is refused, and what flew
//! flies on.

use super::confidence::{AXES, Learnt, Range};
use super::lag_bank::LAG_MAX_S;
use super::rehearsal::{AxisBody, AxisController, rehearse};
use crate::config::{Tuning, observed};
use crate::elementary::{larger, magnitude};
use crate::torque_observer::DisturbanceAlert;
use crate::vehicle::{Actuation, VehicleParameters};

/// Half of the widest range over its best value that is certain enough.
const GAIN_CERTAIN: f32 = 0.15;
const LAG_CERTAIN: f32 = 0.25;
/// The same for a short lag, s.
const LAG_CERTAIN_S: f32 = 0.003;
/// What is not worth a change, as a share.
const GAIN_ALIKE: f32 = 0.05;
const LAG_ALIKE: f32 = 0.08;
/// Largest peak sensitivity with any vehicle that the data allow: a phase margin of 23 degrees at least.
pub const PEAK_SENSITIVITY_MAX: f32 = 2.5;

/// A vehicle's model beside the one that everything began with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearntModel {
    /// Angular acceleration per torque over that of the first model, roll and pitch.
    pub gain: [f32; AXES],
    /// Time constant of the motors' lag, s.
    pub lag_s: f32,
}

/// Why a model may not fly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// With a vehicle that the data allow the loop is not stable.
    Unstable {
        /// 0 roll, 1 pitch.
        axis: usize,
    },
    /// With a vehicle that the data allow the sensitivity's peak is too high.
    Sensitive {
        /// 0 roll, 1 pitch.
        axis: usize,
        /// The peak.
        peak_sensitivity: f32,
    },
}

impl LearntModel {
    /// What is flown before anything was learnt.
    pub fn first(vehicle: &VehicleParameters) -> Self {
        Self { gain: [1.0; AXES], lag_s: vehicle.actuation.lag_s }
    }

    /// The first vehicle as this model has it. The torque's unit stays that of the first: what the motors lift too
    /// little is counted as inertia.
    pub fn of(&self, first: &VehicleParameters) -> VehicleParameters {
        let [roll, pitch] = self.gain;
        let [roll_kg_m2, pitch_kg_m2, yaw_kg_m2] = first.inertia_kg_m2;
        VehicleParameters {
            inertia_kg_m2: [roll_kg_m2 / roll, pitch_kg_m2 / pitch, yaw_kg_m2],
            ring_inertia_kg_m2: first.ring_inertia_kg_m2 / pitch,
            actuation: Actuation { lag_s: self.lag_s, ..first.actuation },
            ..*first
        }
    }

    /// Another model, where the data say that this one is wrong and are certain of what is right.
    pub fn corrected(&self, learnt: &Learnt) -> Option<Self> {
        let Learnt { gain, lag_s } = learnt;
        let lag_is_certain = 0.5 * (lag_s.high - lag_s.low) <= larger(LAG_CERTAIN_S, LAG_CERTAIN * lag_s.best);
        // a lag that may be beyond the bank is none, and one that no gain goes with is no motors'
        let is_known = gain.iter().flatten().any(is_certain) && lag_s.high < LAG_MAX_S;
        if !(lag_is_certain && is_known) {
            return None;
        }
        let differs = |range: &Range, flown: f32, alike: f32| {
            !range.holds(flown) && magnitude(range.best - flown) > alike * range.best
        };
        let mut other = *self;
        let mut wrong = false;
        for (flown, gain) in other.gain.iter_mut().zip(gain) {
            let Some(range) = gain.as_ref().filter(|range| is_certain(range)) else { continue };
            wrong |= differs(range, *flown, GAIN_ALIKE);
            *flown = range.best;
        }
        wrong |= differs(lag_s, self.lag_s, LAG_ALIKE) && magnitude(lag_s.best - self.lag_s) > LAG_CERTAIN_S;
        other.lag_s = lag_s.best;
        wrong.then_some(other)
    }
}

fn is_certain(gain: &Range) -> bool {
    gain.best > 0.0 && gain.half_width_share() <= GAIN_CERTAIN
}

/// A controller that was made for a model, aside.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<'a> {
    /// The vehicle that it is made for.
    pub vehicle: &'a VehicleParameters,
    /// Its tuning.
    pub tuning: &'a Tuning,
    /// Steps per second.
    pub loop_rate_hz: f32,
    /// As [`Mpc::unconstrained_gain`](crate::mpc::Mpc::unconstrained_gain).
    pub law: [[f32; 4]; 3],
}

/// Rehearses a candidate with every vehicle at the ends of what the data allow of the first one. An axis of which
/// nothing certain is known keeps its gain, and is rehearsed with that. Before each part of the work there is a pause.
///
/// # Errors
/// The first reason against it.
pub fn prove(
    candidate: &Candidate<'_>,
    first: &VehicleParameters,
    learnt: &Learnt,
    mut pause: impl FnMut(),
) -> Result<(), Refusal> {
    let (seen, pace) = observed(candidate.vehicle, candidate.tuning, candidate.loop_rate_hz);
    let delay_s = first.actuation.delay_s + candidate.tuning.gyro_delay_s();
    let alerts: &[DisturbanceAlert] = match candidate.tuning.mpc_disturbance_alert {
        DisturbanceAlert::Never => &[DisturbanceAlert::Never],
        _ => &[DisturbanceAlert::Never, DisturbanceAlert::Always],
    };
    for axis in 0..AXES {
        let controller = AxisController {
            law: candidate.law[axis],
            inertia_kg_m2: candidate.vehicle.inertia_kg_m2[axis],
            seen,
            pace,
        };
        let flown = first.inertia_kg_m2[axis] / candidate.vehicle.inertia_kg_m2[axis];
        let gains = match &learnt.gain[axis] {
            Some(gain) if is_certain(gain) => [gain.low, gain.high],
            _ => [flown; 2],
        };
        for (gain, lag_s) in gains.into_iter().flat_map(|gain| [learnt.lag_s.low, learnt.lag_s.high].map(|s| (gain, s)))
        {
            let body = AxisBody {
                inertia_kg_m2: first.inertia_kg_m2[axis] / gain,
                actuation: Actuation { delay_s, lag_s: larger(lag_s, 0.0) },
            };
            for alert in alerts {
                pause();
                match rehearse(&controller, &body, *alert) {
                    Some(standing) if !standing.is_stable() => return Err(Refusal::Unstable { axis }),
                    Some(standing) if standing.peak_sensitivity > PEAK_SENSITIVITY_MAX => {
                        return Err(Refusal::Sensitive { axis, peak_sensitivity: standing.peak_sensitivity });
                    }
                    Some(_) => {}
                    None => return Err(Refusal::Unstable { axis }),
                }
            }
        }
    }
    Ok(())
}
