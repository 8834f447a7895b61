//! A log with its diagnosis: what `sil diagnose` shows of one log.

use super::diagnosis::{page, text};
use super::{Emphasis, HeldAgainst, NotHeldAgainst, identified};
use crate::diagnosis::{Diagnosis, Effort, NotExtended, Observer, extended_model};
use crate::log::Log;
use crate::model::VehicleModel;
use crate::report::Page;

/// A log and what came out.
pub struct Answered {
    /// The log.
    pub log: Log,
    /// What it was held against.
    pub against: HeldAgainst,
    /// What came out.
    pub diagnosis: Diagnosis,
}

impl Answered {
    /// Diagnoses a log.
    ///
    /// # Errors
    /// The log or the controller does not allow it.
    pub fn of(
        log: Log,
        against: HeldAgainst,
        effort: Effort,
        observer: Observer<'_>,
    ) -> Result<Answered, NotHeldAgainst> {
        let diagnosis = against.diagnose(&log, effort, observer)?;
        Ok(Answered { log, against, diagnosis })
    }

    /// The answer on a terminal, behind [`HeldAgainst::text`].
    pub fn text(&self, emphasised: Emphasis) -> String {
        text::answer_text(&self.log, &self.diagnosis, emphasised)
    }

    /// The answer as a page; the command is what made it.
    pub fn page(&self, command: &str) -> Page {
        self.against.on_page(page::page(&self.log, &self.diagnosis, command))
    }

    /// The model with base model and findings in it; none of separate axes.
    ///
    /// # Errors
    /// A finding that no model file can hold.
    pub fn extended(&self) -> Result<Option<VehicleModel>, NotExtended> {
        let vehicle = self.against.vehicle.as_ref();
        vehicle.map(|model| extended_model(model, &self.diagnosis)).transpose()
    }
}

impl HeldAgainst {
    /// What was taken that nobody said; none where somebody did.
    pub fn taken(&self) -> Option<&str> {
        Some(self.said.as_str()).filter(|said| !said.is_empty())
    }

    /// A page with what is said before the answer.
    pub fn on_page(&self, page: Page) -> Page {
        match self.taken() {
            Some(taken) => page.lead(taken),
            None => page,
        }
    }

    /// What is said before the answer: what the log is held against, and what was identified for it.
    pub fn text(&self) -> String {
        let said = if self.said.is_empty() { String::new() } else { format!("{}\n", self.said) };
        let numbers = self.identified.as_ref().map(|identified| format!("{}\n", identified::table(identified)));
        said + &numbers.unwrap_or_default()
    }
}
