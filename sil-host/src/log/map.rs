//! Maps: what the columns of somebody else's CSV mean (docs/log-format.md, "Other people's columns").
//!
//! ```toml
//! description = "whose logs these are"
//! frame = "FRD"                          # or "FLU": then what is about or along y and z changes its sign
//! axes = ["pitch"]                       # the axes the log has; roll and pitch if left out
//! active_when = "thrust_cmd > 0"         # rows in which the motors run; all of them if left out
//! motor_per_axis_cmd = [0.25, 0.25, 0.5] # change of each motor's command per roll_cmd, pitch_cmd, yaw_cmd
//! rig = "free"                           # or "gimbal"; what the log shows if left out
//! frame_turn_deg = 45                    # turns the body axes about yaw, clockwise from above: a plus frame to an X
//! [quantities]                           # names and units of docs/log-format.md, motors in the order of docs/rig.md
//! time_s    = { column = "t" }
//! pitch_deg = { column = "theta", sign = -1, scale = 1.0, offset = 0.0 }
//! thrust_cmd = { columns = { m1 = 0.25, m2 = 0.25, m3 = 0.25, m4 = 0.25 } }   # a sum of columns, each times a number
//! vn_m_s = { rate_of = "x" }             # a velocity: how fast a column changes
//! roll_rad = { euler_of = ["qw", "qx", "qy", "qz"] }   # an angle of a quaternion, body to world
//! ```
//! A value is `sign * scale * field + offset`, in the unit of its name and the frame of the log; `field` is a column, a
//! sum of columns, how fast a column changes, or an Euler angle. Then the frame is turned.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::Log;
use super::error::{LogError, LogErrorKind};
use super::mapped_column::{Made, MappedColumn, Term};
use super::quantity::Quantity;
use crate::axis::Axis;
use crate::document::with_hint;
use crate::model::Rig;

/// The maps that ship with the project, by name.
pub const BUILT_IN_MAPS: [(&str, &str); 8] = [
    ("antx", include_str!("../../../models/maps/antx.toml")),
    ("crazyflie_arplab", include_str!("../../../models/maps/crazyflie_arplab.toml")),
    ("crazypad_controller", include_str!("../../../models/maps/crazypad_controller.toml")),
    ("crazypad_motor", include_str!("../../../models/maps/crazypad_motor.toml")),
    ("sharif", include_str!("../../../models/maps/sharif.toml")),
    ("sharif_pitch", include_str!("../../../models/maps/sharif_pitch.toml")),
    ("sharif_roll_pitch", include_str!("../../../models/maps/sharif_roll_pitch.toml")),
    ("sharif_yaw", include_str!("../../../models/maps/sharif_yaw.toml")),
];

/// What the columns of a foreign CSV mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The file, or the built-in name.
    pub name: String,
    /// Whose logs it is for.
    pub description: String,
    /// Which of roll, pitch and yaw the log has.
    pub axes: [bool; 3],
    /// Rows in which the motors run.
    pub active_when: Option<Threshold>,
    /// Change of each motor's command per unit of roll, pitch and yaw command, with the signs of docs/rig.md.
    pub motor_per_axis_command: Option<[f64; 3]>,
    /// What holds the vehicle, where the map says so.
    pub rig: Option<Rig>,
    /// By how much the body axes are turned about yaw ([`super::Log::turned`]), deg.
    pub frame_turn_deg: f64,
    /// The columns to read.
    pub(super) columns: Vec<MappedColumn>,
}

/// True in rows where a quantity lies above a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// The quantity to look at.
    pub quantity: Quantity,
    /// It must be larger than this, in the unit a [`super::Log`] holds.
    pub above: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MapFile {
    description: String,
    frame: Spanned<String>,
    axes: Option<Vec<Spanned<String>>>,
    active_when: Option<Spanned<String>>,
    motor_per_axis_cmd: Option<Spanned<[f64; 3]>>,
    rig: Option<Spanned<String>>,
    frame_turn_deg: Option<Spanned<f64>>,
    quantities: Spanned<BTreeMap<Spanned<String>, Entry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    column: Option<String>,
    columns: Option<BTreeMap<String, f64>>,
    rate_of: Option<String>,
    euler_of: Option<[String; 4]>,
    #[serde(default = "one")]
    scale: f64,
    #[serde(default)]
    offset: f64,
    #[serde(default = "one")]
    sign: f64,
}

fn one() -> f64 {
    1.0
}

