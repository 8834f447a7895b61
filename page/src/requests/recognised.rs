//! What a log is, before anything is searched in it: rows, rate, flights, what its file says of the vehicle, and what
//! the gate that refuses mislabelled logs has found.

use serde::Deserialize;
use serde_json::json;
use sil_host::log::Log;

use super::Answer;
use super::options::{NotRead, Options, Read};

/// One log: the only file of the call.
#[derive(Deserialize)]
pub(super) struct Recognise {
    name: String,
    #[serde(default)]
    options: Options,
}

impl Recognise {
    /// The log in lines; of one that can't be read the terminal's message, with the draft of a map where that may help.
    pub(super) fn answer(&self, files: &[Vec<u8>]) -> Answer {
        let bytes = files.first().map(Vec::as_slice).unwrap_or_default();
        Ok(match self.options.read(&self.name, bytes) {
            Ok(Read { log, drafted }) => json!({
                "format": format(&log, drafted.is_some()),
                "rows": log.rows(),
                "duration_s": log.duration_s(),
                "rate_hz": log.rate_hz(),
                "has": columns(&log),
                "reached": reached(&log),
                "comments": log.comments,
                "notes": log.notes,
                "facts": log.facts.iter().map(ToString::to_string).collect::<Vec<_>>(),
                "map": drafted.map(|draft| draft.toml),
            }),
            Err(NotRead { message, draft }) => json!({ "problem": message, "map": draft.map(|draft| draft.toml) }),
        })
    }
}

fn format(log: &Log, is_drafted: bool) -> String {
    match (&log.flight_controller, is_drafted) {
        (Some(flight_controller), _) => format!("the log of a flight controller: {flight_controller}"),
        (None, true) => "a table with columns of its own, read by a map that was drafted for it".to_owned(),
        (None, false) => "a table".to_owned(),
    }
}

/// How far the flight went, in the figures by which people know it.
fn reached(log: &Log) -> Vec<String> {
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let mut said = Vec::new();
    if let [Some(roll), Some(pitch), _] = &log.angle_rad {
        let tilt_rad = |(roll, pitch): (&f64, &f64)| (roll.cos() * pitch.cos()).clamp(-1.0, 1.0).acos();
        let tilt_rad = most(&mut roll.iter().zip(pitch).map(tilt_rad));
        said.push(format!("tilt of {:.0} degrees", tilt_rad.to_degrees()));
    }
    let rates = log.rate_rad_s.iter().flatten().flatten().map(|rate_rad_s| rate_rad_s.abs());
    said.push(format!("rate of {:.0} deg/s", most(&mut rates.into_iter()).to_degrees()));
    if log.velocity_ned_m_s.iter().any(Option::is_some) {
        let square = |row: usize| log.velocity_ned_m_s.iter().flatten().map(|column| column[row].powi(2)).sum::<f64>();
        let speed_m_s = most(&mut (0..log.rows()).map(square)).sqrt();
        said.push(format!("speed of {speed_m_s:.1} m/s"));
    }
    if let Some((first, last)) = log.battery_v.as_ref().and_then(|volts| Some((volts.first()?, volts.last()?))) {
        said.push(format!("battery from {first:.1} to {last:.1} V"));
    }
    said
}

/// Which quantities it has.
fn columns(log: &Log) -> Vec<&'static str> {
    let any = |columns: &[Option<Vec<f64>>]| columns.iter().any(Option::is_some);
    let all = [
        ("angles", any(&log.angle_rad)),
        ("rates", any(&log.rate_rad_s)),
        ("motor commands", log.motors().is_some()),
        ("axis commands", any(&log.axis_command)),
        ("references", any(&log.reference_rad)),
        ("specific force", any(&log.accel_body_m_s2)),
        ("velocity", any(&log.velocity_ned_m_s)),
        ("height", log.height_m.is_some()),
        ("rotor speeds", any(&log.rotor_speed_rpm)),
        ("battery voltage", log.battery_v.is_some()),
    ];
    all.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name).collect()
}
