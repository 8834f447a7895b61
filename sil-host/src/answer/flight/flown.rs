//! One controller's flight with its margins and eigenvalues, and what a reader of its figures must know.

use crate::flight::{Flight, FlightSetup, SetupError};
use crate::margins::Margins;
use crate::model::Rig;

use super::figures::Figure;

/// A flight with what was measured around it.
pub struct FlownController {
    /// What it is called beside others: pid, mpc, or the name of its file.
    pub name: String,
    /// How it was set up.
    pub setup: FlightSetup,
    /// Series and figures.
    pub flight: Flight,
    /// How far its loops are from instability.
    pub robustness: Robustness,
    /// Eigenvalues of roll and pitch under the unconstrained MPC.
    pub eigenvalues: Option<[[[f64; 2]; 4]; 2]>,
}

/// What is known of a loop's margins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Robustness {
    /// Nothing: measuring takes several times as long as a flight.
    NotMeasured,
    /// It oscillates by itself, and has none.
    Oscillates,
    /// Those of roll and pitch.
    Measured([Margins; 2]),
}

/// Flies one controller and measures its margins.
///
/// # Errors
/// [`SetupError`] where the configuration can't be flown.
pub fn fly_one(name: &str, setup: FlightSetup) -> Result<FlownController, SetupError> {
    let flown = fly_only(name, setup)?;
    let robustness = flown.setup.margins()?.map_or(Robustness::Oscillates, Robustness::Measured);
    Ok(FlownController { robustness, ..flown })
}

/// Flies one controller and leaves its margins alone.
///
/// # Errors
/// [`SetupError`] where the configuration can't be flown.
pub fn fly_only(name: &str, setup: FlightSetup) -> Result<FlownController, SetupError> {
    let flight = setup.fly()?;
    let eigenvalues = setup.mpc_eigenvalues()?;
    Ok(FlownController { name: name.to_owned(), setup, flight, robustness: Robustness::NotMeasured, eigenvalues })
}

/// What the eigenvalues are of.
pub fn eigenvalues_title(flown: &FlownController) -> String {
    let period_ms = 1e3 / f64::from(flown.setup.choice.rate_hz);
    format!("Closed-loop eigenvalues of the unconstrained MPC, one step = {period_ms} ms")
}

/// True if the flight fell apart, the loop oscillates by itself, or an eigenvalue lies outside of the unit circle.
pub fn is_unstable(flown: &FlownController) -> bool {
    flown.flight.record.ended_early || flown.robustness == Robustness::Oscillates || has_unstable_eigenvalue(flown)
}

fn has_unstable_eigenvalue(flown: &FlownController) -> bool {
    let unstable = |axes: &[[[f64; 2]; 4]; 2]| axes.iter().any(|axis| axis[0][0] >= 1.0);
    flown.eigenvalues.as_ref().is_some_and(unstable)
}

/// What somebody who reads the figures must know.
pub fn remarks(flown: &FlownController) -> Vec<String> {
    let name = &flown.name;
    let summary = &flown.flight.summary;
    let mut remarks = Vec::new();
    if flown.flight.record.ended_early {
        remarks.push(format!(
            "{name}: the flight ended after {:.2} s, the state was no longer finite.",
            summary.duration_s
        ));
    }
    if flown.robustness == Robustness::Oscillates {
        remarks.push(format!("{name}: at hover the loop oscillates by itself, so it has no margins."));
    }
    if has_unstable_eigenvalue(flown) {
        remarks.push(format!("{name}: without active bounds this loop is unstable, an eigenvalue has |z| >= 1."));
    }
    let axes = [summary.axes.roll, summary.axes.pitch];
    if flown.setup.model.rig() == Rig::Free && axes.iter().any(|axis| axis.settling_time_s.is_none()) {
        remarks.push(format!(
            "{name}: in still air the accelerometer of a tilted vehicle measures its thrust, which the estimator takes \
             for gravity; the estimate, and with it the vehicle, drifts a few degrees towards level while a tilt is \
             held."
        ));
    }
    remarks
}

/// A margin of roll and pitch, none where the loop has none.
pub fn margin_values(flown: &FlownController, figure: &Figure<Margins>) -> [Option<f64>; 2] {
    match flown.robustness {
        Robustness::Measured(axes) => axes.map(|margins| (figure.value)(&margins)),
        Robustness::NotMeasured | Robustness::Oscillates => [None; 2],
    }
}