impl Map {
    /// The built-in maps whose columns a header has all. One of columns under this project's names says nothing of
    /// whose log it is, and is none of them.
    pub(super) fn built_in_for(names: &[&str]) -> impl Iterator<Item = &'static str> {
        let fits = |map: &Map| {
            let renames = map.columns.iter().any(|mapped| mapped.called() != mapped.quantity.name());
            renames && map.columns.iter().flat_map(|one| &one.terms).all(|term| names.contains(&term.column.as_str()))
        };
        BUILT_IN_MAPS
            .into_iter()
            .filter(move |(name, text)| Map::parse(name, text).is_ok_and(|map| fits(&map)))
            .map(|(name, _)| name)
    }

    /// Takes a file if there is one at that path, else the built-in map of that name.
    ///
    /// # Errors
    /// Neither exists, or the file is no map; the message says where and what was expected.
    pub fn load(path_or_name: &str) -> Result<Map, LogError> {
        if Path::new(path_or_name).exists() {
            let bytes = super::source::load(Path::new(path_or_name))?;
            let text = super::source::text(path_or_name, bytes)?;
            return Map::parse(path_or_name, &text);
        }
        let built_in = BUILT_IN_MAPS.iter().find(|(name, _)| *name == path_or_name);
        match built_in {
            Some((name, text)) => Map::parse(name, text),
            None => Err(LogError {
                file: path_or_name.to_owned(),
                line: None,
                column: None,
                kind: LogErrorKind::NoSuchMap(BUILT_IN_MAPS.map(|(name, _)| name).join(", ")),
            }),
        }
    }

    /// What it says of a log beside its columns.
    pub(super) fn tell(&self, log: &mut Log) {
        (log.motor_per_axis_command, log.rig) = (self.motor_per_axis_command, self.rig);
        log.notes.push(format!("read by the map {}", self.name));
    }

    /// True if it names a field of this kind of message.
    pub(super) fn names_field_of(&self, kind: &str) -> bool {
        let mut terms = self.columns.iter().flat_map(|mapped| &mapped.terms);
        terms.any(|term| term.column.strip_prefix(kind).is_some_and(|rest| rest.starts_with('.')))
    }

    /// Reads the text of a map; `name` is for messages.
    ///
    /// # Errors
    /// It is no TOML, a key is unknown, or what it says is not enough to read a log by.
    pub fn parse(name: &str, text: &str) -> Result<Map, LogError> {
        let source = MapText { name, text };
        let file: MapFile = toml::from_str(text)
            .map_err(|e| source.error(e.span().map(|span| span.start), None, &with_hint(e.message())))?;
        let sign_of_frame: fn(Quantity) -> f64 = match file.frame.get_ref().as_str() {
            "FRD" => |_| 1.0,
            "FLU" => Quantity::sign_from_flu,
            other => {
                let message = format!("expected \"FRD\" or \"FLU\", found \"{other}\"");
                return Err(source.error(Some(file.frame.span().start), Some("frame"), &message));
            }
        };
        let table_at = file.quantities.span().start;
        let mut columns: Vec<MappedColumn> = Vec::new();
        for (key, entry) in file.quantities.into_inner() {
            let column = source.column(&key, entry, sign_of_frame)?;
            if columns.iter().any(|c| c.quantity == column.quantity) {
                let message = format!("{} is given twice", column.quantity.name());
                return Err(source.error(Some(key.span().start), Some(key.get_ref()), &message));
            }
            columns.push(column);
        }
        columns.sort_by_key(|column| column.quantity);
        let axes = source.axes(file.axes, &columns)?;
        if let Some(missing) = missing_quantity(axes, &columns) {
            return Err(source.error(Some(table_at), Some("quantities"), &missing));
        }
        let active_when = match file.active_when {
            Some(condition) => Some(source.threshold(&condition, &columns)?),
            None => None,
        };
        let motor_per_axis_command = file.motor_per_axis_cmd.map(|given| source.mixer(&given)).transpose()?;
        let frame_turn_deg = file.frame_turn_deg.map(|given| source.turn(&given)).transpose()?.unwrap_or(0.0);
        let rig = file.rig.map(|given| source.rig(&given)).transpose()?;
        let (name, description) = (name.to_owned(), file.description);
        Ok(Map { name, description, axes, active_when, motor_per_axis_command, rig, frame_turn_deg, columns })
    }
}

/// The map's text, to turn a byte offset into a line.
struct MapText<'a> {
    name: &'a str,
    text: &'a str,
}

