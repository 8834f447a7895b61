//! The pages under `docs/` that list names of the code: what is between their markers is generated from it, and the
//! fields of JSON that they describe are those that commands write.
//!
//! `UPDATE_PAGES=1 cargo test -p sil-host --test commands pages` writes the generated parts.

use std::collections::BTreeSet;
use std::path::PathBuf;

use serde_json::Value;
use shared_control::airframe::{MOTORS, TORQUE_SIGNS};
use shared_control::config::{Controller, Tuning};
use sil_host::control_setup::vehicle_parameters;
use sil_host::controller_file::ControllerChoice;
use sil_host::diagnosis::{AtVoltage, BaseTerm, Difference, Estimate, Fact, Holding, LastingGain};
use sil_host::effects::{Effect, Origin};
use sil_host::flight::FlightSetup;
use sil_host::hitl::{HitlFlight, Timing};
use sil_host::log::Quantity;
use sil_host::model::{Rig, VehicleModel, keys};
use sil_host::scenario::Scenario;

use crate::sil::{Folder, RIG_LOG, instance_files};

const UPDATE: &str = "UPDATE_PAGES=1 cargo test -p sil-host --test commands pages";
const THESIS_MPC: &str = include_str!("../../demonstration/thesis-mpc.toml");

fn page(name: &str) -> (PathBuf, String) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs").join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    (path, text)
}

/// Holds the part `part` of a page against what the code says, or writes it there.
fn assert_generated(name: &str, part: &str, text: &str) {
    let (path, page) = page(name);
    let start = format!("<!-- generated: {part} ({UPDATE}) -->\n");
    let (before, rest) = page.split_once(&start).unwrap_or_else(|| panic!("docs/{name} lacks {start}"));
    let (now, after) = rest.split_once("<!-- end -->\n").unwrap_or_else(|| panic!("docs/{name}: {part} has no end"));
    if std::env::var_os("UPDATE_PAGES").is_some() {
        std::fs::write(&path, format!("{before}{start}{text}<!-- end -->\n{after}")).unwrap();
        return;
    }
    assert_eq!(now, text, "\ndocs/{name} is not what the code says. To write it: {UPDATE}");
}

/// Rows as a table of Markdown.
fn table(head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let rule = format!("|{}\n", "---|".repeat(head.len()));
    let rows = rows.into_iter().map(|cells| line(cells.into_iter().map(|cell| cell.replace('|', "\\|")).collect()));
    line(head.iter().map(ToString::to_string).collect()) + &rule + &rows.collect::<String>()
}

#[test]
fn pages_list_every_effect() {
    let rows = Effect::CATALOGUE.iter().map(|entry| {
        let rigs: Vec<_> = entry.rigs.iter().map(|rig| rig.name()).collect();
        vec![
            format!("`{}`", entry.name),
            entry.origin.name().to_owned(),
            rigs.join(", "),
            entry.summary.to_owned(),
            format!("`{}`", entry.example),
        ]
    });
    assert_generated("effects.md", "effects", &table(&["effect", "origin", "rigs", "what it is", "example"], rows));
}

#[test]
fn pages_list_every_parameter_of_every_effect() {
    let rows = Effect::CATALOGUE.iter().flat_map(|entry| {
        entry.parameters.iter().map(|parameter| {
            let default = parameter.usual.map_or(String::new(), |value| format!("{value}"));
            vec![
                format!("`{}`", entry.name),
                format!("`{}`", parameter.name),
                if parameter.unit.is_empty() { "1".to_owned() } else { parameter.unit.to_owned() },
                format!("{}", parameter.nominal),
                default,
                format!("{} to {}", parameter.min, parameter.max),
                parameter.meaning.to_owned(),
            ]
        })
    });
    let head = ["effect", "parameter", "unit", "nominal", "default", "range", "meaning"];
    assert_generated("effects.md", "parameters", &table(&head, rows));
}

