//! A vehicle on a serial port: what came from it goes in, what is to be sent and shown comes out. The port is the
//! page's, the station on this end of the link is the library's.

use std::cell::RefCell;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde_json::{Value, json};
use sil_host::ground_station::{GroundStation, LogEntry, Vehicle};

use super::Answer;

thread_local! {
    /// Between one call and the next: one port is open at a time.
    static STATION: RefCell<GroundStation> = RefCell::default();
}

/// The only file of the call holds the bytes that came.
#[derive(Deserialize)]
pub(super) struct Board {
    /// Time since whenever, ms.
    at_ms: f64,
    #[serde(default)]
    want: Want,
}

/// What the person wants of the vehicle from now on.
#[derive(Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Want {
    /// What was wanted before.
    #[default]
    Same,
    /// A port was opened.
    Anew,
    /// The list of its logs.
    List,
    /// One of them.
    Log(u16),
    /// No log any more.
    Nothing,
}

impl Board {
    /// What is to be sent and shown.
    pub(super) fn answer(&self, files: &[Vec<u8>]) -> Answer {
        let bytes = files.first().map(Vec::as_slice).unwrap_or_default();
        STATION.with_borrow_mut(|station| self.with(station, bytes))
    }

    fn with(&self, station: &mut GroundStation, bytes: &[u8]) -> Answer {
        let now_ms = self.at_ms.max(0.0) as u64;
        match self.want {
            Want::Same => {}
            Want::Anew => *station = GroundStation::default(),
            Want::List => station.list_logs(),
            Want::Log(id) => station.fetch(id, now_ms)?,
            Want::Nothing => station.give_up(),
        }
        station.take(bytes, now_ms);
        let fetched = station.fetched();
        let mut send = station.send(now_ms);
        let fetched = fetched.map(|(entry, bytes, end)| {
            send.extend(end);
            json!({ "log": log(&entry), "bytes": STANDARD.encode(bytes) })
        });
        Ok(json!({
            "send": STANDARD.encode(send),
            "vehicle": station.vehicle(now_ms).map(vehicle),
            "words": station.words().collect::<Vec<_>>(),
            "logs": station.logs().map(|logs| logs.iter().map(log).collect::<Vec<_>>()),
            "fetching": station.fetching().map(|fetch| json!({
                "id": fetch.entry().id,
                "share": fetch.share(),
                "bytes_per_s": fetch.rate(now_ms),
                "silent": fetch.is_silent(now_ms),
            })),
            "fetched": fetched,
        }))
    }
}

fn vehicle(vehicle: &Vehicle) -> Value {
    let (system, _) = vehicle.id;
    json!({ "system": system, "armed": vehicle.is_armed, "attitude_rad": vehicle.attitude_rad })
}

fn log(entry: &LogEntry) -> Value {
    json!({ "id": entry.id, "bytes": entry.size, "begun_s": entry.begun_s })
}
