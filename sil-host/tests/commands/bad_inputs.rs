//! Every kind of bad input that people give: each is made from one good log by a small function, and the answer must
//! hold the words that its owner needs. What is certain is read, with a note. The library answers here; that the
//! command says the same is tested beside its JSON (`json`).

use std::path::Path;

use sil_host::log::{Column, Log, Wanted, write, write_file};
use sil_host::model::VehicleModel;
use sil_host::synthesis::Synthesis;

use crate::sil::{Folder, GENERIC_FREE_MODEL};

/// A free flight of 12 s at 100 rows/s with everything in it.
fn good() -> Log {
    let model = VehicleModel::parse(GENERIC_FREE_MODEL, "free.toml").unwrap();
    Synthesis { seed: 4, log_rate_hz: 100, duration_s: 12.0, ..Synthesis::of(model) }.log().unwrap()
}

fn csv(log: &Log) -> String {
    let mut bytes = Vec::new();
    write(log, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

fn scale(column: &mut Column, by: f64) {
    column.iter_mut().flatten().for_each(|value| *value *= by);
}

fn scale_all(columns: &mut [Column], by: f64) {
    columns.iter_mut().for_each(|column| scale(column, by));
}

/// The value of a row, held from there on.
fn freeze(column: &mut Column, from: usize) {
    let values = column.as_mut().unwrap();
    let held = values[from];
    values[from..].fill(held);
}

/// The text with another value in a line, counted from 1.
fn with_field(text: &str, line: usize, name: &str, value: &str) -> String {
    let header = text.lines().find(|line| !line.starts_with('#')).unwrap();
    let place = header.split(',').position(|here| here == name).unwrap_or_else(|| panic!("no {name} in {header}"));
    let change = |(index, original): (usize, &str)| {
        if index + 1 != line {
            return format!("{original}\n");
        }
        let mut fields: Vec<&str> = original.split(',').collect();
        fields[place] = value;
        format!("{}\n", fields.join(","))
    };
    text.lines().enumerate().map(change).collect()
}

fn with_header(text: &str, from: &str, to: &str) -> String {
    let changed = text.replacen(from, to, 1);
    assert_ne!(changed, text, "{from}");
    changed
}

/// What is done to the log, and the words of the answer: of the refusal, or of the reader's notes.
enum Case {
    /// Its columns are changed.
    Columns(fn(&mut Log)),
    /// The CSV's text is.
    Text(fn(&str) -> String),
    /// The bytes of a file of this name are, made from the CSV.
    Bytes(&'static str, fn(&str) -> Vec<u8>),
    /// The bytes of the same flight as a ULog are.
    Ulog(fn(Vec<u8>) -> Vec<u8>),
}

use Case::{Bytes, Columns, Text, Ulog};

/// A row: its name, what is done, whether it is read nevertheless, and the words of the answer.
type Row = (&'static str, Case, bool, &'static [&'static str]);

const READ: bool = true;
const REFUSED: bool = false;
const DEG: f64 = 57.295_779_513_082_32;

const OF_UNITS_AND_SIGNS: &[Row] = &[
    ("rates in deg/s", Columns(|l| scale_all(&mut l.rate_rad_s, DEG)), REFUSED, &["p_deg_s is converted"]),
    ("p in deg/s", Columns(|l| scale(&mut l.rate_rad_s[0], DEG)), REFUSED, &["p_deg_s is converted"]),
    ("r in deg/s, no yaw flown", Columns(|l| scale(&mut l.rate_rad_s[2], DEG)), READ, &["angles of roll, pitch;"]),
    ("angles in degrees", Columns(|l| scale_all(&mut l.angle_rad, DEG)), REFUSED, &["_deg"]),
    ("roll in degrees", Columns(|l| scale(&mut l.angle_rad[0], DEG)), REFUSED, &["roll_deg"]),
    ("p turned", Columns(|l| scale(&mut l.rate_rad_s[0], -1.0)), REFUSED, &["turned", "`p_rad_s`"]),
    ("q turned", Columns(|l| scale(&mut l.rate_rad_s[1], -1.0)), REFUSED, &["turned", "`q_rad_s`"]),
    ("r turned, no yaw flown", Columns(|l| scale(&mut l.rate_rad_s[2], -1.0)), READ, &["angles of roll, pitch;"]),
    ("roll turned", Columns(|l| scale(&mut l.angle_rad[0], -1.0)), REFUSED, &["roll_rad = {"]),
    ("pitch turned", Columns(|l| scale(&mut l.angle_rad[1], -1.0)), REFUSED, &["pitch_rad = {"]),
    ("p and q swapped", Columns(|l| l.rate_rad_s.swap(0, 1)), REFUSED, &["swapped"]),
    ("roll and pitch swapped", Columns(|l| l.angle_rad.swap(0, 1)), REFUSED, &["swapped"]),
    ("accelerometer in g", Columns(|l| scale_all(&mut l.accel_body_m_s2, 1.0 / 9.81)), REFUSED, &["g"]),
    ("accelerometer upside down", Columns(|l| scale(&mut l.accel_body_m_s2[2], -1.0)), REFUSED, &["az"]),
    ("motors 1 and 2 swapped", Columns(|l| l.motor_command.swap(0, 1)), REFUSED, &["order", "motor1 = {"]),
    ("motors 3 and 4 swapped", Columns(|l| l.motor_command.swap(2, 3)), REFUSED, &["order", "motor3 = {"]),
    ("motors 1 and 3 swapped", Columns(|l| l.motor_command.swap(0, 2)), REFUSED, &["motor1 = {"]),
    ("motors shifted by one", Columns(|l| l.motor_command.rotate_left(1)), REFUSED, &["motor"]),
    ("motors in percent", Columns(|l| scale_all(&mut l.motor_command, 100.0)), REFUSED, &["motor1_pct is converted"]),
    (
        "motors as pulse widths",
        Columns(|l| l.motor_command.iter_mut().flatten().flatten().for_each(|m| *m = 1000.0 + 1000.0 * *m)),
        REFUSED,
        &["pulse width in us", "--map"],
    ),
    ("time in ms", Columns(|l| l.time_s.iter_mut().for_each(|t| *t *= 1e3)), REFUSED, &["time_ms = {"]),
    ("time in us", Columns(|l| l.time_s.iter_mut().for_each(|t| *t *= 1e6)), REFUSED, &["time_us = {"]),
    ("time in minutes", Columns(|l| l.time_s.iter_mut().for_each(|t| *t /= 60.0)), REFUSED, &["time_min = {"]),
    ("time in hours", Columns(|l| l.time_s.iter_mut().for_each(|t| *t /= 3600.0)), REFUSED, &["unit", "larger"]),
    ("q in deg/s and turned", Columns(|l| scale(&mut l.rate_rad_s[1], -DEG)), REFUSED, &["`q_rad_s`"]),
    (
        "all rates turned",
        Columns(|l| scale_all(&mut l.rate_rad_s, -1.0)),
        REFUSED,
        &["turned", "`p_rad_s`", "`q_rad_s`"],
    ),
    ("all angles turned", Columns(|l| scale_all(&mut l.angle_rad, -1.0)), REFUSED, &["turned", "`roll_rad`"]),
    ("accelerometer in mg", Columns(|l| scale_all(&mut l.accel_body_m_s2, 1000.0 / 9.81)), REFUSED, &["az"]),
    ("accelerometer in cm/s2", Columns(|l| scale_all(&mut l.accel_body_m_s2, 100.0)), REFUSED, &["az"]),
    ("accelerometer's x and z swapped", Columns(|l| l.accel_body_m_s2.swap(0, 2)), REFUSED, &["a"]),
    ("motors reversed", Columns(|l| l.motor_command.reverse()), REFUSED, &["motor"]),
    (
        "motors turned round",
        Columns(|l| l.motor_command.iter_mut().flatten().flatten().for_each(|m| *m = 1.0 - *m)),
        REFUSED,
        &["motor"],
    ),
    ("motors of 0 to 2000", Columns(|l| scale_all(&mut l.motor_command, 2000.0)), REFUSED, &["motor1", "outside"]),
    ("motors of 16 bits", Columns(|l| scale_all(&mut l.motor_command, 65535.0)), REFUSED, &["motor1", "outside"]),
    (
        "forward-left-up",
        Columns(|l| {
            for axis in [1, 2] {
                scale(&mut l.angle_rad[axis], -1.0);
                scale(&mut l.rate_rad_s[axis], -1.0);
                scale(&mut l.accel_body_m_s2[axis], -1.0);
            }
        }),
        REFUSED,
        &["az"],
    ),
    (
        "a plus frame and motors in another order",
        Columns(|l| {
            *l = l.clone().turned(-45.0).unwrap();
            l.motor_command.swap(0, 3);
        }),
        REFUSED,
        &["plus frame", "--frame-turn"],
    ),
    ("a plus frame", Columns(|l| *l = l.clone().turned(-45.0).unwrap()), REFUSED, &["plus frame", "--frame-turn 45"]),
];

const OF_READINGS: &[Row] = &[
    ("p frozen", Columns(|l| freeze(&mut l.rate_rad_s[0], 0)), REFUSED, &["`p_rad_s`", "leave the column out"]),
    ("q frozen half way", Columns(|l| freeze(&mut l.rate_rad_s[1], 600)), REFUSED, &["`q_rad_s`"]),
    ("roll frozen half way", Columns(|l| freeze(&mut l.angle_rad[0], 600)), REFUSED, &["`roll_rad`"]),
    ("motor 2 frozen", Columns(|l| freeze(&mut l.motor_command[1], 0)), REFUSED, &["`motor2`"]),
    ("a motor at 0", Columns(|l| scale(&mut l.motor_command[3], 0.0)), REFUSED, &["`motor4` stays at 0", "not logged"]),
    (
        "all motors at 0",
        Columns(|l| scale_all(&mut l.motor_command, 0.0)),
        READ,
        &["no part was recognised as a flight"],
    ),
    ("all rates 0", Columns(|l| scale_all(&mut l.rate_rad_s, 0.0)), REFUSED, &["_rad_s"]),
    ("NaN", Text(|t| with_field(t, 500, "pitch_rad", "NaN")), REFUSED, &[":500: `pitch_rad`", "finite number"]),
    ("infinite", Text(|t| with_field(t, 500, "q_rad_s", "inf")), REFUSED, &[":500: `q_rad_s`", "finite number"]),
    ("a word", Text(|t| with_field(t, 77, "motor1", "armed")), REFUSED, &[":77: `motor1`", "`armed`"]),
    ("a date", Text(|t| with_field(t, 50, "time_s", "12:00:01")), REFUSED, &[":50: `time_s`", "`12:00:01`"]),
    ("a hexadecimal", Text(|t| with_field(t, 50, "motor3", "0x1F")), REFUSED, &[":50: `motor3`", "`0x1F`"]),
    ("a wild value", Text(|t| with_field(t, 400, "p_rad_s", "5000")), REFUSED, &[":400: `p_rad_s`", "is outside"]),
    ("time back", Text(|t| with_field(t, 900, "time_s", "0.5")), REFUSED, &[":900: `time_s`", "time must increase"]),
    ("a blank field", Text(|t| with_field(t, 300, "motor1", "")), READ, &["1 blank fields are missing values"]),
    ("a blank time", Text(|t| with_field(t, 300, "time_s", "")), REFUSED, &[":300: `time_s`", "expected a number"]),
    (
        "a line twice",
        Text(|t| {
            let line = t.lines().nth(200).unwrap();
            t.replacen(line, &format!("{line}\n{line}"), 1)
        }),
        READ,
        &["1 lines repeat the one before"],
    ),
    (
        "two rows of one time",
        Text(|t| {
            let time = t.lines().nth(200).unwrap().split(',').next().unwrap().to_owned();
            with_field(t, 202, "time_s", &time)
        }),
        REFUSED,
        &[":202: `time_s`", "time must increase"],
    ),
    (
        "rows missing here and there",
        Text(|t| {
            let is_kept = |(line, _): &(usize, &str)| line % 7 != 0 || *line < heading(t);
            t.lines().enumerate().filter(is_kept).map(|(_, line)| format!("{line}\n")).collect()
        }),
        READ,
        &["checked"],
    ),
    (
        "a value that is too long",
        Text(|t| with_field(t, 60, "q_rad_s", &"9".repeat(400))),
        REFUSED,
        &[":60: `q_rad_s`"],
    ),
    (
        "a comma for a point",
        Text(|t| with_field(t, 60, "q_rad_s", "0,25")),
        REFUSED,
        &[":60: ", "fields as in the header"],
    ),
    ("NULL", Text(|t| with_field(t, 60, "q_rad_s", "NULL")), REFUSED, &[":60: `q_rad_s`", "`NULL`"]),
    ("a quoted number", Text(|t| with_field(t, 60, "q_rad_s", "\"0.25\"")), READ, &["checked"]),
    ("thousands", Text(|t| with_field(t, 60, "motor1", "1 200")), REFUSED, &[":60: `motor1`", "`1 200`"]),
    ("a negative motor", Text(|t| with_field(t, 60, "motor1", "-0.5")), REFUSED, &[":60: `motor1`", "outside"]),
    ("a gap of 2 s", Columns(|l| l.time_s[600..].iter_mut().for_each(|t| *t += 2.0)), READ, &["1 gap(s) in time"]),
    (
        "two flights",
        Columns(|l| {
            for motor in l.motor_command.iter_mut().flatten() {
                motor[500..700].fill(0.0);
            }
        }),
        READ,
        &["flown"],
    ),
    ("a start at 1e9 s", Columns(|l| l.time_s.iter_mut().for_each(|t| *t += 1e9)), READ, &["checked"]),
];

const OF_FILES: &[Row] = &[
    ("nothing", Bytes("log.csv", |_| Vec::new()), REFUSED, &["the file is empty", "at least 100 rows"]),
    ("one byte", Bytes("log.csv", |_| b"x".to_vec()), REFUSED, &["required column is missing"]),
    ("zero bytes", Bytes("log.csv", |_| vec![0; 5000]), REFUSED, &["zero"]),
    ("zeros at the end", Bytes("log.csv", |t| [t.as_bytes(), &[0; 4096]].concat()), READ, &["may be cut off"]),
    ("a PDF", Bytes("report.pdf", |_| b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n1 0 obj\n<<>>\n".repeat(50)), REFUSED, &["PDF"]),
    ("a PNG", Bytes("plot.png", |_| b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".repeat(50)), REFUSED, &["picture"]),
    ("a ZIP", Bytes("logs.zip", |_| b"PK\x03\x04\x14\0\0\0\x08\0".repeat(50)), REFUSED, &["zip", "unpack"]),
    (
        "an Excel table",
        Bytes("log.xlsx", |_| b"PK\x03\x04\x14\0\x06\0[Content_Types].xml".repeat(50)),
        REFUSED,
        &["save it as CSV"],
    ),
    (
        "a web page",
        Bytes("log.csv", |_| b"<!DOCTYPE html>\n<html><body>404</body></html>\n".repeat(9)),
        REFUSED,
        &["web page"],
    ),
    ("JSON", Bytes("log.json", |_| b"{\"t\": [1, 2, 3]}\n".repeat(9)), REFUSED, &["JSON"]),
    (
        "a MAVLink log",
        Bytes("log.tlog", |_| {
            (0..900_u32)
                .flat_map(|k| [&k.to_be_bytes()[..], b"\0\x05\x12\x34\xfd\x09\0\0\x01\x01\x01\0\0\0"].concat())
                .collect()
        }),
        REFUSED,
        &["tlog", "telemetry"],
    ),
    ("a ROS bag", Bytes("log.bag", |_| b"#ROSBAG V2.0\nE\0\0\0\x0f\0\0\0".repeat(50)), REFUSED, &["ROS"]),
    (
        "a MATLAB file",
        Bytes("log.mat", |_| b"MATLAB 5.0 MAT-file, Platform: PCWIN64\0\x01IM".repeat(50)),
        REFUSED,
        &["MATLAB", "CSV"],
    ),
    (
        "UTF-16",
        Bytes("log.csv", |t| [0xff, 0xfe].into_iter().chain(t.encode_utf16().flat_map(u16::to_le_bytes)).collect()),
        READ,
        &["checked: rates turn"],
    ),
    ("99 rows", Text(|t| t.lines().take(heading(t) + 99).map(|l| format!("{l}\n")).collect()), REFUSED, &["99"]),
    ("half of it", Text(|t| t[..t.len() / 2].to_owned()), READ, &["may be cut off"]),
    (
        "gzip cut off",
        Bytes("log.csv.gz", |t| {
            let packed = gzip(t);
            packed[..packed.len() / 2].to_vec()
        }),
        REFUSED,
        &["gzip", "damaged or cut off"],
    ),
    ("a column gone", Text(|t| with_header(t, "q_rad_s", "turning")), REFUSED, &["`q_rad_s`", "is missing", "--map"]),
    (
        "several columns gone",
        Text(|t| t.replacen("q_rad_s", "a", 1).replacen("pitch_rad", "b", 1).replacen("motor3", "c", 1)),
        REFUSED,
        &["`pitch_rad`: required column is missing, and so are q_rad_s, motor3"],
    ),
    (
        "no header",
        Text(|t| t.lines().skip(heading(t)).map(|l| format!("{l}\n")).collect()),
        REFUSED,
        &["numbers stand where"],
    ),
    ("a column twice", Text(|t| with_header(t, "q_rad_s", "p_rad_s")), REFUSED, &["given twice"]),
    ("two units", Text(|t| with_header(t, "q_rad_s", "p_deg_s")), REFUSED, &["given twice", "`p_deg_s`"]),
    (
        "a field too few",
        Text(|t| {
            let line = t.lines().nth(99).unwrap();
            t.replacen(line, line.rsplit_once(',').unwrap().0, 1)
        }),
        REFUSED,
        &[":100:", "fields as in the header"],
    ),
    ("semicolons", Text(|t| t.replace(',', ";")), READ, &["checked"]),
    ("tabs", Text(|t| t.replace(',', "\t")), READ, &["checked"]),
    ("decimal commas", Text(|t| t.replace(',', ";").replace('.', ",")), READ, &["checked"]),
    ("commas for both", Text(|t| t.replace('.', ",")), REFUSED, &["fields as in the header"]),
    ("a byte order mark", Text(|t| format!("\u{feff}{t}")), READ, &["checked"]),
    ("CR LF", Text(|t| t.replace('\n', "\r\n")), READ, &["checked"]),
    ("CR alone", Text(|t| t.replace('\n', "\r")), READ, &["checked"]),
    ("no last line end", Text(|t| t.trim_end().to_owned()), READ, &["may be cut off"]),
    ("spaces around fields", Text(|t| t.replace(',', " , ")), READ, &["checked"]),
    ("quotes", Text(|t| with_header(t, "p_rad_s", "\"p_rad_s\"")), READ, &["checked"]),
    ("blank lines at the end", Text(|t| format!("{t}\n\n\n")), READ, &["checked"]),
    ("text behind the rows", Text(|t| format!("{t}end of log\n")), REFUSED, &["fields as in the header"]),
    ("a ULog cut off", Ulog(|b| b[..b.len() / 2].to_vec()), READ, &["cut off or damaged from byte"]),
    ("a ULog's head alone", Ulog(|b| b[..200].to_vec()), REFUSED, &["log.ulg"]),
    (
        "a ULog with zeros in it",
        Ulog(|mut b| {
            let half = b.len() / 2;
            b[half..half + 500].fill(0);
            b
        }),
        READ,
        &["checked"],
    ),
    ("a ULog named CSV", Bytes("log.csv", |_| b"ULog\x01\x12\x35\x01".repeat(30)), REFUSED, &["holds no body rates"]),
    ("a DataFlash log of nothing", Bytes("log.bin", |_| vec![0xa3, 0x95, 0x80]), REFUSED, &["log.bin"]),
    (
        "noise named bin",
        Bytes("log.bin", |_| (0..9000_u32).map(|k| (k * k % 251) as u8).collect()),
        REFUSED,
        &["log.bin"],
    ),
    (
        "a Blackbox head alone",
        Bytes("log.bbl", |_| {
            b"H Product:Blackbox flight data recorder by Nicholas Sherlock\nH Data version:2\n".to_vec()
        }),
        REFUSED,
        &["log.bbl"],
    ),
];

/// Lines up to the header, which is the last of them.
fn heading(text: &str) -> usize {
    1 + text.lines().take_while(|line| line.starts_with('#')).count()
}

fn gzip(text: &str) -> Vec<u8> {
    let folder = Folder::new();
    folder.write("log.csv", text);
    let log = sil_host::log::read(&folder.path("log.csv"), None).unwrap();
    write_file(&log, &folder.path("log.csv.gz")).unwrap();
    folder.bytes("log.csv.gz")
}

#[test]
fn each_gets_the_answer_that_its_owner_needs() {
    let good = good();
    let text = csv(&good);
    let folder = Folder::new();
    write_file(&good, &folder.path("log.ulg")).unwrap();
    let ulog = folder.bytes("log.ulg");
    let mut wrong = String::new();
    let rows: Vec<&Row> = OF_UNITS_AND_SIGNS.iter().chain(OF_READINGS).chain(OF_FILES).collect();
    for (name, case, is_read, words) in &rows {
        let (file, bytes) = match case {
            Columns(spoil) => {
                let mut log = good.clone();
                spoil(&mut log);
                ("log.csv", csv(&log).into_bytes())
            }
            Text(spoil) => ("log.csv", spoil(&text).into_bytes()),
            Bytes(file, spoil) => (*file, spoil(&text)),
            Ulog(spoil) => ("log.ulg", spoil(ulog.clone())),
        };
        let (was_read, said) = match Wanted::default().read(Path::new(file), &mut bytes.as_slice()) {
            Ok(log) => (true, log.notes.join("\n")),
            Err(error) => (false, error.to_string()),
        };
        let lacks: Vec<_> = words.iter().filter(|word| !said.contains(**word)).collect();
        if was_read != *is_read || !lacks.is_empty() {
            wrong += &format!("{name}: read: {was_read}; lacks {lacks:?}:\n    {said}\n");
        }
    }
    assert!(rows.len() >= 100, "{}", rows.len());
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn a_folder_and_no_file_are_named() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("flights")).unwrap();
    for command in ["compare", "diagnose", "identify", "map"] {
        folder.sil(&[command, "flights"]).assert_refused(&["flights", "Is a directory"]);
        folder.sil(&[command, "absent.ulg"]).assert_refused(&["absent.ulg", "No such file"]);
    }
}

/// A flight controller's log without a model is held against what it shows, by `compare` as by `diagnose`.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_foreign_log_is_compared_with_what_it_shows() {
    let folder = Folder::new();
    write_file(&good(), &folder.path("flight.ulg")).unwrap();
    folder.write("other.toml", include_str!("../../../models/crazyflie-free.toml"));
    // the diagnosis' own identification is tested in `identify`
    let outcome = folder.sil(&["compare", "flight.ulg"]).assert_done();
    assert!(outcome.stdout.contains("the vehicle was identified from this log first"), "{outcome:?}");
    for command in [&["compare", "flight.ulg"][..], &["diagnose", "flight.ulg", "--quick"]] {
        let outcome = folder.sil(&[command, &["--model", "other.toml"]].concat()).assert_done();
        assert!(outcome.stdout.starts_with("MISMATCH: roll answers to a motor's command"), "{outcome:?}");
    }
    let page = String::from_utf8(folder.bytes("out/compare.html")).unwrap();
    assert!(page.contains("MISMATCH: roll answers"), "the page says it too");
}
