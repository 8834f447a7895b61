//! `sil diagnose`: its JSON, its page, and the flight that it proposes.

use serde_json::{Value, json};

use crate::json::assert_fits;
use crate::sil::{Folder, GENERIC_FREE_MODEL, GENERIC_GIMBAL_MODEL};

/// Four seconds of roll alone: a weak thrust and a heavy body look alike.
fn short_log(folder: &Folder) {
    let rates = ["--rate", "200", "--control-rate", "200", "--duration", "6"];
    folder.sil(&[&["synth", "--effect", "thrust_scale:scale=0.95", "log.csv"], &rates[..]].concat()).assert_done();
}

fn agreement() -> Value {
    json!({
        "rmse": "number", "mean_abs": "number", "fit_pct": "number?", "theil": "number?",
        "theil_split": { "bias": "number", "variance": "number", "covariance": "number" },
        "ljung_box": { "statistic": "number", "bound": "number", "lags": "integer" },
        "input_correlation": { "correlation": "number", "lag": "integer", "bound": "number" },
    })
}

/// The fields of docs/commands.md, and behind them what the log shows in detail.
fn answer() -> Value {
    let errors = json!({ "roll_deg": "number", "pitch_deg": "number", "p_deg_s": "number", "q_deg_s": "number" });
    let error = json!({
        "quantity": "string", "unit": "string", "nominal": "number", "base": "number", "extended": "number",
        "noise_floor": "number",
    });
    json!({
        "log": { "path": "string", "rows": 1200, "duration_s": "number", "rate_hz": "number", "notes": "anything" },
        "verdict": "explained",
        "not_shown_because": null,
        "known": "anything",
        "warnings": "anything",
        "base": "anything",
        "lateness_s": "anything",
        "holding": "anything",
        "lasting_gains": "anything",
        "by_reference": "anything",
        "findings": [{
            "effect": "string", "axis": "anything", "where": "string",
            "parameters": { "scale": { "value": "number", "std": "number" } },
            "gain_pct": "number", "confounded_with": ["string"], "stability_pct": "number?", "one_of": "anything",
            "statement": "string",
        }],
        "rejected": [{ "effect": "string", "axis": "string", "reason": "string" }],
        "prediction_error": {
            "window_s": 0.5, "nominal": errors, "base": errors, "extended": errors, "noise_floor": errors,
        },
        "closed_loop": null,
        "unexplained": { "variance_pct": "number", "times_floor": "number", "white": true, "signature": "" },
        "separating_experiment": "string",
        "gain": { "total_pct": "number", "total_interval_pct": "anything", "findings_interval_pct": "anything" },
        "horizons": [{ "horizon_s": "number", "windows": "integer", "held_out": "boolean", "errors": [error] }],
        "statistics": [{
            "quantity": "string", "unit": "string", "moved": "boolean", "commands_fit_pct": "number?",
            "excited": "boolean", "nominal": agreement(), "base": agreement(),
            "extended": agreement(),
        }],
        "conditions": [{
            "axis": "string", "condition": "string", "unit": "string",
            "nominal_pct": "number", "extended_pct": "number", "chance_pct": "number",
        }],
        "spectra": [{
            "axis": "string", "frequency_hz": ["number"], "nominal_deg_s2": ["number"], "extended_deg_s2": ["number"],
        }],
        "excitation": {
            "condition_number": "number", "findings_condition_number": "number",
            "parameters": [{
                "effect": "string", "axis": "anything", "parameter": "string",
                "std_alone": "number?", "std_together": "number?",
            }],
            "weaknesses": ["string"],
        },
    })
}

