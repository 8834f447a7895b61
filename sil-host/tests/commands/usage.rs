//! The command line itself: help, values that no flight can have, outputs that can't be written.

use std::process::Stdio;

use crate::sil::{Folder, GIMBAL_MODEL, Outcome, RIG_LOG, instance_files};

#[test]
fn every_command_has_help_with_an_example() {
    let folder = Folder::new();
    for command in ["", "fly", "compare", "diagnose", "identify", "synth", "serve", "hitl", "bench-mpc"] {
        let arguments: Vec<&str> = [command, "--help"].into_iter().filter(|word| !word.is_empty()).collect();
        let help = folder.sil(&arguments).assert_done().stdout;
        let example = format!("Example: {}", format!("sil {command}").trim());
        assert!(help.contains(&example), "no \"{example}\" in\n{help}");
        assert!(command.is_empty() || help.contains("--json <"), "{help}");
    }
}

#[test]
fn json_on_stdout_stands_there_alone_and_quiet_is_quiet() {
    let folder = Folder::new();
    folder.write("log.csv", first_seconds());
    folder.sil(&["compare", "log.csv", "--json", "out.json"]).assert_done();
    let piped = folder.sil(&["compare", "log.csv", "--json", "-"]).assert_done().stdout;
    assert_eq!(piped.as_bytes(), folder.bytes("out.json"));
    std::fs::remove_file(folder.path("out.json")).unwrap();
    let quiet = folder.sil(&["compare", "log.csv", "--quiet", "--json", "out.json"]).assert_done();
    assert_eq!(quiet.stdout, "");
    assert_eq!(piped.as_bytes(), folder.bytes("out.json"));
    // what a command is for is no chatter
    for command in [&["completions", "bash"][..], &["man"]] {
        assert_eq!(folder.sil(&[command, &["--quiet"]].concat()).stdout, folder.sil(command).assert_done().stdout);
    }
}

#[test]
fn a_log_is_read_from_a_pipe() {
    let folder = Folder::new();
    folder.write("log.csv", first_seconds());
    let json = |log: &str, stdin: Stdio| {
        let mut command = folder.command(&["compare", log, "--json", "-"]);
        command.stdin(stdin);
        Outcome::of(&["compare", log], command).assert_done().stdout
    };
    let of_pipe = json("-", std::fs::File::open(folder.path("log.csv")).unwrap().into());
    assert_eq!(of_pipe, json("log.csv", Stdio::null()));
    folder.sil(&["compare", "-"]).assert_refused(&["stdin"]);
}

/// The rig log's first five seconds.
fn first_seconds() -> String {
    RIG_LOG.lines().take(500).map(|line| format!("{line}\n")).collect()
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn scripts_can_fail_on_a_discrepancy() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    let diagnose = |extra: &[&str]| folder.sil(&[&["diagnose", "log.csv", "--quick"], extra].concat());
    diagnose(&["--fail-on", "unexplained"]).assert_done();
    let outcome = diagnose(&["--fail-on", "discrepancy", "--json", "out.json"]);
    assert_eq!(outcome.status, Some(3), "{outcome:?}");
    assert_eq!(folder.json("out.json")["verdict"], "explained", "the answer is written before");
}

#[test]
fn slips_of_the_pen_are_pointed_out() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    folder.write("mpc.toml", "controller = \"mpc\"\ncontrol_horizn = 3\n");
    folder.write("script.toml", "duration = 3\n");
    let fly = |flag: &str, file: &str| folder.sil(&["fly", flag, file]);
    fly("--controller", "mpc.toml").assert_refused(&["mpc.toml", "did you mean `control_horizon`?"]);
    fly("--script", "script.toml").assert_refused(&["script.toml", "did you mean `duration_s`?"]);
    let effect = ["synth", "--effect", "cg_ofset:axis=pitch,cos_moment_nm=0.1", "out.csv"];
    folder.sil(&effect).assert_refused(&["did you mean `cg_offset`?"]);
}

#[test]
fn values_may_begin_with_a_minus_sign() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    folder.sil(&["compare", "log.csv", "--from", "-5", "--to", "20"]).assert_done();
    folder.sil(&["fly", "--seed", "-1"]).assert_refused(&["invalid value '-1' for '--seed <SEED>'"]);
}

#[test]
fn shells_and_man_learn_the_commands() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish"] {
        let script = folder.sil(&["completions", shell]).assert_done().stdout;
        assert!(script.contains("diagnose") && script.contains("baseline"), "{shell}: {script}");
    }
    assert!(folder.sil(&["man"]).assert_done().stdout.starts_with(".ie"));
    folder.sil(&["man", "--out", "man"]).assert_done();
    let page = String::from_utf8(folder.bytes("man/sil-diagnose.1")).unwrap();
    assert!(page.contains("fail\\-on"), "{page}");
}

#[test]
fn a_port_that_is_not_there_is_named() {
    let folder = Folder::new();
    let port = "no-such-port";
    folder.sil(&["hitl", "--serial", port]).assert_refused(&[port, "expected a serial port"]);
    folder.sil(&["hitl", "--serial", port, "--rate", "3"]).assert_refused(&["--rate", "50..=1000"]);
    folder.sil(&["hitl"]).assert_refused(&["--serial"]);
}

