//! The LSM303D's accelerometer on SPI1: identity, data rates, ranges, the data-ready pin PB4.
//!
//! Data sheet DocID023312, section 8. Its magnetometer stays in power-down; FIFO, high-pass filter and interrupt
//! generators have no model.

use super::st_sensor::{Kind, Registers};
use crate::time::{TICKS_PER_S, Ticks};

const CTRL0: usize = 0x1f;
const CTRL1: usize = 0x20;
const CTRL2: usize = 0x21;
const CTRL3: usize = 0x22;

const ALL_AXES: u8 = 0b111;
const BLOCK_DATA_UPDATE: u8 = 1 << 3;
const DATA_READY_ON_INT1: u8 = 1 << 2;
/// Self test, three wires.
const SPECIAL: u8 = 0b11;
/// Full scale, CTRL2 bits 5 to 3: 8 g.
const RANGE_8_G: u8 = 3;
/// Thousandths of g to the count at each full scale, 2 to 16 g (table 3).
const MG_PER_COUNT: [f64; 5] = [0.061, 0.122, 0.183, 0.244, 0.732];

/// Samples in eight seconds by the four highest bits of CTRL1: 3.125 to 1600 Hz, 0 is power-down.
const SAMPLES_IN_8_S: [u64; 11] = [0, 25, 50, 100, 200, 400, 800, 1600, 3200, 6400, 12_800];

pub(crate) const LSM303D: Kind = Kind {
    identity: 0x49,
    reset_values: &[(CTRL1 as u8, 0x07), (0x24, 0x18), (0x25, 0x20), (0x26, 0x01)],
    period,
    drives_data_ready: |registers| registers[CTRL3] & DATA_READY_ON_INT1 != 0,
    holds_while_read: |registers| registers[CTRL1] & BLOCK_DATA_UPDATE != 0,
    check_settings,
    counts_at_range,
    too_fast: "LSM303D accessed at more than 10 MHz",
};

fn period(registers: &Registers) -> Option<Ticks> {
    let samples = SAMPLES_IN_8_S.get(usize::from(registers[CTRL1] >> 4)).copied().filter(|samples| *samples > 0)?;
    Some(8 * TICKS_PER_S / samples)
}

fn counts_at_range(registers: &Registers) -> f64 {
    let range = usize::from(registers[CTRL2] >> 3 & 7);
    MG_PER_COUNT.get(range).map_or(1.0, |mg_per_count| MG_PER_COUNT[usize::from(RANGE_8_G)] / mg_per_count)
}

/// The counts are for +-8 g.
fn check_settings(registers: &Registers) -> Result<(), &'static str> {
    if registers[CTRL2] >> 3 & 7 != RANGE_8_G {
        return Err("LSM303D range other than 8 g");
    }
    let plain = registers[CTRL2] & SPECIAL == 0 && registers[CTRL0] == 0;
    if plain && registers[CTRL1] & ALL_AXES == ALL_AXES {
        Ok(())
    } else {
        Err("LSM303D with axes off, filters, FIFO, self test or three wires")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::st_sensor::tests::{chip, register, transfer};

    #[test]
    fn it_tells_its_name_and_starts_in_power_down() {
        let mut chip = chip(&LSM303D, &[]);
        assert_eq!(register(&mut chip, 0x0f), 0x49);
        assert_eq!(chip.next_event(), None);
    }

    #[test]
    fn it_samples_at_the_rate_that_is_set() {
        for (control, period) in [(0xa7, TICKS_PER_S / 1600), (0x97, TICKS_PER_S / 800), (0x27, TICKS_PER_S * 4 / 25)] {
            let mut chip = chip(&LSM303D, &[(0x20, control)]);
            let first = chip.next_event().unwrap();
            chip.sample(None);
            assert_eq!(chip.next_event().unwrap() - first, period);
        }
    }

    #[test]
    fn data_ready_appears_on_its_pin_only_if_told_to() {
        let mut chip = chip(&LSM303D, &[(0x20, 0x9f), (0x21, 0x18)]);
        chip.sample(Some([1, 2, 3]));
        assert!(!chip.data_ready());
        transfer(&mut chip, &[0x22, 0x04]);
        assert!(chip.data_ready());
        let burst = transfer(&mut chip, &[0xe8, 0, 0, 0, 0, 0, 0]);
        assert_eq!(burst[1..], [1, 0, 2, 0, 3, 0]);
        assert!(!chip.data_ready());
    }

    #[test]
    fn another_range_is_noticed() {
        let mut chip = chip(&LSM303D, &[(0x20, 0x9f), (0x21, 0x20)]);
        chip.select(true);
        chip.exchange(0xa8, 1_000_000, TICKS_PER_S).unwrap();
        assert!(chip.exchange(0, 1_000_000, TICKS_PER_S).is_err());
    }
}
