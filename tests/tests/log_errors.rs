//! Every way in which a log or a map can be wrong ends in a message that names the file, the line, the column and what
//! was expected; nothing panics. The messages are compared whole: they are the interface.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use sil_host::log::{Log, Map, parse, read};

const HEADER: &str = "time_s,roll_rad,pitch_rad,p_rad_s,q_rad_s,motor1,motor2,motor3,motor4";

/// A good log of 100 rows; data row 10 is line 11.
fn good() -> String {
    let row = |row: usize| format!("{}.5,0.1,-0.1,0,1e-3,0.5,0.5,0.5,0.5\n", row);
    format!("{HEADER}\n{}", (0..100).map(row).collect::<String>())
}

/// The good log with one line (counted from 1) replaced.
fn with_line(number: usize, line: &str) -> String {
    let mut text = String::new();
    for (index, original) in good().lines().enumerate() {
        text += if index + 1 == number { line } else { original };
        text.push('\n');
    }
    text
}

fn with_header(header: &str) -> String {
    with_line(1, header)
}

fn message(text: &str) -> String {
    match parse("run.csv", text, None) {
        Ok(_) => "read without complaint".to_owned(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn the_good_log_is_read() {
    let log = parse("run.csv", &good(), None).unwrap();
    assert_eq!(log.rows(), 100);
    assert_eq!(log.axes, [true, true, false]);
    assert_eq!(log.notes, Vec::<String>::new());
}

/// Name of the case, text, expected message.
type Case = (&'static str, String, &'static str);

fn assert_messages(cases: Vec<Case>) {
    for (name, text, expected) in cases {
        assert_eq!(message(&text), expected, "{name}");
    }
}

#[test]
fn malformed_files_are_named_by_line_and_column() {
    assert_messages(vec![
        ("empty file", String::new(), "run.csv: the file is empty; expected a header line and at least 100 rows"),
        (
            "comments only",
            "# synthetic\n".to_owned(),
            "run.csv: the file is empty; expected a header line and at least 100 rows",
        ),
        ("header only", format!("{HEADER}\n"), "run.csv: expected at least 100 rows, found 0"),
        (
            "99 rows",
            good().lines().take(100).map(|l| format!("{l}\n")).collect(),
            "run.csv: expected at least 100 rows, found 99",
        ),
        (
            "missing column",
            with_header(&HEADER.replace("q_rad_s", "q")),
            "run.csv:1: `q_rad_s`: required column is missing (for other names give a map, --map; `sil map LOG` \
             drafts one); the header has: \
             time_s, roll_rad, pitch_rad, p_rad_s, q, motor1, motor2, motor3, motor4",
        ),
        (
            "the same column twice",
            with_header(&HEADER.replace("pitch_rad", "roll_rad")),
            "run.csv:1: `roll_rad`: given twice: as `roll_rad` and as `roll_rad`",
        ),
        (
            "one column in two units",
            with_header(&HEADER.replace("pitch_rad", "roll_deg")),
            "run.csv:1: `roll_rad`: given twice: as `roll_rad` and as `roll_deg`",
        ),
    ]);
}

#[test]
fn malformed_values_are_named_by_line_and_column() {
    assert_messages(vec![
        (
            "a word",
            with_line(11, "9.5,0.1,none,0,0,0.5,0.5,0.5,0.5"),
            "run.csv:11: `pitch_rad`: expected a number, found `none`",
        ),
        (
            "NaN",
            with_line(11, "9.5,0.1,NaN,0,0,0.5,0.5,0.5,0.5"),
            "run.csv:11: `pitch_rad`: expected a finite number, found `NaN`",
        ),
        (
            "infinite",
            with_line(11, "9.5,0.1,0.1,0,-inf,0.5,0.5,0.5,0.5"),
            "run.csv:11: `q_rad_s`: expected a finite number, found `-inf`",
        ),
        (
            "overflow",
            with_line(11, "1e999,0.1,0.1,0,0,0.5,0.5,0.5,0.5"),
            "run.csv:11: `time_s`: expected a finite number, found `1e999`",
        ),
        (
            "time back",
            with_line(11, "8.25,0.1,0.1,0,0,0.5,0.5,0.5,0.5"),
            "run.csv:11: `time_s`: time must increase: 8.25 s follows 8.5 s",
        ),
        (
            "time standing",
            with_line(11, "8.5,0.1,0.1,0,0,0.5,0.5,0.5,0.5"),
            "run.csv:11: `time_s`: time must increase: 8.5 s follows 8.5 s",
        ),
        ("too few fields", with_line(11, "9.5,0.1,0.1"), "run.csv:11: expected 9 fields as in the header, found 3"),
        (
            "too many fields",
            with_line(11, "9.5,0.1,0.1,0,0,0.5,0.5,0.5,0.5,7"),
            "run.csv:11: expected 9 fields as in the header, found 10",
        ),
        ("an empty line amid the rows", with_line(11, ""), "run.csv:11: expected 9 fields as in the header, found 0"),
    ]);
}

#[test]
fn wrong_units_and_missing_axes_are_named_with_a_hint() {
    assert_messages(vec![
        (
            "degrees called radians",
            with_line(11, "9.5,-28.5,0.1,0,0,0.5,0.5,0.5,0.5"),
            "run.csv:11: `roll_rad`: -28.5 is outside -10..10 (another unit? a column named roll_deg is converted)",
        ),
        (
            "degrees per second called radians",
            with_line(11, "9.5,0.1,0.1,250,0,0.5,0.5,0.5,0.5"),
            "run.csv:11: `p_rad_s`: 250 is outside -100..100 (another unit? a column named p_deg_s is converted)",
        ),
        (
            "percent called a fraction",
            with_line(11, "9.5,0.1,0.1,0,0,50,0.5,0.5,0.5"),
            "run.csv:11: `motor1`: 50 is outside -0.05..1.05 (another unit? a column named motor1_pct is converted)",
        ),
        (
            "a pulse width",
            with_line(11, "9.5,0.1,0.1,0,0,0.5,1500,0.5,0.5"),
            "run.csv:11: `motor2`: 1500 is outside -0.05..1.05 (a pulse width in us? give scale and offset in a --map)",
        ),
        (
            "a negative command",
            with_line(11, "9.5,0.1,0.1,0,0,0.5,-0.06,0.5,0.5"),
            "run.csv:11: `motor2`: -0.06 is outside -0.05..1.05 (another unit? a column named motor2_pct is converted)",
        ),
        (
            "comments and Windows line ends before a bad line",
            format!("# a\r\n#b\r\n{}", with_line(11, "9.5,x,0.1,0,0,0,0,0,0").replace('\n', "\r\n")),
            "run.csv:13: `roll_rad`: expected a number, found `x`",
        ),
        (
            "axis commands for pitch alone",
            with_header("time_s,roll_rad,pitch_rad,p_rad_s,q_rad_s,pitch_cmd,thrust_cmd,note,other"),
            "run.csv:1: `roll_cmd`: required column is missing (for other names give a map, --map; `sil map LOG` \
             drafts one); the header has: \
             time_s, roll_rad, pitch_rad, p_rad_s, q_rad_s, pitch_cmd, thrust_cmd, note, other",
        ),
    ]);
}

#[test]
fn files_that_are_no_text_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let gzip = |bytes: &[u8]| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let whole = gzip(good().as_bytes());
    let mut flipped = whole.clone();
    let checksum = flipped.len() - 6;
    flipped[checksum] ^= 1;
    let with_byte = |byte: u8| {
        let mut bytes = with_line(11, "9.5,0.1,0.1,0,0,?,0,0,0").into_bytes();
        let mark = bytes.iter().position(|byte| *byte == b'?').unwrap();
        bytes[mark] = byte;
        bytes
    };
    let mut binary = with_byte(0xb0);
    binary.push(0);
    let cases: [(&str, Vec<u8>, &str); 9] = [
        ("cut.csv.gz", whole[..whole.len() / 2].to_vec(), "the gzip stream is damaged or cut off ("),
        (
            "flipped.csv.gz",
            flipped,
            "the gzip stream is damaged or cut off (corrupt gzip stream does not have a matching checksum)",
        ),
        ("head.csv.gz", whole[..2].to_vec(), "the gzip stream is damaged or cut off ("),
        ("line11.csv", binary, "not UTF-8 text; expected a CSV file"),
        ("line11_latin1.csv", with_byte(0xb0), "`\u{b0}`"),
        ("flight.ulg", b"anything".to_vec(), "no ULog (PX4) log that can be read: its head is not that"),
        ("renamed.csv", b"ULog\x01\x12\x35\x01".to_vec(), "no ULog (PX4) log that can be read: its head is not"),
        ("flight.BIN.gz", gzip(b"anything"), "no DataFlash (ArduPilot) log that can be read: it does not begin"),
        ("renamed2.csv", vec![0xa3, 0x95, 0x80, 0x80], "the log holds no body rates or angles; it holds: "),
    ];
    for (name, bytes, expected) in cases {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let message = read(&path, None).unwrap_err().to_string();
        assert!(message.contains(expected), "{name}: {message}");
        assert!(message.starts_with(&path.display().to_string()), "{message}");
        assert_eq!(name.starts_with("line11"), message.contains(".csv:11:"), "{message}");
    }
    let missing = read(&folder.path().join("no.csv"), None).unwrap_err();
    assert!(missing.to_string().contains("no.csv: can't be opened: "));
    let a_folder = read(folder.path(), None).unwrap_err();
    assert!(a_folder.to_string().contains("can't be opened: "));
    // compressed, but not named so
    let path = folder.path().join("compressed.csv");
    std::fs::write(&path, whole).unwrap();
    assert_eq!(read(&path, None).unwrap().rows(), 100);
}

/// Name of the case, text, notes that are expected of a log that is otherwise the good one.
type Certain = (&'static str, String, Vec<&'static str>);

#[test]
fn what_is_certain_is_read_and_what_was_left_out_is_noted() {
    let decimal_commas = || good().replace(',', ";").replace('.', ",");
    let repeated_line = with_line(50, &[good().lines().nth(49).unwrap(); 3].join("\n"));
    let cases: Vec<Certain> = vec![
        ("line ends of Windows", good().replace('\n', "\r\n"), vec![]),
        ("line ends of old Macs", good().replace('\n', "\r"), vec![]),
        ("a byte order mark", format!("\u{feff}{}", good()), vec![]),
        ("semicolons", good().replace(',', ";"), vec![]),
        ("semicolons and decimal commas", decimal_commas(), vec![]),
        ("tabs", good().replace(',', "\t"), vec![]),
        ("tabs and decimal commas", decimal_commas().replace(';', "\t"), vec![]),
        ("quoted fields", good().replace(",0.5", ",\"0.5\""), vec![]),
        ("spaces around fields", good().replace(',', " , "), vec![]),
        ("empty lines at the end", format!("{}\n\n", good()), vec![]),
        ("a line three times", repeated_line, vec!["2 lines repeat the one before, the first line 51"]),
        (
            "a last line without its end",
            format!("{}100.5,0.1,-0.1,0,1e-3,0.5,0.5,0.5,0.", good()),
            vec!["line 102 left out: it has no line end and may be cut off"],
        ),
        (
            "a last line of one character",
            format!("{}1", good()),
            vec!["line 102 left out: it has no line end and may be cut off"],
        ),
    ];
    let expected = parse("run.csv", &good(), None).unwrap();
    for (name, text, notes) in cases {
        let log = parse("run.csv", &text, None).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(log.notes, notes, "{name}");
        assert_eq!(Log { notes: Vec::new(), ..log }, expected, "{name}");
    }
}

#[test]
fn what_is_not_certain_is_refused_with_its_line() {
    let mut commas = good().replace(',', ";").replace('.', ",");
    commas.push_str("100,5;0.1;0;0;0;0,5;0,5;0,5;0,5\n");
    let thousands = good().replace(',', ";").replacen("9.5;", "1.009,5;", 1);
    assert_messages(vec![
        (
            "two marks of fractions",
            commas,
            "run.csv:102: `roll_rad`: expected `,` before a fraction, as in the lines before, found `0.1`",
        ),
        (
            "marks of thousands",
            thousands,
            "run.csv:11: `time_s`: expected `.` before a fraction, as in the lines before, found `1.009,5`",
        ),
        (
            "a repeated time with other values",
            with_line(11, "8.5,0.2,-0.1,0,1e-3,0.5,0.5,0.5,0.5"),
            "run.csv:11: `time_s`: time must increase: 8.5 s follows 8.5 s",
        ),
        (
            "time that runs back",
            with_line(11, "7.5,0.1,-0.1,0,1e-3,0.5,0.5,0.5,0.5"),
            "run.csv:11: `time_s`: time must increase: 7.5 s follows 8.5 s",
        ),
        (
            "a blank time",
            with_line(11, ",0.1,-0.1,0,1e-3,0.5,0.5,0.5,0.5"),
            "run.csv:11: `time_s`: expected a number, found ``",
        ),
        (
            "a row of another separator",
            with_line(11, "9.5;0.1;-0.1;0;1e-3;0.5;0.5;0.5;0.5"),
            "run.csv:11: expected 9 fields as in the header, found 1",
        ),
        (
            "blank rates throughout",
            good().replace(",0,1e-3,", ",,,"),
            "run.csv:1: `p_rad_s`: required column has no value in any row; the header has: time_s, roll_rad, \
             pitch_rad, p_rad_s, q_rad_s, motor1, motor2, motor3, motor4",
        ),
    ]);
}

/// A log merged from a gyro at 100 Hz, an attitude at 20 Hz and motors at 50 Hz between the gyro's readings.
#[test]
fn blank_fields_of_a_merged_log_are_missing_values() {
    let mut rows: Vec<(u32, String)> = Vec::new();
    for i in 0..300_u32 {
        let us = 10_000 * i;
        let angles = if i.is_multiple_of(5) { format!("{},{}", 0.001 * f64::from(i), 0.1) } else { ",".to_owned() };
        rows.push((us, format!("{us},{angles},0.1,0,,,,")));
        if i.is_multiple_of(2) {
            rows.push((us + 3000, format!("{},,,,,0.{i:03},0.2,0.3,0.4", us + 3000)));
        }
    }
    let lines: String = rows.iter().map(|(_, row)| format!("{row}\n")).collect();
    let header = HEADER.replace("time_s", "time_us");
    let log = parse("run.csv", &format!("{header}\n{lines}"), None).unwrap();
    assert!(log.notes[0].ends_with("blank fields are missing values"), "{:?}", log.notes);
    // the gyro's rows, from the first command to the last attitude
    assert!((log.time_s[0] - 0.01).abs() < 1e-12 && (log.time_s[log.rows() - 1] - 2.95).abs() < 1e-12);
    assert_eq!(log.rows(), 295);
    let roll = log.angle_rad[0].as_ref().unwrap();
    let motor1 = log.motors().unwrap()[0];
    for (row, time_s) in log.time_s.iter().enumerate() {
        assert!((roll[row] - 0.1 * time_s).abs() < 1e-9, "{time_s} {}", roll[row]);
        // sent 3 ms after every other reading of the gyro
        let sent = 2.0 * ((time_s - 0.003) / 0.02).floor();
        assert!((motor1[row] - 0.001 * sent).abs() < 1e-12, "{time_s} {}", motor1[row]);
    }
    assert!((log.sent_commands.as_ref().unwrap().time_s[1] - 0.023).abs() < 1e-12);
    assert_eq!(log.flight_controller, None);
}

fn assert_close(column: &[f64], expected: f64) {
    // one multiplication by a rounded factor: two units in the last place
    assert!((column[0] - expected).abs() <= 4.5e-16 * expected.abs());
}

#[test]
fn units_are_converted_by_suffix_and_order_is_free() {
    let header = "motor4_pct,motor3,motor2,motor1_pct,q_deg_s,p_rad_s,pitch_deg,roll_rad,\
        temperature,time_ms,battery_mv,az_g,yaw_ref_deg";
    let row = |row: usize| format!("25,0.3,0.4,105,-90,1,180,0.5,x,{row},11100,-1,-45\n");
    let rows: String = (0..100).map(row).collect();
    let log =
        parse("run.csv", &format!("\u{feff}# synthetic\n \"{}\"\n{rows}\n\n", header.replace(',', "\", \"")), None)
            .unwrap();
    let column = |column: &Option<Vec<f64>>| column.clone().unwrap();
    assert_eq!(log.comments, ["synthetic"]);
    assert_eq!(log.notes, ["columns ignored: temperature"]);
    assert_close(&column(&log.motor_command[3]), 0.25);
    assert_close(&column(&log.motor_command[0]), 1.05);
    assert_close(&column(&log.rate_rad_s[1]), -std::f64::consts::FRAC_PI_2);
    assert_close(&column(&log.angle_rad[1]), std::f64::consts::PI);
    assert_close(&column(&log.angle_rad[0]), 0.5);
    assert_close(&column(&log.battery_v), 11.1);
    assert_close(&column(&log.accel_body_m_s2[2]), -9.80665);
    assert_close(&column(&log.reference_rad[2]), -std::f64::consts::FRAC_PI_4);
    assert_close(&log.time_s[99..], 0.099);
}

const MAP: &str = "description = \"bench\"\nframe = \"FRD\"\naxes = [\"pitch\"]\nactive_when = \"thrust_cmd > 0.1\"\n\
    [quantities]\ntime_s = { column = \"t\" }\npitch_deg = { column = \"theta\", sign = -1, scale = 2, offset = 1 }\n\
    pitch_cmd = { column = \"u\" }\nthrust_cmd = { column = \"T\" }\n";

fn foreign(header: &str) -> String {
    let row = |row: usize| format!("{row},30,0.2,{}\n", if row < 50 { 0.1 } else { 0.5 });
    format!("{header}\n{}", (0..100).map(row).collect::<String>())
}

#[test]
fn a_map_reads_a_foreign_log() {
    let map = Map::parse("bench.toml", MAP).unwrap();
    let log: Log = parse("run.csv", &foreign("t,theta,u,T"), Some(&map)).unwrap();
    assert_eq!(log.axes, [false, true, false]);
    assert!(log.driven_by_axis_commands());
    assert_close(&log.angle_rad[1].clone().unwrap(), (-59.0_f64).to_radians());
    let active = log.active_rows();
    assert!(!active[49] && active[50]);
    assert_eq!(log.notes, ["read by the map bench.toml"]);
    assert_eq!(
        parse("run.csv", &foreign("t,theta,v,T"), Some(&map)).unwrap_err().to_string(),
        "run.csv:1: `u`: column is missing, which the map bench.toml takes for pitch_cmd; \
         the header has: t, theta, v, T"
    );
    // the first row in which the throttle is open; what was commanded before moved nothing
    assert_eq!(
        parse("run.csv", &foreign("t,theta,u,T").replace(",0.2,", ",1.2,"), Some(&map)).unwrap_err().to_string(),
        "run.csv:52: `u`: 1.2 is outside -1.05..1.05 (another unit? a column named pitch_cmd_pct is converted)"
    );
}

#[test]
fn malformed_maps_are_named_by_line_and_key() {
    let cases = [
        ("FRD\"", "NED\"", "bench.toml:2: `frame`: expected \"FRD\" or \"FLU\", found \"NED\""),
        ("[\"pitch\"]", "[\"pich\"]", "bench.toml:3: `axes`: expected roll, pitch or yaw, found `pich`"),
        ("[\"pitch\"]", "[]", "bench.toml:5: `quantities`: axes names no axis"),
        (
            "[\"pitch\"]",
            "[\"roll\"]",
            "bench.toml:5: `quantities`: roll_rad or p_rad_s is missing (axes has roll); roll_cmd is missing (or \
             motor1 to motor4)",
        ),
        (
            "thrust_cmd > 0.1",
            "thrust_cmd < 0.1",
            "bench.toml:4: `active_when`: expected \"QUANTITY > NUMBER\" with a quantity of this map, \
             found \"thrust_cmd < 0.1\"",
        ),
        (
            "thrust_cmd > 0.1",
            "motor1 > 0.1",
            "bench.toml:4: `active_when`: expected \"QUANTITY > NUMBER\" with a quantity of this map, \
             found \"motor1 > 0.1\"",
        ),
        ("time_s =", "battery_v =", "bench.toml:5: `quantities`: time_s is missing"),
        ("pitch_cmd =", "roll_cmd =", "bench.toml:5: `quantities`: pitch_cmd is missing (or motor1 to motor4)"),
        (
            "pitch_deg",
            "pitch",
            "bench.toml:7: `pitch`: no quantity of that name and unit; docs/log-format.md lists them",
        ),
        ("thrust_cmd = {", "pitch_rad = {", "bench.toml:9: `pitch_rad`: pitch_rad is given twice"),
        ("sign = -1", "sign = 2", "bench.toml:7: `pitch_deg`: sign must be 1 or -1"),
        ("scale = 2", "scale = 0", "bench.toml:7: `pitch_deg`: scale must be finite and not 0, offset finite"),
        ("offset = 1", "offset = nan", "bench.toml:7: `pitch_deg`: scale must be finite and not 0, offset finite"),
    ];
    for (from, to, expected) in cases {
        let text = MAP.replacen(from, to, 1);
        assert_ne!(text, MAP, "{from}");
        assert_eq!(Map::parse("bench.toml", &text).unwrap_err().to_string(), expected);
    }
    let of_the_toml_library = [
        (
            "sign = -1",
            "sine = -1",
            "bench.toml:7: unknown field `sine`, expected one of `column`, `columns`, `rate_of`, `euler_of`, \
             `scale`, `offset`, `sign`",
        ),
        ("column = \"u\"", "", "bench.toml:8: `pitch_cmd`: expected column = \"NAME\", or columns = {"),
        ("frame =", "frame", "bench.toml:2: "),
    ];
    for (from, to, expected) in of_the_toml_library {
        let message = Map::parse("bench.toml", &MAP.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(message.starts_with(expected), "{message}");
    }
    assert_eq!(
        Map::load("nowhere.toml").unwrap_err().to_string(),
        "nowhere.toml: no such file, and no built-in map of that name; built in are: \
         antx, crazyflie_arplab, crazypad_controller, crazypad_motor, sharif, sharif_pitch, sharif_roll_pitch, \
         sharif_yaw"
    );
}

proptest::proptest! {
    /// Garbage in every byte, and a good log with bytes changed, end in a log or an error, never in a panic.
    #[test]
    fn no_text_makes_the_reader_panic(
        garbage in proptest::collection::vec(proptest::prelude::any::<char>(), 0..200),
        changes in proptest::collection::vec((0..4000_usize, 0..128_u8), 0..4),
    ) {
        let _ = parse("run.csv", &garbage.iter().collect::<String>(), None);
        let _ = Map::parse("map.toml", &garbage.iter().collect::<String>());
        let mut bytes = good().into_bytes();
        let mut map = MAP.as_bytes().to_vec();
        for (place, byte) in changes {
            let (in_log, in_map) = (place % bytes.len(), place % map.len());
            bytes[in_log] = byte;
            map[in_map] = byte;
        }
        let _ = parse("run.csv", &String::from_utf8(bytes).unwrap(), None);
        let _ = Map::parse("map.toml", &String::from_utf8(map).unwrap());
    }
}
