//! What the L3GD20 and the LSM303D have in common: ST's serial interface, a status register, three output words.
//!
//! Data sheets: DocID022116 (L3GD20) sections 5.2 and 7; DocID023312 (LSM303D) sections 6.2 and 8. The first byte of a
//! transfer is read (bit 7), auto-increment (bit 6) and the register. An axis' data-available bit falls when its high
//! byte is read, that of all three with the last of them.

use crate::time::{TICKS_PER_S, Ticks};

const READ: u8 = 1 << 7;
const AUTO_INCREMENT: u8 = 1 << 6;
const REGISTER: u8 = 0x3f;
/// Registers of one chip.
pub(crate) const REGISTERS: usize = 0x40;

const WHO_AM_I: u8 = 0x0f;
const STATUS: u8 = 0x27;
const OUT_X_L: u8 = 0x28;
const OUT_Z_H: u8 = 0x2d;

const ALL_AVAILABLE: u8 = 1 << 3;
const ALL_OVERRUN: u8 = 1 << 7;
const AXES: u8 = 0b111;

const CLOCK_MAX_HZ: u64 = 10_000_000;
/// From power until it answers: its calibration is loaded.
const START_TICKS: Ticks = TICKS_PER_S / 100;

/// Its registers, as they were written.
pub(crate) type Registers = [u8; REGISTERS];

/// What tells one chip from the other.
#[derive(Debug)]
pub(crate) struct Kind {
    pub(crate) identity: u8,
    /// Registers that are not 0 after power-on.
    pub(crate) reset_values: &'static [(u8, u8)],
    /// Time between samples; none in power-down.
    pub(crate) period: fn(&Registers) -> Option<Ticks>,
    /// Is its data-ready pin told to show that data are there?
    pub(crate) drives_data_ready: fn(&Registers) -> bool,
    /// Do the output registers change only between reads of an axis' two bytes?
    pub(crate) holds_while_read: fn(&Registers) -> bool,
    /// Are these the settings that the world's counts are for?
    pub(crate) check_settings: fn(&Registers) -> Result<(), &'static str>,
    /// Counts at the range that is set over those at the range of the world's counts.
    pub(crate) counts_at_range: fn(&Registers) -> f64,
    /// What is said of a clock that is too fast.
    pub(crate) too_fast: &'static str,
}

#[derive(Clone, Debug)]
pub(crate) struct StSensor {
    kind: &'static Kind,
    registers: Registers,
    powered_at: Option<Ticks>,
    next_sample: Option<Ticks>,
    selected: bool,
    /// The register that the running transfer is at, whether it reads, whether it walks on.
    transfer: Option<(u8, bool, bool)>,
    /// The axis of which only the low byte has been read, and what came for it meanwhile.
    half_read: Option<usize>,
    waiting: Option<i16>,
    /// A test has turned its settings: its counts then follow its range.
    upset: bool,
    /// What it holds in a register whatever is written.
    stuck: Option<(u8, u8)>,
}

impl StSensor {
    /// Without power.
    pub(crate) fn new(kind: &'static Kind) -> Self {
        let mut registers = [0; REGISTERS];
        registers[usize::from(WHO_AM_I)] = kind.identity;
        for (register, value) in kind.reset_values {
            registers[usize::from(*register)] = *value;
        }
        Self {
            kind,
            registers,
            powered_at: None,
            next_sample: None,
            selected: false,
            transfer: None,
            half_read: None,
            waiting: None,
            upset: false,
            stuck: None,
        }
    }

    /// Switches its supply.
    pub(crate) fn power(&mut self, on: bool, now: Ticks) {
        if on != self.powered_at.is_some() {
            *self = Self { powered_at: on.then_some(now), selected: self.selected, ..Self::new(self.kind) };
        }
    }

    /// A dip of its supply that nobody else noticed: as after power-on, in power-down.
    pub(crate) fn lose_settings(&mut self, now: Ticks) {
        self.power(false, now);
        self.power(true, now);
        self.upset = true;
    }

    /// A register holds another value from now on, for good if it keeps nothing else.
    pub(crate) fn turn_register(&mut self, register: u8, value: u8, for_good: bool) {
        self.registers[usize::from(register)] = value;
        self.upset = true;
        self.stuck = for_good.then_some((register, value));
    }

    /// Chip select; a transfer begins when it falls.
    pub(crate) fn select(&mut self, low: bool) {
        if low != self.selected {
            self.transfer = None;
        }
        self.selected = low;
    }

