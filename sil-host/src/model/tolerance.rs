//! How far the parts of one vehicle differ from those of the next: the table `[tolerance]` of a model file.
//!
//! ```toml
//! [tolerance]
//! "body.mass_kg" = { relative_sd = 0.01 }                 # normal, cut off at three standard deviations
//! "propulsion.motor.resistance_ohm" = { relative_half_width = 0.05 }   # uniform; each motor has its own
//! "propulsion.rotor.drag_nm_s2" = { like = "propulsion.rotor.reaction_torque_nm_s2" }   # by the same share
//! ```
//! A key is the address of any number of the same file, tables of one header counted (`effect.1.scale`).

use std::collections::BTreeMap;

use super::VehicleModel;
use crate::document::{Holds, KeyRead, ModelError, Section, Table, admissible};

/// A normal spread is cut off at so many standard deviations, to either side.
pub const CUT_SD: f64 = 3.0;

/// One for the whole vehicle, though it belongs to each arm's propulsion: one battery feeds all four.
const SHARED: [&str; 1] = ["propulsion.esc.battery_v"];

/// What the pilot and the controller do with a vehicle is no part of it.
const NO_PART: [&str; 2] = ["base_command", "body.known_rotor_drag_1_s"];

/// A number of a model that differs from vehicle to vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct Tolerance {
    /// Its address in the model file.
    pub key: String,
    /// How it is spread about the model's value.
    pub spread: Spread,
}

/// How a number is spread about its nominal value.
#[derive(Clone, Debug, PartialEq)]
pub enum Spread {
    /// Normal, cut off at [`CUT_SD`].
    Normal(Extent),
    /// Every value within the half width equally often.
    Uniform(Extent),
    /// By the same share as another number, whose address this is.
    Like(String),
}

/// Half a width or a standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// In the unit of the number.
    Absolute(f64),
    /// As a share of its nominal value.
    Relative(f64),
}

impl Extent {
    /// In the unit of a number with this nominal value.
    pub fn about(self, nominal: f64) -> f64 {
        match self {
            Self::Absolute(extent) => extent,
            Self::Relative(share) => share * nominal.abs(),
        }
    }
}

impl Tolerance {
    /// True where each of the four motors has a value of its own.
    pub fn is_per_motor(&self) -> bool {
        is_per_motor(&self.key)
    }

    /// How far it may lie from the model's value, in its unit; none for one that goes like another.
    pub fn reach(&self, nominal: f64) -> Option<f64> {
        match self.spread {
            Spread::Normal(extent) => Some(CUT_SD * extent.about(nominal)),
            Spread::Uniform(extent) => Some(extent.about(nominal)),
            Spread::Like(_) => None,
        }
    }

    /// Values that it may be spread about, by address.
    pub(super) fn nominals(reads: &[KeyRead]) -> BTreeMap<String, f64> {
        spreadable(reads).map(|(read, value)| (read.address.clone(), value)).collect()
    }

    /// Reads the table, where a file has one. `reads` are the numbers of the rest of the file.
    pub(super) fn read_all(root: &Section<'_>) -> Result<Vec<Tolerance>, ModelError> {
        let reads = root.reads();
        let Some(section) = root.optional_section("tolerance")? else { return Ok(Vec::new()) };
        let sections = section.named_sections("a table such as { relative_sd = 0.02 }")?;
        let mut tolerances = Vec::new();
        for (key, section) in &sections {
            tolerances.push(read_one(key, section, &reads)?);
        }
        for ((_, section), tolerance) in sections.iter().zip(&tolerances) {
            check_like(section, tolerance, &tolerances, &reads)?;
        }
        Ok(tolerances)
    }

    pub(super) fn write_all(tolerances: &[Tolerance], table: &mut Table) {
        if tolerances.is_empty() {
            return;
        }
        table.header("[tolerance]");
        for tolerance in tolerances {
            let (name, extent) = match &tolerance.spread {
                Spread::Normal(Extent::Absolute(sd)) => ("sd", format!("{sd:?}")),
                Spread::Normal(Extent::Relative(sd)) => ("relative_sd", format!("{sd:?}")),
                Spread::Uniform(Extent::Absolute(width)) => ("half_width", format!("{width:?}")),
                Spread::Uniform(Extent::Relative(width)) => ("relative_half_width", format!("{width:?}")),
                Spread::Like(key) => ("like", format!("\"{key}\"")),
            };
            table.inline(&tolerance.key, name, &extent);
        }
    }
}

