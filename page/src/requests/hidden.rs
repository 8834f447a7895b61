//! The quiz: a log of a vehicle with one effect hidden in it, and what is to be seen of it.

use serde::Deserialize;
use serde_json::json;
use sil_host::answer::comparison::page;
use sil_host::comparison::compare;
use sil_host::effects::Effect;
use sil_host::log::write;
use sil_host::prediction::Subject;
use sil_host::synthesis::Synthesis;

use super::{Answer, message, models};

/// What is hidden, and where.
#[derive(Deserialize)]
pub(super) struct Hide {
    /// A model that ships.
    model: String,
    /// In the short form of the command line.
    effect: String,
    seed: u64,
}

impl Hide {
    /// The log as a file, and the comparison with the model that lacks the effect.
    pub(super) fn answer(&self) -> Answer {
        let nominal = models::vehicle(&self.model)?;
        let mut model = nominal.clone();
        model.effects.push(Effect::parse_for(&self.effect, model.rig(), model.inertia_kg_m2).map_err(message)?);
        let synthesis = Synthesis { log_rate_hz: 100, blind: true, seed: self.seed, ..Synthesis::of(model) };
        let mut log = synthesis.log().map_err(message)?;
        log.path = "quiz.csv".to_owned();
        let mut file = Vec::new();
        write(&log, &mut file).map_err(message)?;
        let subject = Subject::Vehicle(&nominal);
        let comparison = compare(&log, &subject, None).map_err(message)?;
        Ok(json!({
            "log": String::from_utf8(file).map_err(message)?,
            "fragment": page::page(&log, &comparison, &subject, "the quiz").to_fragment(),
        }))
    }
}
