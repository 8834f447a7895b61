//! The chip's peripherals, one a file, each with its section of RM0090.

pub(crate) mod adc;
pub(crate) mod dbgmcu;
pub(crate) mod dma;
pub(crate) mod exti;
pub(crate) mod flash;
pub(crate) mod flash_timing;
pub(crate) mod gpio;
pub(crate) mod iwdg;
pub(crate) mod line_noise;
pub(crate) mod otg_fs;
pub(crate) mod pin;
pub(crate) mod pwr;
pub(crate) mod rcc;
pub(crate) mod sdio;
pub(crate) mod spi;
pub(crate) mod spi_clock;
pub(crate) mod syscfg;
pub(crate) mod timer;
pub(crate) mod usart;

use crate::time::Ticks;

/// A register, or a value in it, that this model does not have; the text says which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unmodelled(pub(crate) &'static str);

/// What the CPU and DMA see of a peripheral.
///
/// Peripherals know their registers and pins; the wires between them are the board's.
pub(crate) trait Peripheral {
    /// A word. Reading may have an effect, as on a data register.
    fn read(&mut self, offset: u32, now: Ticks) -> Result<u32, Unmodelled>;
    /// A word, or for a shorter access its low part.
    fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Unmodelled>;
    /// Lets everything happen that is due by `now`.
    fn tick(&mut self, _now: Ticks) {}
    /// When something will happen next.
    fn next_event(&self) -> Option<Ticks> {
        None
    }
}
