//! Every key of a model file, as the readers themselves ask for them: each of the project's models is read, and what is
//! asked for on the way is written down.

use super::{BenchAxis, BenchModel, Rig, VehicleModel};
use crate::document::{Holds, KeyRead, ModelError, Section, Source};
use crate::vehicle::propulsion::{DevicePropulsion, Esc, LookUpTable, Propulsion};

/// Between them they have every rig, every level of propulsion and every map of a speed controller but the table.
const MODELS: [&str; 6] = [
    include_str!("../../../models/f450-gimbal.toml"),
    include_str!("../../../models/f450-free.toml"),
    include_str!("../../../models/generic-gimbal.toml"),
    include_str!("../../../models/generic-free.toml"),
    include_str!("../../../models/box-gimbal.toml"),
    include_str!("../../../models/box-free.toml"),
];

/// A key of a model file.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelKey {
    /// Header of its table, without the brackets; empty outside of all tables.
    pub table: String,
    /// The key.
    pub key: &'static str,
    /// What it is.
    pub meaning: String,
    /// Its unit; empty for a text and for a number without one.
    pub unit: String,
    /// What it may be: "0.01 to 2", or names.
    pub range: String,
    /// Can it be left out?
    pub is_optional: bool,
    /// What stands for it where it is left out; none where nothing does, or it can't be.
    pub default: Option<f64>,
    /// In which files it stands: `rig = "free"`; empty for all.
    pub only_with: String,
}

/// All keys: those of vehicles, then those of benches; effects and tolerances have pages of their own.
///
/// # Errors
/// One of the project's own models can't be read.
pub fn keys() -> Result<Vec<ModelKey>, ModelError> {
    let texts = MODELS.iter().map(|text| (*text).to_owned()).chain(with_tables());
    let vehicles = texts.map(|text| reads_of(&text, |root| VehicleModel::read(root).map(|_| ())));
    let vehicles = vehicles.collect::<Result<Vec<_>, _>>()?;
    let bench = BenchModel { axes: [Some(BenchAxis::default()); 3], ..BenchModel::default() }.to_toml();
    let bench = reads_of(&bench, |root| BenchModel::read(root).map(|_| ()))?;
    let mut keys: Vec<ModelKey> = Vec::new();
    let has_own_page = |read: &&KeyRead| read.table.starts_with('[') || read.table.starts_with("tolerance");
    for read in vehicles.iter().flatten().filter(|read| !has_own_page(read)) {
        if keys.iter().all(|key| (key.table.as_str(), key.key) != (read.table.as_str(), read.key)) {
            keys.push(ModelKey::of(read, condition(read, &vehicles)));
        }
    }
    keys.sort_by(|a, b| a.table.cmp(&b.table));
    let only = "rig = \"axis\"".to_owned();
    // which rig it is every file says first
    keys.extend(bench.iter().filter(|read| read.key != "rig").map(|read| ModelKey::of(read, only.clone())));
    Ok(keys)
}

/// A model whose speed controller is a table, and one whose rotor's lift is.
fn with_tables() -> Vec<String> {
    let model = VehicleModel { tolerances: Vec::new(), ..VehicleModel::nominal(Rig::Gimbal) };
    let table = LookUpTable::new(&[(0.0, 0.0), (1.0, 10.0)]);
    let (Propulsion::Device(device), Some(table)) = (model.propulsion, table) else { return Vec::new() };
    let esc = DevicePropulsion { esc: Esc::Table(table), ..device };
    let lift = DevicePropulsion { lift_table: Some(table), ..device };
    let with = |device| VehicleModel { propulsion: Propulsion::Device(device), ..model.clone() }.to_toml();
    [esc, lift].map(with).to_vec()
}

