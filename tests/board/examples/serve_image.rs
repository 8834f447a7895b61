//! A board as a ground station meets it for the first time: freshly flashed, in the gimbal, an empty card in its slot,
//! TELEM1 on a TCP port and USB on another, in real time or as near to it as this computer comes.
//! `cargo run --release -p emulated-board --example serve_image -- ELF [PORT [USB_PORT [EFFECT...]]]`, then
//! `mavproxy.py --master tcp:127.0.0.1:5760`. Port 0 is any free one; it says which. Effects are those of
//! docs/effects.md as `sil serve --effect` takes them: what the vehicle is beyond the F450 that the board takes it for.
//!
//! The vehicle is held level while no motor turns and free to turn about its axes while one does. The USB cable is
//! plugged in all the time; who connects to its port opens the serial port, and whoever goes closes it.

use std::cell::RefCell;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use emulated_board::time::{TICKS_PER_US, Ticks};
use emulated_board::{Content, Image, MILLISECOND, Machine, Pauses, SdCard, Surroundings, UsbHost, Vehicle};
use fatfs::FatType;
use sil_host::effects::Effect;
use sil_host::model::{Rig, VehicleModel};

const PORTS: [u16; 2] = [5760, 5761];
/// How far it runs before it looks at the lines and at the clock.
const SLICE_MS: u64 = 5;
/// How often it says how fast it is.
const REPORT_EVERY: Duration = Duration::from_secs(10);
const CARD_BYTES: usize = 64 << 20;

/// Where the board has a connector.
#[derive(Clone, Copy, PartialEq)]
enum Line {
    Telem1,
    Usb,
}

/// A connector's line at a TCP port, for one client at a time.
struct Port {
    line: Line,
    listener: TcpListener,
    client: Option<TcpStream>,
    /// The computer has opened the serial port since the device was found.
    is_open: bool,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(path) = arguments.first() else {
        eprintln!("usage: serve_image ELF [PORT [USB_PORT [EFFECT...]]]");
        std::process::exit(2);
    };
    let port = |at: usize| arguments.get(at + 1).and_then(|text| text.parse().ok()).unwrap_or(PORTS[at]);
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    for text in arguments.iter().skip(3) {
        let effect = Effect::parse_for(text, model.rig(), model.inertia_kg_m2);
        model.effects.push(effect.unwrap_or_else(|problem| panic!("{text}: {problem}")));
    }
    let image = Image::load(Path::new(path)).expect("an image");
    let vehicle = Vehicle::new(&model, 1);
    let mut machine = Machine::new(&image, Box::new(Surroundings(Rc::clone(&vehicle))), 1).expect("a board");
    machine.blank_fram();
    machine.insert_card(empty_card());
    machine.with_usb(|computer| computer.plug(true));
    let mut ports = [Port::new(Line::Telem1, port(0)), Port::new(Line::Usb, port(1))];
    let (start, mut report_at) = (Instant::now(), REPORT_EVERY);
    loop {
        let until = machine.now() + SLICE_MS * MILLISECOND;
        if let Err(stop) = machine.run_until(until) {
            println!("stopped: {stop}");
            return;
        }
        hold_or_release(&vehicle, machine.now());
        for port in &mut ports {
            port.serve(&mut machine, start);
        }
        let board = Duration::from_micros(machine.now() / TICKS_PER_US);
        std::thread::sleep(board.saturating_sub(start.elapsed()));
        if board >= report_at {
            report_at += REPORT_EVERY;
            let share = board.as_secs_f64() / start.elapsed().as_secs_f64();
            println!("{:.0} s of the board at {share:.2} times real time", board.as_secs_f64());
        }
    }
}

fn empty_card() -> SdCard {
    SdCard::new(Content::formatted(FatType::Fat16, CARD_BYTES), Pauses::USUAL, 1)
}

/// A hand at the gimbal.
fn hold_or_release(vehicle: &RefCell<Vehicle>, now: Ticks) {
    let mut vehicle = vehicle.borrow_mut();
    let turns = vehicle.commands().iter().any(|command| *command > 0.0);
    if turns && vehicle.is_down() {
        vehicle.release(now);
    } else if !turns && !vehicle.is_down() {
        vehicle.turn_by_hand([0.0; 2]);
    }
}

impl Port {
    fn new(line: Line, port: u16) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", port)).expect("a free port");
        listener.set_nonblocking(true).expect("a port that can be looked at");
        let port = Self { line, listener, client: None, is_open: false };
        println!("{} at tcp:{}", port.name(), port.listener.local_addr().expect("an address"));
        port
    }

    fn name(&self) -> &'static str {
        match self.line {
            Line::Telem1 => "TELEM1",
            Line::Usb => "USB",
        }
    }

    /// Lets clients come and go, and bytes both ways.
    fn serve(&mut self, machine: &mut Machine, start: Instant) {
        if let Ok((stream, _)) = self.listener.accept() {
            stream.set_nonblocking(true).expect("a connection that can be looked at");
            println!("{:.1} s: a ground station on {}", start.elapsed().as_secs_f64(), self.name());
            self.client = Some(stream);
        }
        if self.line == Line::Usb {
            self.open_or_close(machine);
        }
        let sent = match self.line {
            Line::Telem1 => machine.telem1_receive(),
            Line::Usb => machine.with_usb(UsbHost::take_received),
        };
        if self.client.as_mut().is_some_and(|stream| !exchange(stream, &sent, self.line, machine)) {
            println!("{:.1} s: the ground station on {} went away", start.elapsed().as_secs_f64(), self.name());
            self.client = None;
        }
    }

    /// As a program does with the device's file, which is another one after the board's restart.
    fn open_or_close(&mut self, machine: &mut Machine) {
        let (is_there, wanted) = (machine.with_usb(|computer| computer.enumerated().is_some()), self.client.is_some());
        if !is_there {
            self.is_open = false;
        } else if wanted != self.is_open {
            machine.with_usb(|computer| if wanted { computer.open() } else { computer.close() });
            self.is_open = wanted;
        }
    }
}

/// Both ways; false once nobody is there.
fn exchange(stream: &mut TcpStream, sent: &[u8], line: Line, machine: &mut Machine) -> bool {
    let mut bytes = [0; 512];
    match stream.read(&mut bytes) {
        Ok(0) => return false,
        Ok(count) => match line {
            Line::Telem1 => machine.telem1_send(&bytes[..count]),
            Line::Usb => machine.with_usb(|computer| computer.send(&bytes[..count])),
        },
        Err(error) if error.kind() == ErrorKind::WouldBlock => {}
        Err(_) => return false,
    }
    stream.write_all(sent).is_ok()
}
