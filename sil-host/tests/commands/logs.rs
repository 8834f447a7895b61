//! The logs that the commands write are read back by the commands, and hold what they should.

use crate::sil::{Folder, GIMBAL_MODEL, RIG_LOG};

/// Held against the model and the controller that made it, a log misses by its noise only: the deviation of the closed
/// loop is that of the estimator with and without noise (CLI: a nominal log), the replay's error is the noise floor's
/// but for the share that a finite log leaves to chance, 30 % either way.
fn assert_nominal(folder: &Folder, log: &str, controller: &str) {
    folder.sil(&["compare", log, "--controller", controller, "--json", "out.json"]).assert_done();
    let json = folder.json("out.json");
    for axis in ["roll", "pitch"] {
        let deviation_deg = json["closed_loop"][format!("{axis}_mean_abs_deg")].as_f64().unwrap();
        assert!(deviation_deg < 0.3, "{log}, {axis}: {deviation_deg} deg");
        let error = |which: &str| json["prediction_error"][which][format!("{axis}_deg")].as_f64().unwrap();
        let ratio = error("nominal") / error("noise_floor");
        assert!((0.7..1.3).contains(&ratio), "{log}, {axis}: {ratio} of the noise floor");
    }
}

#[test]
fn of_fly() {
    let folder = Folder::new();
    folder.sil(&["fly", "--seed", "3", "--log", "log.csv"]).assert_done();
    assert_nominal(&folder, "log-pid.csv", "pid");
    assert_nominal(&folder, "log-mpc.csv", "mpc");
}

#[test]
fn of_synth() {
    let folder = Folder::new();
    folder.write("slow.toml", "controller = \"mpc\"\nrate_hz = 100\n");
    for (arguments, log, controller) in [
        (&["--rate", "200"][..], "plain.csv", "pid"),
        (&["--rate", "400", "--throttle", "0.42", "--seed", "1"], "packed.csv.gz", "pid"),
        (&["--rate", "100", "--control-rate", "100", "--controller", "mpc"], "mpc.csv", "slow.toml"),
    ] {
        folder.sil(&[&["synth"], arguments, &[log]].concat()).assert_done();
        assert_nominal(&folder, log, controller);
    }
}

#[test]
fn of_synth_are_the_same_bytes_for_the_same_seed() {
    let folder = Folder::new();
    for (seed, log) in [("1", "a.csv"), ("1", "b.csv"), ("2", "c.csv")] {
        folder.sil(&["synth", "--duration", "3", "--seed", seed, log]).assert_done();
    }
    assert!(folder.bytes("a.csv") == folder.bytes("b.csv"));
    assert!(folder.bytes("a.csv") != folder.bytes("c.csv"));
}

/// The thesis' figure 5.3: an off-balance ring spoils the pitch of the thesis' MPC and leaves roll alone.
#[test]
fn of_an_off_balance_ring_deviate_in_pitch() {
    let folder = Folder::new();
    let effect = "cg_offset:axis=pitch,cos_moment_nm=0.1";
    let rates = ["--rate", "100", "--control-rate", "100"];
    folder
        .sil(&[&["synth", "--controller", THESIS_MPC, "--effect", effect, "log.csv"], &rates[..]].concat())
        .assert_done();
    folder.sil(&["compare", "log.csv", "--controller", THESIS_MPC, "--json", "out.json"]).assert_done();
    let deviation = |axis: &str| folder.json("out.json")["closed_loop"][axis].as_f64().unwrap();
    assert!(deviation("roll_mean_abs_deg") < 0.3);
    assert!(deviation("pitch_mean_abs_deg") > 1.0, "{}", deviation("pitch_mean_abs_deg"));
}

/// Several effects, uneven rows, rows that are missing, and a file that mentions none of it.
#[test]
fn of_synth_can_be_hard_to_read() {
    let folder = Folder::new();
    let effects = ["--effect", "motor_lag:time_constant_s=0.02", "--effect", "battery_sag:per_volt=0.1"];
    let rows = ["--jitter", "0.001", "--drop-out", "0.1", "--blind", "--duration", "10", "log.csv"];
    folder.sil(&[&["synth"], &effects[..], &rows].concat()).assert_done();
    let text = String::from_utf8(folder.bytes("log.csv")).unwrap();
    assert_eq!(text.lines().filter(|line| line.starts_with('#')).count(), 1);
    assert!(!text.contains("motor_lag") && text.contains("battery_v"));
    // 2000 rows less a tenth
    assert!((1700..1900).contains(&text.lines().count()));
    folder.sil(&["compare", "log.csv"]).assert_done();
}

/// `fly` and `synth` fly an extended model, and `compare` holds a log against it.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn of_an_extended_model_are_explained_by_it() {
    let folder = Folder::new();
    let effects = "\n[[effect]]\nname = \"spring\"\naxis = \"pitch\"\nstiffness_nm_rad = 0.1\n\
                   [[effect]]\nname = \"attitude_delay\"\ndelay_s = 0.01\n";
    folder.write("extended.toml", GIMBAL_MODEL.to_owned() + effects);
    folder.sil(&["synth", "--model", "extended.toml", "--rate", "400", "synth.csv"]).assert_done();
    folder.sil(&["fly", "--model", "extended.toml", "--controller", "pid", "--log", "fly.csv"]).assert_done();
    let error = |log: &str, model: &[&str]| {
        folder.sil(&[&["compare", log, "--json", "out.json"], model].concat()).assert_done();
        folder.json("out.json")["prediction_error"]["nominal"]["q_deg_s"].as_f64().unwrap()
    };
    for log in ["synth.csv", "fly.csv"] {
        let (nominal, extended) = (error(log, &[]), error(log, &["--model", "extended.toml"]));
        assert!(extended < 0.5 * nominal, "{log}: {extended} deg/s against {nominal}");
    }
}

