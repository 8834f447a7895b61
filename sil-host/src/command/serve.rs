//! `sil serve`: a simulated vehicle that ground stations connect to.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use serde::Serialize;
use shared_control::config::Controller;
use shared_control::link::LinkSettings;
use shared_control::params::table::Field;
use shared_control::params::vehicle::VehicleNumbers;
use shared_control::params::{Params, Rig};
use sil_host::answer::board_parameters::board_parameters;
use sil_host::effects::Effect;
use sil_host::model::VehicleModel;
use sil_host::serve::lock_step::{LockStep, LockStepFigures, SimulatorPort};
use sil_host::serve::parameter_file::{self, InMemory, ParameterFile};
use sil_host::serve::signing_file::SigningFile;
use sil_host::serve::{
    LogShelf, Memory, Pace, ParameterStore, ServedVehicle, SigningStore, Sockets, SocketsSetup, TICK_US, Unsigned,
};

use super::serve_simulator::{in_lock_step, simulator};
use super::{Failure, RigArgument, bad_input, failed, make_folder, print, vehicle_model, write_json};

/// Simulate a vehicle in real time that ground stations connect to
///
/// The control core flies it as on the board, with the board's parameters and its link (MAVLink 2). It sends to a
/// ground station's UDP port and waits for TCP clients; all share one link. Parameters set over the link are kept in
/// the file of --params. From arming until a second after disarming it writes a log, which ground stations download.
/// With --simulator another program's vehicle is flown instead, in real time or as fast as that program goes. Ctrl-C
/// ends it.
#[derive(Args)]
#[command(after_help = "Example: sil serve --rig free --params out/f450.params\n\n\
QGroundControl finds it by itself; others listen at udp:127.0.0.1:14550 or connect to\n\
tcp:127.0.0.1:5760. docs/ground-stations.md says how, and what they see.")]
pub struct ServeArguments {
    /// Who flies; sets the parameter CONTROLLER [default: as the parameters say, else pid]
    #[arg(long, value_enum)]
    controller: Option<ControllerArgument>,
    /// Which rig holds the vehicle [default: that of the model, else gimbal]
    #[arg(long, value_enum)]
    rig: Option<RigArgument>,
    /// Vehicle model; without --params the board knows its numbers [default: the project's F450 on that rig]
    #[arg(long, value_name = "M.toml")]
    model: Option<PathBuf>,
    /// Let the vehicle have this effect, which the board knows nothing of; may be given several times
    #[arg(long, value_name = "NAME:KEY=VALUE,..")]
    effect: Vec<String>,
    /// Keep the board's parameters in this file, as ground stations save them; made if it is not there
    #[arg(long, value_name = "P.params")]
    params: Option<PathBuf>,
    /// Keep the flights' logs (ULog) in this folder; made if it is not there [default: in memory]
    #[arg(long, value_name = "DIR")]
    logs: Option<PathBuf>,
    /// Let only signed frames count, with the key in this file: 64 hexadecimal digits, or a passphrase of one line; the
    /// clock of timestamps is kept beside it. Made by SETUP_SIGNING from this computer if it is not there
    #[arg(long, value_name = "KEY")]
    signing: Option<PathBuf>,
    /// Fly the vehicle of another program, a simulator for PX4 that waits at this address, as tcp:127.0.0.1:4560; the
    /// board's parameters say what it is, by default an F450 in free flight
    #[arg(long, value_name = "tcp:HOST:PORT", value_parser = simulator)]
    #[arg(conflicts_with_all = ["effect", "speed", "seed"])]
    simulator: Option<SocketAddr>,
    /// How many times as fast as real time
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = speed)]
    speed: f64,
    /// Address or port of the ground station that is sent to, or off
    #[arg(long, value_name = "ADDRESS", default_value = "14550", value_parser = address)]
    udp: Place,
    /// Address or port where TCP clients are waited for, or off; 0 for any free port
    #[arg(long, value_name = "ADDRESS", default_value = "5760", value_parser = address)]
    tcp: Place,
    /// End after so many simulated seconds
    #[arg(long = "for", value_name = "SECONDS")]
    duration_s: Option<f64>,
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write what came and went over the link as JSON at the end; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum ControllerArgument {
    /// The PID cascade.
    Pid,
    /// Model predictive control.
    Mpc,
}

/// Where a socket is; none for none.
#[derive(Clone, Copy)]
struct Place(Option<SocketAddr>);

/// Longest that nothing is looked at.
const NAP: Duration = Duration::from_millis(1);

/// Simulated time between two looks at what has arrived, µs: a step of the loop at 400 Hz.
const RECEIVE_US: u64 = 2_500;

/// What came and went, as `sil serve --json` writes it (docs/commands.md).
#[derive(Serialize)]
struct ServeFigures {
    /// Simulated time, s.
    simulated_s: f64,
    /// Simulated time that was left out because the computer was too slow, s.
    missed_s: f64,
    /// Starts of the board by command.
    restarts: u32,
    /// Bytes that came from ground stations.
    bytes_received: u64,
    /// Bytes that the vehicle said.
    bytes_sent: u64,
    /// Orders that found no room.
    orders_dropped: u32,
    /// Of the talk with another program's simulator.
    #[serde(skip_serializing_if = "Option::is_none")]
    simulator: Option<LockStepFigures>,
}