#[test]
fn is_told_as_json_on_a_page_and_by_a_flight_that_can_be_flown() {
    let folder = Folder::new();
    short_log(&folder);
    let outputs = ["--json", "out.json", "--report", "out.html", "--experiment", "next.toml", "--extended", "out.toml"];
    let outcome =
        folder.sil(&[&["diagnose", "log.csv", "--quick", "--rig", "gimbal"], &outputs[..]].concat()).assert_done();
    let json = folder.json("out.json");
    assert_fits(&json, &answer(), "");
    // four seconds of roll: weak thrust or a heavy body?
    let finding = &json["findings"][0];
    let names = [&finding["effect"], &finding["confounded_with"][0]].map(|name| name.as_str().unwrap());
    assert!(names.contains(&"thrust_scale") && names.contains(&"inertia_error"), "{finding}");
    // both are printed as well
    for sentence in [&json["findings"][0]["statement"], &json["separating_experiment"]] {
        assert!(outcome.stdout.contains(sentence.as_str().unwrap()), "{outcome:?}");
    }
    let page = String::from_utf8(folder.bytes("out.html")).unwrap();
    assert!(page.contains("<code>sil diagnose log.csv --rig gimbal --quick</code>"));
    assert!(page.contains(json["separating_experiment"].as_str().unwrap()));
    let proposed = String::from_utf8(folder.bytes("next.toml")).unwrap();
    assert!(proposed.contains("pitch_deg") && page.contains("pitch_deg = "), "{proposed}");
    let flight = ["fly", "--script", "next.toml", "--model", "out.toml", "--controller", "pid", "--json", "fly.json"];
    folder.sil(&flight).assert_done();
    // the log knows roll alone: now both are to move
    let axes = &folder.json("fly.json")["runs"][0]["axes"];
    assert!(axes["pitch"]["rise_time_s"].is_number() && axes["roll"]["rise_time_s"].is_number(), "{axes}");
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn other_cuts_of_the_log_are_searched_unless_it_is_to_be_quick() {
    let folder = Folder::new();
    folder.write("gimbal.toml", GENERIC_GIMBAL_MODEL);
    let rates = ["--rate", "100", "--control-rate", "100", "--duration", "6", "--model", "gimbal.toml"];
    let effect = "torque_bias:axis=roll,torque_nm=0.05";
    folder.sil(&[&["synth", "--effect", effect, "log.csv"], &rates[..]].concat()).assert_done();
    let found = |effort: &[&str]| {
        let asked = ["diagnose", "log.csv", "--model", "gimbal.toml", "--json", "out.json"];
        folder.sil(&[&asked[..], effort].concat()).assert_done();
        folder.json("out.json")["findings"][0].clone()
    };
    let (quick, usual) = (found(&["--quick"]), found(&[]));
    assert!(quick["stability_pct"].is_null(), "{quick}");
    assert_eq!((&usual["effect"], &usual["stability_pct"]), (&json!("torque_bias"), &json!(100.0)));
    assert_eq!(usual["one_of"], json!([]));
    assert_eq!(quick["parameters"], usual["parameters"]);
    let refused = folder.sil(&["diagnose", "log.csv", "--quick", "--thorough"]);
    assert!(refused.stderr.contains("cannot be used with"), "{refused:?}");
}

#[test]
fn of_a_log_that_leaves_no_doubt_has_no_flight_to_propose() {
    let folder = Folder::new();
    let effect = "weak_motor:motor=2,scale=0.95";
    let rates = ["--rate", "200", "--control-rate", "200", "--duration", "15"];
    folder.sil(&[&["synth", "--effect", effect, "log.csv"], &rates[..]].concat()).assert_done();
    let outcome = folder
        .sil(&["diagnose", "log.csv", "--quick", "--experiment", "next.toml", "--json", "out.json"])
        .assert_done();
    assert!(outcome.stdout.contains("experiment      none:"), "{outcome:?}");
    assert!(!folder.path("next.toml").exists());
    assert_eq!(folder.json("out.json")["separating_experiment"], "");
}

#[test]
fn what_is_known_is_held_and_shown() {
    let folder = Folder::new();
    short_log(&folder);
    let command = ["diagnose", "log.csv", "--known", "thrust_scale=0.95", "--json", "out.json", "--report", "out.html"];
    let outcome = folder.sil(&command).assert_done();
    let json = folder.json("out.json");
    assert_eq!(json["known"], json!([{ "name": "thrust_scale", "value": 0.95, "std": 0.0 }]));
    assert_eq!((&json["verdict"], &json["findings"]), (&json!("no_discrepancy"), &json!([])));
    let page = String::from_utf8(folder.bytes("out.html")).unwrap();
    for text in [&outcome.stdout, &page] {
        assert!(text.contains("and held: thrust_scale 0.95"), "{text}");
    }
    assert!(page.contains("--known thrust_scale=0.95"), "{page}");
    let refused = |known: &str, expected: &[&str]| {
        folder.sil(&["diagnose", "log.csv", "--known", known]).assert_refused(expected);
    };
    refused("thrust=1", &["`thrust` cannot be held", "mass_kg", "thrust_scale", "delay_s"]);
    refused("mass_kg=1", &["--known mass_kg=1", "pivot"]);
    refused("delay_s", &["NAME=VALUE"]);
}

/// The fields of docs/commands.md for one flight against others.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_flight_is_compared_with_normal_ones_as_json_text_and_page() {
    let folder = Folder::new();
    folder.write("free.toml", GENERIC_FREE_MODEL);
    let synth = |name: &str, seed: &str, effect: &[&str]| {
        let flown = ["synth", "--model", "free.toml", "--rate", "100", "--control-rate", "100", "--duration", "8"];
        folder.sil(&[&flown[..], &["--seed", seed, name], effect].concat()).assert_done();
    };
    synth("normal1.csv", "1", &[]);
    synth("normal2.csv", "2", &[]);
    synth("today.csv", "3", &["--effect", "weak_motor:motor=2,scale=0.6"]);
    let against = ["--model", "free.toml", "--baseline", "normal1.csv", "--baseline", "normal2.csv"];
    let outputs = ["--json", "out.json", "--report", "out.html"];
    let outcome = folder.sil(&[&["diagnose", "today.csv"], &against[..], &outputs].concat()).assert_done();
    let json = folder.json("out.json");
    let finding = &json["findings"][0];
    assert_eq!((&finding["effect"], &finding["parameters"]["motor"]["value"]), (&json!("weak_motor"), &json!(2.0)));
    assert_eq!(json["baseline"]["logs"], json!(["normal1.csv", "normal2.csv"]));
    let page = String::from_utf8(folder.bytes("out.html")).unwrap();
    assert!(outcome.stdout.contains(finding["statement"].as_str().unwrap()), "{outcome:?}");
    for text in [&outcome.stdout, &page] {
        assert!(text.contains("otor 2 (rear left)") && text.contains("yaw trim"), "{text}");
    }
    assert!(page.contains("--baseline normal1.csv --baseline normal2.csv"), "{page}");
    // the same vehicle again
    synth("again.csv", "4", &[]);
    let outcome = folder.sil(&[&["diagnose", "again.csv"], &against[..]].concat()).assert_done();
    assert!(outcome.stdout.contains("A normal flight"), "{outcome:?}");
    for (extra, expected) in [
        (&["--controller", "pid"][..], "leave out --controller"),
        (&["--extended", "m.toml"], "--extended"),
        (&["--baseline", "absent.csv"], "absent.csv"),
    ] {
        folder.sil(&[&["diagnose", "today.csv"], &against[..], extra].concat()).assert_refused(&[expected]);
    }
    folder.sil(&["diagnose", "today.csv", "--untouched"]).assert_refused(&["--baseline"]);
}