impl MapText<'_> {
    fn error(&self, at_byte: Option<usize>, key: Option<&str>, message: &str) -> LogError {
        let before = at_byte.and_then(|at| self.text.get(..at));
        LogError {
            file: self.name.to_owned(),
            line: before.map(|text| 1 + text.matches('\n').count()),
            column: key.map(str::to_owned),
            kind: LogErrorKind::MapSyntax(message.trim_end().to_owned()),
        }
    }

    fn column(
        &self,
        key: &Spanned<String>,
        entry: Entry,
        sign_of_frame: fn(Quantity) -> f64,
    ) -> Result<MappedColumn, LogError> {
        let fail = |message: &str| Err(self.error(Some(key.span().start), Some(key.get_ref()), message));
        let Some((quantity, factor)) = Quantity::from_name(key.get_ref()) else {
            return fail("no quantity of that name and unit; docs/log-format.md lists them");
        };
        if entry.sign != 1.0 && entry.sign != -1.0 {
            return fail("sign must be 1 or -1");
        }
        if !entry.scale.is_finite() || entry.scale == 0.0 || !entry.offset.is_finite() {
            return fail("scale must be finite and not 0, offset finite");
        }
        let to_log = sign_of_frame(quantity) * factor;
        let scale = to_log * entry.sign * entry.scale;
        let (fields, made) = match (entry.column, entry.columns, entry.rate_of, entry.euler_of) {
            (Some(column), None, None, None) => (vec![(column, 1.0)], Made::Sum),
            (None, Some(columns), None, None) if columns.values().all(|share| share.is_finite() && *share != 0.0) => {
                (columns.into_iter().collect(), Made::Sum)
            }
            (None, Some(_), None, None) => return fail("each of columns must have a finite number that is not 0"),
            (None, None, Some(column), None) => (vec![(column, 1.0)], Made::RateOf),
            (None, None, None, Some(columns)) => (columns.map(|column| (column, 1.0)).into(), Made::EulerOf),
            _ => (Vec::new(), Made::Sum),
        };
        if fields.is_empty() {
            return fail(
                "expected column = \"NAME\", or columns = { NAME = NUMBER, ... } for a sum, or rate_of = \"NAME\" for \
                 how fast a place changes, or euler_of = [\"W\", \"X\", \"Y\", \"Z\"] for an angle of a quaternion",
            );
        }
        if made == Made::RateOf && (!matches!(quantity, Quantity::Velocity(_)) || entry.offset != 0.0) {
            return fail("rate_of makes a velocity of a place, without offset");
        }
        if made == Made::EulerOf && (!matches!(quantity, Quantity::Angle(_)) || entry.scale != 1.0) {
            return fail("euler_of makes roll_rad, pitch_rad or yaw_rad of a quaternion, without scale");
        }
        // whatever the unit of the key, a quaternion's angles come in radians
        let scale = if made == Made::EulerOf { scale / factor } else { scale };
        let terms = fields.into_iter().map(|(column, share)| Term { column, share }).collect();
        Ok(MappedColumn { quantity, terms, scale, offset: to_log * entry.offset, made })
    }

    fn turn(&self, given: &Spanned<f64>) -> Result<f64, LogError> {
        let turn_deg = *given.get_ref();
        if (-360.0..=360.0).contains(&turn_deg) {
            return Ok(turn_deg);
        }
        let message = "expected an angle of -360 to 360 degrees";
        Err(self.error(Some(given.span().start), Some("frame_turn_deg"), message))
    }

    fn rig(&self, given: &Spanned<String>) -> Result<Rig, LogError> {
        let found = Rig::NAMES.into_iter().find(|(name, _)| name == given.get_ref());
        found.map(|(_, rig)| rig).ok_or_else(|| {
            let message = format!("expected \"free\" or \"gimbal\", found \"{}\"", given.get_ref());
            self.error(Some(given.span().start), Some("rig"), &message)
        })
    }

    fn axes(&self, declared: Option<Vec<Spanned<String>>>, columns: &[MappedColumn]) -> Result<[bool; 3], LogError> {
        let Some(declared) = declared else {
            return Ok([true, true, describes(Axis::Yaw, columns)]);
        };
        let mut axes = [false; 3];
        for name in declared {
            let Some(axis) = Axis::ALL.iter().find(|axis| axis.name() == name.get_ref()) else {
                let message = format!("expected roll, pitch or yaw, found `{}`", name.get_ref());
                return Err(self.error(Some(name.span().start), Some("axes"), &message));
            };
            axes[axis.index()] = true;
        }
        Ok(axes)
    }

    fn mixer(&self, given: &Spanned<[f64; 3]>) -> Result<[f64; 3], LogError> {
        let per_command = *given.get_ref();
        if per_command.iter().all(|per| per.is_finite() && *per > 0.0) {
            return Ok(per_command);
        }
        let message = "expected three numbers above 0: each motor's change per roll_cmd, pitch_cmd and yaw_cmd";
        Err(self.error(Some(given.span().start), Some("motor_per_axis_cmd"), message))
    }

    fn threshold(&self, condition: &Spanned<String>, columns: &[MappedColumn]) -> Result<Threshold, LogError> {
        let parsed = condition.get_ref().split_once('>').and_then(|(name, value)| {
            let (quantity, factor) = Quantity::from_name(name.trim())?;
            let above: f64 = value.trim().parse().ok()?;
            let given = columns.iter().any(|column| column.quantity == quantity);
            (given && above.is_finite()).then_some(Threshold { quantity, above: above * factor })
        });
        parsed.ok_or_else(|| {
            let message = format!(
                "expected \"QUANTITY > NUMBER\" with a quantity of this map, found \"{}\"",
                condition.get_ref()
            );
            self.error(Some(condition.span().start), Some("active_when"), &message)
        })
    }
}

