//! The gate of logs on real vehicles' logs: it refuses none of them, and refuses nearly all of their spoiled copies.

use campaigns::real_logs::folder;
use campaigns::real_logs::{files, load};
use sil_host::log::flown::Flown;
use sil_host::log::sanity::examine;
use sil_host::log::{Map, read};

/// The logs of each folder whose name starts so, and the map that they are read by.
const LOGS: [(&str, &str, &str); 10] = [
    ("rig_antx_2dof", "Lab", "antx"),
    ("flight_crazyflie_arplab", "log1", "crazyflie_arplab"),
    ("flight_crazypad", "controller_data", "crazypad_controller"),
    ("flight_crazypad", "motor_data", "crazypad_motor"),
    ("rig_sharif_3dof", "cl_3dof", "sharif"),
    ("rig_sharif_3dof", "ol_3dof", "sharif"),
    ("rig_sharif_3dof", "cl_rollpitch", "sharif_roll_pitch"),
    ("rig_sharif_3dof", "ol_rollpitch", "sharif_roll_pitch"),
    ("rig_sharif_3dof", "cl_pitch", "sharif_pitch"),
    ("rig_sharif_3dof", "ol_yaw", "sharif_yaw"),
];

#[test]
fn no_real_log_is_refused() {
    let mut refused = Vec::new();
    for (folder, start, map) in LOGS {
        let meaning = Map::load(map).unwrap();
        for path in files(folder, start) {
            let log = load(&path, map);
            let found = examine(&log, Some(&meaning));
            println!("{}: {:?}", path.file_name().unwrap().to_string_lossy(), found.confirmed);
            for c in &found.contradictions {
                println!("    {c}");
                refused.push(format!("{}: {c}", path.display()));
            }
        }
    }
    if let Some(data) = folder() {
        for name in ["flight_ardupilot_log171/log171.bin.gz", "formats/pyulog_sample.ulg.gz"] {
            match read(&data.join(name), None) {
                Ok(log) => {
                    let found = examine(&log, None);
                    println!("{name}: {:?} {:?}", found.confirmed, found.contradictions);
                    refused.extend(found.contradictions.iter().map(|c| format!("{name}: {c}")));
                }
                Err(e) => println!("{name}: {e}"),
            }
        }
    }
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

#[test]
fn what_flew_of_real_logs() {
    for (folder, start, map) in LOGS {
        for path in files(folder, start) {
            let log = load(&path, map);
            let flown = Flown::of(&log);
            let part = flown.part(&log, None).unwrap();
            println!("{}: {}", path.file_name().unwrap().to_string_lossy(), part.notes[0]);
            for note in &flown.notes {
                println!("    {note}");
            }
            // the data's own pages: CrazyPAD flies twice, motors off from 11.5 to 16.5 s, and is on its way up from 3.3
            // and from 17.2 s on; the stand's motors obey from 5 s to the end, where half a second is taken for a
            // take-off; the Crazyflie flies from 16 to 51 s in log15
            let [first, last] = [flown.flights[0].from_s, flown.flights[flown.flights.len() - 1].to_s];
            let name = path.display();
            match folder {
                "flight_crazypad" => {
                    assert!(flown.flights.len() == 2 && first > 3.4 && last > 24.0, "{name}: {flown:?}");
                    assert!(flown.flights[0].to_s < 11.7 && flown.flights[1].from_s > 17.3, "{name}: {flown:?}");
                }
                "rig_sharif_3dof" if !name.to_string().contains("mimo_b") => {
                    let end_s = log.time_s[log.rows() - 1];
                    assert!(first < 5.9 && last == end_s && flown.flights.len() == 1, "{name}: {flown:?}");
                }
                _ if start == "log1" => assert!(first < 16.0 && last > 30.0, "{name}: {flown:?}"),
                _ => (),
            }
            let found = examine(&part, None);
            assert!(found.contradictions.is_empty(), "{}: {:?}", path.display(), found.contradictions);
        }
    }
    if let Some(data) = folder() {
        for name in ["flight_ardupilot_log171/log171.bin.gz", "formats/pyulog_sample.ulg.gz"] {
            let log = read(&data.join(name), None).unwrap();
            let part = Flown::of(&log).part(&log, None).unwrap();
            println!("{name}: {:?}", part.notes);
            let found = examine(&part, None);
            assert!(found.contradictions.is_empty(), "{name}: {:?}", found.contradictions);
        }
    }
}