#[test]
fn pages_list_the_motors() {
    let sign = |value: f32| if value > 0.0 { "+" } else { "-" };
    let rows = MOTORS.iter().enumerate().map(|(number, motor)| {
        let (end, side) =
            (if motor.forward > 0 { "front" } else { "rear" }, if motor.right > 0 { "right" } else { "left" });
        let spin = if motor.spin > 0 { "clockwise" } else { "counter-clockwise" };
        let along = |direction: i8| format!("{}d/sqrt2", sign(f32::from(direction)));
        let mut cells = vec![(number + 1).to_string(), format!("{end} {side}"), spin.to_owned()];
        cells.extend([along(motor.forward), along(motor.right)]);
        cells.extend(TORQUE_SIGNS.map(|signs| sign(signs[number]).to_owned()));
        cells
    });
    let head = ["motor", "position", "spin, seen from above", "x", "y", "adds to roll", "to pitch", "to yaw"];
    assert_generated("rig.md", "motors", &table(&head, rows));
}

#[test]
fn pages_list_every_column_of_a_log() {
    let mut kinds: Vec<Vec<Quantity>> = Vec::new();
    for quantity in Quantity::ALL {
        match kinds.last_mut() {
            Some(kind) if kind[0].meaning() == quantity.meaning() => kind.push(quantity),
            _ => kinds.push(vec![quantity]),
        }
    }
    let rows = kinds.iter().map(|kind| {
        let names: Vec<_> = kind.iter().map(|quantity| format!("`{}`", quantity.name())).collect();
        let (_, unit) = kind[0].names().next().unwrap();
        let others: Vec<_> = kind[0].names().skip(1).map(|(name, unit)| format!("{unit} (`{name}`)")).collect();
        let range = kind[0].range();
        let range =
            if *range.end() < f64::MAX { format!("{} to {}", range.start(), range.end()) } else { "any".into() };
        vec![names.join(", "), unit.to_owned(), others.join(", "), range, kind[0].meaning().to_owned()]
    });
    let head = ["columns", "unit", "other units that are read", "range", "meaning"];
    assert_generated("log-format.md", "columns", &table(&head, rows));
}

/// Names, types and meanings from where the core declares them, defaults from the core at work.
#[test]
fn pages_list_every_key_of_a_tuning() {
    let source = include_str!("../../../shared-control/src/config/tuning.rs");
    let declared = source.split_once("pub struct Tuning {\n").unwrap().1.split_once("\n}").unwrap().0;
    let mut keys: Vec<[String; 3]> = Vec::new();
    let mut meaning: Vec<&str> = Vec::new();
    for line in declared.lines().map(str::trim) {
        match line.strip_prefix("pub ").and_then(|field| field.trim_end_matches(',').split_once(": ")) {
            Some((name, kind)) => {
                let kind = match kind {
                    "[f32; 3]" => "3 numbers",
                    "f32" | "Option<f32>" => "number",
                    "usize" => "whole number",
                    "bool" => "true or false",
                    _ => "text",
                };
                let meaning = std::mem::take(&mut meaning).join(" ").replace(['[', ']'], "");
                keys.push([format!("`{name}`"), kind.to_owned(), meaning]);
            }
            None => meaning.push(line.trim_start_matches("///").trim()),
        }
    }
    let model = VehicleModel::nominal(Rig::Gimbal);
    let tunings = [Controller::Cascade, Controller::Mpc]
        .map(|controller| format!("{:?}", Tuning::for_flight(&vehicle_parameters(&model), controller, false)));
    let value_in = |tuning: &str, name: &str| {
        let (_, rest) = tuning.split_once(&format!("{name}: ")).unwrap();
        let end = if rest.starts_with('[') { "]" } else { "," };
        let value = rest.split(end).next().unwrap().trim_matches(['[', ' ', '}']);
        let short = |number: &str| match number.parse::<f32>() {
            Ok(number) => format!("{}", format!("{number:.3e}").parse::<f32>().unwrap()),
            Err(_) => number.to_lowercase(),
        };
        value.split(", ").map(short).collect::<Vec<_>>().join(", ")
    };
    let rows = keys.into_iter().map(|[name, kind, meaning]| {
        let [pid, mpc] = tunings.each_ref().map(|tuning| value_in(tuning, name.trim_matches('`')));
        let value = if pid == mpc { pid } else { format!("{pid}; under the MPC {mpc}") };
        vec![name, kind, value, meaning]
    });
    assert_generated("commands.md", "tuning keys", &table(&["key", "type", "default", "meaning"], rows));
}

