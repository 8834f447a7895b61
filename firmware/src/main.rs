//! The Pixhawk 1 image: it wires the control core to the sensors and the motor outputs.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod pixhawk;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("The firmware runs on a Pixhawk 1 only. Build its image with: cargo fw");
    std::process::exit(2);
}
