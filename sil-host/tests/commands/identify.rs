//! `sil identify`, and what a diagnosis without a model does with a foreign log.

use crate::sil::{Folder, GENERIC_FREE_MODEL};

/// A free flight of the quick model, as somebody else would log it.
fn foreign_flight(folder: &Folder) {
    folder.write("free.toml", GENERIC_FREE_MODEL);
    let flown = ["synth", "--model", "free.toml", "--duration", "8", "--rate", "100", "--blind", "flight.csv"];
    folder.sil(&flown).assert_done();
    let text = String::from_utf8(folder.bytes("flight.csv")).unwrap();
    // other names, and no word of where it comes from
    let text: String = text.lines().filter(|line| !line.starts_with('#')).map(|line| format!("{line}\n")).collect();
    folder.write("foreign.csv", text.replacen("p_rad_s", "gyro_x", 1));
    folder.write(
        "foreign.toml",
        "description = \"somebody's\"\nframe = \"FRD\"\naxes = [\"roll\", \"pitch\", \"yaw\"]\n[quantities]\n\
         time_s = { column = \"time_s\" }\np_rad_s = { column = \"gyro_x\" }\nq_rad_s = { column = \"q_rad_s\" }\n\
         r_rad_s = { column = \"r_rad_s\" }\nroll_rad = { column = \"roll_rad\" }\n\
         pitch_rad = { column = \"pitch_rad\" }\nyaw_rad = { column = \"yaw_rad\" }\n\
         motor1 = { column = \"motor1\" }\nmotor2 = { column = \"motor2\" }\nmotor3 = { column = \"motor3\" }\n\
         motor4 = { column = \"motor4\" }\nax_m_s2 = { column = \"ax_m_s2\" }\nay_m_s2 = { column = \"ay_m_s2\" }\n\
         az_m_s2 = { column = \"az_m_s2\" }\n",
    );
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_foreign_flight_is_identified_and_its_model_serves_the_other_commands() {
    let folder = Folder::new();
    foreign_flight(&folder);
    let map = ["foreign.csv", "--map", "foreign.toml"];
    let identified = folder.sil(&[&["identify"], &map[..], &["-o", "vehicle.toml"]].concat()).assert_done().stdout;
    assert!(identified.contains("motor_lag_s") && identified.contains("95 % interval"), "{identified}");
    let toml = String::from_utf8(folder.bytes("vehicle.toml")).unwrap();
    assert!(toml.contains("NOT KNOWN") && toml.contains("rig = \"free\""), "{toml}");
    let compared = folder.sil(&[&["compare"], &map[..], &["--model", "vehicle.toml"]].concat()).assert_done().stdout;
    assert!(compared.contains("identified from foreign.csv"), "{compared}");
    // what this flight does not show, the reaction torque of yaw, a board does not take
    let known = ["--known", "mass_kg=1.2", "--known", "arm_m=0.226", "--params", "vehicle.params"];
    folder.sil(&[&["identify"], &map[..], &known[..]].concat()).assert_refused(&["--params", "board", "do not show"]);
    let bench = ["identify", "flight.csv", "--rig", "axis", "--params", "no.params"];
    folder.sil(&bench).assert_refused(&["--params", "separate axes"]);
    // without a model the diagnosis identifies first, and says so first
    let told = folder.sil(&[&["diagnose", "--quick"], &map[..]].concat()).assert_done().stdout;
    assert!(told.starts_with("No --model: the vehicle was identified from this log first"), "{told}");
    // another vehicle's model is a mismatch, and that is said first
    folder.write("crazyflie.toml", include_str!("../../../models/crazyflie-free.toml"));
    let other = [&["compare"], &map[..], &["--model", "crazyflie.toml"]].concat();
    let told = folder.sil(&other).assert_done().stdout;
    assert!(told.starts_with("MISMATCH: ") || told.contains("answers to a motor's command"), "{told}");
    let gimbal = [&["diagnose", "--quick"], &map[..], &["--rig", "gimbal"]].concat();
    let told = folder.sil(&gimbal).assert_done().stdout;
    assert!(told.starts_with("MISMATCH: the log is of a free flight (by its accelerometer"), "{told}");
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn axes_are_identified_where_no_vehicle_can_be() {
    let folder = Folder::new();
    folder.sil(&["synth", "--duration", "12", "rig.csv"]).assert_done();
    folder.sil(&["identify", "rig.csv", "--rig", "axis", "-o", "bench.toml"]).assert_done();
    let toml = String::from_utf8(folder.bytes("bench.toml")).unwrap();
    assert!(toml.contains("rig = \"axis\"") && toml.contains("gain_rad_s2"), "{toml}");
    let compared = folder.sil(&["compare", "rig.csv", "--model", "bench.toml"]).assert_done().stdout;
    assert!(compared.contains("The bench \"identified from rig.csv\""), "{compared}");
    folder.sil(&["diagnose", "rig.csv", "--quick", "--model", "bench.toml"]).assert_done();
    folder.sil(&["diagnose", "rig.csv", "--model", "bench.toml", "--rig", "free"]).assert_refused(&["rig axis"]);
}

#[test]
fn what_identify_cannot_use_is_refused() {
    let folder = Folder::new();
    folder.sil(&["synth", "--duration", "6", "rig.csv"]).assert_done();
    for (more, expected) in [
        (&["--model", "x.toml"][..], "leave out --model"),
        (&["--rig", "gimbal"], "--rig gimbal"),
        (&["--rig", "free", "--known", "mass=1"], "expected mass_kg=VALUE"),
        (&["--rig", "free", "--known", "mass_kg=-1"], "above 0"),
        (&["--rig", "axis", "--known", "mass_kg=1"], "neither mass nor arm"),
    ] {
        folder.sil(&[&["identify", "rig.csv"], more].concat()).assert_refused(&[expected]);
    }
}