#[test]
fn pages_list_every_key_of_a_model_file() {
    // the axes of a bench have the same keys
    let keys = keys().unwrap().into_iter().filter(|key| !["pitch", "yaw"].contains(&key.table.as_str()));
    let rows = keys.map(|key| {
        let table = match key.table.as_str() {
            "" => String::new(),
            "roll" => "`[roll]`, `[pitch]`, `[yaw]`".to_owned(),
            table => format!("`[{table}]`"),
        };
        let code = |text: &str| if text.is_empty() { String::new() } else { format!("`{text}`") };
        let without = if key.is_optional { "not known" } else { "required" };
        let default = key.default.map_or_else(|| without.to_owned(), |value| value.to_string());
        vec![table, code(key.key), key.meaning, key.unit, key.range, default, code(&key.only_with)]
    });
    let head = ["table", "key", "meaning", "unit", "range", "default", "only with"];
    assert_generated("rig.md", "keys of model files", &table(&head, rows));
}

#[test]
fn pages_hold_the_help_of_every_command() {
    let folder = Folder::new();
    let help = |command: &str| {
        let arguments: Vec<&str> = command.split_whitespace().skip(1).chain(["--help"]).collect();
        let mut command = folder.command(&arguments);
        // the width of somebody's terminal must not show
        command.env_remove("COLUMNS");
        let text = crate::sil::Outcome::of(&arguments, command).assert_done().stdout;
        text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
    };
    let all = help("sil");
    let list = all.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let is_command = |line: &&str| line.starts_with("  ") && !line.starts_with("   ");
    let names = list.lines().filter(is_command).map(|line| line.split_whitespace().next().unwrap());
    let names: Vec<String> = names.filter(|name| *name != "help").map(|name| format!("sil {name}")).collect();
    let section = |name: &String| format!("### `{name}`\n```text\n{}\n```\n", help(name));
    let text: Vec<String> = [&"sil".to_owned()].into_iter().chain(&names).map(section).collect();
    assert_generated("commands.md", "commands", &format!("\n{}\n", text.join("\n")));
}

#[test]
fn pages_describe_the_json_of_flights_and_logs() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    folder.write("script.toml", "duration_s = 1\n[[step]]\nat_s = 0.2\nroll_deg = 5\n");
    for (command, arguments) in [
        ("fly", vec!["--controller", "mpc", "--script", "script.toml"]),
        ("synth", vec!["--duration", "2", "made.csv"]),
        ("compare", vec!["log.csv", "--controller", "mpc"]),
        ("bench-mpc", vec![&*instance_files()[0]]),
        ("serve", vec!["--udp", "off", "--tcp", "0", "--for", "0.1"]),
    ] {
        let arguments = [&[command, "--json", "out.json"], &arguments[..]].concat();
        folder.sil(&arguments).assert_done();
        assert_described(command, &folder.json("out.json"));
    }
}

#[test]
fn pages_describe_the_json_of_a_refinement() {
    let folder = Folder::new();
    let rotor: String = (1..=9).map(|k| format!("{},{}\n", 100 * k, 0.05 * f64::from(k * k) + 1e-4)).collect();
    for name in ["monday.csv", "tuesday.csv"] {
        folder.write(name, format!("speed_rad_s,lift_n\n{rotor}"));
    }
    folder.sil(&["refine", "monday.csv", "tuesday.csv", "--json", "out.json"]).assert_done();
    let mut answer = folder.json("out.json");
    assert_eq!(answer["forms"][0]["unseen_error"], Value::Null);
    // a table of tidy columns has nothing to remark
    answer["notes"] = serde_json::json!([]);
    assert_described("refine", &answer);
}