/// The thesis' controller.
const THESIS_MPC: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/demonstration/thesis-mpc.toml");

/// The arguments that made the bundled log.
const RIG_LOG_ARGUMENTS: [&str; 11] = [
    "synth",
    "--effect",
    "cg_offset:axis=pitch,cos_moment_nm=0.2",
    "--rate",
    "100",
    "--control-rate",
    "100",
    "--controller",
    THESIS_MPC,
    "--seed",
    "5",
];

/// Values are compared, not bytes: what is written is rounded to 1e-6, and a platform's last bit may turn a digit.
#[test]
fn the_bundled_log_is_what_synth_writes_now() {
    let folder = Folder::new();
    folder.sil(&[&RIG_LOG_ARGUMENTS[..], &["log.csv"]].concat()).assert_done();
    let again = "the bundled log is out of date; make it again at the workspace's root with\n    \
        cargo run --release -- synth --effect \"cg_offset:axis=pitch,cos_moment_nm=0.2\" --rate 100 --control-rate 100 \
        --controller sil-host/demonstration/thesis-mpc.toml --seed 5 sil-host/demonstration/rig-log.csv\n";
    let written = String::from_utf8(folder.bytes("log.csv")).unwrap();
    assert_eq!(written.lines().count(), RIG_LOG.lines().count(), "{again}");
    for (line, (new, bundled)) in (1..).zip(written.lines().zip(RIG_LOG.lines())) {
        let numbers = |text: &str| text.split(',').map(|field| field.parse::<f64>().ok()).collect::<Option<Vec<_>>>();
        match (numbers(new), numbers(bundled)) {
            (Some(new), Some(bundled)) => {
                let same = new.len() == bundled.len() && new.iter().zip(&bundled).all(|(a, b)| (a - b).abs() < 1.5e-6);
                assert!(same, "{again}line {line}: {bundled:?} is bundled, {new:?} is written");
            }
            _ => assert_eq!(new, bundled, "{again}line {line}"),
        }
    }
}

/// A controller that is not the modelled one is blamed by the name and the value of what differs, on a rig that has an
/// effect of its own, and both are reported; the closed loop is simulated before and after.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn of_another_controller_name_its_gain_beside_the_plants_effect() {
    let folder = Folder::new();
    folder.write("flown.toml", "controller = \"pid\"\n[tuning]\nrate_proportional_1_s = [29.47, 40.0, 11.8]\n");
    let effect = "cg_offset:axis=pitch,cos_moment_nm=0.1";
    let synthesis =
        ["synth", "--controller", "flown.toml", "--rate", "400", "--duration", "15", "--effect", effect, "log.csv"];
    folder.sil(&synthesis).assert_done();
    let diagnosis =
        ["diagnose", "log.csv", "--quick", "--controller", "pid", "--extended", "m.toml", "--json", "out.json"];
    folder.sil(&diagnosis).assert_done();
    let json = folder.json("out.json");
    let findings = json["findings"].as_array().unwrap();
    let named: Vec<_> = findings.iter().map(|finding| finding["effect"].as_str().unwrap()).collect();
    assert_eq!(named, ["cg_offset", "controller_mismatch"], "{json:#}");
    let parameters = &findings[1]["parameters"];
    assert_eq!(parameters["parameter"]["value"], "rate_proportional_1_s");
    assert_eq!((&findings[1]["axis"], &findings[1]["where"]), (&"pitch".into(), &"controller".into()));
    assert!((parameters["logged"]["value"].as_f64().unwrap() - 40.0).abs() < 1.0, "{parameters}");
    assert!((parameters["modelled"]["value"].as_f64().unwrap() - 29.47).abs() < 0.1, "{parameters}");
    assert_eq!(json["verdict"], "explained");
    let deviation = |which: &str| json["closed_loop"][which]["pitch_mean_abs_deg"].as_f64().unwrap();
    assert!(deviation("extended") < 0.3 && deviation("nominal") < 2.0, "{}", json["closed_loop"]);
    let model = String::from_utf8(folder.bytes("m.toml")).unwrap();
    assert!(model.contains("cg_offset") && !model.contains("controller_mismatch"));
}

/// A log of every second step of its controller does not show what the controller saw.
#[test]
fn of_half_the_controllers_rate_are_no_ground_for_blaming_it() {
    let folder = Folder::new();
    folder.sil(&["synth", "--duration", "10", "--rate", "200", "log.csv"]).assert_done();
    folder.sil(&["diagnose", "log.csv", "--quick", "--controller", "pid", "--json", "out.json"]).assert_done();
    let rejected = folder.json("out.json")["rejected"].clone();
    let reason = rejected.as_array().unwrap().iter().find(|one| one["effect"] == "controller_mismatch").unwrap();
    let reason = reason["reason"].as_str().unwrap();
    assert!(reason.contains("200 rows a second and the controller runs at 400"), "{reason}");
}