impl VehicleModel {
    /// Drops those tolerances that the model can't have any more because its numbers were exchanged; says which.
    pub fn drop_impossible_tolerances(&mut self) -> Vec<String> {
        let mut wanted = std::mem::take(&mut self.tolerances);
        let mut dropped = Vec::new();
        // what goes like another needs that one first
        wanted.sort_by_key(|tolerance| matches!(tolerance.spread, Spread::Like(_)));
        for tolerance in wanted {
            self.tolerances.push(tolerance);
            if VehicleModel::parse(&self.to_toml(), "").is_err() {
                dropped.extend(self.tolerances.pop().map(|tolerance| tolerance.key));
            }
        }
        dropped
    }
}

fn is_per_motor(key: &str) -> bool {
    key.starts_with("propulsion.") && !SHARED.contains(&key)
}

/// The single numbers of a file, which may be spread.
fn spreadable(reads: &[KeyRead]) -> impl Iterator<Item = (&KeyRead, f64)> {
    // an effect's motor is a number, too
    let is_part = |read: &&KeyRead| !NO_PART.contains(&read.address.as_str()) && read.key != "motor";
    let of_a_part = reads.iter().filter(is_part);
    of_a_part.filter_map(|read| Some((read, read.value?)).filter(|_| matches!(read.holds, Holds::Number(_))))
}

fn read_one(key: &str, section: &Section<'_>, reads: &[KeyRead]) -> Result<Tolerance, ModelError> {
    let Some((read, nominal)) = spreadable(reads).find(|(read, _)| read.address == key) else {
        let known = spreadable(reads).map(|(read, _)| read.address.as_str());
        return Err(section.unknown_name("[tolerance]", key, known));
    };
    let of_unit = |what| admissible(0.0, 1e6, what);
    let of_share = |what| admissible(0.0, 1.0, what);
    let sd = section.optional_number("sd", of_unit("the standard deviation, in the number's own unit"))?;
    let relative_sd = section.optional_number("relative_sd", of_share("the standard deviation over the value"))?;
    let width = section.optional_number("half_width", of_unit("half of a uniform width, in the number's own unit"))?;
    let relative_width =
        section.optional_number("relative_half_width", of_share("half of a uniform width over the value"))?;
    let like = section.optional_text("like", "the address of the number that it goes with, by the same share")?;
    section.finish()?;
    let given = [
        sd.map(|sd| Spread::Normal(Extent::Absolute(sd))),
        relative_sd.map(|sd| Spread::Normal(Extent::Relative(sd))),
        width.map(|width| Spread::Uniform(Extent::Absolute(width))),
        relative_width.map(|width| Spread::Uniform(Extent::Relative(width))),
        like.map(|like| Spread::Like(like.to_owned())),
    ];
    let mut given = given.into_iter().flatten();
    let (Some(spread), None) = (given.next(), given.next()) else {
        return Err(section.impossible(format!(
            "the tolerance of `{key}` is not clear: expected one of sd, relative_sd, half_width, relative_half_width, \
             like"
        )));
    };
    let tolerance = Tolerance { key: key.to_owned(), spread };
    check_reach(section, &tolerance, nominal, read)?;
    Ok(tolerance)
}

/// No value that can be drawn may be one that the key does not admit.
fn check_reach(section: &Section<'_>, tolerance: &Tolerance, nominal: f64, read: &KeyRead) -> Result<(), ModelError> {
    let (key, Holds::Number(range)) = (&tolerance.key, &read.holds) else { return Ok(()) };
    match tolerance.reach(nominal) {
        Some(0.0) => Err(section.impossible(format!(
            "the tolerance of `{key}` is 0: expected one above 0, and sd or half_width where the number itself is 0"
        ))),
        Some(reach) if nominal - reach < range.min || nominal + reach > range.max => {
            let (low, high) = (nominal - reach, nominal + reach);
            let expected = range.describe();
            Err(section.impossible(format!(
                "`{key}` would be drawn from {low:.4e} to {high:.4e} (a normal spread is cut off at {CUT_SD} standard \
                 deviations): expected {expected}"
            )))
        }
        _ => Ok(()),
    }
}

