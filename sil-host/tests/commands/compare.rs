//! `sil compare` of several: logs over each other, and one log beside what several controllers make of its references.

use serde_json::Value;
use sil_host::log::write_file;
use sil_host::model::VehicleModel;
use sil_host::synthesis::Synthesis;

use crate::sil::{Folder, GENERIC_FREE_MODEL};

fn alone(folder: &Folder, arguments: &[&str]) -> Value {
    let outputs = ["--model", "gimbal.toml", "--json", "alone.json", "--report", "alone.html"];
    folder.sil(&[&["compare"], arguments, &outputs].concat()).assert_done();
    folder.json("alone.json")
}

/// Each log has the figures that it has alone; what can't be read is said, and shows in the exit status.
#[test]
fn several_logs_lie_over_each_other_on_one_page() {
    let folder = Folder::of_healthy_and_suspect();
    folder.write("bad.csv", "time_s,p_rad_s\n0,none\n");
    let logs = ["compare", "healthy.csv", "bad.csv", "suspect.csv"];
    let outcome = folder.sil(&[&logs[..], &["--model", "gimbal.toml", "--json", "out.json"]].concat());
    outcome.assert_message_of_status_2(&["1 of 3 logs have no answer"]);
    assert!(outcome.stdout.contains("bad.csv:1: `roll_rad`"), "{outcome:?}");
    let json = folder.json("out.json");
    let runs = json["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 3);
    assert!(runs[1]["comparison"].is_null() && runs[1]["error"].as_str().unwrap().starts_with("bad.csv:1:"), "{json}");
    let mut rates_missed = Vec::new();
    for (run, name) in [(&runs[0], "healthy.csv"), (&runs[2], "suspect.csv")] {
        assert_eq!((&run["path"], &run["controller"], &run["error"]), (&name.into(), &Value::Null, &Value::Null));
        assert_eq!(run["comparison"], alone(&folder, &[name]));
        let missed = run["comparison"]["prediction_error"]["nominal"]["p_deg_s"].as_f64().unwrap();
        let row = outcome.stdout.lines().find(|line| line.starts_with(name)).unwrap();
        assert!(row.contains(&format!("{missed:.1}")), "{missed} in {row}");
        rates_missed.push(missed);
    }
    assert!(rates_missed[1] > 3.0 * rates_missed[0], "{rates_missed:?}");
    let page = String::from_utf8(folder.bytes("out/compare.html")).unwrap();
    for name in ["healthy.csv", "suspect.csv"] {
        assert!(page.contains(&format!("data-name=\"{name}, measured\"")), "{name} is not drawn");
    }
    assert!(page.contains("<code>sil compare healthy.csv bad.csv suspect.csv --model gimbal.toml</code>"));
}

#[test]
fn one_log_lies_beside_what_each_controller_makes_of_its_references() {
    let folder = Folder::of_healthy_and_suspect();
    let both = ["--controller", "pid", "--controller", "mpc"];
    let asked = ["--model", "gimbal.toml", "--json", "out.json"];
    let outcome = folder.sil(&[&["compare", "healthy.csv"], &both[..], &asked].concat()).assert_done();
    let json = folder.json("out.json");
    let runs = json["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    for (run, controller) in runs.iter().zip(["pid", "mpc"]) {
        assert_eq!(run["controller"], controller);
        let alone = alone(&folder, &["healthy.csv", "--controller", controller]);
        assert_eq!(run["comparison"], alone);
        let deviation = alone["closed_loop"]["pitch_mean_abs_deg"].as_f64().unwrap();
        let row = outcome.stdout.lines().rfind(|line| line.starts_with(controller)).unwrap();
        assert!(row.contains(&format!("{deviation:.2}")), "{deviation} in {row}");
    }
    // flown by the cascade, so that its simulation is the nearer one
    let of = |run: &Value| run["comparison"]["closed_loop"]["roll_mean_abs_deg"].as_f64().unwrap();
    assert!(of(&runs[0]) < of(&runs[1]), "{json}");
    let page = String::from_utf8(folder.bytes("out/compare.html")).unwrap();
    for name in ["measured", "reference", "pid, simulated", "mpc, simulated"] {
        assert!(page.contains(&format!("data-name=\"{name}\"")), "{name} is not drawn");
    }
    assert!(page.contains("--controller pid --controller mpc</code>"), "the command is shown");
    let twice = ["compare", "healthy.csv", "--controller", "pid", "--controller", "pid"];
    folder.sil(&twice).assert_refused(&["--controller pid was given before"]);
    let diagnosed = [&["diagnose", "healthy.csv", "--model", "gimbal.toml"], &both[..]].concat();
    folder
        .sil(&diagnosed)
        .assert_refused(&["--controller mpc: one controller flew a log; `sil compare` takes several"]);
}

/// Nobody said which vehicle: what is normal says it, and that is said.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_foreign_flight_is_held_against_the_vehicle_that_normal_flights_show() {
    let folder = Folder::new();
    let model = VehicleModel::parse(GENERIC_FREE_MODEL, "free.toml").unwrap();
    for (seed, name) in [(1, "normal1.ulg"), (2, "normal2.ulg"), (3, "today.ulg")] {
        let synthesis = Synthesis { seed, log_rate_hz: 100, duration_s: 10.0, ..Synthesis::of(model.clone()) };
        write_file(&synthesis.log().unwrap(), &folder.path(name)).unwrap();
    }
    let baseline = ["diagnose", "today.ulg", "--baseline", "normal1.ulg", "--baseline", "normal2.ulg"];
    let outcome = folder.sil(&[&baseline[..], &["--report", "out.html"]].concat()).assert_done();
    let said = "No --model: the vehicle was identified from the normal flights first";
    assert!(outcome.stdout.starts_with(said), "{outcome:?}");
    assert!(outcome.stdout.contains("A normal flight"), "{outcome:?}");
    assert!(String::from_utf8(folder.bytes("out.html")).unwrap().contains(said));
}
