//! Maps that compute: sums of columns, and axes between the arms of a plus frame.

use sil_host::log::{Map, parse, write_file};
use sil_host::model::VehicleModel;
use sil_host::synthesis::Synthesis;

use crate::sil::{Folder, GENERIC_FREE_MODEL};

const ROWS: usize = 120;

/// Time, two rates and four motors, in nobody's names.
fn foreign() -> String {
    let row = |row: usize| {
        let time_s = 0.01 * row as f64;
        format!("{time_s},0.1,{},10,20,30,4{}\n", 0.01 * row as f64, row % 10)
    };
    "t,gx,gy,a,b,c,d\n".to_owned() + &(0..ROWS).map(row).collect::<String>()
}

fn map(quantities: &str) -> String {
    format!(
        "description = \"\"\nframe = \"FRD\"\n[quantities]\ntime_s = {{ column = \"t\" }}\n\
         p_rad_s = {{ column = \"gx\" }}\nq_deg_s = {{ column = \"gy\", scale = 2, offset = 1 }}\n{quantities}"
    )
}

const COMMANDS: &str = "roll_cmd = { columns = { a = 0.5, d = -0.25 }, scale = 0.01, offset = 0.1, sign = -1 }\n\
                        pitch_cmd = { column = \"b\", scale = 0.01 }\n";

/// Nothing is announced that is then refused.
#[test]
fn a_log_in_which_nothing_flew_is_refused_at_once() {
    let motors = ["a", "b", "c", "d"].into_iter().enumerate();
    let motors =
        motors.map(|(motor, column)| format!("motor{} = {{ column = \"{column}\", scale = 0.01 }}\n", motor + 1));
    let head = "rig = \"free\"\nactive_when = \"motor1 > 0.9\"\n[quantities]";
    let folder = Folder::new();
    folder.write("log.csv", foreign());
    folder.write("m.toml", map(&motors.collect::<String>()).replace("[quantities]", head));
    let outcome = folder.sil(&["diagnose", "log.csv", "--map", "m.toml", "--unchecked"]);
    outcome.assert_message_of_status_2(&["the motors run in none of the 120 rows"]);
    assert!(outcome.stdout.contains("no vehicle could be identified") && !outcome.stdout.contains("Instead"));
}

/// What grows by one a second, taken for a place in centimetres.
#[test]
fn how_fast_a_place_changes_is_a_velocity() {
    let text = map(&format!("{COMMANDS}vn_cm_s = {{ rate_of = \"gy\", sign = -1 }}\n"));
    let log = parse("log.csv", &foreign(), Some(&Map::parse("m.toml", &text).unwrap())).unwrap();
    let north = log.velocity_ned_m_s[0].as_ref().unwrap();
    assert!(north.iter().all(|north| (north + 0.01).abs() < 1e-9), "{north:?}");
    let offset = text.replace("\"gy\", sign = -1", "\"gy\", offset = 1");
    let refused = Map::parse("m.toml", &offset).unwrap_err().to_string();
    assert!(refused.contains("`vn_cm_s`: rate_of makes a velocity of a place, without offset"), "{refused}");
}

/// A body that is rolled by 0.4 rad in every row but one, whose quaternion is none.
#[test]
fn an_angle_is_made_of_a_quaternion() {
    let row = |row: usize| {
        let (w, x) = if row == 7 { (0.0, 0.0) } else { (f64::cos(0.2), f64::sin(0.2)) };
        format!("{},{w},{x},0,0,0.1,{},10,20,30,4{}\n", 0.01 * row as f64, 0.01 * row as f64, row % 10)
    };
    let text = "t,qw,qx,qy,qz,gx,gy,a,b,c,d\n".to_owned() + &(0..ROWS).map(row).collect::<String>();
    let of = |line: &str| Map::parse("m.toml", &map(&format!("{COMMANDS}{line}\n")));
    let angle = |line: &str, axis: usize| {
        let log = parse("log.csv", &text, Some(&of(line).unwrap())).unwrap();
        log.angle_rad[axis].clone().unwrap()
    };
    let euler = "euler_of = [\"qw\", \"qx\", \"qy\", \"qz\"]";
    let expected = |own: &[f64], rad: f64| own.iter().all(|own| (own - rad).abs() < 1e-12);
    assert!(expected(&angle(&format!("roll_rad = {{ {euler} }}"), 0), 0.4));
    assert!(expected(
        &angle(&format!("roll_deg = {{ {euler}, sign = -1, offset = 90 }}"), 0),
        std::f64::consts::FRAC_PI_2 - 0.4
    ));
    assert!(expected(&angle(&format!("pitch_rad = {{ {euler} }}"), 1), 0.0));
    // the same columns in another order: a body that is pitched, in a frame that counts it the other way
    let pitched = format!("pitch_rad = {{ {} }}", euler.replace("qx\", \"qy", "qy\", \"qx"));
    let flu = map(&format!("{COMMANDS}{pitched}\n")).replace("FRD", "FLU");
    let log = parse("log.csv", &text, Some(&Map::parse("m.toml", &flu).unwrap())).unwrap();
    assert!(expected(log.angle_rad[1].as_ref().unwrap(), -0.4));
    for (line, refused) in [
        (format!("vn_m_s = {{ {euler} }}"), "euler_of makes roll_rad, pitch_rad or yaw_rad of a quaternion"),
        (format!("roll_rad = {{ {euler}, scale = 2 }}"), "without scale"),
        (format!("roll_rad = {{ {euler}, column = \"a\" }}"), "expected column = \"NAME\""),
        ("roll_rad = { euler_of = [\"qw\", \"qx\"] }".to_owned(), "invalid length"),
    ] {
        let error = of(&line).unwrap_err().to_string();
        assert!(error.contains(refused), "{line}: {error}");
    }
    let absent = of(&format!("roll_rad = {{ {} }}", euler.replace("qz", "q4"))).unwrap();
    let error = parse("log.csv", &text, Some(&absent)).unwrap_err().to_string();
    assert!(error.contains("`q4`: column is missing, which the map m.toml takes for roll_rad"), "{error}");
}

