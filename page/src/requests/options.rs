//! What a person says of a log beside the log: the options of `sil diagnose`, as the page's form has them.

use std::path::Path;

use serde::Deserialize;
use sil_host::answer::{Said, SaidRig};
use sil_host::controller_file::ControllerChoice;
use sil_host::diagnosis::{Effort, Fact};
use sil_host::log::draft::{Draft, draft_from};
use sil_host::log::{BUILT_IN_MAPS, Log, Map, NotWanted, Rows, Wanted};

use super::message;
use super::models::{rig, said_model};

/// The form's fields; one that is left empty says nothing.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Options {
    /// Name of a map that ships, or the text of a map.
    map: Option<String>,
    frame_turn_deg: Option<f64>,
    from_s: Option<f64>,
    to_s: Option<f64>,
    flight: Option<usize>,
    whole: bool,
    unchecked: bool,
    /// Name of a model that ships, or the text of one.
    model: Option<String>,
    /// `gimbal`, `free` or `axis`.
    rig: Option<String>,
    /// `pid`, `mpc`, or the text of a controller file.
    controller: Option<String>,
    /// Numbers that are held, NAME=VALUE.
    known: Vec<String>,
    /// `quick` or `thorough`; the usual search else.
    effort: Option<String>,
    /// With normal flights: nobody touched the vehicle between them.
    pub(super) untouched: bool,
}

/// A log as it was read.
pub(super) struct Read {
    pub(super) log: Log,
    /// The map that was drafted for it, where none was given and it needs one.
    pub(super) drafted: Option<Draft>,
}

/// A log that can't be read.
pub(super) struct NotRead {
    /// What the terminal would say.
    pub(super) message: String,
    /// The start of a map for it, where its columns are other people's.
    pub(super) draft: Option<Draft>,
}

impl Options {
    /// Reads a log, or the part of it that was requested. Of a table with other people's columns the map is drafted,
    /// and taken if nothing in it is doubtful.
    pub(super) fn read(&self, name: &str, bytes: &[u8]) -> Result<Read, NotRead> {
        let name = Path::new(name);
        let wanted = self.wanted().map_err(|message| NotRead { message, draft: None })?;
        let error = match wanted.read(name, &mut &*bytes) {
            Ok(log) => return Ok(Read { log, drafted: None }),
            Err(error) => error,
        };
        let draft = match draft_from(name, &mut &*bytes) {
            Ok(draft) if self.map.is_none() => draft,
            _ => None,
        };
        // what contradicts its labels is the owner's to mend, and a flight that is not there no matter of columns
        if let NotWanted::Log(_) = error
            && let Some(draft) = draft.as_ref().filter(|draft| draft.problems.is_empty())
            && let Ok(map) = Map::parse("drafted map", &draft.toml)
            && let Ok(log) = (Wanted { map: Some(map), ..wanted }).read(name, &mut &*bytes)
        {
            return Ok(Read { log, drafted: Some(draft.clone()) });
        }
        Err(NotRead { message: error.to_string(), draft })
    }

    fn wanted(&self) -> Result<Wanted, String> {
        let map = match &self.map {
            None => None,
            Some(name) if BUILT_IN_MAPS.iter().any(|(built_in, _)| built_in == name) => Some(Map::load(name)),
            Some(text) => Some(Map::parse("map", text)),
        };
        let rows = match (self.from_s, self.to_s, self.flight) {
            (None, None, _) if self.whole => Rows::All,
            (None, None, Some(number)) => Rows::Flight(number),
            (None, None, None) => Rows::Flown,
            (from_s, to_s, _) => Rows::Between(from_s.unwrap_or(f64::NEG_INFINITY), to_s.unwrap_or(f64::INFINITY)),
        };
        Ok(Wanted {
            map: map.transpose().map_err(message)?,
            frame_turn_deg: self.frame_turn_deg.unwrap_or(0.0),
            rows,
            unchecked: self.unchecked,
        })
    }

    /// What was said of the vehicle and of what flew it.
    pub(super) fn said(&self, is_mapped: bool) -> Result<Said, String> {
        let rig = match self.rig.as_deref() {
            None => None,
            Some("axis") => Some(SaidRig::Axis),
            Some(name) => Some(SaidRig::Vehicle(rig(name)?)),
        };
        let controller = |text: &String| match text.as_str() {
            "pid" | "mpc" | "mpc-quick" => ControllerChoice::from_argument(text).map(|choice| (text.clone(), choice)),
            text => ControllerChoice::parse(text, "controller.toml").map(|choice| ("controller.toml".into(), choice)),
        };
        Ok(Said {
            is_mapped: is_mapped || self.map.is_some(),
            rig,
            model: self.model.as_deref().map(said_model).transpose()?,
            controller: self.controller.as_ref().map(controller).transpose().map_err(message)?,
        })
    }

    /// The numbers that are held.
    pub(super) fn facts(&self) -> Result<Vec<Fact>, String> {
        self.known.iter().map(|text| Fact::parse(text)).collect::<Result<_, _>>().map_err(message)
    }

    /// How long is searched.
    pub(super) fn effort(&self) -> Effort {
        match self.effort.as_deref() {
            Some("quick") => Effort::Quick,
            Some("thorough") => Effort::Thorough,
            _ => Effort::Usual,
        }
    }

    /// The options as `sil diagnose` takes them; of a text the name of a file stands there.
    pub(super) fn command_line(&self) -> String {
        let file = |given: &Option<String>, name: &str| {
            given.as_ref().map(|text| if text.contains('\n') { name.to_owned() } else { text.clone() })
        };
        let model = self.model.as_deref().and_then(|model| said_model(model).ok()).map(|(file, _)| file);
        let number = |value: Option<f64>| value.map(|value| value.to_string());
        let values = [
            ("--map", file(&self.map, "map.toml")),
            ("--frame-turn", number(self.frame_turn_deg)),
            ("--from", number(self.from_s)),
            ("--to", number(self.to_s)),
            ("--flight", self.flight.map(|flight| flight.to_string())),
            ("--model", model),
            ("--rig", self.rig.clone()),
            ("--controller", file(&self.controller, "controller.toml")),
        ];
        let values = values.into_iter().filter_map(|(option, value)| Some(format!(" {option} {}", value?)));
        let known = self.known.iter().map(|fact| format!(" --known {fact}"));
        let effort = self.effort.iter().filter(|effort| *effort != "usual").map(|effort| format!(" --{effort}"));
        let flags = [("--whole", self.whole), ("--unchecked", self.unchecked), ("--untouched", self.untouched)];
        let flags = flags.into_iter().filter(|(_, is_set)| *is_set).map(|(flag, _)| format!(" {flag}"));
        values.chain(flags).chain(known).chain(effort).collect()
    }
}
