//! What is tested on a log beyond its prediction: what the nominal model leaves to each log, and what it lacks columns
//! for.

use super::fitted::Fitted;
use super::verdict::Rejected;
use crate::axis::Axis;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::effects::{CatalogueEntry, Effect};
use crate::log::Log;
use crate::prediction::commands::axis_commands;
use crate::prediction::{MeasuredNoise, NotPredictable, Subject};

impl Subject<'_> {
    /// What the nominal model leaves to each log: the input gains of separate axes, of those that are commanded.
    ///
    /// # Errors
    /// None of them is.
    pub(super) fn fitted_along(&self, log: &Log) -> Result<Vec<Fitted>, NotPredictable> {
        let (Subject::Axes | Subject::Bench(_)) = self else { return Ok(Vec::new()) };
        let undriven = undriven_axes(log);
        let of_log: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| log.axes[axis.index()]).collect();
        let driven: Vec<Axis> = of_log.iter().copied().filter(|axis| !undriven.contains(axis)).collect();
        match of_log.first() {
            Some(first) if driven.is_empty() => Err(NotPredictable::NoExcitation { axis: first.name() }),
            _ => Ok(driven.into_iter().map(Fitted::InputGain).collect()),
        }
    }

    /// What a log can't be tested for: for want of columns in free flight, of commands on separate axes.
    pub(super) fn not_tested(&self, log: &Log) -> Vec<Rejected> {
        if let Subject::Axes | Subject::Bench(_) = self {
            let without_gain = |axis: Axis| Rejected {
                effect: "input_gain",
                axis: axis.name().to_owned(),
                reason: "not fitted: the command of this axis never changes".to_owned(),
            };
            return undriven_axes(log).into_iter().map(without_gain).collect();
        }
        let scope = self.scope(log);
        let wanting = |entry: &CatalogueEntry| {
            let needs = entry.needs.filter(|needs| self.flies_free() && !scope.has(*needs))?;
            let reason = format!("not tested: {}", needs.missing());
            Some(Rejected { effect: entry.name, axis: String::new(), reason })
        };
        Effect::CATALOGUE.iter().filter_map(wanting).collect()
    }

    /// The log in windows, to be fitted under the sensors' noise alone.
    ///
    /// # Errors
    /// As [`Subject::windowed`].
    pub(super) fn shooting<'l>(&self, log: &'l Log, noise: &MeasuredNoise) -> Result<Shooting<'l>, NotPredictable> {
        Ok(Shooting::new(self.windowed(log, noise)?))
    }
}

/// Separate axes whose command never changes while the motors run: it acts as a constant moment does, and no gain can
/// be found.
fn undriven_axes(log: &Log) -> Vec<Axis> {
    let log = log.commanding();
    let commands = axis_commands(log);
    let active: Vec<&[f64; 4]> =
        commands.iter().zip(log.active_rows()).filter_map(|(c, runs)| runs.then_some(c)).collect();
    let is_constant = |axis: &Axis| active.windows(2).all(|pair| pair[0][axis.index()] == pair[1][axis.index()]);
    Axis::ALL.into_iter().filter(|axis| log.axes[axis.index()] && is_constant(axis)).collect()
}
