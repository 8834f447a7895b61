//! A board as a ground station meets it for the first time: freshly flashed, in the gimbal, TELEM1 on a TCP port, in
//! real time or as near to it as this computer comes.
//! `cargo run --release -p emulated-board --example serve_image -- ELF [PORT]`, then
//! `mavproxy.py --master tcp:127.0.0.1:5760`. Port 0 is any free one; it says which.
//!
//! The vehicle is held level while no motor turns and free to turn about its axes while one does.

use std::cell::RefCell;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use emulated_board::time::{TICKS_PER_US, Ticks};
use emulated_board::{Image, MILLISECOND, Machine, Surroundings, Vehicle};
use sil_host::model::{Rig, VehicleModel};

const PORT: u16 = 5760;
/// How far it runs before it looks at the line and at the clock.
const SLICE_MS: u64 = 5;
/// How often it says how fast it is.
const REPORT_EVERY: Duration = Duration::from_secs(10);

fn main() {
    let mut arguments = std::env::args().skip(1);
    let Some(path) = arguments.next() else {
        eprintln!("usage: serve_image ELF [PORT]");
        std::process::exit(2);
    };
    let port = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(PORT);
    let image = Image::load(Path::new(&path)).expect("an image");
    let vehicle = Vehicle::new(&VehicleModel::nominal(Rig::Gimbal), 1);
    let mut machine = Machine::new(&image, Box::new(Surroundings(Rc::clone(&vehicle))), 1).expect("a board");
    machine.blank_fram();
    let listener = TcpListener::bind(("127.0.0.1", port)).expect("a free port");
    listener.set_nonblocking(true).expect("a port that can be looked at");
    println!("TELEM1 at tcp:{}", listener.local_addr().expect("an address"));
    let (start, mut ground) = (Instant::now(), None);
    let mut report_at = REPORT_EVERY;
    loop {
        if let Ok((stream, _)) = listener.accept() {
            stream.set_nonblocking(true).expect("a connection that can be looked at");
            println!("{:.1} s: a ground station", start.elapsed().as_secs_f64());
            ground = Some(stream);
        }
        let until = machine.now() + SLICE_MS * MILLISECOND;
        if let Err(stop) = machine.run_until(until) {
            println!("stopped: {stop}");
            return;
        }
        hold_or_release(&vehicle, machine.now());
        let sent = machine.telem1_receive();
        if ground.as_mut().is_some_and(|stream| !exchange(stream, &sent, &mut machine)) {
            println!("{:.1} s: the ground station went away", start.elapsed().as_secs_f64());
            ground = None;
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

/// Both ways; false once nobody is there.
fn exchange(stream: &mut TcpStream, sent: &[u8], machine: &mut Machine) -> bool {
    let mut bytes = [0; 512];
    match stream.read(&mut bytes) {
        Ok(0) => return false,
        Ok(count) => machine.telem1_send(&bytes[..count]),
        Err(error) if error.kind() == ErrorKind::WouldBlock => {}
        Err(_) => return false,
    }
    stream.write_all(sent).is_ok()
}
