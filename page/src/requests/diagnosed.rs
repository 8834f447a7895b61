//! What the simulation gets wrong in a log, in several, or in one beside normal flights: what `sil diagnose` answers.

use std::path::Path;

use serde::Deserialize;
use serde_json::json;
use sil_host::answer::{Answered, HeldAgainst, Row, baseline, several_json, several_page, several_text};
use sil_host::diagnosis::{BetweenFlights, Given, Observer, diagnose_against};
use sil_host::log::Log;
use sil_host::report::Page;

use super::options::{Options, Read};
use super::{Answer, message};

/// Logs: the files of the call, in this order.
#[derive(Deserialize)]
pub(super) struct Diagnose {
    logs: Vec<Named>,
    #[serde(default)]
    options: Options,
}

/// A log by its file's name.
#[derive(Deserialize)]
struct Named {
    name: String,
    /// True of a flight of the healthy vehicle, with which the others are compared.
    #[serde(default)]
    normal: bool,
}

type NamedFile<'a> = (&'a Named, &'a Vec<u8>);

impl Diagnose {
    pub(super) fn answer(&self, files: &[Vec<u8>], observer: Observer<'_>) -> Answer {
        let (normal, suspects): (Vec<NamedFile>, Vec<NamedFile>) =
            self.logs.iter().zip(files).partition(|(log, _)| log.normal);
        match (suspects.as_slice(), normal.as_slice()) {
            ([], _) => Err("No log is to be explained: all are marked as normal flights.".to_owned()),
            ([(log, bytes)], []) => self.one(&log.name, bytes, observer),
            (several, []) => self.several(several, observer),
            ([suspect], normal) => self.against(*suspect, normal, observer),
            _ => Err("Beside normal flights one log can be explained at a time.".to_owned()),
        }
    }

    fn answered(&self, name: &str, bytes: &[u8], observer: Observer<'_>) -> Result<Answered, String> {
        let Read { log, drafted } = self.options.read(name, bytes).map_err(|not_read| not_read.message)?;
        let (said, facts) = (self.options.said(drafted.is_some())?, self.options.facts()?);
        // gaps would end a controller's replay
        let log = if said.controller.is_none() { log.examined() } else { log };
        let against = HeldAgainst::of(&log, &said, &facts, None, observer).map_err(message)?;
        Answered::of(log, against, self.options.effort(), observer).map_err(message)
    }

    fn one(&self, name: &str, bytes: &[u8], observer: Observer<'_>) -> Answer {
        let answered = self.answered(name, bytes, observer)?;
        let experiment = answered.diagnosis.experiment.as_ref();
        let script = experiment.and_then(|experiment| experiment.scenario.as_ref());
        let page = answered.page(&self.command());
        let text = answered.against.text() + &answered.text(str::to_owned);
        let mut answer = shown(&page, text, &answered.diagnosis)?;
        answer["extended"] = json!(answered.extended().map_err(message)?.map(|model| model.to_toml()));
        answer["next"] = json!(answered.diagnosis.separating_experiment);
        answer["script"] = json!(script.map(|scenario| scenario.to_script()));
        answer["rig"] = json!(answered.against.vehicle.as_ref().map(|vehicle| vehicle.rig().name()));
        let causes = answered.diagnosis.findings.iter().map(|finding| finding.effect);
        answer["causes"] = json!(causes.collect::<Vec<_>>());
        Ok(answer)
    }

    fn several(&self, logs: &[NamedFile], observer: Observer<'_>) -> Answer {
        let row = |(log, bytes): &NamedFile| Row::of(Path::new(&log.name), self.answered(&log.name, bytes, observer));
        let rows: Vec<Row> = logs.iter().map(row).collect();
        shown(&several_page(&rows, &self.command()), several_text(&rows), &several_json(&rows))
    }

    fn against(&self, (suspect, bytes): NamedFile, normal: &[NamedFile], observer: Observer<'_>) -> Answer {
        let read = |(log, bytes): &NamedFile| self.options.read(&log.name, bytes).map_err(|not_read| not_read.message);
        let Read { log, drafted } = read(&(suspect, bytes))?;
        let normal =
            normal.iter().map(|normal| Ok(read(normal)?.log.examined())).collect::<Result<Vec<Log>, String>>()?;
        let (log, said, facts) = (log.examined(), self.options.said(drafted.is_some())?, self.options.facts()?);
        let against = HeldAgainst::of_normal(&normal, &said, &facts, observer).map_err(message)?;
        let between = if self.options.untouched { BetweenFlights::Untouched } else { BetweenFlights::Serviced };
        let given = Given { known: &against.known, between };
        let answer = diagnose_against(&log, &normal, &against.subject(), given, observer).map_err(message)?;
        let page = against.on_page(baseline::page(&answer, &self.command()));
        shown(&page, against.text() + &baseline::text(&answer), &answer)
    }

    /// The command that answers the same on a terminal.
    fn command(&self) -> String {
        let names = |normal: bool, option: &str| -> String {
            let logs = self.logs.iter().filter(|log| log.normal == normal);
            logs.map(|log| format!("{option} '{}'", log.name.replace('\'', "'\\''"))).collect()
        };
        format!("sil diagnose{}{}{}", names(false, ""), self.options.command_line(), names(true, " --baseline"))
    }
}

/// An answer in all of its forms.
fn shown(page: &Page, text: String, of_json: &impl serde::Serialize) -> Answer {
    let json = sil_host::answer::json(of_json).map_err(message)?;
    Ok(json!({ "fragment": page.to_fragment(), "report": page.to_html(), "text": text, "json": json }))
}