#[test]
fn what_cannot_be_served_is_named() {
    let folder = Folder::new();
    let serve = |arguments: &[&str]| {
        folder.sil(&[&["serve", "--udp", "off", "--tcp", "0", "--for", "0.1"], arguments].concat())
    };
    serve(&["--speed", "0"]).assert_refused(&["--speed", "expected 0.01 to 100"]);
    folder.sil(&["serve", "--udp", "nowhere"]).assert_refused(&["--udp", "expected a port, an address"]);
    serve(&["--effect", "torque"]).assert_refused(&["--effect torque"]);
    serve(&["--simulator", "nowhere"]).assert_refused(&["--simulator", "as tcp:127.0.0.1:4560"]);
    serve(&["--simulator", "4560", "--speed", "2"]).assert_refused(&["--simulator", "--speed"]);
    // nobody waits at port 1: it goes on by the wall clock, and says so
    let alone = serve(&["--simulator", "tcp:127.0.0.1:1", "--json", "alone.json"]).assert_done();
    assert!(alone.stdout.contains("waits for a simulator at 127.0.0.1:1"), "{}", alone.stdout);
    assert_eq!(folder.json("alone.json")["simulator"]["sensors"], 0);
    folder.write("bad.params", "1 1 CONTROLLER 1 9\n1 1 LOOP_RATE_HZ 250 9\n");
    serve(&["--params", "bad.params"]).assert_refused(&["bad.params, line 2", "LOOP_RATE_HZ: 250", "100 or 400"]);
    // a file that is not there is made, and what the command line says of it counts
    serve(&["--params", "new/a.params", "--controller", "mpc"]).assert_done();
    assert!(String::from_utf8(folder.bytes("new/a.params")).unwrap().contains("\tCONTROLLER\t1\t9\n"));
}

/// The value of each row is impossible; the message names the flag and what it expected.
#[test]
fn impossible_values_are_refused() {
    let folder = Folder::new();
    let fly = ["fly", "--controller"];
    for controller in ["pid", "mpc", "both"] {
        for (flag, value, expected) in [
            ("--rate", "3", "50..=1000"),
            ("--rate", "fast", "invalid value 'fast'"),
            ("--control-horizon", "0", "1..=30"),
            ("--control-horizon", "31", "1..=30"),
            ("--prediction-step", "nan", "expected 0.001 to 0.1 s"),
            ("--prediction-step", "-1", "expected 0.001 to 0.1 s"),
            ("--prediction-step", "0", "expected 0.001 to 0.1 s"),
            ("--prediction-step", "1e9", "expected 0.001 to 0.1 s"),
            ("--prediction-step", "inf", "expected 0.001 to 0.1 s"),
            ("--horizon", "4", "expected 5 (the control horizon) to 30 steps"),
            ("--horizon", "31", "expected 5 (the control horizon) to 30 steps"),
            ("--seed", "x", "invalid value 'x'"),
            ("--rig", "axis", "gimbal, free"),
        ] {
            folder.sil(&[&fly[..], &[controller, flag, value]].concat()).assert_refused(&[flag, expected]);
        }
    }
    for (flag, value, expected) in [
        ("--throttle", "2", "expected 0.05 to 0.95"),
        ("--throttle", "-0.5", "expected 0.05 to 0.95"),
        ("--throttle", "nan", "expected 0.05 to 0.95"),
        ("--noise", "x", "expected two numbers"),
        ("--noise", "0.1", "expected two numbers"),
        ("--noise", "nan,nan", "expected two numbers"),
        ("--noise", "0,-1", "expected two numbers"),
        ("--duration", "0", "expected 1 to 3600 s"),
        ("--duration", "-1", "expected 1 to 3600 s"),
        ("--duration", "inf", "expected 1 to 3600 s"),
        ("--jitter", "-1", "expected 0 to 0.1 s"),
        ("--jitter", "nan", "expected 0 to 0.1 s"),
        ("--drop-out", "1", "expected 0 to 0.9 of the rows"),
        ("--drop-out", "nan", "expected 0 to 0.9 of the rows"),
        ("--rate", "5", "10..=1000"),
        ("--rate", "401 --control-rate 400", "there are 400 a second"),
        ("--control-rate", "3", "50..=1000"),
    ] {
        let value: Vec<&str> = value.split(' ').collect();
        folder.sil(&[&["synth", flag][..], &value, &["out.csv"]].concat()).assert_refused(&[flag, expected]);
    }
    assert!(!folder.path("out.csv").exists());
}

