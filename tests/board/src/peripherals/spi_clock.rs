//! The clock pin of an SPI master: how fast it may go, when its feedback comes too late, and where it rests while the
//! peripheral is off. Data sheet of the STM32F427, "I/O AC characteristics"; errata sheet ES0206, "Corrupted last bit
//! of data and/or CRC, received in Master mode with delayed SCK feedback"; RM0090 section 28.3.1.

use super::pin::{Drive, Load, Speed};

/// Said of a clock beyond the pin.
pub const PIN_TOO_SLOW: &str =
    "SPI clock faster than its pin's speed allows (STM32F427 data sheet, I/O AC characteristics)";
/// Said of a clock whose way back takes too long.
pub const LAST_BIT_LATE: &str = "the last bit that SPI receives is late: SCK's pin is too slow for its bus's clock \
     (ES0206, corrupted last bit in master mode with delayed SCK feedback)";
/// Said of a clock without a level while a device listens.
pub const CLOCK_FLOATS: &str =
    "a device is selected while SPI is off and nothing holds its clock at the idle level (RM0090 section 28.3.1)";

/// Can the pin follow?
pub(crate) fn check_pin(speed: Speed, load: Load, clock_hz: u64) -> Result<(), &'static str> {
    if clock_hz > speed.frequency_max_hz(load) { Err(PIN_TOO_SLOW) } else { Ok(()) }
}

/// Does the last bit that is received keep its value from the byte before? The receiver is clocked by what comes back
/// from the pin, and must have it before the bus's clock goes on.
///
/// ES0206 has 90 MHz at 30 pF for the two highest speeds. For the two others it is the 25 MHz of ES0182, the sheet of
/// the F405, whose pins are the same.
pub(crate) fn loses_last_bit(speed: Speed, bus_hz: u64) -> bool {
    let bus_max_hz = match speed {
        Speed::Low | Speed::Medium => 25_000_000,
        Speed::High | Speed::VeryHigh => 90_000_000,
    };
    bus_hz > bus_max_hz
}

/// Is the clock where it rests (`idles_high`: CPOL), while the peripheral does not drive it?
pub(crate) fn rests(drive: Drive, idles_high: bool) -> bool {
    drive.level() == Some(idles_high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slowest_pin_is_for_4_mhz_or_8_with_a_light_load() {
        for (load, limit) in [(Load::Heavy, 4_000_000), (Load::Light, 8_000_000)] {
            assert_eq!(check_pin(Speed::Low, load, limit), Ok(()));
            assert_eq!(check_pin(Speed::Low, load, limit + 1), Err(PIN_TOO_SLOW));
            assert_eq!(check_pin(Speed::High, load, 42_000_000), Ok(()));
        }
    }

    #[test]
    fn the_feedback_of_a_slow_pin_is_late_at_42_mhz_and_in_time_at_21() {
        assert!(loses_last_bit(Speed::Low, 42_000_000));
        assert!(!loses_last_bit(Speed::Low, 21_000_000));
        // both buses of a board at 168 MHz
        assert!(!loses_last_bit(Speed::High, 42_000_000) && !loses_last_bit(Speed::High, 84_000_000));
    }

    #[test]
    fn a_floating_clock_rests_nowhere() {
        assert!(!rests(Drive::None, true) && !rests(Drive::None, false));
        assert!(rests(Drive::Weak(true), true) && !rests(Drive::Weak(false), true));
        assert!(rests(Drive::Strong(false), false));
    }
}
