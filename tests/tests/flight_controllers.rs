//! Logs in flight controllers' own formats, recorded by other people: what is read has the signs and motors of
//! docs/rig.md, and equals what other people's decoders read.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

use campaigns::real_logs::{TORQUE_SIGNS, folder};
use flate2::read::GzDecoder;
use sil_host::axis::Axis;
use sil_host::log::{Log, Map, read, read_recording, write_file};

/// A file of the real logs; none where these are absent.
fn real_log(path: &str) -> Option<PathBuf> {
    let path = folder()?.join(path);
    assert!(path.exists(), "{} is gone", path.display());
    Some(path)
}

/// Mean product of two series, each without its mean, over the root of their mean squares.
fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (mean_x, mean_y) = (mean(x), mean(y));
    let sum = |of: &dyn Fn(f64, f64) -> f64| x.iter().zip(y).map(|(x, y)| of(x - mean_x, y - mean_y)).sum::<f64>();
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}

/// ArduPilot's own outputs of the rate controllers, which no convention of ours takes: right side down, nose up and
/// nose right are positive (ArduPilot, "Onboard Message Log Messages").
const RATE_CONTROLLERS: &str = "description = \"outputs of the rate controllers\"\nframe = \"FRD\"\n\
    axes = [\"roll\", \"pitch\", \"yaw\"]\n[quantities]\ntime_ms = { column = \"TimeMS\" }\n\
    p_rad_s = { column = \"IMU.GyrX\" }\nq_rad_s = { column = \"IMU.GyrY\" }\nr_rad_s = { column = \"IMU.GyrZ\" }\n\
    roll_cmd = { column = \"RATE.ROut\", scale = 1e-4 }\npitch_cmd = { column = \"RATE.POut\", scale = 1e-4 }\n\
    yaw_cmd = { column = \"RATE.YOut\", scale = 1e-4 }\n";

#[test]
fn an_ardupilot_copters_motors_do_what_its_rate_controllers_say() {
    if let Some(path) = real_log("flight_ardupilot_log171/log171.bin.gz") {
        let log = read(&path, None).unwrap();
        assert_eq!(log.flight_controller.as_deref(), Some("ArduPilot"));
        let map = Map::parse("rate_controllers", RATE_CONTROLLERS).unwrap();
        let said = read(&path, Some(&map)).unwrap();
        let motors = log.motors().unwrap();
        let flies = |row: &usize| (0..4).all(|motor| motors[motor][*row] > 0.2);
        let place = |row: usize| said.time_s.binary_search_by(|time_s| time_s.total_cmp(&log.time_s[row])).ok();
        let pairs: Vec<(usize, usize)> =
            (0..log.rows()).filter(flies).filter_map(|row| Some((row, place(row)?))).collect();
        assert!(pairs.len() > 5000);
        for axis in Axis::ALL {
            let signs = TORQUE_SIGNS[axis.index()];
            let torques: Vec<f64> =
                pairs.iter().map(|(row, _)| (0..4).map(|motor| signs[motor] * motors[motor][*row]).sum()).collect();
            let command = said.axis_command[axis.index()].as_ref().unwrap();
            let commands: Vec<f64> = pairs.iter().map(|(_, row)| command[*row]).collect();
            let agreement = correlation(&torques, &commands);
            println!("{}: rate controller to motors {agreement:+.2}", axis.name());
            // the controllers' outputs are logged at 10 Hz and held; another order or sign is near 0 or negative
            assert!(agreement > 0.5, "{}: {agreement}", axis.name());
        }
        // sign and unit: on the whole the accelerometer shows the weight, less what vibration clips
        let down = log.accel_body_m_s2[2].as_ref().unwrap();
        let mean = down.iter().sum::<f64>() / down.len() as f64;
        assert!((-10.5..-7.5).contains(&mean), "{mean}");
    }
}

/// Other people's readings: (quantity, message) to (time, value).
type Readings = BTreeMap<(String, String), Vec<(f64, f64)>>;

