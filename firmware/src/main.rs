//! The Pixhawk 1 image. So far a stub that drives nothing: it starts behind the bootloader and has the control core step
//! in a loop on inputs that nobody measured. It proves that the whole core compiles, links and fits for the STM32F427.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("The firmware runs on a Pixhawk 1 only. Build its image with: cargo fw");
    std::process::exit(2);
}
