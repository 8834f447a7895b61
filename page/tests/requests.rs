//! What the page requests, answered without a browser.

use serde_json::{Value, json};
use sil_page::requests::answer;

/// What the page gets for a request with these files.
fn answered(request: &Value, files: &[&[u8]]) -> Value {
    let files = files.iter().map(|file| file.to_vec()).collect();
    serde_json::from_str(&answer(request.to_string().as_bytes(), files, &|_| ())).unwrap()
}

/// A flight of a second in which both controllers step, with some keys of the request changed.
fn flight(changes: Value, of_mpc: Value) -> Value {
    let controller =
        |name| json!({ "controller": name, "rate_hz": 400, "control_horizon": 5, "factors": {}, "values": {} });
    let mut mpc = controller("mpc");
    mpc.as_object_mut().unwrap().extend(of_mpc.as_object().unwrap().clone());
    let mut request = json!({
        "request": "fly", "model": "generic-gimbal", "effects": [], "controllers": [controller("pid"), mpc], "seed": 0,
        "script": "duration_s = 1\n[[step]]\nat_s = 0.2\nroll_deg = 10\n", "margins": false,
    });
    request.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
    answered(&request, &[])
}

#[test]
fn every_slider_of_the_page_has_a_meaning_in_the_catalogue() {
    let catalogue = answered(&json!({ "request": "catalogue" }), &[]);
    let meanings = catalogue["ok"]["tuning"].as_array().unwrap();
    let sliders = include_str!("../web/tuning.js");
    let keys = sliders.split("factor(\"").chain(sliders.split("value(\"")).filter_map(|part| part.split_once('"'));
    let keys: Vec<&str> = keys.map(|(key, _)| key).filter(|key| key.contains('_')).collect();
    assert!(keys.len() > 10, "{keys:?}");
    for key in keys.into_iter().filter(|key| !key.contains(' ')) {
        let row =
            meanings.iter().find(|row| row["key"] == key).unwrap_or_else(|| panic!("{key} is no key of a tuning"));
        assert!(row["meaning"].as_str().unwrap().len() > 10, "{row}");
    }
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn every_effect_can_be_flown_as_its_sliders_begin_and_end() {
    let catalogue = answered(&json!({ "request": "catalogue" }), &[]);
    for effect in catalogue["ok"]["effects"].as_array().unwrap() {
        let rig = effect["rigs"][0].as_str().unwrap();
        let place = &effect["places"][rig];
        let place =
            place[0].as_str().map(|key| format!("{key}={},", place[1][0].as_str().unwrap())).unwrap_or_default();
        for at in ["/example", "/slider/0", "/slider/1"] {
            let of = |parameter: &Value| {
                let (name, value) = (parameter["name"].as_str().unwrap(), parameter.pointer(at).unwrap());
                format!("{name}={value}")
            };
            let parameters: Vec<String> = effect["parameters"].as_array().unwrap().iter().map(of).collect();
            let short = format!("{}:{place}{}", effect["name"].as_str().unwrap(), parameters.join(","));
            let flown = flight(json!({ "model": format!("generic-{rig}"), "effects": [&short] }), json!({}));
            assert!(flown["ok"]["fragment"].is_string() || at != "/example", "{short}: {flown}");
            // a slider may end where the effect can't be: it is said in words
            assert!(flown["ok"].is_object() || flown["error"].is_string(), "{short}: {flown}");
        }
    }
}

#[test]
fn a_factor_multiplies_what_follows_from_the_vehicle() {
    let nominal = flight(json!({}), json!({}));
    let doubled =
        flight(json!({}), json!({ "factors": { "mpc_tracking_weight": 2.0 }, "values": { "mpc_horizon": 12 } }));
    let weight = |flown: &Value| flown["ok"]["tuning"][1]["mpc_tracking_weight"][0].as_f64().unwrap();
    assert_eq!(weight(&doubled), 2.0 * weight(&nominal));
    assert_eq!(doubled["ok"]["tuning"][1]["mpc_horizon"], 12);
    assert_ne!(doubled["ok"]["fragment"], nominal["ok"]["fragment"]);
}

#[test]
fn what_cannot_be_is_answered_with_the_librarys_message() {
    for (changes, of_mpc, expected) in [
        (json!({ "script": "duration_s = 1\n[[step]]\nat_s = 5\n" }), json!({}), "duration_s must be above"),
        (json!({ "effects": ["no_such:x=1"] }), json!({}), "no_such"),
        (json!({ "model": "f450" }), json!({}), "model.toml"),
        (json!({}), json!({ "rate_hz": 5 }), "50 to 1000"),
        (json!({}), json!({ "values": { "tilt_max_rad": 3.0 } }), "tilt_max_rad"),
        (json!({}), json!({ "factors": { "tilt": 3.0 } }), "tilt"),
    ] {
        let error = flight(changes, of_mpc)["error"].as_str().unwrap_or_default().to_owned();
        assert!(error.contains(expected), "{expected}: {error}");
    }
    let error = answered(&json!({ "request": "nonsense" }), &[]);
    assert!(error["error"].as_str().unwrap().contains("the page's request"), "{error}");
}

#[test]
fn a_log_is_recognised_with_how_far_it_went() {
    let mut log = "time_s,roll_deg,pitch_rad,p_deg_s,q_rad_s,motor1,motor2,motor3,motor4,battery_v\n".to_owned();
    for row in 0..200 {
        let (roll, rate) = if row == 100 { (-25.0, -310.0) } else { (1.0, 2.0) };
        log += &format!(
            "{:.2},{roll},0,{rate},0,0.5,0.5,0.5,0.5,{:.3}\n",
            0.01 * f64::from(row),
            12.6 - 0.005 * f64::from(row)
        );
    }
    let request = json!({ "request": "recognise", "name": "a.csv", "options": { "whole": true, "unchecked": true } });
    let reached = &answered(&request, &[log.as_bytes()])["ok"]["reached"];
    assert_eq!(*reached, json!(["tilt of 25 degrees", "rate of 310 deg/s", "battery from 12.6 to 11.6 V"]));
}

#[test]
fn a_file_that_is_no_log_is_recognised_as_none() {
    let request = json!({ "request": "recognise", "name": "a.csv" });
    let known = answered(&request, &[b"this,that\n1,2\n3,4\n"]);
    assert!(known["ok"]["problem"].as_str().unwrap().contains("a.csv"), "{known}");
    assert!(known["ok"]["map"].as_str().unwrap().contains("STILL WRONG"), "{known}");
    // a call without its file
    assert!(answered(&request, &[])["ok"]["problem"].is_string());
}
