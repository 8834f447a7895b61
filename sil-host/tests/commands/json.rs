//! The JSON that commands write has exactly the fields of docs/commands.md, each of its type.

use serde_json::{Value, json};

use crate::sil::{Folder, RIG_LOG, instance_files};

/// Holds a value against a template: objects have the same keys, every element of an array fits the template's one
/// element, and a leaf is "integer", "number", "number?" (or null), "string", "boolean" or "anything".
pub fn assert_fits(value: &Value, template: &Value, place: &str) {
    match template {
        Value::Object(fields) => {
            let object = value.as_object().unwrap_or_else(|| panic!("{place}: expected an object, found {value}"));
            let keys =
                |of: &serde_json::Map<String, Value>| of.keys().cloned().collect::<std::collections::BTreeSet<_>>();
            assert_eq!(keys(object), keys(fields), "{place}");
            for (key, template) in fields {
                assert_fits(&object[key], template, &format!("{place}.{key}"));
            }
        }
        Value::Array(elements) => {
            let array = value.as_array().unwrap_or_else(|| panic!("{place}: expected an array, found {value}"));
            assert!(!array.is_empty(), "{place}");
            for (index, element) in array.iter().enumerate() {
                assert_fits(element, &elements[0], &format!("{place}[{index}]"));
            }
        }
        leaf => {
            let fits = match leaf.as_str() {
                Some("integer") => value.is_u64(),
                Some("number") => value.is_number(),
                Some("number?") => value.is_number() || value.is_null(),
                Some("string") => value.is_string(),
                Some("boolean") => value.is_boolean(),
                Some("anything") => true,
                // a value to the letter
                _ => value == leaf,
            };
            assert!(fits, "{place}: expected {leaf}, found {value}");
        }
    }
}

fn axis() -> Value {
    json!({
        "rise_time_s": "number?", "overshoot_pct": "number?", "settling_time_s": "number?",
        "steady_error_deg": "number?", "largest_late_error_deg": "number?",
        "mean_abs_error_deg": "number", "rms_error_deg": "number",
    })
}

fn run(mpc: Value) -> Value {
    json!({
        "controller": "string", "rate_hz": "integer", "rig": "string", "model": "string", "seed": "integer",
        "duration_s": "number", "axes": { "roll": axis(), "pitch": axis() },
        "effort": "number", "saturated_pct": "number", "real_time_factor": "number", "mpc": mpc,
    })
}

fn mpc() -> Value {
    json!({
        "horizon": "integer", "control_horizon": "integer", "prediction_step_s": "number",
        "iterations_max": "integer", "fallbacks": "integer", "unsolved": "integer",
    })
}

#[test]
fn of_fly() {
    let folder = Folder::new();
    folder
        .sil(&["fly", "--rate", "100", "--control-horizon", "2", "--seed", "9", "--json", "deep/out.json"])
        .assert_done();
    let json = folder.json("deep/out.json");
    let runs = json["runs"].as_array().unwrap();
    assert_eq!((json.as_object().unwrap().len(), runs.len()), (1, 2));
    assert_fits(&runs[0], &run(Value::Null), "pid");
    assert_fits(&runs[1], &run(mpc()), "mpc");
    for (flown, controller) in runs.iter().zip(["pid", "mpc"]) {
        assert_eq!(flown["controller"], controller);
        assert_eq!((flown["rate_hz"].as_u64(), flown["seed"].as_u64()), (Some(100), Some(9)));
        assert_eq!((flown["rig"].as_str(), flown["duration_s"].as_f64()), (Some("gimbal"), Some(29.75)));
        // every step of the test sequence settles: no figure is missing
        assert!(flown["axes"]["pitch"]["settling_time_s"].is_number());
    }
    assert_eq!(runs[1]["mpc"]["control_horizon"], 2);
    // 10 ms / (1 + 17 T), docs/tuning.md, with T = 2 ms
    assert!((runs[1]["mpc"]["prediction_step_s"].as_f64().unwrap() - 0.00967).abs() < 1e-5);
    assert_eq!(runs[1]["mpc"]["horizon"], 30);
}

/// Nothing steps: what is a mean over steps is null, the rest is there.
#[test]
fn of_fly_without_a_step() {
    let folder = Folder::new();
    folder.write("still.toml", "duration_s = 0.5\n");
    folder
        .sil(&["fly", "--controller", "pid", "--rig", "free", "--script", "still.toml", "--json", "out.json"])
        .assert_done();
    let json = folder.json("out.json");
    assert_fits(&json, &json!({ "runs": [run(Value::Null)] }), "");
    let flown = &json["runs"][0];
    assert_eq!((flown["rig"].as_str(), flown["duration_s"].as_f64()), (Some("free"), Some(0.5)));
    for figure in ["rise_time_s", "overshoot_pct", "settling_time_s", "steady_error_deg"] {
        assert!(flown["axes"]["roll"][figure].is_null(), "{figure}");
    }
}

fn comparison(closed_loop: Value, roll: &str) -> Value {
    let errors = || json!({ "roll_deg": roll, "pitch_deg": "number", "p_deg_s": roll, "q_deg_s": "number" });
    json!({
        "closed_loop": closed_loop,
        "prediction_error": {
            "window_s": 0.5, "nominal": errors(), "noise_floor": errors(),
            "channels": [{ "quantity": "string", "unit": "string", "nominal": "number", "noise_floor": "number" }],
        },
    })
}