#[test]
fn pages_describe_the_json_of_a_study() {
    let folder = Folder::new();
    folder.write("s.toml", "duration_s = 0.5\n[[step]]\nat_s = 0.1\nroll_deg = 5\n");
    let arguments = ["--runs", "60", "--controller", "pid", "--script", "s.toml", "--json", "out.json"];
    folder.sil(&[&["montecarlo"], &arguments[..]].concat()).assert_done();
    let mut answer = folder.json("out.json");
    // no vehicle is lost within half a second
    answer["lost"][0]["commands"] = serde_json::json!(["sil fly --draw 0:1"]);
    // a figure that is the same in every flight comes from nothing
    let figures = answer["figures"].as_array_mut().unwrap();
    figures.retain(|figure| !figure["influences"].as_array().unwrap().is_empty());
    assert_described("montecarlo", &answer);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn pages_describe_the_json_of_the_thesis() {
    let folder = Folder::new();
    folder.sil(&["thesis", "--json", "out.json", "--report", "out.html"]).assert_done();
    assert_described("thesis", &folder.json("out.json"));
    let page = String::from_utf8(folder.bytes("out.html")).unwrap();
    for figure in ["Table 5.1", "Figure 5.3", "Figure 5.6", "C.7"] {
        assert!(page.contains(figure), "{figure} is not on the page");
    }
}

#[test]
fn pages_describe_the_json_of_a_diagnosis() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    folder.write("mpc.toml", THESIS_MPC);
    folder.sil(&["diagnose", "log.csv", "--quick", "--controller", "mpc.toml", "--json", "out.json"]).assert_done();
    let mut answer = folder.json("out.json");
    // this log needs no base model
    assert_eq!(answer["base"], serde_json::json!([]));
    let parameters = [("scale", Estimate { value: 0.9, std: 0.01 })].into();
    let term = BaseTerm { effect: "thrust_scale", axis: None, parameters, ordinary: true, extension: None };
    answer["base"] = serde_json::to_value([term]).unwrap();
    answer["lateness_s"] = serde_json::to_value(Estimate { value: 0.02, std: 0.001 }).unwrap();
    let holding = Holding { axis: "roll", std_rad_s2: 64.0, memory_s: 0.3 };
    answer["holding"] = serde_json::to_value([holding]).unwrap();
    let lasting = LastingGain { axis: "roll", gain_rad_s2: 300.0, std_rad_s2: 20.0 };
    answer["lasting_gains"] = serde_json::to_value([lasting]).unwrap();
    answer["known"] = serde_json::to_value([Fact { name: "mass_kg", value: 1.0, std: 0.0 }]).unwrap();
    assert_described("diagnose", &answer);
}

#[test]
fn pages_describe_the_json_of_several_comparisons() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG.lines().take(800).map(|line| format!("{line}\n")).collect::<String>());
    let both = ["compare", "log.csv", "--controller", "pid", "--controller", "mpc", "--json", "out.json"];
    folder.sil(&both).assert_done();
    let mut answer = folder.json("out.json");
    answer["runs"][0]["error"] = "why".into();
    assert_described("compare, several", &answer);
}

#[test]
fn pages_describe_the_json_of_a_comparison_of_flights() {
    let folder = Folder::new();
    // its first eight seconds
    folder.write("log.csv", RIG_LOG.lines().take(800).map(|line| format!("{line}\n")).collect::<String>());
    folder.sil(&["diagnose", "log.csv", "--baseline", "log.csv", "--json", "out.json"]).assert_done();
    let mut answer = folder.json("out.json");
    // one flight against itself shows no cause: one is put in, with another that can't be told from it
    let difference = |one_of: Vec<Difference>| Difference {
        effect: "weak_motor",
        axis: None,
        origin: Origin::Actuator,
        parameters: [("scale", Estimate { value: 0.9, std: 0.01 })].into(),
        interval_95: [0.88, 0.92],
        explains_pct: Some(90.0),
        chance: Some(0.01),
        one_of,
        told_apart_by: String::new(),
        statement: String::new(),
    };
    let finding = serde_json::to_value(difference(vec![difference(Vec::new())])).unwrap();
    answer["known"] = serde_json::to_value([Fact { name: "mass_kg", value: 1.0, std: 0.0 }]).unwrap();
    (answer["nearest"], answer["findings"]) = (finding.clone(), serde_json::json!([finding]));
    let follows = Estimate { value: 1.0, std: 0.2 };
    let at_voltage = AtVoltage { battery_v: 11.0, normal_battery_v: 10.5, follows };
    answer["baseline"]["at_voltage"] = serde_json::to_value(at_voltage).unwrap();
    assert_described("diagnose --baseline", &answer);
}

