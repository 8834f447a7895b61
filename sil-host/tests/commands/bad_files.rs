//! Files that can't be used: each is refused with status 2 and a message that names the file, the place in it and what
//! was expected there.

use crate::sil::{Folder, GIMBAL_MODEL, RIG_LOG};

/// The bundled log with its line `number` (from 1) replaced.
fn log_with_line(number: usize, line: &str) -> String {
    let lines = RIG_LOG.lines().enumerate();
    lines.map(|(index, original)| format!("{}\n", if index + 1 == number { line } else { original })).collect()
}

/// The bundled log with a field of its line `number` changed.
fn log_with_field(number: usize, column: usize, change: impl Fn(&str) -> String) -> String {
    let line = RIG_LOG.lines().nth(number - 1).unwrap();
    let fields: Vec<String> = line
        .split(',')
        .enumerate()
        .map(|(index, field)| if index == column { change(field) } else { field.to_owned() })
        .collect();
    log_with_line(number, &fields.join(","))
}

/// The bundled log with its attitude in degrees under names that say radian.
fn log_in_degrees() -> String {
    let in_degrees = |line: &str| {
        let degrees = |field: &str| field.parse::<f64>().unwrap().to_degrees().to_string();
        let fields = line.split(',').enumerate();
        let fields =
            fields.map(|(index, field)| if matches!(index, 1 | 2) { degrees(field) } else { field.to_owned() });
        fields.collect::<Vec<_>>().join(",")
    };
    let lines = RIG_LOG.lines().enumerate();
    lines.map(|(index, line)| if index < 4 { format!("{line}\n") } else { format!("{}\n", in_degrees(line)) }).collect()
}

#[test]
fn a_bad_log_is_refused_with_its_line() {
    let cases: [(&str, Vec<u8>, &[&str]); 11] = [
        ("empty", Vec::new(), &["log.csv: the file is empty; expected a header line and at least 100 rows"]),
        (
            "NaN",
            log_with_field(500, 2, |_| "NaN".into()).into_bytes(),
            &["log.csv:500: `pitch_rad`: expected a finite number, found `NaN`"],
        ),
        (
            "a word",
            log_with_field(7, 7, |_| "full".into()).into_bytes(),
            &["log.csv:7: `motor1`: expected a number, found `full`"],
        ),
        (
            "degrees",
            log_in_degrees().into_bytes(),
            &["log.csv:", "outside -10..10 (another unit? a column named", "_deg is converted)"],
        ),
        (
            "percent",
            log_with_field(9, 8, |_| "48.5".into()).into_bytes(),
            &["log.csv:9: `motor2`: 48.5 is outside -0.05..1.05 (another unit? a column named motor2_pct is \
                 converted)"],
        ),
        (
            "time back",
            log_with_field(1000, 0, |_| "1.5".into()).into_bytes(),
            &["log.csv:1000: `time_s`: time must increase: 1.5 s follows 9.94 s"],
        ),
        (
            "a column gone",
            RIG_LOG.replacen("q_rad_s", "turning", 1).into_bytes(),
            &["log.csv:4: `q_rad_s`: required column is missing", "the header has: time_s"],
        ),
        ("a field gone", log_with_line(20, "0.15,1,2").into_bytes(), &["log.csv:20: expected 16 fields", "found 3"]),
        (
            "99 rows",
            RIG_LOG.lines().take(4 + 99).map(|line| format!("{line}\n")).collect::<String>().into_bytes(),
            &["log.csv: expected at least 100 rows, found 99"],
        ),
        (
            "garbage",
            (0..5000_u32).map(|k| (k * k % 251) as u8).collect(),
            &["log.csv", "not UTF-8 text; expected a CSV"],
        ),
        ("text that is no table", b"all quiet\n".repeat(300), &["log.csv:1: `time_s`: required column is missing"]),
    ];
    let folder = Folder::new();
    for (name, bytes, expected) in cases {
        println!("{name}");
        folder.write("log.csv", bytes);
        folder.sil(&["compare", "log.csv"]).assert_refused(expected);
    }
}

/// Time in milliseconds under a name that says seconds, and a clock that jumps: no closed loop is simulated for hours.
#[test]
fn a_log_of_implausible_duration_is_refused() {
    let folder = Folder::new();
    let in_milliseconds = |line: &str| {
        let (time, rest) = line.split_once(',').unwrap();
        format!("{},{rest}\n", time.parse::<f64>().unwrap() * 1e3)
    };
    let lines = RIG_LOG.lines().enumerate();
    let slow: String =
        lines.map(|(index, line)| if index < 4 { format!("{line}\n") } else { in_milliseconds(line) }).collect();
    folder.write("slow.csv", slow);
    let last = RIG_LOG.lines().count();
    folder.write("jump.csv", log_with_field(last, 0, |_| "1e9".into()));
    let compare = |log| folder.sil(&["compare", log, "--controller", "pid"]);
    compare("slow.csv").assert_refused(&["slow.csv: ", "0.1000 rows per second", "time_ms = { column = \"time_s\" }"]);
    compare("jump.csv").assert_refused(&["jump.csv: time_s spans 1000000000 s", "up to 3600 s"]);
    folder.sil(&["compare", "jump.csv"]).assert_done();
    let unchecked = ["compare", "slow.csv", "--controller", "pid", "--unchecked"];
    folder.sil(&unchecked).assert_refused(&["slow.csv: rows every 10 s are too few"]);
}

