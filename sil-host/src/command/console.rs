//! `sil console`: what a vehicle's owner wants, in words.

use std::io::{self, BufRead, ErrorKind, IsTerminal, Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::time::Duration;

use clap::Args;
use sil_host::console::{Console, ConsoleError, Goes, HELP};

use super::{Failure, bad_input, failed, print};

/// Talk with a vehicle in words: parameters, calibration, motor test, arming, logs
///
/// Reads lines from the terminal, or takes those of --do; help lists them. What the vehicle says is shown as it comes.
/// Where nobody sits at the terminal, the first line that is refused ends it.
#[derive(Args)]
#[command(after_help = "Example: sil console tcp:127.0.0.1:5760 --do status --do \"params BATT\"\n\n\
A board's TELEM1 on a serial adapter: sil console /dev/ttyUSB0. A simulated one: sil serve.")]
pub struct ConsoleArguments {
    /// Serial port, tcp:HOST:PORT to connect to, or udp:PORT or udp:ADDRESS:PORT to listen at
    #[arg(value_name = "PORT")]
    port: String,
    /// Bits per second of a serial port
    #[arg(long, value_name = "N", default_value_t = 57_600)]
    baud: u32,
    /// Do this instead of reading lines; may be given several times
    #[arg(long = "do", value_name = "LINE")]
    lines: Vec<String>,
}

/// Longest that one look at the port waits.
const LOOK: Duration = Duration::from_millis(10);
/// From one look at the terminal to the next.
const TURN: Duration = Duration::from_millis(50);

/// What a vehicle is at the other end of.
trait Stream: Read + Write {}
impl<S: Read + Write> Stream for S {}

pub fn run(arguments: &ConsoleArguments) -> Result<(), Failure> {
    let mut console = Console::new(open(arguments)?);
    for line in &arguments.lines {
        obey(&mut console, line)?;
    }
    if !arguments.lines.is_empty() {
        return Ok(());
    }
    let is_person = io::stdin().is_terminal();
    if is_person {
        print(HELP.to_owned())?;
    }
    let lines = lines_of_stdin();
    loop {
        let line = match lines.try_recv() {
            Ok(line) => line,
            Err(TryRecvError::Disconnected) => return Ok(()),
            Err(TryRecvError::Empty) => {
                console.idle(TURN, &mut show).map_err(failed)?;
                continue;
            }
        };
        match obey(&mut console, &line) {
            Ok(Goes::On) => {}
            Ok(Goes::Off) => return Ok(()),
            // whoever sits there reads it and goes on
            Err(failure) if is_person => print(format!("{}\n", failure.message))?,
            Err(failure) => return Err(failure),
        }
    }
}

fn obey(console: &mut Console<Box<dyn Stream>>, line: &str) -> Result<Goes, Failure> {
    console.obey(line, &mut show).map_err(|error| match error {
        ConsoleError::Line(_) => bad_input(error),
        _ => failed(error),
    })
}

fn show(line: &str) {
    // a terminal that is gone shows in the next line that is read
    let _ = print(format!("{line}\n"));
}

/// Read beside the link, which must not wait for them.
fn lines_of_stdin() -> Receiver<String> {
    let (lines, received) = mpsc::channel();
    std::thread::spawn(move || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            if lines.send(line).is_err() {
                return;
            }
        }
    });
    received
}

fn open(arguments: &ConsoleArguments) -> Result<Box<dyn Stream>, Failure> {
    let port = arguments.port.as_str();
    let no_way = |error: io::Error| bad_input(format!("{port}: cannot be opened: {error}"));
    if let Some(address) = port.strip_prefix("tcp:") {
        let stream = TcpStream::connect(address).map_err(no_way)?;
        stream.set_read_timeout(Some(LOOK)).and_then(|()| stream.set_nodelay(true)).map_err(no_way)?;
        return Ok(Box::new(stream));
    }
    if let Some(place) = port.strip_prefix("udp:") {
        let of_port = place.parse().ok().map(|port: u16| SocketAddr::from(([127, 0, 0, 1], port)));
        let expected = || bad_input(format!("{port}: expected udp:PORT or udp:ADDRESS:PORT"));
        let address = of_port.or_else(|| place.parse().ok()).ok_or_else(expected)?;
        let socket = UdpSocket::bind(address).map_err(no_way)?;
        socket.set_read_timeout(Some(LOOK)).map_err(no_way)?;
        return Ok(Box::new(Datagrams { socket, peer: None }));
    }
    let opened = serialport::new(port, arguments.baud).timeout(LOOK).open();
    Ok(Box::new(opened.map_err(|error| bad_input(super::hitl::no_port(port, &error)))?))
}

/// A vehicle that speaks first, to the port at which is listened.
struct Datagrams {
    socket: UdpSocket,
    peer: Option<SocketAddr>,
}

impl Read for Datagrams {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let (count, from) = self.socket.recv_from(buffer)?;
        self.peer.get_or_insert(from);
        // an empty one is no end
        if count == 0 || self.peer != Some(from) { Err(ErrorKind::WouldBlock.into()) } else { Ok(count) }
    }
}

impl Write for Datagrams {
    /// To nobody as long as nobody has spoken.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.peer {
            Some(peer) if !bytes.is_empty() => self.socket.send_to(bytes, peer),
            _ => Ok(bytes.len()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