/// Figures of a flight of which no board was part: what a board does is tested elsewhere, the fields are the same.
#[test]
fn pages_describe_the_json_of_a_board_in_the_loop() {
    let setup = FlightSetup {
        model: VehicleModel::nominal(Rig::Gimbal),
        controller_model: None,
        choice: ControllerChoice::nominal(Controller::Cascade),
        scenario: Scenario { duration_s: 0.1, ..Scenario::test_sequence() },
        seed: 0,
    };
    let summary = setup.fly().unwrap().summary;
    let flight = HitlFlight { summary, timing: Timing::default(), achieved_rate_hz: 400.0, sent_again: 0 };
    assert_described("hitl", &serde_json::to_value(flight.figures()).unwrap());
}

/// What there is only while another program simulates the vehicle.
#[test]
fn figures_of_a_lock_step_are_described() {
    let figures = sil_host::serve::lock_step::LockStepFigures::default();
    assert_described("serve --simulator", &serde_json::json!({ "simulator": figures }));
}

/// Every field of the JSON stands in the page's table, with its type, and the table has no other.
fn assert_described(command: &str, json: &Value) {
    let (_, page) = page("commands.md");
    let table = page.split(&format!("<!-- json: {command} -->")).nth(1).unwrap().split("\n\n").next().unwrap();
    let rows: Vec<_> = rows_of(table).map(|cells| (code_in(&cells[0]).next().unwrap(), cells[1].clone())).collect();
    let mut fields = BTreeSet::new();
    collect_fields(json, "", &mut fields);
    for (field, kind) in &fields {
        let described = rows.iter().find(|(row, _)| row == field || is_under(field, row));
        let (row, types) = described.unwrap_or_else(|| panic!("docs/commands.md, {command}: `{field}` is not there"));
        let fits = row.ends_with(".*") || types.split(" or ").any(|one| one == *kind || types.is_empty());
        assert!(
            fits || (*kind == "integer" && types.contains("number")),
            "{command}: `{field}` is {kind}, not {types}"
        );
    }
    for (row, _) in &rows {
        let exists = fields.iter().any(|(field, _)| field == row || is_under(field, row));
        assert!(exists, "docs/commands.md, {command}: no field `{row}`");
    }
}

/// Whether a row such as `axes.pitch.*` stands for a field.
fn is_under(field: &str, row: &str) -> bool {
    row.strip_suffix('*').is_some_and(|stem| field.starts_with(stem))
}

/// All fields below a value with their types, elements of arrays as `[]`, parameters of a finding as `NAME`; objects
/// and arrays themselves only where they hold no fields.
fn collect_fields(value: &Value, place: &str, fields: &mut BTreeSet<(String, &'static str)>) {
    let kind = match value {
        Value::Object(object) => {
            for (key, value) in object {
                let key = if place.ends_with("[].parameters") || place == "nearest.parameters" { "NAME" } else { key };
                let dot = if place.is_empty() { "" } else { "." };
                collect_fields(value, &format!("{place}{dot}{key}"), fields);
            }
            "object"
        }
        Value::Array(elements) => {
            for element in elements.iter().filter(|element| element.is_object()) {
                collect_fields(element, &format!("{place}[]"), fields);
            }
            if elements.iter().any(Value::is_object) {
                return;
            }
            "array"
        }
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(number) if number.is_f64() => "number",
        Value::Number(_) => "integer",
        Value::String(_) => "string",
    };
    if kind != "object" || NULLABLE.iter().any(|field| place.ends_with(field)) {
        fields.insert((place.to_owned(), kind));
    }
}

/// Objects that may be null have a row of their own.
const NULLABLE: [&str; 5] = [".mpc", "closed_loop", ".theil_split", ".ljung_box", ".input_correlation"];

/// The cells of a Markdown table's rows, head and rule left out.
fn rows_of(text: &str) -> impl Iterator<Item = Vec<String>> {
    let rows = text.lines().filter(|line| line.starts_with('|')).skip(2);
    rows.map(|line| line.trim_matches('|').replace("\\|", "/").split('|').map(|cell| cell.trim().to_owned()).collect())
}

/// What stands between backticks.
fn code_in(cell: &str) -> impl Iterator<Item = String> {
    cell.split('`').skip(1).step_by(2).map(ToOwned::to_owned)
}
