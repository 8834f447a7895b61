//! Whether the modelled controller produced the logged commands, and if not, which of its parameters differs.
//!
//! ```text
//!   log --inputs: the core's own steps--> replay at the modelled numbers --> residual: flown less replayed
//!   log's references --comparison: simulated flight--> replay --instruments: what each number would do, without noise
//!   residual --whitening--> scores along the instruments --fit--> the numbers that differ, or none
//! ```
//! The thesis could not say whether its modelled controller was the version that flew (section 5.3.2). Here the model
//! is the control core itself. Of the vehicle's model only the numbers that the controllers know enter, so that an
//! error of the plant is not taken for one of the controller; the simulated flight need only be like the real one.
//!
//! What a log of a flight does not show: gains of yaw (it holds no rate of the heading's set-point), the throttle that
//! was commanded, numbers that have no effect in what was flown, and a common factor of an MPC's weights.

mod fit;
mod inputs;
mod instruments;
mod parameters;
mod replay;
mod whitening;

use std::collections::BTreeMap;

use super::{Estimate, Finding, Rejected};
use crate::closed_loop::{LogRefused, simulated_flight};
use crate::control_setup::vehicle_parameters;
use crate::controller_file::ControllerChoice;
use crate::effects::Origin;
use crate::flight_log::flight_log;
use crate::log::Log;
use crate::model::VehicleModel;
use fit::{Comparison, Found};
use inputs::{NotReplayable, Step};
use instruments::{Tunable, tunables};
use parameters::Numbers;
use replay::Design;

/// Time after which the core's filters hold what the log gave them, s; what they held at its beginning is not known.
const SETTLING_S: f64 = 1.0;
/// Standard deviations of the sum of squared scores beyond which it is not chance; the log's noise is not quite white.
const REMAINDER: f64 = 8.0;
/// A cause counts as found, if not as the only one, where less than this share of the modelled controller's mismatch
/// remains.
const LEFT_SHARE_MAX: f64 = 0.02;

/// Changes that must be larger than this share to be found are mentioned.
const COARSE: f64 = 0.1;

/// What a log shows of its controller.
#[derive(Clone, Debug)]
pub struct Examination {
    /// Numbers that differ, most important first.
    pub findings: Vec<Finding>,
    /// Why none does, or why that cannot be decided.
    pub rejected: Vec<Rejected>,
    /// What no number explains, in words; empty where nothing remains.
    pub remainder: String,
    /// The controller with the numbers that flew.
    pub corrected: ControllerChoice,
}

/// Holds a log's commands against those of a controller that knows a vehicle.
///
/// # Errors
/// The controller can't fly that vehicle, or the log is too long to be simulated.
pub fn examine(log: &Log, model: &VehicleModel, choice: ControllerChoice) -> Result<Examination, LogRefused> {
    let Some((setup, flight)) = simulated_flight(log, model, choice)? else {
        let missing = NotReplayable::Missing(crate::closed_loop::missing_for_closed_loop(log));
        return Ok(not_examined(&missing, choice));
    };
    let design = Design {
        vehicle: vehicle_parameters(&setup.known_model()),
        clocks: setup.design_parameters(),
        controller: choice.controller,
    };
    let modelled = Numbers { tuning: setup.tuning(), control_horizon: choice.control_horizon };
    let config = design.config(&modelled)?;
    let steps_of = |log: &Log| inputs::steps(log, &config, &design.clocks);
    let (measured, simulated) = match (steps_of(log), steps_of(&flight_log(&flight, choice.rate_hz))) {
        (Ok(measured), Ok(simulated)) => (measured, simulated),
        (Err(reason), _) | (_, Err(reason)) => return Ok(not_examined(&reason, choice)),
    };
    let counts = rows_that_count(&measured, &simulated, choice.rate_hz);
    let tunables = tunables(&design, &simulated, &modelled)?;
    let comparison = Comparison { design, measured: &measured, counts: &counts, tunables: &tunables, modelled };
    Ok(match comparison.search() {
        Some(found) => answer(&found, &comparison, choice),
        None => not_examined(&NotReplayable::Missing("rows in which no motor is at a limit".into()), choice),
    })
}

fn not_examined(reason: &NotReplayable, corrected: ControllerChoice) -> Examination {
    let rejected = vec![rejection(format!("not tested: {reason}"))];
    Examination { findings: Vec::new(), rejected, remainder: String::new(), corrected }
}

fn rejection(reason: String) -> Rejected {
    Rejected { effect: "controller_mismatch", axis: String::new(), reason }
}

/// Rows after the settling in which every motor has room, as long as both flights last.
fn rows_that_count(measured: &[Step], simulated: &[Step], rate_hz: u32) -> Vec<bool> {
    let settled = (SETTLING_S * f64::from(rate_hz)) as usize;
    let flown = |steps: &[Step]| steps.iter().filter_map(|step| step.flown).collect::<Vec<_>>();
    let (measured, simulated) = (flown(measured), flown(simulated));
    measured
        .iter()
        .enumerate()
        .map(|(row, flown)| row >= settled && row < simulated.len() && !flown.saturated)
        .collect()
}

