//! What there is to choose from, with names, meanings and ranges as they stand in the library: effects, keys of a
//! tuning, models, maps.

use serde_json::{Value, json};
use sil_host::effects::{ActsOn, CatalogueEntry, Effect, Parameter};
use sil_host::log::BUILT_IN_MAPS;
use sil_host::model::{Rig, VehicleModel};
use sil_host::scenario::Scenario;

use super::{Answer, message, models};

/// The page with the table of a tuning's keys, which a test writes from the core's own source.
const COMMANDS: &str = include_str!("../../../docs/commands.md");
/// What stands before that table.
const TUNING_TABLE: &str = "<!-- generated: tuning keys";

/// A slider goes to so many times the example's size, either way where that makes sense.
const TRAVEL: f64 = 4.0;

pub(super) fn answer() -> Answer {
    let effects = Effect::CATALOGUE.iter().map(effect).collect::<Result<Vec<_>, _>>()?;
    let model = |(name, _): &(&'static str, &str)| {
        let vehicle = models::vehicle(name)?;
        Ok(json!({ "name": name, "called": vehicle.name, "rig": vehicle.rig().name() }))
    };
    Ok(json!({
        "effects": effects,
        "tuning": tuning(),
        "models": models::MODELS.iter().map(model).collect::<Result<Vec<Value>, String>>()?,
        "maps": BUILT_IN_MAPS.map(|(name, _)| name),
        "sequence": Scenario::test_sequence().to_script(),
        "version": env!("CARGO_PKG_VERSION"),
    }))
}

fn effect(entry: &CatalogueEntry) -> Result<Value, String> {
    let rig = entry.rigs.first().copied().unwrap_or(Rig::Gimbal);
    let inertia_kg_m2 = VehicleModel::nominal(rig).inertia_kg_m2;
    let example = Effect::parse_for(entry.example, rig, inertia_kg_m2).map_err(message)?;
    let sizes = example.parameters();
    // of alternatives the example has one
    let parameter = |of: &Parameter| {
        let (_, size) = *sizes.iter().find(|(name, _)| *name == of.name)?;
        let travel = TRAVEL * (size - of.nominal).abs().max(f64::EPSILON);
        Some(json!({
            "name": of.name,
            "unit": of.unit,
            "meaning": of.meaning,
            "range": [of.min, of.max],
            "slider": [(of.nominal - travel).max(of.min), (of.nominal + travel).min(of.max)],
            "nominal": of.nominal,
            "example": size,
        }))
    };
    Ok(json!({
        "name": entry.name,
        "summary": entry.summary,
        "origin": entry.origin.name(),
        "rigs": entry.rigs.iter().map(|rig| rig.name()).collect::<Vec<_>>(),
        "places": { "gimbal": places(entry.acts_on, Rig::Gimbal), "free": places(entry.acts_on, Rig::Free) },
        "parameters": entry.parameters.iter().filter_map(parameter).collect::<Vec<_>>(),
    }))
}

/// Where on the vehicle it can act: the key of its short form with the values; none for the whole vehicle.
fn places(acts_on: ActsOn, rig: Rig) -> Option<(&'static str, &'static [&'static str])> {
    match (acts_on, rig) {
        (ActsOn::Vehicle, _) => None,
        (ActsOn::RollOrPitch, _) | (ActsOn::TurningAxis, Rig::Gimbal) => Some(("axis", &["roll", "pitch"])),
        (ActsOn::TurningAxis, Rig::Free) | (ActsOn::AnyAxis, _) => Some(("axis", &["roll", "pitch", "yaw"])),
        (ActsOn::Motor, _) => Some(("motor", &["1", "2", "3", "4"])),
    }
}

/// Rows of the table: key, type, meaning.
fn tuning() -> Vec<Value> {
    let table = COMMANDS.split_once(TUNING_TABLE).map_or("", |(_, rest)| rest);
    let lines = table.lines().skip(1).take_while(|line| line.starts_with('|')).skip(2);
    let cells = lines.map(|line| line.trim_matches('|').splitn(4, '|').map(str::trim).collect::<Vec<_>>());
    cells
        .filter_map(|cells| match cells[..] {
            [key, kind, _, meaning] => {
                let [key, meaning] = [key, meaning].map(|text| text.replace('`', ""));
                Some(json!({ "key": key, "kind": kind, "meaning": meaning }))
            }
            _ => None,
        })
        .collect()
}
