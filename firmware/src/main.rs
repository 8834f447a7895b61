//! The Pixhawk 1 image. So far a stub that drives nothing: it starts behind the bootloader and hands inputs of the
//! control core round in a loop. It proves that the core compiles, links and fits for the STM32F427.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use core::hint::black_box;
    use core::panic::PanicInfo;

    use shared_control::signals::{RawImuSample, StepInput};

    #[cortex_m_rt::entry]
    fn run() -> ! {
        let mut input = StepInput::default();
        loop {
            input.time_us += 1;
            input.imu.clear();
            // a batch that was just emptied takes one sample
            let _ = input.imu.push(RawImuSample { time_us: input.time_us, ..RawImuSample::default() });
            // else the optimiser would leave nothing of the core in the image
            black_box(&input);
        }
    }

    #[panic_handler]
    fn stop(_: &PanicInfo) -> ! {
        cortex_m::interrupt::disable();
        loop {
            cortex_m::asm::nop();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("The firmware runs on a Pixhawk 1 only. Build its image with: cargo fw");
    std::process::exit(2);
}