/// What goes like another needs one that is drawn, as often as itself, and of which a share is something.
fn check_like(
    section: &Section<'_>,
    tolerance: &Tolerance,
    all: &[Tolerance],
    reads: &[KeyRead],
) -> Result<(), ModelError> {
    let (key, Spread::Like(other)) = (&tolerance.key, &tolerance.spread) else { return Ok(()) };
    let drawn = |other: &&Tolerance| !matches!(other.spread, Spread::Like(_));
    let Some(leader) = all.iter().filter(drawn).find(|leader| leader.key == *other) else {
        let known = all.iter().filter(drawn).map(|leader| leader.key.as_str());
        return Err(section.unknown_name("[tolerance] that is drawn itself", other, known));
    };
    if leader.is_per_motor() != tolerance.is_per_motor() {
        return Err(
            section.impossible(format!("`{key}` can't go like `{other}`: only one of them is each motor's own"))
        );
    }
    let of = |key: &str| spreadable(reads).find(|(read, _)| read.address == key);
    let (Some((_, of_leader)), Some((read, own))) = (of(other), of(key)) else { return Ok(()) };
    if of_leader == 0.0 || own == 0.0 {
        return Err(
            section.impossible(format!("`{key}` can't go like `{other}`: one of them is 0, which has no share"))
        );
    }
    let share = leader.reach(of_leader).unwrap_or(0.0) / of_leader.abs();
    let follower = Tolerance { spread: Spread::Uniform(Extent::Relative(share)), ..tolerance.clone() };
    check_reach(section, &follower, own, read)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GIMBAL: &str = include_str!("../../../models/f450-gimbal.toml");

    fn with(tolerances: &str) -> String {
        let (model, _) = GIMBAL.split_once("\n[tolerance]").unwrap();
        format!("{model}\n[tolerance]\n{tolerances}\n")
    }

    #[test]
    fn tolerances_are_read_and_written_back() {
        let model = VehicleModel::parse(GIMBAL, "m").unwrap();
        assert!(model.tolerances.len() > 8);
        let text = with(
            "arm_m = { sd = 0.001 }\n\"propulsion.rotor.lift_n_s2\" = { relative_half_width = 0.1 }\n\
             \"propulsion.rotor.drag_nm_s2\" = { like = \"propulsion.rotor.lift_n_s2\" }\n\
             \"effect.1.scale\" = { sd = 0.03 }\n[[effect]]\nname = \"thrust_scale\"\nscale = 1.0\n",
        );
        let model = VehicleModel::parse(&text, "m").unwrap();
        assert_eq!(model.tolerances[0].spread, Spread::Normal(Extent::Absolute(0.001)));
        let of_each: Vec<bool> = model.tolerances.iter().map(Tolerance::is_per_motor).collect();
        assert_eq!(of_each, [false, true, true, false]);
        assert_eq!(VehicleModel::parse(&model.to_toml(), "written").unwrap(), model);
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        for (tolerances, expected) in [
            ("\"body.ixx\" = { relative_sd = 0.1 }", "did you mean `body.ixx_kg_m2`?"),
            ("\"base_command\" = { sd = 0.1 }", "unknown key `base_command`"),
            ("\"body.mass_kg\" = { sd = 0.1 }", "unknown key `body.mass_kg`"),
            ("arm_m = { relative_sdd = 0.1 }", "did you mean `relative_sd`?"),
            ("arm_m = { sd = 0.1, half_width = 0.1 }", "expected one of sd, relative_sd"),
            ("arm_m = {}", "expected one of sd, relative_sd"),
            ("arm_m = 0.1", "`arm_m` is of type float"),
            ("arm_m = { sd = \"much\" }", "`sd` is of type string"),
            ("arm_m = { relative_sd = 1.5 }", "the standard deviation over the value (0.0 to 1.0)"),
            ("arm_m = { sd = -1 }", "`sd` is -1"),
            ("arm_m = { sd = 0 }", "the tolerance of `arm_m` is 0"),
            ("\"body.ixx_kg_m2\" = { relative_sd = 0.34 }", "would be drawn from -2.3024e-4"),
            ("arm_m = { like = \"body.ixx_kg_m2\" }", "unknown key `body.ixx_kg_m2` in [tolerance] that is drawn"),
            (
                "arm_m = { sd = 0.001 }\n\"propulsion.rotor.lift_n_s2\" = { like = \"arm_m\" }",
                "only one of them is each motor's own",
            ),
        ] {
            let text = with(tolerances);
            let line = 1 + text[..text.find(tolerances).unwrap()].matches('\n').count();
            let line = line + tolerances.matches('\n').count();
            let error = VehicleModel::parse(&text, "m.toml").unwrap_err().to_string();
            assert!(error.starts_with(&format!("m.toml:{line}:")) && error.contains(expected), "{line}: {error}");
        }
    }

    #[test]
    fn what_a_changed_model_can_not_have_is_dropped() {
        let mut model = VehicleModel::parse(GIMBAL, "m").unwrap();
        let before = model.clone();
        assert!(model.drop_impossible_tolerances().is_empty());
        assert_eq!(model.tolerances.len(), before.tolerances.len());
        let crate::vehicle::propulsion::Propulsion::Device(device) = &mut model.propulsion else { panic!("no device") };
        device.esc = crate::vehicle::propulsion::Esc::Duty { battery_v: 11.1 };
        assert_eq!(model.drop_impossible_tolerances(), ["propulsion.esc.gain1_v"]);
        VehicleModel::parse(&model.to_toml(), "written").unwrap();
    }
}
