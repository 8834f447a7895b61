//! A board as a ground station meets it for the first time: freshly flashed, held still, TELEM1 on a TCP port, in real
//! time. `cargo run --release -p emulated-board --example serve_image -- ELF [PORT]`, then
//! `mavproxy.py --master tcp:127.0.0.1:5760`.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};

use emulated_board::time::TICKS_PER_US;
use emulated_board::{Image, MILLISECOND, Machine, Surroundings, Vehicle};
use sil_host::model::{Rig, VehicleModel};

const PORT: u16 = 5760;
/// How far it runs before it looks at the line and at the clock.
const SLICE_MS: u64 = 5;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let Some(path) = arguments.next() else {
        eprintln!("usage: serve_image ELF [PORT]");
        std::process::exit(2);
    };
    let port = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(PORT);
    let image = Image::load(Path::new(&path)).expect("an image");
    let vehicle = Vehicle::new(&VehicleModel::nominal(Rig::Gimbal), 1);
    let mut machine = Machine::new(&image, Box::new(Surroundings(vehicle)), 1).expect("a board");
    machine.blank_fram();
    let listener = TcpListener::bind(("127.0.0.1", port)).expect("a free port");
    listener.set_nonblocking(true).expect("a port that can be looked at");
    println!("TELEM1 at tcp:127.0.0.1:{port}");
    let (start, mut ground) = (Instant::now(), None);
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
        let sent = machine.telem1_receive();
        if ground.as_mut().is_some_and(|stream| !exchange(stream, &sent, &mut machine)) {
            println!("{:.1} s: the ground station went away", start.elapsed().as_secs_f64());
            ground = None;
        }
        let board = Duration::from_micros(machine.now() / TICKS_PER_US);
        std::thread::sleep(board.saturating_sub(start.elapsed()));
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
