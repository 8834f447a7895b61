//! Sections 5.3 and 5.4 flown again: each controller in the simulation and "in the testbed", which here is the
//! simulated one with the ring off balance and noise in its sensors, and the deviation between the two as table 5.1
//! measures it.

use rayon::prelude::*;
use serde::Serialize;

use super::copter_cascade::{IntegralLimit, copter_cascade};
use super::testbed::{RING_MOMENT_NM, off_balance};
use crate::controller_file::ControllerChoice;
use crate::cosim::record::FlightRecord;
use crate::flight::{Axes, FlightSetup, SetupError};
use crate::model::{Rig, SensorNoise, VehicleModel};
use crate::scenario::Scenario;
use crate::statistics::mean_absolute_deviation;

/// Rows of the thesis' log per second (section 5.3.3).
const LOG_RATE_HZ: f64 = 10.0;
/// Seed of the testbed's noise.
const SEED: u64 = 1;
/// Factors on Copter's gains that are flown.
const RATE_FACTORS: [f64; 6] = [1.0, 1.5, 2.0, 3.0, 4.0, 6.0];
/// How late a log may begin, s.
const LATE_S: [f64; 5] = [0.0, 0.05, 0.1, 0.15, 0.2];
/// Halvings of the interval in which a factor is sought: to 1e-4.
const HALVINGS: usize = 14;

/// A controller in the simulation and in the testbed.
#[derive(Clone, Debug)]
pub struct Pair {
    /// The balanced vehicle, without noise.
    pub simulated: FlightRecord,
    /// The ring off balance, with noise.
    pub tested: FlightRecord,
}

/// Mean deviations of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// Mean |simulated - tested| of roll at the thesis' rows, degrees.
    pub roll_deg: f64,
    /// The same of pitch.
    pub pitch_deg: f64,
}

/// Copter's cascade with a factor on its rate loop's gains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CopterRow {
    /// The factor.
    pub rate_factor: f64,
    /// With Copter's limit of the integral.
    pub limited: Deviation,
    /// Without it.
    pub unlimited: Deviation,
}

/// What a log that begins late makes of flights that are alike.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LateRow {
    /// How late, s.
    pub late_s: f64,
    /// Under the thesis' MPC.
    pub thesis_mpc: Deviation,
    /// Under this project's cascade.
    pub cascade: Deviation,
}

impl Pair {
    /// Flies both.
    ///
    /// # Errors
    /// [`SetupError`] where the controller can't fly.
    pub fn fly(choice: ControllerChoice) -> Result<Self, SetupError> {
        let balanced = VehicleModel { noise: SensorNoise::NONE, ..VehicleModel::nominal(Rig::Gimbal) };
        Ok(Self { simulated: fly(balanced, choice)?, tested: fly(off_balance(RING_MOMENT_NM), choice)? })
    }

    /// Table 5.1's measure, the test's log `late_s` behind.
    pub fn deviation(&self, late_s: f64) -> Deviation {
        let of_axis = |axis: usize| {
            let (simulated, tested) = (&self.simulated.angle_rad, &self.tested.logged_angle_rad);
            let step_s = step_s(&self.simulated.time_s);
            let rows = (simulated.len().min(tested.len()) as f64 * step_s * LOG_RATE_HZ) as usize;
            let row_at = |time_s: f64| (time_s / step_s).round().max(0.0) as usize;
            let at = |row: usize| {
                let time_s = row as f64 / LOG_RATE_HZ;
                Some((simulated.get(row_at(time_s))?[axis], tested.get(row_at(time_s + late_s))?[axis]))
            };
            let (simulated, tested): (Vec<f64>, Vec<f64>) = (0..rows).filter_map(at).unzip();
            mean_absolute_deviation(&simulated, &tested).unwrap_or(f64::NAN).to_degrees()
        };
        Deviation { roll_deg: of_axis(0), pitch_deg: of_axis(1) }
    }

    /// Figures of the simulated and of the tested flight.
    pub fn axes(&self) -> [Axes; 2] {
        [&self.simulated, &self.tested].map(FlightSetup::axes)
    }
}

fn step_s(time_s: &[f64]) -> f64 {
    match time_s {
        [first, second, ..] => second - first,
        _ => f64::NAN,
    }
}

/// The test sequence under a controller that was made for the balanced vehicle.
pub(super) fn fly(model: VehicleModel, choice: ControllerChoice) -> Result<FlightRecord, SetupError> {
    let setup = FlightSetup { model, controller_model: None, choice, scenario: Scenario::test_sequence(), seed: SEED };
    Ok(setup.fly()?.record)
}

fn copter(rate_factor: f64, limit: IntegralLimit) -> Result<Deviation, SetupError> {
    Ok(Pair::fly(copter_cascade(&VehicleModel::nominal(Rig::Gimbal), rate_factor, limit))?.deviation(0.0))
}

/// Copter's cascade with stiffer and stiffer rate loops.
///
/// # Errors
/// [`SetupError`]: none of these is refused.
pub fn copter_rows() -> Result<Vec<CopterRow>, SetupError> {
    let of = |rate_factor| {
        let (limited, unlimited) =
            (copter(rate_factor, IntegralLimit::Copter)?, copter(rate_factor, IntegralLimit::Motors)?);
        Ok(CopterRow { rate_factor, limited, unlimited })
    };
    RATE_FACTORS.into_par_iter().map(of).collect()
}

/// Among factors that bracket it in `rows`, the one with which the limited cascade deviates by `pitch_deg`.
///
/// # Errors
/// [`SetupError`]: none of these is refused.
pub fn factor_for(pitch_deg: f64, rows: &[CopterRow]) -> Result<Option<f64>, SetupError> {
    let bracket = rows.windows(2).find(|pair| {
        let [softer, stiffer] = [pair[0].limited.pitch_deg, pair[1].limited.pitch_deg];
        softer >= pitch_deg && stiffer < pitch_deg
    });
    let Some([softer, stiffer]) = bracket else { return Ok(None) };
    let (mut low, mut high) = (softer.rate_factor, stiffer.rate_factor);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let is_softer = copter(middle, IntegralLimit::Copter)?.pitch_deg >= pitch_deg;
        *(if is_softer { &mut low } else { &mut high }) = middle;
    }
    Ok(Some(0.5 * (low + high)))
}

/// The deviations of both controllers if the test's log begins late.
pub fn late_rows(mpc: &Pair, cascade: &Pair) -> Vec<LateRow> {
    let row = |late_s| LateRow { late_s, thesis_mpc: mpc.deviation(late_s), cascade: cascade.deviation(late_s) };
    LATE_S.map(row).to_vec()
}
