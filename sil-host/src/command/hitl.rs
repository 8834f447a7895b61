//! `sil hitl`: the plant for a board in the loop.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use sil_host::answer::flight::figures::{FOLLOWING, WHOLE_FLIGHT};
use sil_host::answer::text_table::{TextTable, number};
use sil_host::hitl::{self, BoardPort, HitlFlight, HitlSetup, Patience};

use super::{Failure, RigArgument, bad_input, failed, print, vehicle_model, write_json};

/// Simulate the vehicle for a board in the loop, which flies the test sequence
///
/// The board must be in HITL mode (parameter HIL, then restart); its motor outputs stay disarmed. The simulated vehicle
/// must be the one that the board is configured for.
#[derive(Args)]
#[command(after_help = "Example: sil hitl --serial /dev/ttyUSB0")]
pub struct HitlArguments {
    /// Serial port that TELEM1 is wired to
    #[arg(long, value_name = "PORT")]
    serial: String,
    /// Bits per second
    #[arg(long, value_name = "N", default_value_t = 921_600)]
    baud: u32,
    /// The board's loop rate, steps per second
    #[arg(long, value_name = "HZ", default_value_t = 400, value_parser = clap::value_parser!(u32).range(50..=1000))]
    rate: u32,
    /// Which rig holds the vehicle [default: that of the model, else gimbal]
    #[arg(long, value_enum)]
    rig: Option<RigArgument>,
    /// Vehicle model [default: the project's F450 on that rig]
    #[arg(long, value_name = "M.toml")]
    model: Option<PathBuf>,
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write the figures as JSON; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

/// Longest that one look at the port waits for a byte.
const LOOK: Duration = Duration::from_millis(10);

pub fn run(arguments: &HitlArguments) -> Result<(), Failure> {
    let model = vehicle_model(arguments.model.as_deref(), arguments.rig.map(Into::into))?;
    let setup = HitlSetup { model, seed: arguments.seed, rate_hz: arguments.rate };
    let stream = serialport::new(&arguments.serial, arguments.baud)
        .timeout(LOOK)
        .open()
        .map_err(|error| bad_input(no_port(&arguments.serial, &error)))?;
    let mut port = BoardPort::new(stream, Patience::SERIAL);
    let flight = hitl::fly(&mut port, &setup, &mut show_progress);
    end_progress();
    let flight = flight.map_err(|error| failed(format!("{}: {error}", arguments.serial)))?;
    print(text(&setup, &flight))?;
    write_json(arguments.json.as_deref(), &flight.figures())
}

/// On a terminal only; it is gone when the figures come.
fn show_progress(flown_s: f64, of_s: f64) {
    if std::io::stderr().is_terminal() {
        // progress that can't be shown is no reason to stop
        let _ = write!(std::io::stderr(), "\rin flight: {flown_s:4.1} of {of_s:.1} s ");
    }
}

fn end_progress() {
    if std::io::stderr().is_terminal() {
        let _ = write!(std::io::stderr(), "\r{:40}\r", "");
    }
}

/// With the ports that there are.
pub(super) fn no_port(name: &str, error: &serialport::Error) -> String {
    let there: Vec<_> =
        serialport::available_ports().unwrap_or_default().into_iter().map(|port| port.port_name).collect();
    let there = if there.is_empty() { "there is none".to_owned() } else { format!("there are: {}", there.join(", ")) };
    format!("{name}: cannot be opened: {error}; expected a serial port, {there}")
}

/// What the terminal shows: the figures of `sil fly`, then those of the lock-step.
fn text(setup: &HitlSetup, flight: &HitlFlight) -> String {
    let (summary, figures) = (&flight.summary, flight.figures());
    let mut axes = TextTable::new(["".to_owned(), format!("{} roll", summary.controller), "pitch".to_owned()]);
    for figure in FOLLOWING {
        let cells = [summary.axes.roll, summary.axes.pitch].map(|axis| number((figure.value)(&axis), figure.decimals));
        axes.row([figure.name.to_owned()].into_iter().chain(cells));
    }
    let mut whole = TextTable::new(["", "board in the loop"]);
    for figure in WHOLE_FLIGHT {
        whole.row([figure.name.to_owned(), (figure.text)(summary)]);
    }
    whole.row(["round trip, median, ms".to_owned(), number(figures.round_trip_p50_ms, 2)]);
    whole.row(["round trip, 99 of 100 within, ms".to_owned(), number(figures.round_trip_p99_ms, 2)]);
    whole.row(["steps per second of real time".to_owned(), number(flight.achieved_rate_hz, 0)]);
    whole.row(["messages sent again".to_owned(), flight.sent_again.to_string()]);
    format!("{}: test sequence, board in the loop, seed {}\n\n{axes}\n{whole}\n", setup.model.name, setup.seed)
}