/// Every option that takes a file, with things in its place that are no such file.
#[test]
fn no_option_takes_a_missing_file_a_folder_or_garbage() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    folder.write("garbage", [0xff, 0x00, 0xfe, 0x9f]);
    folder.write("empty", "");
    folder.write("prose", "It was a bright cold day in April.\n");
    std::fs::create_dir(folder.path("folder")).unwrap();
    for arguments in [
        &["compare"][..],
        &["compare", "log.csv", "--map"],
        &["compare", "log.csv", "--controller"],
        &["compare", "log.csv", "--model"],
        &["fly", "--model"],
        &["fly", "--script"],
        &["synth", "out.csv", "--model"],
        &["synth", "out.csv", "--controller"],
        &["bench-mpc"],
    ] {
        for (file, expected) in [
            ("missing", &["o such file"][..]),
            ("folder", &["Is a directory"]),
            ("garbage", &[]),
            ("empty", &[]),
            ("prose", &[]),
        ] {
            let outcome = folder.sil(&[arguments, &[file]].concat());
            outcome.assert_refused(&[&[file][..], expected].concat());
        }
    }
    assert!(!folder.path("out.csv").exists());
}

#[test]
fn a_bad_model_is_refused_with_line_and_column() {
    let folder = Folder::new();
    for (from, to, expected) in [
        ("ixx_kg_m2 = 0.0115118", "", "m.toml:11:1: [body] lacks `ixx_kg_m2`: expected a moment of inertia in kg m^2"),
        (
            "ixx_kg_m2 = 0.0115118",
            "ixx_kg_m2 = -0.01",
            "m.toml:12:13: `ixx_kg_m2` is -0.01: expected a moment of inertia",
        ),
        ("ixx_kg_m2 = 0.0115118", "ixx_kg_m2 = nan", "m.toml:12:13: `ixx_kg_m2` is NaN: expected a moment of inertia"),
        (
            "ixx_kg_m2 = 0.0115118",
            "ixx_kg_m2 = \"1\"",
            "m.toml:12:13: `ixx_kg_m2` is of type string: expected a moment",
        ),
        ("arm_m = 0.226", "arm_m = 0.226\nwings = 2", "m.toml:9:1:"),
        ("rig = \"gimbal\"", "rig = \"hook\"", "m.toml:5:7: `rig` is \"hook\": expected \"gimbal\" or \"free\""),
        ("[body]", "[body", "m.toml:11:6: not valid TOML"),
        ("[noise]", "[[effect]]\nname = \"gremlins\"\n[noise]", "`name` is \"gremlins\": expected \"cg_offset\""),
    ] {
        let text = GIMBAL_MODEL.replacen(from, to, 1);
        assert_ne!(text, GIMBAL_MODEL, "{from}");
        folder.write("m.toml", text);
        folder.sil(&["fly", "--model", "m.toml"]).assert_refused(&["m.toml:", expected]);
    }
}

#[test]
fn a_bad_script_map_or_controller_is_refused_with_its_place() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    let step = "duration_s = 3\n[[step]]\nat_s = 1\n";
    let script = &["fly", "--script"][..];
    let controller = &["compare", "log.csv", "--controller"][..];
    let synth_controller = &["synth", "out.csv", "--controller"][..];
    let map = &["compare", "log.csv", "--map"][..];
    for (arguments, text, expected) in [
        (script, "[[step]]\nat_s = 1\n".to_owned(), &["line 1", "missing field `duration_s`"][..]),
        (script, "duration_s = nan\n".to_owned(), &["duration_s must be above"]),
        (script, "duration_s = 1e9\n".to_owned(), &["at most 3600 s"]),
        (script, "duration_s = \"long\"\n".to_owned(), &["line 1, column 14", "expected f64"]),
        (script, format!("{step}rol_deg = 3\n"), &["line 4, column 1", "unknown field `rol_deg`, expected one of"]),
        (script, format!("{step}roll_deg = nan\n"), &["file.toml:2: [[step]] number 1: roll_deg must be within"]),
        (
            script,
            format!("{step}throttle = 50\n"),
            &["file.toml:2: [[step]] number 1: throttle must be within 0 and 1"],
        ),
        (script, format!("{step}[[step]]\nat_s = 0.5\n"), &["file.toml:4: [[step]] number 2: at_s must be"]),
        (controller, "controller = \"pdi\"\n".to_owned(), &["line 1, column 14", "expected `pid` or `mpc`"]),
        (controller, "controller = \"pid\"\nrate_hz = 0\n".to_owned(), &["line 2, column 11", "expected 50 to 1000"]),
        (synth_controller, "controller = \"pid\"\nrate_hz = 3\n".to_owned(), &["line 2", "expected 50 to 1000"]),
        (controller, "controller = \"mpc\"\ncontrol_horizon = 31\n".to_owned(), &["line 2", "expected 1 to 30"]),
        (
            controller,
            "controller = \"pid\"\n[tuning]\nangle_gain_1_s = [-1, 1, 1]\n".to_owned(),
            &["--controller file.toml: ", "angle_gain_1_s must be a finite number above zero"],
        ),
        (
            controller,
            "controller = \"pid\"\n[tuning]\ngain = 1\n".to_owned(),
            &["line 3, column 1", "unknown field `gain`"],
        ),
        (
            map,
            "description = \"\"\nframe = \"NED\"\n[quantities]\n".to_owned(),
            &["file.toml:2: `frame`: expected \"FRD\""],
        ),
        (map, "description = \"\"\n".to_owned(), &["file.toml:1: missing field `frame`"]),
        (map, "quantities".to_owned(), &["file.toml:1: "]),
    ] {
        folder.write("file.toml", &text);
        println!("{text}");
        folder.sil(&[arguments, &["file.toml"]].concat()).assert_refused(&[&["file.toml"][..], expected].concat());
    }
    assert!(!folder.path("out.csv").exists());
}