fn describes(axis: Axis, columns: &[MappedColumn]) -> bool {
    let of_axis = [Quantity::Angle(axis), Quantity::Rate(axis)];
    columns.iter().any(|column| of_axis.contains(&column.quantity))
}

/// All that a log needs beyond what the map gives: time, angle or rate of each declared axis, and what drives it.
fn missing_quantity(axes: [bool; 3], columns: &[MappedColumn]) -> Option<String> {
    let given = |quantity| columns.iter().any(|column| column.quantity == quantity);
    let motors = (0..4).all(|motor| given(Quantity::Motor(motor)));
    let mut missing = Vec::new();
    if !given(Quantity::Time) {
        missing.push("time_s is missing".to_owned());
    }
    if !axes.contains(&true) {
        missing.push("axes names no axis".to_owned());
    }
    for axis in Axis::ALL.into_iter().filter(|axis| axes[axis.index()]) {
        if !describes(axis, columns) {
            let (angle, rate) = (Quantity::Angle(axis).name(), Quantity::Rate(axis).name());
            missing.push(format!("{angle} or {rate} is missing (axes has {})", axis.name()));
        }
        if !motors && !given(Quantity::Command(axis)) {
            let command = Quantity::Command(axis).name();
            missing.push(format!("{command} is missing (or motor1 to motor4)"));
        }
    }
    (!missing.is_empty()).then(|| missing.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_map_parses_and_is_found_by_its_name() {
        for (name, _) in BUILT_IN_MAPS {
            let map = Map::load(name).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(map.name, name);
            assert!(!map.description.is_empty());
        }
    }

    #[test]
    fn forward_left_up_turns_what_is_about_y_and_z() {
        let text = |frame: &str| {
            format!(
                "description = \"\"\nframe = \"{frame}\"\naxes = [\"roll\", \"pitch\", \"yaw\"]\n[quantities]\n\
                 time_ms = {{ column = \"t\" }}\np_rad_s = {{ column = \"gx\" }}\n\
                 q_deg_s = {{ column = \"gy\", scale = 2, offset = 3 }}\nr_rad_s = {{ column = \"gz\", sign = -1 }}\n\
                 roll_cmd = {{ column = \"a\" }}\npitch_cmd = {{ column = \"b\" }}\nyaw_cmd = {{ column = \"c\" }}\n"
            )
        };
        let [frd, flu] = ["FRD", "FLU"].map(|frame| Map::parse("m", &text(frame)).unwrap());
        for (frd, flu) in frd.columns.iter().zip(&flu.columns) {
            let turned = match frd.quantity {
                Quantity::Rate(axis) | Quantity::Command(axis) => axis != Axis::Roll,
                _ => false,
            };
            let sign = if turned { -1.0 } else { 1.0 };
            assert_eq!((flu.scale, flu.offset), (sign * frd.scale, sign * frd.offset));
        }
        let q = &flu.columns[2];
        assert_eq!(q.quantity, Quantity::Rate(Axis::Pitch));
        assert_eq!(q.scale, -(2.0_f64 * (std::f64::consts::PI / 180.0)));
        assert_eq!(q.offset, -(3.0_f64 * (std::f64::consts::PI / 180.0)));
    }
}