#[test]
fn unknown_effects_and_wrong_parameters_are_refused() {
    let folder = Folder::new();
    for (effect, expected) in [
        ("", "expected \"cg_offset\""),
        ("gremlins", "\"gremlins\": expected \"cg_offset\""),
        ("cg_offset", "lacks `axis`: expected \"roll\" or \"pitch\""),
        ("cg_offset:axis=yaw,cos_moment_nm=0.1", "\"yaw\": expected \"roll\" or \"pitch\""),
        ("cg_offset:axis=pitch", "lacks `cos_moment_nm`: expected the moment when level in N m"),
        ("cg_offset:axis=pitch,cos_moment_nm=x", "`cos_moment_nm`"),
        ("cg_offset:axis=pitch,cos_moment_nm=nan", "`cos_moment_nm`"),
        (
            "cg_offset:axis=pitch,cos_moment_nm=1e9",
            "is 1000000000: expected the moment when level in N m (-20.0 to 20.0)",
        ),
        ("cg_offset:axis=pitch,cos_moment_nm=0.1,colour=3", "`colour`"),
        ("cg_offset:axis=pitch,cos_moment_nm", "expected key=value"),
        ("wind:north_m_s=3", "wind has no meaning on the rig gimbal, only on: free"),
        ("weak_motor:motor=7,scale=1", "`motor` is 7: expected the motor's number, whole (1.0 to 4.0)"),
        ("cg_offset:axis=pitch,cos_moment_nm=1,cos_moment_nm=1", "duplicate key"),
        ("cg_offset:axis=pitch,\"]=1", "not valid"),
    ] {
        folder.sil(&["synth", "--effect", effect, "out.csv"]).assert_refused(&["--effect", effect, expected]);
    }
    assert!(!folder.path("out.csv").exists());
}

#[test]
fn arguments_that_contradict_each_other_are_refused() {
    let folder = Folder::new();
    folder.write("gimbal.toml", GIMBAL_MODEL);
    folder.write("log.csv", RIG_LOG);
    for arguments in [
        &["fly", "--rig", "free", "--model", "gimbal.toml"][..],
        &["compare", "log.csv", "--rig", "free", "--model", "gimbal.toml"],
        &["synth", "--rig", "free", "--model", "gimbal.toml", "out.csv"],
    ] {
        folder.sil(arguments).assert_refused(&["gimbal.toml is a model for the rig gimbal, but --rig says free"]);
    }
    for extra in [["--model", "gimbal.toml"], ["--controller", "pid"]] {
        folder
            .sil(&[&["compare", "log.csv", "--rig", "axis"][..], &extra].concat())
            .assert_refused(&["--rig axis has no vehicle model", extra[0]]);
    }
    for extra in ["--extended", "--experiment"] {
        folder
            .sil(&["diagnose", "log.csv", "--rig", "axis", extra, "out.toml"])
            .assert_refused(&["--rig axis has no vehicle model", extra]);
    }
    for arguments in [&["compare"][..], &["synth"], &["bench-mpc"], &["hover"], &["fly", "--fast"]] {
        folder.sil(arguments).assert_refused(&["--help"]);
    }
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn an_output_that_cannot_be_written_is_a_failure_of_its_own() {
    let folder = Folder::new();
    let instances = instance_files().remove(0);
    folder.write("file", "in the way");
    folder.write("short.toml", "duration_s = 0.1\n");
    folder.write("log.csv", first_seconds());
    std::fs::create_dir(folder.path("folder")).unwrap();
    for out in ["folder", "file/out"] {
        for arguments in [
            &["fly", "--controller", "pid", "--script", "short.toml", "--log", out][..],
            &["fly", "--controller", "pid", "--script", "short.toml", "--report", out],
            &["fly", "--controller", "pid", "--script", "short.toml", "--json", out],
            &["synth", "--duration", "1", out],
            &["synth", "--duration", "1", "out.csv", "--json", out],
            &["compare", "log.csv", "--report", out],
            &["compare", "log.csv", "--json", out],
            &["bench-mpc", &instances, "--json", out],
        ] {
            folder.sil(arguments).assert_failed(&[out.split('/').next().unwrap()]);
        }
    }
    assert_eq!(folder.bytes("file"), b"in the way");
    let folder = Folder::new();
    folder.write("out", "a file where the demonstration wants its folder");
    folder.sil(&[]).assert_failed(&["out: cannot be made"]);
}

/// `sil fly | head` ends without a word, and the files are written all the same.
#[test]
fn a_reader_that_has_seen_enough_is_no_failure() {
    let folder = Folder::new();
    let mut run = folder
        .command(&["fly", "--controller", "pid", "--json", "out.json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(run.stdout.take());
    let output = run.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
    assert!(folder.json("out.json")["runs"].is_array());
}

/// A full disk behind `sil fly > file`.
#[cfg(target_os = "linux")]
#[test]
fn an_output_that_takes_nothing_is_a_failure_of_its_own() {
    let folder = Folder::new();
    let arguments = ["fly", "--controller", "pid"];
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = folder.command(&arguments);
    let output = command.stdout(full).stderr(Stdio::piped()).spawn().unwrap().wait_with_output().unwrap();
    let outcome = Outcome {
        arguments: arguments.join(" "),
        status: output.status.code(),
        stdout: String::new(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    };
    outcome.assert_failed(&["the output: cannot be written"]);
}