fn decoded(python: &str, kind: &str, path: &Path) -> Readings {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/decoders.py");
    let output = Command::new(python).arg(script).arg(kind).arg(path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut readings = Readings::new();
    for line in String::from_utf8(output.stdout).unwrap().lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let reading = (words[2].parse().unwrap(), words[3].parse().unwrap());
        readings.entry((words[0].to_owned(), words[1].to_owned())).or_default().push(reading);
    }
    readings
}

/// Both read the same quantities, at the same times, with the same values.
fn assert_agreement(python: &str, kind: &str, path: &Path) {
    let recording = read_recording(path).unwrap().unwrap();
    let mut theirs = decoded(python, kind, path);
    let mut compared = 0;
    for stream in &recording.streams {
        for column in &stream.columns {
            let key = (column.quantity.name(), stream.name.clone());
            let decoded = theirs.remove(&key).unwrap_or_else(|| panic!("{key:?} is read by us alone"));
            assert_eq!(decoded.len(), column.value.len(), "{key:?}");
            for ((time_s, value), (their_time_s, theirs)) in
                stream.time_s.iter().zip(&column.value).zip(&decoded).map(|(ours, theirs)| (ours, *theirs))
            {
                // both compute in 64 bit: a few roundings, and angles of 1 near which an arc sine is less certain
                let is_equal =
                    (value - theirs).abs() <= 1e-7 * value.abs().max(1.0) || value.is_nan() && theirs.is_nan();
                assert!(
                    (time_s - their_time_s).abs() < 1e-9 && is_equal,
                    "{key:?}: {time_s} {value}, {their_time_s} {theirs}"
                );
                compared += 1;
            }
        }
    }
    assert!(theirs.is_empty(), "not read by us: {:?}", theirs.keys());
    println!("{}: {compared} readings agree", path.display());
}

/// A file of the real data, decompressed for decoders that know no gzip.
fn unpacked(folder: &Path, path: &Path) -> PathBuf {
    let name = path.file_stem().unwrap();
    let to = folder.join(name);
    std::io::copy(&mut GzDecoder::new(File::open(path).unwrap()), &mut File::create(&to).unwrap()).unwrap();
    to
}

/// Needs Python with pyulog and pymavlink, whose path `DECODERS_PYTHON` has: `cargo xtask decoders` sees to it.
#[test]
#[ignore = "needs pyulog and pymavlink: cargo xtask decoders"]
fn other_peoples_decoders_read_the_same() {
    let python = std::env::var("DECODERS_PYTHON").expect("DECODERS_PYTHON: a Python that has pyulog and pymavlink");
    let folder = tempfile::tempdir().unwrap();
    if let Some(path) = real_log("formats/pyulog_sample.ulg.gz") {
        assert_agreement(&python, "px4", &unpacked(folder.path(), &path));
    }
    if let Some(path) = real_log("flight_ardupilot_log171/log171.bin.gz") {
        assert_agreement(&python, "ardupilot", &unpacked(folder.path(), &path));
    }
    // and a flight that is written here
    let column = |scale: f64, phase: f64| {
        Some((0..500).map(|row| scale * (0.02 * f64::from(row) + phase).sin()).collect::<Vec<f64>>())
    };
    let log = Log {
        axes: [true; 3],
        time_s: (0..500).map(|row| 0.0025 * f64::from(row)).collect(),
        angle_rad: [column(0.5, 0.0), column(0.4, 1.0), column(3.0, 2.0)],
        rate_rad_s: [column(2.0, 0.5), column(1.0, 1.5), column(0.5, 2.5)],
        motor_command: core::array::from_fn(|motor| Some(vec![0.2 + 0.1 * motor as f64; 500])),
        reference_rad: [column(0.6, 0.0), column(0.5, 1.0), None],
        accel_body_m_s2: [column(1.0, 0.0), column(1.0, 1.0), Some(vec![-9.8; 500])],
        battery_v: Some(vec![11.1; 500]),
        velocity_ned_m_s: [column(1.0, 0.1), column(2.0, 0.2), column(3.0, 0.3)],
        height_m: Some(vec![10.0; 500]),
        ..Log::default()
    };
    let path = folder.path().join("flight.ulg");
    write_file(&log, &path).unwrap();
    assert_agreement(&python, "px4", &path);
}
