//! What is tested on a log beyond its prediction: what the nominal model leaves to each log, and what it lacks columns
//! for.

use super::fitted::Fitted;
use super::verdict::Rejected;
use crate::axis::Axis;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::effects::{CatalogueEntry, Effect};
use crate::log::Log;
use crate::prediction::windowed_log::WindowedLog;
use crate::prediction::{MeasuredNoise, NotPredictable, Subject};

impl Subject<'_> {
    /// What the nominal model leaves to each log: the input gains of separate axes.
    ///
    /// # Errors
    /// An axis' command is zero in every window: its gain can't be found.
    pub(super) fn fitted_along(&self, log: &WindowedLog<'_>) -> Result<Vec<Fitted>, NotPredictable> {
        let Subject::Axes = self else { return Ok(Vec::new()) };
        let axes: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| log.turns(*axis)).collect();
        for axis in &axes {
            let in_windows = log.windows.iter().flat_map(|window| log.commands_between(window.start, window.end));
            if in_windows.into_iter().all(|command| command[axis.index()] == 0.0) {
                return Err(NotPredictable::NoExcitation { axis: axis.name() });
            }
        }
        Ok(axes.into_iter().map(Fitted::InputGain).collect())
    }

    /// What a log of free flight can't be tested for, for want of columns.
    pub(super) fn not_tested(&self, log: &Log) -> Vec<Rejected> {
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
