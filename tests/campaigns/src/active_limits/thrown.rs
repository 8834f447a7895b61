//! The whole of what flies, core, sensors and the gimbal's own motion, thrown out of level by a torque from outside
//! that nobody announces, on vehicles that the MPC does not expect.

use rayon::prelude::*;
use serde::Serialize;
use sil_host::scenario::Scenario;
use sil_host::sensors::random::RandomStream;

use super::regulation::around_zero;
use crate::comparison::contender::Contender;
use crate::comparison::draw::Draw;

/// When it comes, and after which it must be level again, s.
const THROWN_S: f64 = 2.0;
const LEVEL_S: f64 = 6.0;
const END_S: f64 = 7.0;
/// Longest throw, s, and its largest torque about roll and pitch, N m: such as reach every angle up to a right one.
const LONGEST_S: f64 = 0.3;
const TORQUE_MAX_NM: [f64; 2] = [0.8, 1.6];
/// Level: within this of the set-point, rad.
const LEVEL_RAD: f64 = 0.0175;
/// Bins of the largest angle, degrees; beyond a right one the gimbal's angles are no longer the vehicle's.
const BINS_DEG: [f64; 5] = [15.0, 30.0, 60.0, 90.0, f64::INFINITY];

/// The flights that were thrown so far.
#[derive(Clone, Debug, Serialize)]
pub struct Thrown {
    /// Largest angle of roll or pitch above that of the row before, up to this, degrees; none where it has no end.
    pub up_to_deg: Option<f64>,
    /// How many.
    pub flights: usize,
    /// Of these not level from four seconds after the throw on.
    pub lost: usize,
    /// Samples with a motor at a limit, mean, %.
    pub limited_pct: f64,
}

/// Flies so many throws.
pub fn throw(contender: &Contender, flights: u64) -> Vec<Thrown> {
    let flown: Vec<(f64, bool, f64)> = (0..flights).into_par_iter().map(|seed| fly(contender, seed)).collect();
    let mut least_deg = 0.0;
    BINS_DEG
        .iter()
        .map(|&up_to_deg| {
            let of: Vec<_> = flown.iter().filter(|(deg, ..)| (least_deg..up_to_deg).contains(deg)).collect();
            least_deg = up_to_deg;
            Thrown {
                up_to_deg: Some(up_to_deg).filter(|end| end.is_finite()),
                flights: of.len(),
                lost: of.iter().filter(|(_, is_level, _)| !is_level).count(),
                limited_pct: of.iter().map(|(.., limited)| limited).sum::<f64>() / of.len().max(1) as f64,
            }
        })
        .collect()
}

/// Largest angle, degrees; whether it ended level; samples with a motor at a limit, %.
fn fly(contender: &Contender, seed: u64) -> (f64, bool, f64) {
    let mut draws = RandomStream::new(seed, "thrown");
    let torque_nm = TORQUE_MAX_NM.map(|most_nm| most_nm * around_zero(&mut draws));
    let end_s = THROWN_S + LONGEST_S * draws.uniform();
    let setup = contender.setup(&Draw::new(seed), &Scenario::hover(END_S));
    let record = contender.fly(&setup, |time_s| {
        let [roll_nm, pitch_nm] = if (THROWN_S..end_s).contains(&time_s) { torque_nm } else { [0.0; 2] };
        [roll_nm, pitch_nm, 0.0]
    });
    let angles_rad: Vec<f64> =
        record.angle_of(0).iter().zip(record.angle_of(1)).map(|(roll, pitch)| roll.abs().max(pitch.abs())).collect();
    let largest = |from_s: f64| {
        let later = record.time_s.iter().zip(&angles_rad).filter(|(time_s, _)| **time_s >= from_s);
        later.map(|(_, angle_rad)| *angle_rad).fold(0.0, f64::max)
    };
    let is_level = !record.ended_early && largest(LEVEL_S) < LEVEL_RAD;
    (largest(0.0).to_degrees(), is_level, sil_host::metrics::saturated_pct(&record.commands))
}
