//! Runs an image on a board that lies still: `cargo run --release -p emulated-board --example run_image ELF SECONDS`.

use std::path::Path;
use std::time::Instant;

use emulated_board::time::{TICKS_PER_S, seconds};
use emulated_board::{Counts, Image, Machine, Pulse, World};

struct Still {
    pulses: u64,
}

impl World for Still {
    fn imu(&mut self, now: u64) -> Counts {
        // a count of noise, else the firmware takes the sensor for stuck
        let noise = (now / 336_000 % 3) as i16 - 1;
        Counts { gyro: [noise, -noise, noise], accel: [noise, noise, -4096] }
    }

    fn pulse(&mut self, pulse: Pulse) {
        self.pulses += 1;
        if self.pulses <= 4 {
            println!("{:.6} s: channel {} high for {} us", seconds(pulse.rise), pulse.channel + 1, pulse.width / 336);
        }
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (Some(path), Some(duration_s)) = (arguments.next(), arguments.next().and_then(|text| text.parse::<f64>().ok()))
    else {
        eprintln!("usage: run_image ELF SECONDS");
        std::process::exit(2);
    };
    let image = Image::load(Path::new(&path)).expect("an image");
    let mut machine = Machine::new(&image, Box::new(Still { pulses: 0 }), 1).expect("a board");
    let start = Instant::now();
    let result = machine.run_until((duration_s * TICKS_PER_S as f64) as u64);
    let elapsed_s = start.elapsed().as_secs_f64();
    if let Err(stop) = result {
        println!("stopped: {stop}");
    }
    println!(
        "{:.6} s in {elapsed_s:.3} s, {:?}, asleep: {}",
        seconds(machine.now()),
        machine.counters(),
        machine.is_asleep()
    );
    println!("pc {:#010x}", machine.program_counter());
    println!("TELEM1: {} bytes", machine.telem1_receive().len());
}
