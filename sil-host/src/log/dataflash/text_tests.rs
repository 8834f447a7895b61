//! Texts written here as boards, Mission Planner and mavlogdump write them, and what they are read as.

use std::path::Path;

use super::super::{FactValue, Log, parse_bytes};

const LABELS: [(&str, &str, &str); 4] = [
    ("ATT", "IccccCC", "TimeMS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    ("IMU", "Iffffff", "TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    ("RCOU", "Ihhhh", "TimeMS,Chan1,Chan2,Chan3,Chan4"),
    ("MODE", "Mh", "Mode,ThrCrs"),
];

/// The messages of a flight of 300 rows of 10 ms: kind, and the fields as they are printed.
fn rows() -> Vec<(&'static str, String)> {
    let row = |row: usize| {
        let ms = 1000 + 10 * row;
        let roll_deg = 0.1 * row as f64;
        [
            ("ATT", format!("{ms}, 0.00, {roll_deg:.2}, 0.00, -1.50, 189.54, 359.00")),
            ("IMU", format!("{ms}, 0.25, 3.118068E-05, -0.5, 0.1, -0.2, -9.80665")),
            ("RCOU", format!("{ms}, 1200, 1400, 1600, 1800")),
        ]
    };
    std::iter::once(("MODE", "Stabilize, 450".to_owned())).chain((0..300).flat_map(row)).collect()
}

fn parameters() -> [(&'static str, &'static str); 3] {
    [("FRAME", "1"), ("RC3_MIN", "1000.000"), ("RC3_MAX", "2000.000000")]
}

/// As old boards and Mission Planner write it.
fn separated() -> String {
    let mut text = "9\n\nArduCopter V3.1 (5c6503e2)\nFree RAM: 1044\n".to_owned();
    text += "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format\nFMT, 129, 23, PARM, Nf, Name,Value\n";
    for (name, format, labels) in LABELS {
        text += &format!("FMT, 1, 19, {name}, {format}, {labels}\n");
    }
    parameters().iter().for_each(|(name, value)| text += &format!("PARM, {name}, {value}\n"));
    rows().iter().for_each(|(kind, fields)| text += &format!("{kind}, {fields}\n"));
    text
}

/// As mavlogdump prints it.
fn printed() -> String {
    let stamp = "2014-03-01 10:00:00.00: ";
    let mut text = format!("{stamp}FMT {{Type : 128, Length : 89, Name : FMT, Format : BBnNZ, Columns : A,B}}\n");
    text += &format!("{stamp}MSG {{Message : ArduCopter V3.1, of a test}}\n");
    for (name, value) in parameters() {
        text += &format!("{stamp}PARM {{Name : {name}, Value : {value}}}\n");
    }
    for (kind, fields) in rows() {
        let (_, _, labels) = LABELS.into_iter().find(|(name, _, _)| *name == kind).unwrap();
        let pairs: Vec<String> =
            labels.split(',').zip(fields.split(", ")).map(|(label, value)| format!("{label} : {value}")).collect();
        text += &format!("{stamp}{kind} {{{}}}\n", pairs.join(", "));
    }
    text
}

fn read(text: String) -> Result<Log, String> {
    parse_bytes(Path::new("x.log"), text.into_bytes(), None).map_err(|error| error.to_string())
}

#[test]
fn a_text_log_is_read_as_the_binary_one_would_be() {
    for text in [separated(), printed()] {
        let log = read(text).unwrap();
        assert_eq!(log.flight_controller.as_deref(), Some("ArduPilot"));
        assert!(log.rows() == 300 && (log.duration_s() - 2.99).abs() < 1e-9, "{}", log.duration_s());
        assert_eq!(log.motors().unwrap().map(|motor| motor[9]), [0.2, 0.4, 0.6, 0.8]);
        assert_eq!(log.rate_rad_s.each_ref().map(|rate| rate.as_ref().unwrap()[9]), [0.25, 3.118068e-5, -0.5]);
        let angle_deg = log.angle_rad.each_ref().map(|angle| angle.as_ref().unwrap()[9].to_degrees());
        for (angle, said) in angle_deg.into_iter().zip([0.9, -1.5, -1.0]) {
            assert!((angle - said).abs() < 1e-9, "{angle_deg:?}");
        }
        let firmware = log.facts.iter().find(|fact| fact.name == "firmware").unwrap();
        assert!(matches!(&firmware.value, FactValue::Text(text) if text.starts_with("ArduCopter V3.1")));
        assert!(!log.notes.iter().any(|note| note.contains("damaged")), "{:?}", log.notes);
    }
}

#[test]
fn damaged_lines_are_left_out_and_counted() {
    for (text, sound, spoiled) in [
        (separated(), "IMU, 1500, 0.25, 3.118068E-05", "IMU, 1500, 0.25, ATT"),
        (separated(), "RCOU, 1500, 1200, 1400, 1600, 1800", "RCOU, 1500, 1200"),
        (printed(), "TimeMS : 1500, GyrX : 0.25", "TimeMS : 1500, GyrX : 0.2.5"),
    ] {
        assert!(text.contains(sound));
        let cut = text.replace(sound, spoiled);
        // and the last line's end
        let log = read(cut.trim_end().to_owned()).unwrap();
        assert!(log.notes.contains(&"2 lines are damaged or cut off, and left out".to_owned()), "{:?}", log.notes);
    }
}

#[test]
fn what_was_not_logged_is_said_and_what_logs_it() {
    let without = |kind: &str| {
        let kept = separated();
        kept.lines().filter(|line| !line.starts_with(kind)).fold(String::new(), |text, line| text + line + "\n")
    };
    let said = read(without("RCOU")).unwrap_err();
    assert!(said.contains("no messages RCOU (motors): the parameter LOG_BITMASK"), "{said}");
    // rates or angles alone will do
    assert!(read(without("IMU")).unwrap().rate_rad_s[0].is_none());
    let untimed = separated().replace("TimeMS,DesRoll", "RollIn,DesRoll");
    assert!(read(untimed).unwrap_err().contains("its messages ATT carry no times"));
}

#[test]
fn a_table_whose_cells_speak_of_formats_is_none() {
    let mut table = "time_s,roll_rad,pitch_rad,p_rad_s,q_rad_s,motor1,motor2,motor3,motor4,note\n".to_owned();
    for row in 0..200 {
        table += &format!("{:.2},0,0,0,0,0.5,0.5,0.5,0.5,FMT\n", 0.01 * f64::from(row));
    }
    assert_eq!(read(table).unwrap().flight_controller, None);
}