#[test]
fn of_compare() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    folder.sil(&["compare", "log.csv", "--json", "out.json"]).assert_done();
    assert_fits(&folder.json("out.json"), &comparison(Value::Null, "number"), "");
    folder.sil(&["compare", "log.csv", "--controller", "mpc", "--json", "out.json"]).assert_done();
    let closed_loop = json!({ "roll_mean_abs_deg": "number", "pitch_mean_abs_deg": "number" });
    assert_fits(&folder.json("out.json"), &comparison(closed_loop, "number"), "");
}

/// A foreign bench on which only pitch moves: figures of roll are null.
#[test]
fn of_compare_on_one_axis() {
    let folder = Folder::new();
    let map = "description = \"a bench\"\nframe = \"FRD\"\naxes = [\"pitch\"]\n[quantities]\n\
        time_s = { column = \"t\" }\npitch_rad = { column = \"theta\" }\nq_rad_s = { column = \"omega\" }\n\
        pitch_cmd = { column = \"u\" }\n";
    // 4 s of a double integrator of 10 rad/s^2 per unit under a square wave of 1 Hz
    let (mut angle, mut rate, mut rows) = (0.0_f64, 0.0_f64, "t,theta,omega,u\n".to_owned());
    for row in 0..1000 {
        let command = if (row / 125) % 2 == 0 { 0.2 } else { -0.2 };
        rows += &format!("{},{angle},{rate},{command}\n", f64::from(row) * 0.004);
        angle += rate * 0.004 + 0.5 * 10.0 * command * 0.004 * 0.004;
        rate += 10.0 * command * 0.004;
    }
    folder.write("map.toml", map);
    folder.write("log.csv", rows);
    let outcome = folder.sil(&["compare", "log.csv", "--map", "map.toml", "--json", "out.json"]).assert_done();
    let mut template = comparison(Value::Null, "number");
    for errors in ["nominal", "noise_floor"] {
        template["prediction_error"][errors]["roll_deg"] = Value::Null;
        template["prediction_error"][errors]["p_deg_s"] = Value::Null;
    }
    assert_fits(&folder.json("out.json"), &template, "");
    assert!(outcome.stdout.contains("input gain of pitch, fitted: 10.00 rad/s^2"), "{outcome:?}");
}

#[test]
fn of_synth() {
    let folder = Folder::new();
    folder.sil(&["synth", "--duration", "2", "--rate", "50", "--json", "out.json", "log.csv"]).assert_done();
    // 100 rows from 0 to 1.98 s, as `log` of `sil diagnose`
    let log = json!({ "path": "log.csv", "rows": 100, "duration_s": 1.98, "rate_hz": "number" });
    assert_fits(&folder.json("out.json"), &json!({ "log": log }), "");
}

/// Every instance of the benchmark is solved, its first input within 1e-4 of the input's limit (issue "Must show").
#[test]
fn of_bench_mpc_on_all_instances() {
    let folder = Folder::new();
    let files = instance_files();
    assert_eq!(files.len(), 12);
    let arguments: Vec<&str> =
        ["bench-mpc", "--json", "out.json"].into_iter().chain(files.iter().map(String::as_str)).collect();
    let outcome = folder.sil(&arguments).assert_done();
    let json = folder.json("out.json");
    let case = json!({
        "file": "string", "case": "string", "sub": "string", "ts_s": "number", "instances": "integer",
        "solved": "integer", "error_max": "number", "iterations_median": "integer", "iterations_max": "integer",
    });
    assert_fits(&json, &json!({ "cases": [case] }), "");
    let cases = json["cases"].as_array().unwrap();
    assert_eq!(cases.len(), files.len());
    for (case, file) in cases.iter().zip(&files) {
        assert_eq!(case["file"], file.as_str());
        assert_eq!((case["instances"].as_u64(), case["solved"].as_u64()), (Some(200), Some(200)), "{case}");
        assert!(case["error_max"].as_f64().unwrap() <= 1e-4, "{case}");
    }
    assert_eq!(outcome.stdout.matches("200/200").count(), 12);
}

/// A page in a browser has a log's bytes and its name, and no files: what it makes of them is what the command says.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn of_diagnose_is_what_the_library_makes_of_the_bytes() {
    use sil_host::answer::{Answered, HeldAgainst, Said, json};
    use sil_host::diagnosis::Effort;
    use sil_host::log::Wanted;
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    let asked = ["diagnose", "log.csv", "--quick", "--json", "out.json", "--report", "out.html"];
    let outcome = folder.sil(&asked).assert_done();
    let log = Wanted::default().read("log.csv".as_ref(), &mut RIG_LOG.as_bytes()).unwrap();
    let against = HeldAgainst::of(&log, &Said::default(), &[], None, &|_| ()).unwrap();
    let before = against.text();
    let answered = Answered::of(log, against, Effort::Quick, &|_| ()).unwrap();
    assert_eq!(json(&answered.diagnosis).unwrap().as_bytes(), folder.bytes("out.json"));
    assert_eq!(answered.page("sil diagnose log.csv --quick").to_html().as_bytes(), folder.bytes("out.html"));
    assert!(outcome.stdout.starts_with(&(before + &answered.text(str::to_owned))), "{outcome:?}");
    // and a file that can't be used gets the command's words
    folder.write("bad.csv", "t,x\n1,2\n");
    let refused = Wanted::default().read("bad.csv".as_ref(), &mut &b"t,x\n1,2\n"[..]).unwrap_err();
    folder.sil(&["diagnose", "bad.csv"]).assert_refused(&[&refused.to_string()]);
}