fn answer(found: &Found, comparison: &Comparison<'_>, choice: ControllerChoice) -> Examination {
    let fit = &found.fit;
    let freedom = found.directions.saturating_sub(fit.taken.len()).max(1) as f64;
    let is_remaining = fit.sum > freedom + REMAINDER * (2.0 * freedom).sqrt();
    let is_named = !fit.taken.is_empty() && (!is_remaining || fit.sum < LEFT_SHARE_MAX * found.nominal_sum);
    let remainder = if is_remaining {
        "the logged commands are not those of the modelled controller, and no parameter of it explains all of it"
    } else {
        ""
    };
    if !is_named {
        let reason = if is_remaining {
            format!(
                "{remainder}: the best one lowers the squared mismatch from {:.0} to {:.0}; noise alone gives \
                 {freedom:.0}",
                found.nominal_sum, fit.sum
            )
        } else {
            format!("the logged commands are those of the modelled controller{}", undetectable(found, comparison))
        };
        let rejected = vec![rejection(reason)];
        return Examination { findings: Vec::new(), rejected, remainder: remainder.to_owned(), corrected: choice };
    }
    let mut corrected = choice;
    let spread = (fit.sum / freedom).max(1.0).sqrt();
    let falls: f64 = fit.taken.iter().map(|taken| taken.fall).sum();
    let findings = (0..fit.taken.len()).map(|at| {
        let taken = &fit.taken[at];
        comparison.tunables[taken.place].parameter.put(&fit.numbers, &mut corrected);
        finding(found, comparison, at, spread, 100.0 * taken.fall / falls)
    });
    let findings = findings.collect();
    Examination { findings, rejected: Vec::new(), remainder: remainder.to_owned(), corrected }
}

/// The numbers of which this log shows nothing, or little.
fn undetectable(found: &Found, comparison: &Comparison<'_>) -> String {
    let is_tested = |name: &str| comparison.tunables.iter().any(|tunable| tunable.parameter.name == name);
    let controller = comparison.design.controller;
    let mut names: Vec<&str> = parameters::all()
        .iter()
        .filter(|parameter| parameter.is_of(controller))
        .map(|parameter| parameter.name)
        .collect();
    names.dedup();
    names.retain(|name| !is_tested(name));
    let mut text = String::new();
    if !names.is_empty() {
        text = format!("; without effect in this flight: {}", names.join(", "));
    }
    let coarse: Vec<String> = comparison
        .tunables
        .iter()
        .zip(&found.least_found)
        .filter_map(|(tunable, least)| Some((tunable, (*least)?)))
        .filter(|(tunable, least)| *least > COARSE && !tunable.parameter.is_count())
        .map(|(tunable, least)| format!("{} below {:.0} %", name_of(tunable), 100.0 * least))
        .collect();
    if !coarse.is_empty() {
        text += &format!("; not detectable in this flight: changes of {}", coarse.join(", "));
    }
    text
}

fn finding(found: &Found, comparison: &Comparison<'_>, at: usize, spread: f64, gain_pct: f64) -> Finding {
    let fit = &found.fit;
    let parameter = &comparison.tunables[fit.taken[at].place].parameter;
    let std = if parameter.is_count() { 0.0 } else { spread * fit.std[at] };
    let logged = Estimate { value: parameter.of(&fit.numbers), std };
    let modelled = Estimate { value: parameter.of(&comparison.modelled), std: 0.0 };
    let axis = parameter.axis.map(crate::axis::Axis::name);
    let decimals = logged.decimals().unwrap_or(0);
    let mut statement = format!(
        "the controller that flew had {}{} {:.decimals$} +- {:.decimals$}, not {:.decimals$} as modelled",
        parameter.name,
        axis.map_or_else(String::new, |axis| format!(" ({axis})")),
        logged.value,
        logged.std,
        modelled.value,
    );
    let others: Vec<String> = fit.taken[at].alike.iter().map(|place| name_of(&comparison.tunables[*place])).collect();
    if !others.is_empty() {
        statement += &format!("; a change of {} would look the same in this log", others.join(" or "));
    }
    Finding {
        effect: "controller_mismatch",
        axis,
        origin: Origin::Controller,
        controller_parameter: Some(parameter.name),
        parameters: BTreeMap::from([("logged", logged), ("modelled", modelled)]),
        gain_pct,
        confounded_with: Vec::new(),
        stability_pct: None,
        one_of: Vec::new(),
        statement: statement + ".",
        extension: None,
    }
}

fn name_of(tunable: &Tunable) -> String {
    let axis = tunable.parameter.axis.map_or_else(String::new, |axis| format!(" ({})", axis.name()));
    format!("{}{axis}", tunable.parameter.name)
}