#[test]
fn a_sum_of_columns_is_one_column() {
    let of = |quantities: &str| Map::parse("m.toml", &map(quantities));
    let log = parse("log.csv", &foreign(), Some(&of(COMMANDS).unwrap())).unwrap();
    let (roll, pitch) = (log.axis_command[0].as_ref().unwrap(), log.axis_command[1].as_ref().unwrap());
    for row in 0..ROWS {
        let d = 40.0 + (row % 10) as f64;
        assert!((roll[row] - (0.1 - 0.01 * (0.5 * 10.0 - 0.25 * d))).abs() < 1e-12, "{row}");
        assert!((pitch[row] - 0.2).abs() < 1e-12);
    }
    assert!(log.notes.iter().any(|note| note == "columns ignored: c"), "{:?}", log.notes);
    let refused = |quantities: &str, expected: &str| {
        let text = of(&COMMANDS.replace("columns = { a = 0.5, d = -0.25 }", quantities)).unwrap_err().to_string();
        assert!(text.starts_with("m.toml:7: `roll_cmd`: ") && text.contains(expected), "{text}");
    };
    refused("columns = { }", "expected column = \"NAME\", or columns =");
    refused("column = \"a\", columns = { d = 1 }", "expected column = \"NAME\", or columns =");
    refused("columns = { a = 0 }", "a finite number that is not 0");
    refused("rate_of = \"a\"", "rate_of makes a velocity of a place");
    let absent = of(&COMMANDS.replace("d = -0.25", "e = -0.25")).unwrap();
    let message = parse("log.csv", &foreign(), Some(&absent)).unwrap_err().to_string();
    assert!(
        message.contains("log.csv:1: `e`: column is missing, which the map m.toml takes for roll_cmd"),
        "{message}"
    );
    // where one part is blank there is no sum, and where the sum is out of range it is named
    let blank = foreign().replacen(",10,20,30,43\n", ",,20,30,43\n", 1);
    let log = parse("log.csv", &blank, Some(&of(COMMANDS).unwrap())).unwrap();
    assert!(log.notes.iter().any(|note| note.contains("1 blank fields")), "{:?}", log.notes);
    let wide = foreign().replacen(",10,20,30,43\n", ",1000,20,30,43\n", 1);
    let message = parse("log.csv", &wide, Some(&of(COMMANDS).unwrap())).unwrap_err().to_string();
    assert!(message.contains("log.csv:5: `a + d`: -4.7925 is outside"), "{message}");
}

/// The log of an X, as a plus would have written it: its axes along two of the arms.
#[test]
fn a_plus_is_recognised_and_read_as_an_x() {
    let folder = Folder::new();
    folder.write("free.toml", GENERIC_FREE_MODEL);
    let model = VehicleModel::parse(GENERIC_FREE_MODEL, "free.toml").unwrap();
    let x = Synthesis { seed: 1, duration_s: 12.0, ..Synthesis::of(model) }.log().unwrap();
    let plus = x.clone().turned(-45.0).unwrap();
    write_file(&x, &folder.path("x.csv")).unwrap();
    write_file(&plus, &folder.path("plus.csv")).unwrap();
    let said = ["--frame-turn 45", "frame_turn_deg = 45", "plus frame", "sil map plus.csv"];
    folder.sil(&["diagnose", "plus.csv"]).assert_refused(&said);
    folder.sil(&["map", "plus.csv", "--out", "plus.toml"]).assert_done();
    let drafted = String::from_utf8(folder.bytes("plus.toml")).unwrap();
    assert!(drafted.contains("\nframe_turn_deg = 45 "), "{drafted}");
    let errors = |log: &str, how: &[&str]| {
        let model = ["--model", "free.toml", "--json", "out.json"];
        let outcome = folder.sil(&[&["compare", log], how, &model].concat()).assert_done();
        let json = folder.json("out.json");
        let of = |name: &str| json["prediction_error"]["nominal"][name].as_f64().unwrap();
        (["roll_deg", "pitch_deg", "p_deg_s", "q_deg_s"].map(of), outcome.stdout)
    };
    let (expected, _) = errors("x.csv", &[]);
    for how in [&["--frame-turn", "45"][..], &["--map", "plus.toml", "--rig", "free"]] {
        let (turned, said) = errors("plus.csv", how);
        assert!(said.contains("body axes turned by 45 degrees about yaw"), "{said}");
        for (turned, expected) in turned.iter().zip(expected) {
            // turned and turned back in doubles
            assert!((turned / expected - 1.0).abs() < 1e-6, "{turned} {expected}");
        }
    }
    folder.sil(&["compare", "plus.csv", "--frame-turn", "400"]).assert_refused(&["--frame-turn 400: expected"]);
}
