//! `sil identify`, and what a diagnosis without a model does with a foreign log.

use sil_host::sensors::random::RandomStream;

use crate::sil::{Folder, GENERIC_FREE_MODEL};

/// A free flight of the quick model, as somebody else would log it.
fn foreign_flight(folder: &Folder) {
    folder.write("free.toml", GENERIC_FREE_MODEL);
    let flown = ["synth", "--model", "free.toml", "--duration", "8", "--rate", "100", "--blind", "flight.csv"];
    folder.sil(&flown).assert_done();
    let text = String::from_utf8(folder.bytes("flight.csv")).unwrap();
    // other names, and no word of where it comes from
    let text: String = text.lines().filter(|line| !line.starts_with('#')).map(|line| format!("{line}\n")).collect();
    folder.write("foreign.csv", text.replacen("p_rad_s", "gyro_x", 1));
    folder.write(
        "foreign.toml",
        "description = \"somebody's\"\nframe = \"FRD\"\naxes = [\"roll\", \"pitch\", \"yaw\"]\n[quantities]\n\
         time_s = { column = \"time_s\" }\np_rad_s = { column = \"gyro_x\" }\nq_rad_s = { column = \"q_rad_s\" }\n\
         r_rad_s = { column = \"r_rad_s\" }\nroll_rad = { column = \"roll_rad\" }\n\
         pitch_rad = { column = \"pitch_rad\" }\nyaw_rad = { column = \"yaw_rad\" }\n\
         motor1 = { column = \"motor1\" }\nmotor2 = { column = \"motor2\" }\nmotor3 = { column = \"motor3\" }\n\
         motor4 = { column = \"motor4\" }\nax_m_s2 = { column = \"ax_m_s2\" }\nay_m_s2 = { column = \"ay_m_s2\" }\n\
         az_m_s2 = { column = \"az_m_s2\" }\n",
    );
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_foreign_flight_is_identified_and_its_model_serves_the_other_commands() {
    let folder = Folder::new();
    foreign_flight(&folder);
    let map = ["foreign.csv", "--map", "foreign.toml"];
    let identified = folder.sil(&[&["identify"], &map[..], &["-o", "vehicle.toml"]].concat()).assert_done().stdout;
    assert!(identified.contains("motor_lag_s") && identified.contains("95 % interval"), "{identified}");
    let toml = String::from_utf8(folder.bytes("vehicle.toml")).unwrap();
    assert!(toml.contains("NOT KNOWN") && toml.contains("rig = \"free\""), "{toml}");
    let compared = folder.sil(&[&["compare"], &map[..], &["--model", "vehicle.toml"]].concat()).assert_done().stdout;
    assert!(compared.contains("identified from foreign.csv"), "{compared}");
    // what this flight does not show, the reaction torque of yaw, a board does not take; the model is told all the same
    let known = ["--known", "mass_kg=1.2", "--known", "arm_m=0.226", "--params", "vehicle.params"];
    let refused = folder.sil(&[&["identify"], &map[..], &known[..]].concat());
    refused.assert_message_of_status_2(&["--params", "board", "do not show"]);
    assert!(refused.stdout.contains("mass_kg = 1.2"), "{refused:?}");
    let bench = ["identify", "flight.csv", "--rig", "axis", "--params", "no.params"];
    folder.sil(&bench).assert_refused(&["--params", "separate axes"]);
    // without a model the diagnosis identifies first, and says so first
    let told = folder.sil(&[&["diagnose", "--quick"], &map[..]].concat()).assert_done().stdout;
    assert!(told.starts_with("No --model: the vehicle was identified from this log first"), "{told}");
    // another vehicle's model is a mismatch, and that is said first
    folder.write("crazyflie.toml", include_str!("../../../models/crazyflie-free.toml"));
    let other = [&["compare"], &map[..], &["--model", "crazyflie.toml"]].concat();
    let told = folder.sil(&other).assert_done().stdout;
    assert!(told.starts_with("MISMATCH: ") || told.contains("answers to a motor's command"), "{told}");
    let gimbal = [&["diagnose", "--quick"], &map[..], &["--rig", "gimbal"]].concat();
    let told = folder.sil(&gimbal).assert_done().stdout;
    assert!(told.starts_with("MISMATCH: the log is of a free flight (by its accelerometer"), "{told}");
}

/// 40 s of four motors that hold a vehicle against a moment of 15 rad/s^2 about roll, which is remembered for 0.3 s,
/// and of a hundredth of that about pitch. Commands turn it at 300 rad/s^2, 20 ms late.
fn flight_in_its_own_wake(folder: &Folder) {
    let mut random = RandomStream::new(3, "wake");
    let names = "time_s,roll_rad,pitch_rad,p_rad_s,q_rad_s,motor1,motor2,motor3,motor4";
    let mut text = format!("# free flight\n{names}\n");
    let [mut angle, mut rate, mut integral, mut wake, mut followed, mut wanted] = [[0.0f64; 2]; 6];
    for row in 0..8000 {
        if row % 100 == 0 {
            wanted = [0.7 * random.normal(), 0.035 * random.normal()];
        }
        let [p, q] = rate.map(|rate| rate + 2e-3 * random.normal());
        let [phi, theta] = angle.map(|angle| angle + 5e-4 * random.normal());
        let mut command = [0.0; 2];
        for (axis, seen) in [p, q].into_iter().enumerate() {
            let error = wanted[axis] - 2.0 * angle[axis] - seen;
            integral[axis] += 0.005 * error;
            command[axis] = ((14.0 * error + 60.0 * integral[axis]) / 300.0).clamp(-0.45, 0.45);
        }
        let [roll, pitch] = command;
        let [a, b, c, d] = [-roll + pitch, roll - pitch, roll + pitch, -roll - pitch].map(|of| 0.5 + 0.5 * of);
        let time_s = f64::from(row) * 0.005;
        text += &format!("{time_s:.3},{phi:.6},{theta:.6},{p:.6},{q:.6},{a:.6},{b:.6},{c:.6},{d:.6}\n");
        for _ in 0..20 {
            for axis in 0..2 {
                let kick = [15.0, 0.15][axis] * (2.0f64 * 2.5e-4 / 0.3).sqrt() * random.normal();
                wake[axis] += kick - 2.5e-4 / 0.3 * wake[axis];
                followed[axis] += 2.5e-4 / 0.02 * (command[axis] - followed[axis]);
                rate[axis] += 2.5e-4 * (300.0 * followed[axis] + wake[axis]);
                angle[axis] += 2.5e-4 * rate[axis];
            }
        }
    }
    folder.write("wake.csv", text);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_flight_in_its_own_wake_gives_its_axes() {
    let folder = Folder::new();
    flight_in_its_own_wake(&folder);
    folder.sil(&["identify", "wake.csv", "-o", "axes.toml", "--json", "axes.json"]).assert_done();
    let toml = String::from_utf8(folder.bytes("axes.toml")).unwrap();
    assert!(toml.starts_with("# no vehicle could be identified: ") && toml.contains("rig = \"axis\""), "{toml}");
    let answer = folder.json("axes.json");
    for name in ["roll_input_gain", "pitch_input_gain"] {
        let number = answer["numbers"].as_array().unwrap().iter().find(|number| number["name"] == name).unwrap();
        let [value, std] = ["value", "std"].map(|of| number["own"][of].as_f64().unwrap());
        // a fit that takes the disturbance for white has less than 200; how right intervals are is tested in `holding`
        assert!((value - 300.0).abs() < 75.0 && std < 60.0, "{number}");
    }
    // what only a vehicle has is refused, with the reason
    folder.sil(&["identify", "wake.csv", "--known", "mass_kg=1"]).assert_refused(&["wake.csv", "Wanted"]);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn axes_are_identified_where_no_vehicle_can_be() {
    let folder = Folder::new();
    folder.sil(&["synth", "--duration", "12", "rig.csv"]).assert_done();
    folder.sil(&["identify", "rig.csv", "--rig", "axis", "-o", "bench.toml"]).assert_done();
    let toml = String::from_utf8(folder.bytes("bench.toml")).unwrap();
    assert!(toml.contains("rig = \"axis\"") && toml.contains("gain_rad_s2"), "{toml}");
    let compared = folder.sil(&["compare", "rig.csv", "--model", "bench.toml"]).assert_done().stdout;
    assert!(compared.contains("The bench \"identified from rig.csv\""), "{compared}");
    folder.sil(&["diagnose", "rig.csv", "--quick", "--model", "bench.toml"]).assert_done();
    folder.sil(&["diagnose", "rig.csv", "--model", "bench.toml", "--rig", "free"]).assert_refused(&["rig axis"]);
}

#[test]
fn what_identify_cannot_use_is_refused() {
    let folder = Folder::new();
    folder.sil(&["synth", "--duration", "6", "rig.csv"]).assert_done();
    for (more, expected) in [
        (&["--model", "x.toml"][..], "leave out --model"),
        (&["--rig", "gimbal"], "--rig gimbal"),
        (&["--rig", "free", "--known", "mass=1"], "expected mass_kg=VALUE"),
        (&["--rig", "free", "--known", "mass_kg=-1"], "above 0"),
        (&["--rig", "axis", "--known", "mass_kg=1"], "neither mass nor arm"),
    ] {
        folder.sil(&[&["identify", "rig.csv"], more].concat()).assert_refused(&[expected]);
    }
}