/// Each log has the answer that it has alone; what can't be read is a row, and shows in the exit status.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn several_logs_stand_in_one_table() {
    let folder = Folder::of_healthy_and_suspect();
    folder.write("bad.csv", "time_s,p_rad_s\n0,none\n");
    let asked = ["--quick", "--model", "gimbal.toml", "--json", "out.json", "--report", "out.html"];
    let logs = ["diagnose", "healthy.csv", "bad.csv", "suspect.csv"];
    let outcome = folder.sil(&[&logs[..], &asked].concat());
    assert_eq!(outcome.status, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("1 of 3 logs have no answer"), "{outcome:?}");
    let row = |name: &str| outcome.stdout.lines().find(|line| line.starts_with(name)).unwrap_or_default().to_owned();
    assert!(row("healthy.csv ").contains("agrees"), "{outcome:?}");
    let suspect = row("suspect.csv ");
    assert!(suspect.contains("explained") && suspect.contains("(roll)") && suspect.contains("N\u{a0}m"), "{suspect}");
    assert!(row("bad.csv ").contains("no answer"), "{outcome:?}");
    assert!(outcome.stdout.contains("bad.csv:1: `roll_rad`"), "{outcome:?}");

    let json = folder.json("out.json");
    let logs = json["logs"].as_array().unwrap();
    assert_eq!(logs.len(), 3);
    assert!(logs[1]["diagnosis"].is_null() && logs[1]["error"].as_str().unwrap().starts_with("bad.csv:1:"), "{json}");
    for (row, name) in [(&logs[0], "healthy.csv"), (&logs[2], "suspect.csv")] {
        assert_eq!((&row["path"], &row["error"]), (&json!(name), &Value::Null));
    }
    let alone = ["diagnose", "suspect.csv", "--quick", "--model", "gimbal.toml", "--json", "alone.json"];
    folder.sil(&alone).assert_done();
    assert_eq!(logs[2]["diagnosis"], folder.json("alone.json"));
    let page = String::from_utf8(folder.bytes("out.html")).unwrap();
    for (number, name) in [(2, "healthy.csv"), (3, "bad.csv"), (4, "suspect.csv")] {
        assert!(page.contains(&format!("<a href=\"#section-{number}\">{name}</a>")), "{name}");
        assert!(page.contains(&format!("<section id=\"section-{number}\"><h2>{name}</h2>")), "{name}");
    }
    let counted = "Of 3 logs 1 differs from the simulation, 1 agrees with it, 1 has no answer";
    assert!(page.contains(counted) && outcome.stdout.contains(counted), "{outcome:?}");
    assert!(page.contains("<code>sil diagnose healthy.csv bad.csv suspect.csv --model gimbal.toml --quick</code>"));

    let suspects = ["diagnose", "healthy.csv", "suspect.csv", "--quick", "--model", "gimbal.toml"];
    let failing = folder.sil(&[&suspects[..], &["--fail-on", "discrepancy"]].concat());
    assert_eq!(failing.status, Some(3), "{failing:?}");
    folder.sil(&["diagnose", "healthy.csv", "suspect.csv", "--extended", "x.toml"]).assert_refused(&["--extended"]);
}