/// What a reader asks of a text.
fn reads_of(text: &str, read: impl Fn(&Section<'_>) -> Result<(), ModelError>) -> Result<Vec<KeyRead>, ModelError> {
    let source = Source { name: "a model", text };
    let document = source.parse()?;
    let root = Section::root(source, &document);
    read(&root)?;
    Ok(root.reads())
}

/// The choice that decides whether a key is asked for, or that its table is there; empty for one that every file has.
fn condition(of: &KeyRead, files: &[Vec<KeyRead>]) -> String {
    let is_asked = |file: &[KeyRead]| file.iter().any(|read| read.table == of.table && read.key == of.key);
    let has = |file: &[KeyRead], choice: &str| file.iter().filter_map(choice_of).any(|other| other == choice);
    let choices = files.iter().flatten().filter_map(choice_of);
    let its_table = || format!("[{}]", of.table);
    let mut deciding = choices.filter(|choice| files.iter().all(|file| is_asked(file) == has(file, choice)));
    if files.iter().all(|file| is_asked(file)) { String::new() } else { deciding.next().unwrap_or_else(its_table) }
}

/// `rig = "free"`.
fn choice_of(read: &KeyRead) -> Option<String> {
    match &read.holds {
        Holds::Choice { found, .. } => Some(format!("{} = \"{found}\"", read.key)),
        _ => None,
    }
}

impl ModelKey {
    fn of(read: &KeyRead, only_with: String) -> ModelKey {
        let (meaning, unit, range) = match &read.holds {
            Holds::Number(range) => {
                let (meaning, unit) = range.what.rsplit_once(" in ").unwrap_or((range.what, ""));
                (meaning.to_owned(), unit.to_owned(), format!("{} to {}", short(range.min), short(range.max)))
            }
            Holds::Numbers(range) => {
                let (meaning, unit) = range.what.rsplit_once(" in ").unwrap_or((range.what, ""));
                let range = format!("list, {} to {}", short(range.min), short(range.max));
                (meaning.to_owned(), unit.to_owned(), range)
            }
            Holds::Text(what) => ((*what).to_owned(), String::new(), "text".to_owned()),
            Holds::Choice { names, .. } => {
                let names: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
                ("one of these".to_owned(), String::new(), names.join(" or "))
            }
        };
        let default = read.default.filter(|_| read.is_optional);
        let (table, is_optional) = (read.table.clone(), read.is_optional);
        ModelKey { table, key: read.key, meaning, unit, range, is_optional, default, only_with }
    }
}

/// 2, 0.01, 1e-10.
fn short(value: f64) -> String {
    format!("{value:?}").trim_end_matches(".0").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_decides_about_a_key_is_named() {
        let keys = keys().unwrap();
        let condition = |table: &str, key: &str| {
            let mut found = keys.iter().filter(|of| of.table == table && of.key == key);
            found.next().unwrap_or_else(|| panic!("no [{table}] {key}")).only_with.clone()
        };
        assert_eq!(condition("body", "ixx_kg_m2"), "");
        assert_eq!(condition("body", "mass_kg"), "rig = \"free\"");
        assert_eq!(condition("ring", "inertia_kg_m2"), "rig = \"gimbal\"");
        assert_eq!(condition("propulsion", "time_constant_s"), "level = \"generic\"");
        assert_eq!(condition("propulsion.esc", "battery_v"), "map = \"duty\"");
        assert_eq!(condition("propulsion.esc", "voltage_v"), "map = \"table\"");
        assert_eq!(condition("yaw", "gain_rad_s2"), "rig = \"axis\"");
        // no key is written that is not here
        for text in MODELS {
            let model = VehicleModel { tolerances: Vec::new(), ..VehicleModel::parse(text, "m").unwrap() };
            let written = model.to_toml();
            for line in written.lines().filter(|line| line.contains(" = ")) {
                let key = line.split(" = ").next().unwrap();
                assert!(keys.iter().any(|of| of.key == key), "{key}");
            }
        }
    }

    #[test]
    fn what_may_be_left_out_has_a_default() {
        let keys = keys().unwrap();
        let optional: Vec<&str> = keys.iter().filter(|key| key.default.is_some()).map(|key| key.key).collect();
        assert_eq!(optional.len(), 5 + 3 * 5, "{optional:?}");
        let height = keys.iter().find(|key| key.key == "height_m").unwrap();
        assert_eq!((height.default, height.unit.as_str()), (Some(0.02), "m"));
    }
}
