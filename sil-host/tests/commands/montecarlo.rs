//! `sil montecarlo`: drawn vehicles flown, interrupted, in shards, and one of them flown again by `sil fly --draw`.

use serde_json::Value;

use crate::sil::{Folder, GENERIC_GIMBAL_MODEL};

const TOLERANCES: &str = "\n[tolerance]\n\"body.ixx_kg_m2\" = { relative_sd = 0.05 }\n\
                          \"propulsion.lift_n_s2\" = { relative_half_width = 0.1 }\n";

/// A vehicle with tolerances and a script of a second.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("m.toml", format!("{GENERIC_GIMBAL_MODEL}{TOLERANCES}"));
    folder.write("s.toml", "name = \"a step\"\nduration_s = 1\n[[step]]\nat_s = 0.1\nroll_deg = 8\n");
    folder
}

const FLOWN: [&str; 5] = ["montecarlo", "--model", "m.toml", "--script", "s.toml"];

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn the_worst_vehicle_is_flown_again_to_the_bit_by_the_command_that_is_printed() {
    let folder = folder();
    let arguments = ["--runs", "60", "--seed", "9", "--json", "a.json", "--report", "a.html", "--out", "a.parquet"];
    let said = folder.sil(&[&FLOWN[..], &arguments].concat()).assert_done().stdout;
    for expected in
        ["60 vehicles, 5 numbers drawn of each, seed 9; a step", "pid: 0 of 60 flights lost", "mpc.fallbacks"]
    {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    let answer = folder.json("a.json");
    let figures = answer["figures"].as_array().unwrap();
    for name in ["pid.roll.rms_error_deg", "pid.effort", "mpc.pitch.rms_error_deg", "mpc.fallbacks"] {
        let figure = figures.iter().find(|figure| figure["name"] == name).unwrap();
        let worst = &figure["worst"][0];
        let command = worst["command"].as_str().unwrap();
        // what is the same in every flight has no worst
        assert!(said.contains(command) || figure["max"] == figure["min"], "{command}: {said}");
        let words: Vec<&str> = command.split(' ').skip(1).chain(["--json", "f.json"]).collect();
        let flown = folder.sil(&words).assert_done().stdout;
        assert!(flown.contains("drawn vehicle 9:"), "{flown}");
        let parts: Vec<&str> = name.split('.').collect();
        let run = &folder.json("f.json")["runs"][0];
        assert_eq!(run["controller"], parts[0]);
        let again = match parts[1..] {
            [axis, figure] => &run["axes"][axis][figure],
            ["fallbacks"] => &run["mpc"]["fallbacks"],
            _ => &run[parts[1]],
        };
        assert!(again.is_number());
        assert_eq!(again.as_f64(), worst["value"].as_f64(), "{command}: {figure}");
    }
    let page = String::from_utf8(folder.bytes("a.html")).unwrap();
    for expected in ["Of 60 vehicles pid loses none, mpc loses none", "Cumulative distributions", "sil fly --draw 9:"] {
        assert!(page.contains(expected), "{expected}");
    }
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn shards_make_the_same_answer_as_the_whole() {
    let folder = folder();
    let runs = ["--runs", "450", "--controller", "pid", "--seed", "2"];
    let fly = |more: &[&str]| folder.sil(&[&FLOWN[..], &runs, more].concat()).assert_done().stdout;
    fly(&["--out", "whole.parquet", "--json", "whole.json"]);
    fly(&["--out", "one.parquet", "--shard", "1/2"]);
    fly(&["--out", "two.parquet", "--shard", "2/2"]);
    let joined = ["montecarlo", "--summarise", "two.parquet", "one.parquet", "--json", "joined.json"];
    folder.sil(&joined).assert_done();
    let (whole, joined) = (folder.json("whole.json"), folder.json("joined.json"));
    assert_eq!((&joined["runs"], &joined["flown"]), (&450.into(), &0.into()));
    let figures = |answer: &Value| -> Vec<[Value; 6]> {
        let of = |figure: &Value| ["name", "count", "p50", "max", "worst", "nominal"].map(|key| figure[key].clone());
        answer["figures"].as_array().unwrap().iter().map(of).collect()
    };
    assert_eq!(figures(&whole), figures(&joined));
    // given again, nothing is left to fly
    let said = fly(&["--out", "whole.parquet", "--json", "again.json"]);
    assert!(!said.contains("vehicles flown in"), "{said}");
    assert_eq!(folder.json("again.json")["figures"], whole["figures"]);
}

/// Killed, not asked to stop: what was flown is kept in whole parts, and the same command flies the rest.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_study_that_was_killed_goes_on_to_the_same_bytes() {
    let folder = folder();
    let study = |out| [&FLOWN[..], &["--controller", "pid", "--runs", "900", "--seed", "4", "--out", out]].concat();
    folder.sil(&study("whole.parquet")).assert_done();
    let killed = study("killed.parquet");
    let mut process = folder.command(&killed).stdout(std::process::Stdio::null()).spawn().unwrap();
    let parts = || folder.path("killed.parquet.parts").read_dir().map_or(0, Iterator::count);
    while parts() == 0 && process.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    process.kill().unwrap();
    assert!(!process.wait().unwrap().success() && parts() > 0 && !folder.path("killed.parquet").exists());
    let said = folder.sil(&killed).assert_done().stdout;
    assert!(said.contains("900 vehicles"), "{said}");
    assert_eq!(folder.bytes("killed.parquet"), folder.bytes("whole.parquet"));
}

#[test]
fn what_can_not_be_studied_is_refused() {
    let folder = folder();
    folder.write("plain.toml", GENERIC_GIMBAL_MODEL);
    folder.write("wrong.toml", format!("{GENERIC_GIMBAL_MODEL}\n[tolerance]\n\"body.ixx\" = {{ sd = 1 }}\n"));
    folder.write("rows.parquet", "time_s\n");
    for (arguments, expected) in [
        (&["montecarlo", "--model", "plain.toml"][..], "has no tolerances"),
        (&["fly", "--model", "plain.toml", "--draw", "1:2"], "has no tolerances"),
        (&["fly", "--model", "m.toml", "--draw", "12"], "expected SEED:NUMBER"),
        (&["montecarlo", "--model", "wrong.toml"], "did you mean `body.ixx_kg_m2`?"),
        (&["montecarlo", "--model", "m.toml", "--shard", "3/2"], "expected K/N"),
        (&["montecarlo", "--model", "m.toml", "--runs", "0"], "--runs"),
        (&["montecarlo", "--summarise", "rows.parquet"], "rows.parquet: not a Parquet file"),
        (&["montecarlo", "--summarise", "none.parquet"], "none.parquet: cannot be read"),
    ] {
        let outcome = folder.sil(arguments);
        assert_eq!(outcome.status, Some(2), "{arguments:?}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "{arguments:?}: {}", outcome.stderr);
    }
    let arguments = [&FLOWN[..], &["--runs", "3", "--controller", "pid", "--out", "o.parquet"]].concat();
    folder.sil(&arguments).assert_done();
    let other = folder.sil(&[&arguments[..], &["--seed", "1"]].concat());
    assert_eq!(other.status, Some(2));
    assert!(other.stderr.contains("o.parquet: holds another study"), "{}", other.stderr);
}

/// The largest part of its memory that a study ever held, kB.
#[cfg(target_os = "linux")]
fn peak_memory_kb(folder: &Folder, arguments: &[&str]) -> u64 {
    let mut study = folder.command(arguments).stdout(std::process::Stdio::null()).spawn().unwrap();
    let status = format!("/proc/{}/status", study.id());
    let mut peak_kb = 0;
    while study.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        peak_kb = line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0).max(peak_kb);
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    assert!(study.wait().unwrap().success());
    peak_kb
}

/// A row of 20 columns has 320 bytes while it is held: of 3600 more rows 1.2 MB, twice where they are read. A flight's
/// record has 400 bytes a step: 3600 of 120 steps would take 170 MB.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn memory_does_not_grow_with_the_number_of_vehicles() {
    let folder = folder();
    folder.write("s.toml", "duration_s = 0.3\n[[step]]\nat_s = 0.1\nroll_deg = 8\n");
    let study = |runs, out| [&FLOWN[..], &["--controller", "pid", "--runs", runs, "--out", out]].concat();
    let few_kb = peak_memory_kb(&folder, &study("400", "few.parquet"));
    let many_kb = peak_memory_kb(&folder, &study("4000", "many.parquet"));
    assert!(few_kb > 1000 && many_kb < few_kb + 6000, "{few_kb} kB, {many_kb} kB");
}