fn address(text: &str) -> Result<Place, String> {
    if text == "off" {
        return Ok(Place(None));
    }
    let port = text.parse().ok().map(|port: u16| SocketAddr::from(([127, 0, 0, 1], port)));
    port.or_else(|| text.parse().ok())
        .map(|address| Place(Some(address)))
        .ok_or_else(|| "expected a port, an address such as 192.168.1.5:14550, or off".to_owned())
}

fn speed(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if (0.01..=100.0).contains(&number) { Ok(number) } else { Err("expected 0.01 to 100".to_owned()) }
}

pub fn run(arguments: &ServeArguments) -> Result<(), Failure> {
    let free_unless_said = arguments.simulator.filter(|_| arguments.model.is_none()).map(|_| RigArgument::Free);
    let rig = arguments.rig.or(free_unless_said);
    let known = vehicle_model(arguments.model.as_deref(), rig.map(Into::into))?;
    let (params, store) = parameters(arguments, &known)?;
    let memory = Memory { parameters: store, signing: signing(arguments)?, logs: logs(arguments)? };
    let figures = match arguments.simulator {
        Some(address) => serve_in_lock_step(arguments, address, &params, memory)?,
        None => serve_simulated(arguments, &known, &params, memory)?,
    };
    print(format!(
        "{:.1} s simulated, {} bytes received, {} sent\n",
        figures.simulated_s, figures.bytes_received, figures.bytes_sent
    ))?;
    write_json(arguments.json.as_deref(), &figures)
}

/// The vehicle is this program's.
fn serve_simulated(
    arguments: &ServeArguments,
    known: &VehicleModel,
    params: &Params,
    memory: Memory,
) -> Result<ServeFigures, Failure> {
    let mut model = known.clone();
    for text in &arguments.effect {
        let effect = Effect::parse_for(text, model.rig(), model.inertia_kg_m2);
        model.effects.push(effect.map_err(|problem| bad_input(format!("--effect {text}: {problem}")))?);
    }
    let mut vehicle = ServedVehicle::new(model, arguments.seed, params, memory).map_err(bad_input)?;
    let mut sockets = open(arguments, vehicle.board().link_settings())?;
    print(introduction(arguments, known, params, &sockets))?;
    let missed_s = serve(arguments, &mut vehicle, &mut sockets)?;
    Ok(ServeFigures {
        simulated_s: vehicle.simulated_us() as f64 * 1e-6,
        missed_s,
        restarts: vehicle.restarts(),
        bytes_received: sockets.bytes_received,
        bytes_sent: sockets.bytes_sent,
        orders_dropped: vehicle.board().orders_dropped,
        simulator: None,
    })
}

/// The vehicle is another program's.
fn serve_in_lock_step(
    arguments: &ServeArguments,
    address: SocketAddr,
    params: &Params,
    memory: Memory,
) -> Result<ServeFigures, Failure> {
    let mut lock_step = LockStep::new(params, memory).map_err(bad_input)?;
    let mut sockets = open(arguments, lock_step.board().link_settings())?;
    let what = format!("{}, the vehicle is another program's", controller(params));
    print(format!("{what}\n{}", whereabouts(arguments, &sockets)))?;
    let mut port = SimulatorPort::new(address);
    in_lock_step(arguments.end_us(), &mut lock_step, &mut port, &mut sockets)?;
    Ok(ServeFigures {
        simulated_s: lock_step.simulated_us() as f64 * 1e-6,
        missed_s: 0.0,
        restarts: lock_step.restarts(),
        bytes_received: sockets.bytes_received,
        bytes_sent: sockets.bytes_sent,
        orders_dropped: lock_step.board().orders_dropped,
        simulator: Some(lock_step.figures().clone()),
    })
}

fn open(arguments: &ServeArguments, settings: LinkSettings) -> Result<Sockets, Failure> {
    let setup = SocketsSetup { udp: arguments.udp.0, tcp: arguments.tcp.0 };
    Sockets::open(&setup, settings).map_err(bad_input)
}

impl ServeArguments {
    /// Simulated time at which it ends, µs.
    fn end_us(&self) -> u64 {
        self.duration_s.map_or(u64::MAX, |seconds| (seconds.max(0.0) * 1e6) as u64)
    }
}

/// Until its time is over; simulated time that was left out, s.
fn serve(arguments: &ServeArguments, vehicle: &mut ServedVehicle, sockets: &mut Sockets) -> Result<f64, Failure> {
    let end_us = arguments.end_us();
    let mut pace = Pace::new(arguments.speed, Instant::now());
    while vehicle.simulated_us() < end_us {
        let due = pace.take_due(Instant::now(), TICK_US);
        for _ in 0..due {
            if vehicle.simulated_us().is_multiple_of(RECEIVE_US) {
                sockets.receive(vehicle.board());
            }
            vehicle.advance().map_err(failed)?;
            sockets.send(&vehicle.board().take_sent());
        }
        for line in sockets.take_news() {
            print(format!("{line}\n"))?;
        }
        std::thread::sleep(NAP.div_f64(arguments.speed.max(1.0)));
    }
    Ok(pace.missed_s())
}