    /// One byte each way, at this clock. An error says why what comes out is not to be relied upon.
    pub(crate) fn exchange(&mut self, byte: u8, clock_hz: u64, now: Ticks) -> Result<u8, &'static str> {
        if self.powered_at.is_none_or(|at| now < at + START_TICKS) {
            return Ok(0);
        }
        if clock_hz > CLOCK_MAX_HZ {
            return Err(self.kind.too_fast);
        }
        let Some((register, reads, walks)) = self.transfer else {
            self.transfer = Some((byte & REGISTER, byte & READ != 0, byte & AUTO_INCREMENT != 0));
            return Ok(0);
        };
        self.transfer = Some((if walks { (register + 1) & REGISTER } else { register }, reads, walks));
        if reads {
            return self.read(register);
        }
        self.write(register, byte, now);
        Ok(0)
    }

    fn read(&mut self, register: u8) -> Result<u8, &'static str> {
        let value = self.registers[usize::from(register)];
        if (OUT_X_L..=OUT_Z_H).contains(&register) {
            if !self.upset {
                (self.kind.check_settings)(&self.registers)?;
            }
            let (axis, is_high) = (usize::from((register - OUT_X_L) / 2), register & 1 != 0);
            if is_high {
                self.axis_was_read(axis);
            } else {
                self.half_read = Some(axis);
            }
        }
        Ok(value)
    }

    fn axis_was_read(&mut self, axis: usize) {
        let status = &mut self.registers[usize::from(STATUS)];
        *status &= !(0x11 << axis);
        if *status & AXES == 0 {
            *status &= !(ALL_AVAILABLE | ALL_OVERRUN);
        }
        if self.half_read.take() == Some(axis)
            && let Some(word) = self.waiting.take()
        {
            self.output(axis, word);
        }
    }

    fn write(&mut self, register: u8, value: u8, now: Ticks) {
        if register == WHO_AM_I || (STATUS..=OUT_Z_H).contains(&register) {
            return;
        }
        let before = (self.kind.period)(&self.registers);
        self.registers[usize::from(register)] = value;
        if let Some((register, value)) = self.stuck {
            self.registers[usize::from(register)] = value;
        }
        let period = (self.kind.period)(&self.registers);
        if period != before {
            self.next_sample = period.map(|period| now + period);
        }
    }

    /// When it will take its next sample.
    pub(crate) fn next_event(&self) -> Option<Ticks> {
        self.next_sample
    }

    /// The time of a sample that is due by now.
    pub(crate) fn sample_due(&self, now: Ticks) -> Option<Ticks> {
        self.next_sample.filter(|at| *at <= now)
    }

    /// Takes the sample that is due; without words it repeats its last.
    pub(crate) fn sample(&mut self, words: Option<[i16; 3]>) {
        self.next_sample = self.next_sample.zip((self.kind.period)(&self.registers)).map(|(at, period)| at + period);
        let factor = (self.kind.counts_at_range)(&self.registers);
        for (axis, word) in words.into_iter().flatten().enumerate() {
            // `as` saturates, as the chip does at full scale
            let word = (f64::from(word) * factor) as i16;
            if self.half_read == Some(axis) && (self.kind.holds_while_read)(&self.registers) {
                self.waiting = Some(word);
            } else {
                self.output(axis, word);
            }
        }
        let status = &mut self.registers[usize::from(STATUS)];
        let lost = *status & AXES;
        *status |= lost << 4 | if lost != 0 { ALL_OVERRUN } else { 0 } | AXES | ALL_AVAILABLE;
    }

    fn output(&mut self, axis: usize, word: i16) {
        let low = usize::from(OUT_X_L) + 2 * axis;
        self.registers[low..low + 2].copy_from_slice(&word.to_le_bytes());
    }

    /// Level of its data-ready pin.
    pub(crate) fn data_ready(&self) -> bool {
        self.registers[usize::from(STATUS)] & ALL_AVAILABLE != 0 && (self.kind.drives_data_ready)(&self.registers)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    const CLOCK_HZ: u64 = 5_250_000;

    pub(crate) fn transfer(chip: &mut StSensor, bytes: &[u8]) -> Vec<u8> {
        chip.select(true);
        let answers = bytes.iter().map(|byte| chip.exchange(*byte, CLOCK_HZ, TICKS_PER_S).unwrap()).collect();
        chip.select(false);
        answers
    }

    pub(crate) fn register(chip: &mut StSensor, register: u8) -> u8 {
        transfer(chip, &[READ | register, 0])[1]
    }

    /// Powered, with these registers written.
    pub(crate) fn chip(kind: &'static Kind, settings: &[(u8, u8)]) -> StSensor {
        let mut chip = StSensor::new(kind);
        chip.power(true, 0);
        for (register, value) in settings {
            transfer(&mut chip, &[*register, *value]);
        }
        chip
    }

    fn gyro() -> StSensor {
        chip(&crate::devices::l3gd20::L3GD20, &[(0x20, 0xff), (0x22, 0x08), (0x23, 0xb0)])
    }

    #[test]
    fn without_power_it_is_mute_and_power_loss_forgets() {
        let mut chip = gyro();
        assert_eq!(register(&mut chip, 0x23), 0xb0);
        chip.power(false, 0);
        assert_eq!(register(&mut chip, WHO_AM_I), 0);
        chip.power(true, 0);
        assert_eq!(register(&mut chip, 0x23), 0);
    }

    #[test]
    fn only_the_auto_increment_bit_walks_on() {
        let mut chip = gyro();
        chip.sample(Some([0x0102, 0x0304, 0x0506]));
        assert_eq!(transfer(&mut chip, &[READ | OUT_X_L, 0, 0, 0])[1..], [2, 2, 2]);
        let burst = transfer(&mut chip, &[READ | AUTO_INCREMENT | STATUS, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(burst[1..], [0x0f, 2, 1, 4, 3, 6, 5]);
    }

    #[test]
    fn data_are_available_until_all_high_bytes_are_read() {
        let mut chip = gyro();
        assert!(!chip.data_ready());
        chip.sample(Some([1, 2, 3]));
        assert!(chip.data_ready());
        transfer(&mut chip, &[READ | AUTO_INCREMENT | OUT_X_L, 0, 0, 0, 0]);
        assert_eq!(register(&mut chip, STATUS), ALL_AVAILABLE | 1 << 2);
        assert!(chip.data_ready());
        // the low byte is not enough
        register(&mut chip, OUT_X_L + 4);
        assert!(chip.data_ready());
        register(&mut chip, OUT_Z_H);
        assert_eq!(register(&mut chip, STATUS), 0);
        assert!(!chip.data_ready());
    }

    #[test]
    fn a_sample_that_nobody_read_is_an_overrun() {
        let mut chip = gyro();
        chip.sample(Some([1, 2, 3]));
        chip.sample(Some([4, 5, 6]));
        assert_eq!(register(&mut chip, STATUS), 0xff);
        assert_eq!(register(&mut chip, OUT_X_L), 4);
    }

    #[test]
    fn an_axis_that_is_being_read_does_not_change_where_it_is_told_to_hold() {
        let mut chip = gyro();
        chip.sample(Some([0x0102, 0, 0]));
        assert_eq!(register(&mut chip, OUT_X_L), 2);
        chip.sample(Some([0x0304, 0, 0]));
        assert_eq!(register(&mut chip, OUT_X_L + 1), 1);
        assert_eq!(transfer(&mut chip, &[READ | AUTO_INCREMENT | OUT_X_L, 0, 0])[1..], [4, 3]);
        // without block data update it is torn
        transfer(&mut chip, &[0x23, 0x30]);
        register(&mut chip, OUT_X_L);
        chip.sample(Some([0x0506, 0, 0]));
        assert_eq!(register(&mut chip, OUT_X_L + 1), 5);
    }

    #[test]
    fn settings_that_are_lost_or_turned_change_what_it_says() {
        let mut chip = gyro();
        chip.turn_register(0x23, 0x80, true);
        transfer(&mut chip, &[0x23, 0xb0]);
        assert_eq!(register(&mut chip, 0x23), 0x80);
        // 8.75 instead of 70 thousandths of a degree a second to the count, and full scale
        chip.sample(Some([100, -100, 30_000]));
        let burst = transfer(&mut chip, &[READ | AUTO_INCREMENT | OUT_X_L, 0, 0, 0, 0, 0, 0]);
        assert_eq!(burst[1..], [800i16.to_le_bytes(), (-800i16).to_le_bytes(), i16::MAX.to_le_bytes()].concat());
        chip.lose_settings(0);
        assert_eq!((register(&mut chip, 0x23), chip.next_event()), (0, None));
    }

    #[test]
    fn it_is_not_for_more_than_10_mhz() {
        let mut chip = gyro();
        chip.select(true);
        assert!(chip.exchange(READ | WHO_AM_I, 10_500_000, TICKS_PER_S).is_err());
    }
}
