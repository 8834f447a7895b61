//! The vehicle's parameters, listed with what they do, and set.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::time::Duration;

use mavlink::dialects::common::{MavParamType, PARAM_REQUEST_LIST_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA};
use shared_control::params::Params;
use shared_control::params::table::Field;

use super::ConsoleError;
use super::link::{Link, News};

/// Silence after which what is missing is asked for.
const SILENCE: Duration = Duration::from_millis(700);
/// How often it is asked for.
const ROUNDS: usize = 20;
/// So many of what is missing are asked for at once.
const ASKED_AT_ONCE: usize = 10;

/// What is known of them.
#[derive(Clone, Debug, Default)]
pub struct HeldParameters {
    /// Name and value by index.
    held: BTreeMap<u16, (String, f32)>,
    count: Option<u16>,
}

impl HeldParameters {
    /// Says those whose name or group has a word in it, with what they do.
    pub(super) fn list<S: Read + Write>(
        &mut self,
        link: &mut Link<S>,
        word: &str,
        say: &mut dyn FnMut(&str),
    ) -> Result<(), ConsoleError> {
        if !self.is_whole() {
            self.load(link, say)?;
        }
        let word = word.to_uppercase();
        for (name, value) in self.held.values() {
            let Some(field) = Field::by_name(name.as_bytes()) else {
                say(&format!("{name} = {value}: of a vehicle that is newer or older than this program"));
                continue;
            };
            if !name.contains(&word) && !field.group().to_uppercase().contains(&word) {
                continue;
            }
            let row = field.row();
            let default = row.allowed.number(Params::DEFAULT.get(field));
            let unit = if row.unit.is_empty() { String::new() } else { format!(" {}", row.unit) };
            say(&format!("{name} = {value}{unit} ({}; default {default}): {}", row.allowed, row.meaning));
        }
        Ok(())
    }

    /// Sets one, and says what the vehicle made of it.
    pub(super) fn set<S: Read + Write>(
        &mut self,
        link: &mut Link<S>,
        (name, value): (&str, &str),
        say: &mut dyn FnMut(&str),
    ) -> Result<(), ConsoleError> {
        let name = name.to_uppercase();
        let field = Field::by_name(name.as_bytes())
            .ok_or_else(|| ConsoleError::Line(format!("{name}: no such parameter; params lists them")))?;
        let allowed = field.row().allowed;
        let number: f32 = value
            .parse()
            .ok()
            .filter(|number| allowed.bits(*number).is_some())
            .ok_or_else(|| ConsoleError::Line(format!("{name} {value}: expected {allowed}")))?;
        let (target_system, target_component) = link.target();
        let set = PARAM_SET_DATA {
            param_value: number,
            param_id: name.as_str().into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
            target_system,
            target_component,
        };
        link.send(&set)?;
        let answer = link.wait(3 * SILENCE, say, |news| self.take(news).filter(|of| *of == name))?;
        // why not, if it was not set
        link.wait(SILENCE, say, |_| None::<()>)?;
        if answer.is_none() {
            return Err(ConsoleError::Silent(format!("set {name}")));
        }
        let stands = self.held.values().find(|(of, _)| *of == name).map(|(_, value)| *value);
        match stands {
            Some(stands) if stands == number => Ok(()),
            _ => Err(ConsoleError::Refused(format!("{name} was not set: the vehicle has said why"))),
        }
    }

    /// Asks for all, then for what did not come.
    fn load<S: Read + Write>(&mut self, link: &mut Link<S>, say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        let (target_system, target_component) = link.target();
        for round in 0..ROUNDS {
            let missing = |count: u16| (0..count).filter(|index| !self.held.contains_key(index)).take(ASKED_AT_ONCE);
            let known = self.count.filter(|_| round > 0);
            let wanted: Vec<u16> = known.map(|count| missing(count).collect()).unwrap_or_default();
            if wanted.is_empty() {
                link.send(&PARAM_REQUEST_LIST_DATA { target_system, target_component })?;
            }
            for index in wanted {
                let param_index = index as i16;
                link.send(&PARAM_REQUEST_READ_DATA {
                    param_index,
                    target_system,
                    target_component,
                    ..PARAM_REQUEST_READ_DATA::DEFAULT
                })?;
            }
            while !self.is_whole() {
                if link.wait(SILENCE, say, |news| self.take(news))?.is_none() {
                    break;
                }
            }
            if self.is_whole() {
                return Ok(());
            }
        }
        Err(ConsoleError::Silent("params".to_owned()))
    }

    /// The name of the parameter, if it is one.
    fn take(&mut self, news: &News) -> Option<String> {
        let News::Parameter(name, value, index, count) = news else { return None };
        self.count = Some(*count);
        self.held.insert(*index, (name.clone(), *value));
        Some(name.clone())
    }

    fn is_whole(&self) -> bool {
        self.count.is_some_and(|count| self.held.len() >= usize::from(count))
    }
}
