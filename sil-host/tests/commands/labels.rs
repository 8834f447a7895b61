//! Logs whose columns are not what they say, as a person gives them to `sil`: each is refused with what it likely is
//! and the line of a map that mends it. And the draft of a map, and what is said of the part that flew.

use crate::sil::{Folder, RIG_LOG};

/// The rig's log with other fields: each row's fields, after their columns' names, as a new row.
fn rewritten(header: impl Fn(&mut Vec<String>), row: impl Fn(&mut Vec<f64>, &dyn Fn(&str) -> usize)) -> String {
    let mut lines = RIG_LOG.lines().filter(|line| !line.starts_with('#'));
    let mut names: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let old = names.clone();
    let place = |name: &str| old.iter().position(|here| here == name).unwrap_or_else(|| panic!("no {name}"));
    header(&mut names);
    let mut text = names.join(",") + "\n";
    for line in lines {
        let mut fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        row(&mut fields, &place);
        text += &(fields.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

type Row = fn(&mut Vec<f64>, &dyn Fn(&str) -> usize);

/// What was done to the log, and what a person needs to be told.
const MISLABELLED: [(&str, Row, &[&str]); 14] = [
    (
        "rates in deg/s",
        |f, at| {
            f[at("p_rad_s")] *= 57.3;
            f[at("q_rad_s")] *= 57.3
        },
        &["deg/s", "q_deg_s = {"],
    ),
    ("q in deg/s", |f, at| f[at("q_rad_s")] *= 57.3, &["deg/s", "q_deg_s = { column = \"q_rad_s\" }"]),
    ("q turned", |f, at| f[at("q_rad_s")] *= -1.0, &["turned", "q_rad_s = { column = \"q_rad_s\", sign = -1 }"]),
    ("p turned", |f, at| f[at("p_rad_s")] *= -1.0, &["turned", "p_rad_s = { column = \"p_rad_s\", sign = -1 }"]),
    ("roll turned", |f, at| f[at("roll_rad")] *= -1.0, &["roll_rad = { column = \"roll_rad\", sign = -1 }"]),
    ("pitch turned", |f, at| f[at("pitch_rad")] *= -1.0, &["pitch_rad = { column = \"pitch_rad\", sign = -1 }"]),
    ("p, q swapped", |f, at| f.swap(at("p_rad_s"), at("q_rad_s")), &["swapped", "column = \"q_rad_s\""]),
    ("angles swapped", |f, at| f.swap(at("roll_rad"), at("pitch_rad")), &["swapped"]),
    ("motors 1, 2", |f, at| f.swap(at("motor1"), at("motor2")), &["order", "motor1 = { column = \"motor2\" }"]),
    ("motors 1, 4", |f, at| f.swap(at("motor1"), at("motor4")), &["order", "motor4 = { column = \"motor1\" }"]),
    ("motors 2, 3", |f, at| f.swap(at("motor2"), at("motor3")), &["order", "motor2 = { column = \"motor3\" }"]),
    ("q of 0", |f, at| f[at("q_rad_s")] = 0.0, &["`q_rad_s` stays at 0", "leave the column out"]),
    ("time in ms", |f, at| f[at("time_s")] *= 1e3, &["time_ms = { column = \"time_s\" }"]),
    ("time in us", |f, at| f[at("time_s")] *= 1e6, &["time_us = { column = \"time_s\" }"]),
];

#[test]
fn that_are_wrong_are_refused_with_the_line_that_mends_them() {
    let folder = Folder::new();
    for (name, row, said) in MISLABELLED {
        folder.write("log.csv", rewritten(|_| (), row));
        println!("{name}");
        for command in ["diagnose", "compare"] {
            folder.sil(&[command, "log.csv"]).assert_refused(&[&["log.csv", "sil map log.csv"], said].concat());
        }
    }
}

#[test]
fn of_a_good_log_are_confirmed_and_what_flew_is_said() {
    let folder = Folder::new();
    folder.write("log.csv", RIG_LOG);
    let outcome = folder.sil(&["compare", "log.csv"]).assert_done();
    assert!(outcome.stdout.contains("flown: the whole log"), "{outcome:?}");
    assert!(outcome.stdout.contains("checked: rates turn the angles of roll, pitch"), "{outcome:?}");
    folder.sil(&["compare", "log.csv", "--flight", "2"]).assert_refused(&["log.csv: --flight 2", "no such flight"]);
    folder.sil(&["compare", "log.csv", "--flight", "1", "--whole"]).assert_refused(&["--flight", "--whole"]);
    assert!(folder.sil(&["compare", "log.csv", "--whole"]).assert_done().stdout.contains("checked"));
}

/// Names of nobody's, degrees, a turned rate, motors in another order: the draft is used as it is.
#[test]
fn are_drafted_as_a_map_that_is_used_as_it_is() {
    let folder = Folder::new();
    let rename = |names: &mut Vec<String>| {
        for name in names {
            *name = match name.as_str() {
                "time_s" => "timestamp_s".to_owned(),
                "roll_rad" => "Roll".to_owned(),
                "pitch_rad" => "Pitch".to_owned(),
                "p_rad_s" => "gyro_x".to_owned(),
                "q_rad_s" => "gyro_y".to_owned(),
                "motor1" => "m2".to_owned(),
                "motor2" => "m1".to_owned(),
                other => other.to_owned(),
            }
        }
    };
    let spoil: Row = |fields, at| {
        fields[at("roll_rad")] *= 57.295_779_5;
        fields[at("pitch_rad")] *= 57.295_779_5;
        fields[at("q_rad_s")] *= -1.0;
    };
    folder.write("log.csv", rewritten(rename, spoil));
    folder.sil(&["diagnose", "log.csv"]).assert_refused(&["required column is missing, and so are", "pitch_rad"]);
    folder.sil(&["map", "log.csv", "--out", "log.toml"]).assert_done();
    let map = String::from_utf8(folder.bytes("log.toml").to_vec()).unwrap();
    let line = |start: &str| map.lines().any(|line| line.starts_with(start));
    assert!(line("roll_deg = { column = \"Roll\" }") && line("pitch_deg = { column = \"Pitch\" }"), "{map}");
    assert!(line("q_rad_s = { column = \"gyro_y\", sign = -1 }") && line("p_rad_s = { column = \"gyro_x\" }"), "{map}");
    assert!(line("motor1 = { column = \"m2\" }") && line("motor2 = { column = \"m1\" }"), "{map}");
    folder.sil(&["compare", "log.csv", "--map", "log.toml", "--rig", "gimbal"]).assert_done();
}

#[test]
fn that_say_nothing_are_no_map() {
    let folder = Folder::new();
    folder.write("log.csv", "time,speed_of_wind\n".to_owned() + &"1,2\n2,3\n".repeat(100));
    folder.sil(&["map", "log.csv", "--out", "out.toml"]).assert_message_of_status_2(&[
        "can't be used",
        "body rates",
        "commands are missing",
    ]);
    folder.sil(&["map", "none.csv"]).assert_refused(&["none.csv", "can't be opened"]);
}
