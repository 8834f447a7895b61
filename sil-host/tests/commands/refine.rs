//! `sil refine`: from bench files to a model that the other commands read.

use std::fmt::Write;

use crate::sil::{Folder, GENERIC_GIMBAL_MODEL};

/// A speed controller of 11 V, and a propeller whose lift is `5e-6 w^2`, with a scale that reads 0.1 N too little.
fn benches(folder: &Folder) {
    let (mut esc, mut rotor) = ("command,motor_v\n".to_owned(), "# a stand\nspeed_rpm,lift_gf,torque_nm\n".to_owned());
    for index in 1..=20_u32 {
        let (command, speed) = (0.05 * f64::from(index), 40.0 * f64::from(index));
        // repeatable scatter of some parts in a thousand
        let scatter = f64::from(index * 7 % 11) - 5.0;
        let (motor_v, lift_n) = (11.0 * command + 0.002 * scatter, 5e-6 * speed * speed - 0.1 + 0.0005 * scatter);
        let torque_nm = 8e-8 * speed * speed * (1.0 + 0.001 * scatter);
        let _ = writeln!(esc, "{command},{motor_v}");
        // one drop-out
        let lift_gf = if index == 9 { 0.0 } else { lift_n / 9.80665e-3 };
        let _ = writeln!(rotor, "{},{lift_gf},{torque_nm}", speed * 30.0 / core::f64::consts::PI);
    }
    folder.write("step.toml", "duration_s = 1\n[[step]]\nat_s = 0.2\nroll_deg = 5\n");
    folder.write("esc.csv", esc);
    folder.write("rotor.csv", rotor);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_bench_makes_a_model_that_flies() {
    let folder = Folder::new();
    benches(&folder);
    folder.write("free.toml", include_str!("../../../models/f450-free.toml"));
    let refine = ["refine", "esc.csv", "rotor.csv", "--model", "free.toml", "-o", "mine.toml", "--report", "r.html"];
    let said = folder.sil(&refine).assert_done().stdout;
    for expected in ["battery_v", "lift_n_s2", "square with tare", "base_command is now", "not checked: "] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    let model = String::from_utf8(folder.bytes("mine.toml")).unwrap();
    // with interval and source where measured, marked where not
    assert!(model.contains("20 readings, 1 of them outliers"), "{model}");
    assert!(
        model.contains("# Source: rotor.csv") && model.contains("resistance_ohm = 0.127   # the base's"),
        "{model}"
    );
    let page = String::from_utf8(folder.bytes("r.html")).unwrap();
    assert!(page.contains("measured less the form") && page.contains("Forms side by side"));
    folder.sil(&["fly", "--model", "mine.toml", "--script", "step.toml"]).assert_done();
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_table_is_chosen_in_the_model_file() {
    let folder = Folder::new();
    benches(&folder);
    folder.write("free.toml", include_str!("../../../models/f450-free.toml"));
    let forms = ["--form", "lift=table", "--form", "esc=table", "--model", "free.toml", "-o", "mine.toml"];
    let said = folder.sil(&[&["refine", "esc.csv", "rotor.csv"], &forms[..]].concat()).assert_done().stdout;
    assert!(said.contains("taken (--form)"), "{said}");
    let model = String::from_utf8(folder.bytes("mine.toml")).unwrap();
    assert!(model.contains("map = \"table\"") && model.contains("[propulsion.rotor.lift_table]"), "{model}");
    // a list that does not ascend is no table
    folder.write("bad.toml", model.replacen("command = [0.05, 0.1,", "command = [0.1, 0.05,", 1));
    folder
        .sil(&["fly", "--model", "bad.toml"])
        .assert_refused(&["bad.toml:", "`command` and `voltage_v` are no table"]);
}

#[test]
fn the_thesis_constants_are_said_to_be_impossible() {
    let folder = Folder::new();
    let given = ["--diameter", "0.254", "--mass", "1.2", "--kv", "920", "--supply", "12.6"];
    let said = folder.sil(&[&["refine"], &given[..]].concat()).assert_done().stdout;
    for name in [
        "reaction torque against drag torque",
        "lift against momentum theory",
        "rotor inertia against propeller size",
        "hover thrust against mass",
    ] {
        assert!(said.contains(&format!("CAN'T BE: {name}: ")), "{name}: {said}");
    }
}

#[test]
fn what_refine_cannot_use_is_refused() {
    let folder = Folder::new();
    benches(&folder);
    folder.write("generic.toml", GENERIC_GIMBAL_MODEL);
    folder.write("odd.csv", "speed_rad_s,lift_n\n1,2\n2,x\n");
    folder.write("alone.csv", "speed_rad_s\n1\n2\n3\n");
    for (arguments, expected) in [
        (&["odd.csv"][..], "odd.csv:3: column `lift_n`"),
        (&["alone.csv"], "show no component"),
        (&["none.csv"], "none.csv"),
        (&["rotor.csv", "--form", "lift=cubic"], "for lift one of square, square with tare, power, table"),
        (&["rotor.csv", "--form", "wings=table"], "the component one of resistance"),
        (&["rotor.csv", "--model", "generic.toml"], "level generic"),
        (&["rotor.csv", "--diameter", "-1"], "--diameter -1: expected a number above 0"),
        (&["-o", "out.toml"], "out.toml: nothing to write"),
    ] {
        folder.sil(&[&["refine"], arguments].concat()).assert_refused(&[expected]);
    }
}
