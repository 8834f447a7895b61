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
