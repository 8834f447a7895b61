//! The gyro L3GD20 and its successor L3GD20H on SPI1: identity, data rates, ranges, the data-ready pin PB0.
//!
//! Data sheets DocID022116 (L3GD20) and DocID023469 (L3GD20H), section 7. FIFO, high-pass filter, interrupt generator
//! and big-endian output have no model.

use super::st_sensor::{Kind, Registers};
use crate::time::{TICKS_PER_S, Ticks};

const CTRL_REG1: usize = 0x20;
const CTRL_REG3: usize = 0x22;
const CTRL_REG4: usize = 0x23;
const CTRL_REG5: usize = 0x24;
/// L3GD20H only: its low rates, its reset and more; the bit that switches I2C off changes nothing here.
const LOW_ODR: usize = 0x39;
const I2C_OFF: u8 = 1 << 3;

const POWERED_AND_ALL_AXES: u8 = 0b1111;
const POWERED: u8 = 1 << 3;
const DATA_READY_ON_PIN: u8 = 1 << 3;
const BLOCK_DATA_UPDATE: u8 = 1 << 7;
const BIG_ENDIAN: u8 = 1 << 6;
const THREE_WIRES: u8 = 1;
/// FIFO, high-pass filter, output selection.
const FILTERS: u8 = 0b0101_0011;

/// Samples in ten seconds by the two highest bits of CTRL_REG1. What the L3GD20H's register table calls 100 to 800 Hz
/// is 94.7 to 757.6 Hz in its characteristics.
const SAMPLES_IN_10_S: [u64; 4] = [950, 1900, 3800, 7600];
const SAMPLES_IN_10_S_H: [u64; 4] = [947, 1894, 3788, 7576];

/// CTRL_REG1 starts with all axes on, in power-down.
const RESET_VALUES: &[(u8, u8)] = &[(CTRL_REG1 as u8, 0x07)];

/// The one of most boards.
pub(crate) const L3GD20: Kind = Kind {
    identity: 0xd4,
    reset_values: RESET_VALUES,
    period: |registers| period(registers, &SAMPLES_IN_10_S),
    drives_data_ready,
    holds_while_read,
    check_settings,
    counts_at_range,
    too_fast: "L3GD20 accessed at more than 10 MHz",
};

/// The one of later boards.
pub(crate) const L3GD20H: Kind = Kind {
    identity: 0xd7,
    reset_values: RESET_VALUES,
    period: |registers| period(registers, &SAMPLES_IN_10_S_H),
    drives_data_ready,
    holds_while_read,
    check_settings: |registers| match registers[LOW_ODR] {
        0 | I2C_OFF => check_settings(registers),
        _ => Err("L3GD20H with LOW_ODR"),
    },
    counts_at_range,
    too_fast: "L3GD20H accessed at more than 10 MHz",
};

fn period(registers: &Registers, samples_in_10_s: &[u64; 4]) -> Option<Ticks> {
    let control = registers[CTRL_REG1];
    (control & POWERED != 0).then(|| 10 * TICKS_PER_S / samples_in_10_s[usize::from(control >> 6)])
}

fn drives_data_ready(registers: &Registers) -> bool {
    registers[CTRL_REG3] & DATA_READY_ON_PIN != 0
}

fn holds_while_read(registers: &Registers) -> bool {
    registers[CTRL_REG4] & BLOCK_DATA_UPDATE != 0
}

/// 8.75, 17.5 and 70 thousandths of a degree a second to the count, by bits 5 and 4 of CTRL_REG4 (table 4).
fn counts_at_range(registers: &Registers) -> f64 {
    match registers[CTRL_REG4] >> 4 & 0b11 {
        0 => 70.0 / 8.75,
        1 => 70.0 / 17.5,
        _ => 1.0,
    }
}

/// The counts are for +-2000 deg/s.
fn check_settings(registers: &Registers) -> Result<(), &'static str> {
    let is_2000_deg_s = registers[CTRL_REG4] & 1 << 5 != 0;
    let plain = registers[CTRL_REG4] & (BIG_ENDIAN | THREE_WIRES) == 0 && registers[CTRL_REG5] & FILTERS == 0;
    let all_axes = registers[CTRL_REG1] & POWERED_AND_ALL_AXES == POWERED_AND_ALL_AXES;
    match (is_2000_deg_s, plain && all_axes) {
        (true, true) => Ok(()),
        (false, _) => Err("L3GD20 range other than 2000 deg/s"),
        (true, false) => Err("L3GD20 with axes off, filters, FIFO, three wires or big-endian output"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::st_sensor::StSensor;
    use crate::devices::st_sensor::tests::{chip, register};

    const READ: u8 = 0x80;

    #[test]
    fn the_two_tell_their_names_and_start_in_power_down() {
        for (kind, identity) in [(&L3GD20, 0xd4), (&L3GD20H, 0xd7)] {
            let mut chip = chip(kind, &[]);
            assert_eq!(register(&mut chip, 0x0f), identity);
            assert_eq!(register(&mut chip, 0x20), 0x07);
            assert_eq!(chip.next_event(), None);
        }
    }

    #[test]
    fn they_sample_at_their_own_rates() {
        for (kind, control, in_10_s) in [(&L3GD20, 0xcf, 7600), (&L3GD20, 0x0f, 950), (&L3GD20H, 0xcf, 7576)] {
            let mut chip = chip(kind, &[(0x20, control)]);
            let first = chip.next_event().unwrap();
            chip.sample(None);
            assert_eq!(chip.next_event().unwrap() - first, 10 * TICKS_PER_S / in_10_s);
        }
    }

    fn read_x(chip: &mut StSensor) -> Result<u8, &'static str> {
        chip.select(true);
        chip.exchange(READ | 0x28, 1_000_000, TICKS_PER_S)?;
        let answer = chip.exchange(0, 1_000_000, TICKS_PER_S);
        chip.select(false);
        answer
    }

    #[test]
    fn another_range_or_a_missing_axis_is_noticed() {
        assert!(read_x(&mut chip(&L3GD20, &[(0x20, 0xcf)])).is_err());
        assert!(read_x(&mut chip(&L3GD20, &[(0x20, 0xcd), (0x23, 0x30)])).is_err());
        assert!(read_x(&mut chip(&L3GD20, &[(0x20, 0xcf), (0x23, 0x30)])).is_ok());
        assert!(read_x(&mut chip(&L3GD20H, &[(0x20, 0xcf), (0x23, 0x30), (0x39, 1)])).is_err());
    }
}