/// The board's parameters, and where they are kept.
fn parameters(arguments: &ServeArguments, known: &VehicleModel) -> Result<(Params, Box<dyn ParameterStore>), Failure> {
    let defaults = defaults(arguments, known)?;
    let found = match &arguments.params {
        Some(path) => parameter_file::read(path, &defaults).map_err(bad_input)?,
        None => None,
    };
    let mut params = found.unwrap_or(defaults);
    if let Some(controller) = arguments.controller {
        params.controller = match controller {
            ControllerArgument::Pid => Controller::Cascade,
            ControllerArgument::Mpc => Controller::Mpc,
        };
    }
    let Some(path) = &arguments.params else { return Ok((params, Box::new(InMemory))) };
    let file = ParameterFile::new(path.clone(), known.name.clone());
    if found != Some(params) {
        make_folder(path)?;
        file.write(&params).map_err(|error| failed(format!("{}: cannot be written: {error}", path.display())))?;
    }
    Ok((params, Box::new(file)))
}

/// Where the flights' logs are kept.
fn logs(arguments: &ServeArguments) -> Result<LogShelf, Failure> {
    match &arguments.logs {
        Some(folder) => {
            LogShelf::in_folder(folder).map_err(|error| bad_input(format!("--logs {}: {error}", folder.display())))
        }
        None => Ok(LogShelf::in_memory()),
    }
}

/// Where key and clock of signed frames are kept.
fn signing(arguments: &ServeArguments) -> Result<Box<dyn SigningStore>, Failure> {
    let Some(path) = &arguments.signing else { return Ok(Box::new(Unsigned)) };
    make_folder(path)?;
    Ok(Box::new(SigningFile::open(path).map_err(bad_input)?))
}

/// What the parameters are where no file says otherwise: the vehicle's own numbers.
fn defaults(arguments: &ServeArguments, known: &VehicleModel) -> Result<Params, Failure> {
    let rig = match known.rig() {
        sil_host::model::Rig::Free => Rig::Free,
        _ => Rig::Gimbal,
    };
    let hover_throttle_permille = (known.base_command * 1000.0).round() as u16;
    let vehicle = VehicleNumbers::F450;
    let mut params = Params { rig, hover_throttle_permille, vehicle, ..Params::DEFAULT };
    let Some(path) = &arguments.model else { return Ok(params) };
    let no_board = |problem: String| bad_input(format!("{}: no board can fly it: {problem}", path.display()));
    for (name, value) in board_parameters(known).map_err(no_board)? {
        let set = Field::by_name(name.as_bytes()).and_then(|field| params.with(field, value));
        params = set.ok_or_else(|| no_board(format!("{name} {value}")))?;
    }
    Ok(params)
}

/// What is simulated and where it is found.
fn introduction(arguments: &ServeArguments, known: &VehicleModel, params: &Params, sockets: &Sockets) -> String {
    let speed = match arguments.speed {
        1.0 => "in real time".to_owned(),
        speed => format!("{speed} times as fast as real time"),
    };
    let controller = controller(params);
    let mut text = format!("{}, {controller} at {} Hz, {speed}\n", known.name, params.loop_rate_hz);
    let board_rig = if params.rig == Rig::Free { "free" } else { "gimbal" };
    if known.rig().name() != board_rig {
        text.push_str(&format!(
            "WARNING: the vehicle's rig is {}, the board's parameters are for {board_rig} (RIG)\n",
            known.rig().name()
        ));
    }
    text + &whereabouts(arguments, sockets)
}

fn controller(params: &Params) -> &'static str {
    match params.controller {
        Controller::Cascade => "PID cascade",
        Controller::Mpc => "MPC",
    }
}

/// Where ground stations find it, and where it keeps what lasts.
fn whereabouts(arguments: &ServeArguments, sockets: &Sockets) -> String {
    let mut text = String::new();
    if let Some(ground) = arguments.udp.0 {
        text.push_str(&format!("UDP  sends to {ground}, answers whoever speaks\n"));
    }
    if let Some(address) = sockets.tcp_address() {
        text.push_str(&format!("TCP  waits for clients at {address}\n"));
    }
    match &arguments.params {
        Some(path) => text.push_str(&format!("parameters in {}\n", path.display())),
        None => text.push_str("parameters in memory only; --params FILE keeps them\n"),
    }
    match &arguments.logs {
        Some(folder) => text.push_str(&format!("logs in {}\n", folder.display())),
        None => text.push_str("logs in memory only; --logs DIR keeps them\n"),
    }
    if arguments.duration_s.is_none() {
        text.push_str("Ctrl-C ends it\n");
    }
    text
}
