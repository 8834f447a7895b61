//! What `sil fly` leaves behind: the same bytes for the same seed, one log per controller, a report without figures
//! that differ from run to run.

use crate::sil::Folder;

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn the_same_seed_gives_the_same_bytes() {
    let folder = Folder::new();
    folder.write("short.toml", "duration_s = 1.0\n[[step]]\nat_s = 0.2\nroll_deg = 20\n");
    let fly = |seed: &str, log: &str, report: &str| {
        let script = ["fly", "--script", "short.toml", "--controller", "both"];
        let arguments = [&script[..], &["--seed", seed, "--log", log, "--report", report]].concat();
        let outcome = folder.sil(&arguments).assert_done();
        for line in [format!("log     {}", log.replace(".csv", "-pid.csv")), format!("report  {report}")] {
            assert!(outcome.stdout.lines().any(|printed| printed == line), "no \"{line}\" in {outcome:?}");
        }
    };
    fly("5", "once/log.csv", "once/report.html");
    fly("5", "twice/log.csv", "twice/report.html");
    fly("6", "other/log.csv", "other/report.html");
    for file in ["log-pid.csv", "log-mpc.csv", "report.html"] {
        let bytes = |run: &str| folder.bytes(&format!("{run}/{file}"));
        assert!(bytes("once") == bytes("twice"), "{file} differs from run to run");
        assert!(bytes("once") != bytes("other"), "{file} does not depend on the seed");
    }
    assert!(!folder.path("once/log.csv").exists());
    let report = String::from_utf8(folder.bytes("once/report.html")).unwrap();
    assert!(report.contains("--seed 5") && !report.contains("times real time"));
}

#[test]
fn a_single_controller_writes_the_very_file() {
    let folder = Folder::new();
    folder.write("short.toml", "duration_s = 1.0\n[[step]]\nat_s = 0.2\nroll_deg = 10\n");
    let fly = |controller, log| {
        folder.sil(&["fly", "--script", "short.toml", "--controller", controller, "--log", log]).assert_done()
    };
    fly("pid", "log.csv");
    assert!(String::from_utf8(folder.bytes("log.csv")).unwrap().starts_with("# SYNTHETIC"));
    // both endings of a compressed log stay where they belong
    fly("both", "packed.v2.csv.gz");
    for file in ["packed.v2-pid.csv.gz", "packed.v2-mpc.csv.gz"] {
        assert_eq!(folder.bytes(file)[..2], [0x1f, 0x8b], "{file}");
    }
}

#[test]
fn several_controllers_fly_in_one_report_each_by_its_name() {
    let folder = Folder::new();
    folder.write("script.toml", "duration_s = 2\n[[step]]\nat_s = 0.5\nroll_deg = 10\n");
    folder.write("soft.toml", "controller = \"pid\"\n[tuning]\nrate_max_rad_s = [0.3, 0.3, 0.3]\n");
    let fly = ["fly", "--script", "script.toml", "--controller", "pid", "--controller", "soft.toml"];
    let outputs = ["--report", "out.html", "--json", "out.json", "--log", "log.csv"];
    let outcome = folder.sil(&[&fly[..], &outputs].concat()).assert_done();
    assert!(outcome.stdout.contains("pid roll") && outcome.stdout.contains("soft roll"), "{outcome:?}");
    let rise_s = |run: usize| folder.json("out.json")["runs"][run]["axes"]["roll"]["rise_time_s"].as_f64().unwrap();
    // 80 % of 10 degrees at 0.3 rad/s take 0.47 s
    assert!(rise_s(0) < 0.3 && rise_s(1) > 0.4, "{} {}", rise_s(0), rise_s(1));
    assert!(folder.path("log-pid.csv").exists() && folder.path("log-soft.csv").exists());
    let page = String::from_utf8(folder.bytes("out.html")).unwrap();
    assert!(page.contains(r#"data-name="soft""#) && page.contains(r#"data-name="PID""#));
    folder.sil(&["fly", "--controller", "pid", "--controller", "both"]).assert_refused(&["pid was given before"]);
}

/// What a reader must know first stands in the headline: at 50 Hz the quick MPC without constraints is unstable.
#[test]
fn an_unstable_flight_is_the_reports_headline() {
    let folder = Folder::new();
    let headline = |extra: &[&str]| {
        folder.sil(&[&["fly", "--report", "out.html"], extra].concat()).assert_done();
        let page = String::from_utf8(folder.bytes("out.html")).unwrap();
        let (_, rest) = page.split_once("<h1>").unwrap();
        rest.split_once("</h1>").unwrap().0.to_owned()
    };
    assert_eq!(headline(&["--controller", "mpc-quick", "--rate", "50"]), "Unstable under MPC");
    assert!(headline(&["--controller", "mpc"]).starts_with("MPC settles in "));
}

/// The report names the command that repeats its run.
#[test]
fn the_command_in_a_report_makes_the_same_report() {
    let folder = Folder::new();
    let first = ["fly", "--controller", "mpc", "--rig", "free", "--rate", "100", "--control-horizon", "1"];
    folder.sil(&[&first[..], &["--report", "first.html"]].concat()).assert_done();
    let page = String::from_utf8(folder.bytes("first.html")).unwrap();
    let start = page.find("sil fly --controller").unwrap();
    let command: Vec<&str> = page[start..].split('<').next().unwrap().split_whitespace().skip(1).collect();
    folder.sil(&[&command[..], &["--report", "second.html"]].concat()).assert_done();
    assert!(folder.bytes("first.html") == folder.bytes("second.html"), "sil {}", command.join(" "));
}

/// A controller file says what flies, and the command line has the last word.
#[test]
fn a_controller_file_flies_and_flags_go_over_it() {
    let folder = Folder::new();
    folder.write("c.toml", "controller = \"mpc\"\nrate_hz = 200\ncontrol_horizon = 3\n");
    folder.write("short.toml", "duration_s = 1.0\n");
    let fly = ["fly", "--controller", "c.toml", "--script", "short.toml", "--json", "out.json"];
    for (flags, rate_hz, control_horizon) in [(&[][..], 200, 3), (&["--rate", "100", "--control-horizon", "2"], 100, 2)]
    {
        folder.sil(&[&fly[..], flags].concat()).assert_done();
        let run = &folder.json("out.json")["runs"][0];
        assert_eq!(run["controller"], "mpc");
        assert_eq!((&run["rate_hz"], &run["mpc"]["control_horizon"]), (&rate_hz.into(), &control_horizon.into()));
    }
}

/// How fast is the machine's affair; that it is said is the command's.
#[test]
fn the_speed_of_the_simulation_is_printed() {
    let folder = Folder::new();
    let outcome = folder.sil(&["fly", "--controller", "pid"]).assert_done();
    let line = outcome.stdout.lines().find(|line| line.starts_with("simulated, times real time")).unwrap();
    assert!(line.split_whitespace().last().unwrap().parse::<f64>().unwrap() > 0.0, "{line}");
}
