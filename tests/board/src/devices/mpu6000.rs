//! The MPU-6000 on SPI. InvenSense register map RM-MPU-6000A-00, rev. 4.2, by section; product specification 6.2 for
//! the bus.
//!
//! It samples when its own clock says so and keeps the counts that the world gives it. Those are for +-2000 deg/s and
//! +-8 g: another range has no model.

use super::Counts;
use crate::time::{TICKS_PER_S, Ticks};

const SMPLRT_DIV: u8 = 0x19;
const CONFIG: u8 = 0x1a;
const GYRO_CONFIG: u8 = 0x1b;
const ACCEL_CONFIG: u8 = 0x1c;
const INT_PIN_CFG: u8 = 0x37;
const INT_ENABLE: u8 = 0x38;
const INT_STATUS: u8 = 0x3a;
const ACCEL_XOUT_H: u8 = 0x3b;
const USER_CTRL: u8 = 0x6a;
const PWR_MGMT_1: u8 = 0x6b;
const WHO_AM_I: u8 = 0x75;
const REGISTERS: usize = 0x80;

const READ: u8 = 0x80;
const DEVICE_RESET: u8 = 1 << 7;
const SLEEP: u8 = 1 << 6;
const DATA_READY: u8 = 1;
const ACTIVE_LOW: u8 = 1 << 7;
const LATCHED: u8 = 1 << 5;
const CLEARED_BY_ANY_READ: u8 = 1 << 4;

/// Registers other than the sensors' data are for 1 MHz at most (product specification, table 6.2).
const REGISTER_CLOCK_MAX_HZ: u64 = 1_000_000;
/// Those data for 20 MHz.
const DATA_CLOCK_MAX_HZ: u64 = 20_000_000;
/// An unlatched interrupt pulse (4.15).
const PULSE_TICKS: Ticks = 50 * crate::time::TICKS_PER_US;
/// From power or reset until it answers.
const START_TICKS: Ticks = TICKS_PER_S / 1000 * 30;

#[derive(Clone, Debug)]
pub(crate) struct Mpu6000 {
    registers: [u8; REGISTERS],
    powered_at: Option<Ticks>,
    next_sample: Ticks,
    pulse_end: Option<Ticks>,
    /// The register that the running transfer is at, and whether it reads.
    transfer: Option<(u8, bool)>,
    selected: bool,
}

impl Default for Mpu6000 {
    fn default() -> Self {
        Self {
            registers: reset_values(),
            powered_at: None,
            next_sample: 0,
            pulse_end: None,
            transfer: None,
            selected: false,
        }
    }
}

fn reset_values() -> [u8; REGISTERS] {
    let mut registers = [0; REGISTERS];
    registers[usize::from(PWR_MGMT_1)] = SLEEP;
    registers[usize::from(WHO_AM_I)] = 0x68;
    registers
}

impl Mpu6000 {
    fn register(&self, register: u8) -> u8 {
        self.registers[usize::from(register)]
    }

    /// Switches its supply.
    pub(crate) fn power(&mut self, on: bool, now: Ticks) {
        if on == self.powered_at.is_some() {
            return;
        }
        *self = Self { powered_at: on.then_some(now), selected: self.selected, ..Self::default() };
        self.next_sample = now + START_TICKS;
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
        let Some((register, reads)) = self.transfer else {
            self.transfer = Some((byte & !READ, byte & READ != 0));
            return Ok(0);
        };
        self.transfer = Some((if register < 0x7f { register + 1 } else { register }, reads));
        let is_data = (INT_STATUS..=0x48).contains(&register);
        let clock_max_hz = if is_data && reads { DATA_CLOCK_MAX_HZ } else { REGISTER_CLOCK_MAX_HZ };
        if clock_hz > clock_max_hz {
            return Err("MPU6000 accessed faster than it allows");
        }
        if register > INT_STATUS && is_data && !self.has_the_counts_ranges() {
            return Err("MPU6000 ranges other than 2000 deg/s and 8 g");
        }
        if reads {
            return Ok(self.read(register));
        }
        self.write(register, byte, now);
        Ok(0)
    }

    fn has_the_counts_ranges(&self) -> bool {
        self.register(GYRO_CONFIG) >> 3 & 3 == 3 && self.register(ACCEL_CONFIG) >> 3 & 3 == 2
    }

    fn read(&mut self, register: u8) -> u8 {
        let value = self.register(register);
        // 4.17: reading the status clears it, or any read if so configured (4.15)
        if register == INT_STATUS || self.register(INT_PIN_CFG) & CLEARED_BY_ANY_READ != 0 {
            self.registers[usize::from(INT_STATUS)] = 0;
        }
        value
    }

    fn write(&mut self, register: u8, value: u8, now: Ticks) {
        match register {
            PWR_MGMT_1 if value & DEVICE_RESET != 0 => {
                self.registers = reset_values();
                self.pulse_end = None;
                self.powered_at = Some(now);
                self.next_sample = now + START_TICKS;
            }
            PWR_MGMT_1 => {
                let slept = self.register(PWR_MGMT_1) & SLEEP != 0;
                self.registers[usize::from(PWR_MGMT_1)] = value;
                if slept && value & SLEEP == 0 {
                    self.next_sample = now + self.period();
                }
            }
            WHO_AM_I | INT_STATUS..=0x48 => {}
            // 4.30: the reset bits of USER_CTRL clear themselves
            USER_CTRL => self.registers[usize::from(USER_CTRL)] = value & 0xf0,
            _ => self.registers[usize::from(register)] = value,
        }
    }

    /// 4.2 and 4.3: the gyro's rate is 8 kHz, or 1 kHz with the low-pass on, divided by 1 + SMPLRT_DIV.
    fn period(&self) -> Ticks {
        let rate_hz = if matches!(self.register(CONFIG) & 7, 0 | 7) { 8000 } else { 1000 };
        TICKS_PER_S / rate_hz * (u64::from(self.register(SMPLRT_DIV)) + 1)
    }

    fn is_awake(&self) -> bool {
        self.powered_at.is_some() && self.register(PWR_MGMT_1) & SLEEP == 0
    }

    /// When it will take its next sample or end its interrupt pulse.
    pub(crate) fn next_event(&self) -> Option<Ticks> {
        self.is_awake().then_some(self.next_sample).into_iter().chain(self.pulse_end).min()
    }

    /// The time of a sample that is due by now.
    pub(crate) fn sample_due(&self, now: Ticks) -> Option<Ticks> {
        (self.is_awake() && self.next_sample <= now).then_some(self.next_sample)
    }

    /// Takes the sample that is due; without counts it repeats its last.
    pub(crate) fn sample(&mut self, counts: Option<Counts>) {
        let at = self.next_sample;
        self.next_sample += self.period();
        if let Some(Counts { accel, gyro }) = counts {
            let words = [accel[0], accel[1], accel[2], 0, gyro[0], gyro[1], gyro[2]];
            for (index, word) in words.into_iter().enumerate() {
                let first = usize::from(ACCEL_XOUT_H) + 2 * index;
                self.registers[first..first + 2].copy_from_slice(&word.to_be_bytes());
            }
        }
        self.registers[usize::from(INT_STATUS)] |= DATA_READY;
        self.pulse_end = Some(at + PULSE_TICKS);
    }

    pub(crate) fn tick(&mut self, now: Ticks) {
        self.pulse_end = self.pulse_end.filter(|end| *end > now);
    }

    /// Level of its interrupt pin.
    pub(crate) fn interrupt_pin(&self) -> bool {
        let configuration = self.register(INT_PIN_CFG);
        let raised = self.register(INT_ENABLE) & DATA_READY != 0
            && if configuration & LATCHED != 0 {
                self.register(INT_STATUS) & DATA_READY != 0
            } else {
                self.pulse_end.is_some()
            };
        raised != (configuration & ACTIVE_LOW != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLOW_HZ: u64 = 656_250;
    const FAST_HZ: u64 = 10_500_000;

    fn transfer(chip: &mut Mpu6000, bytes: &[u8], clock_hz: u64) -> Vec<Result<u8, &'static str>> {
        chip.select(true);
        let answers = bytes.iter().map(|byte| chip.exchange(*byte, clock_hz, TICKS_PER_S)).collect();
        chip.select(false);
        answers
    }

    fn awake() -> Mpu6000 {
        let mut chip = Mpu6000::default();
        chip.power(true, 0);
        for (register, value) in
            [(PWR_MGMT_1, 1), (CONFIG, 1), (GYRO_CONFIG, 0x18), (ACCEL_CONFIG, 0x10), (INT_ENABLE, 1)]
        {
            transfer(&mut chip, &[register, value], SLOW_HZ);
        }
        chip
    }

    #[test]
    fn it_says_who_it_is_once_it_has_power() {
        let mut chip = Mpu6000::default();
        assert_eq!(transfer(&mut chip, &[WHO_AM_I | READ, 0], SLOW_HZ)[1], Ok(0));
        chip.power(true, 0);
        assert_eq!(transfer(&mut chip, &[WHO_AM_I | READ, 0], SLOW_HZ)[1], Ok(0x68));
        assert_eq!(transfer(&mut chip, &[PWR_MGMT_1 | READ, 0], SLOW_HZ)[1], Ok(SLEEP));
        assert_eq!(chip.next_event(), None);
    }

    #[test]
    fn a_burst_reads_big_endian_words_from_the_status_on() {
        let mut chip = awake();
        chip.sample(Some(Counts { gyro: [1, -2, 0x1234], accel: [0, 0, -4096] }));
        let mut burst = [0; 16];
        burst[0] = INT_STATUS | READ;
        let answers = transfer(&mut chip, &burst, FAST_HZ);
        let bytes = answers.into_iter().map(Result::unwrap).collect::<Vec<_>>();
        assert_eq!(bytes, [0, 1, 0, 0, 0, 0, 0xf0, 0, 0, 0, 0, 1, 0xff, 0xfe, 0x12, 0x34]);
        // read, hence no longer ready
        assert_eq!(transfer(&mut chip, &[INT_STATUS | READ, 0], FAST_HZ)[1], Ok(0));
    }

    #[test]
    fn registers_are_not_for_the_fast_clock() {
        let mut chip = awake();
        assert!(transfer(&mut chip, &[WHO_AM_I | READ, 0], FAST_HZ)[1].is_err());
        assert!(transfer(&mut chip, &[CONFIG, 0], FAST_HZ)[1].is_err());
    }

    #[test]
    fn the_interrupt_pulses_high_for_50_us_or_holds_until_read() {
        let mut chip = awake();
        let at = chip.next_event().unwrap();
        chip.sample(None);
        assert!(chip.interrupt_pin());
        chip.tick(at + PULSE_TICKS);
        assert!(!chip.interrupt_pin());
        transfer(&mut chip, &[INT_PIN_CFG, LATCHED | ACTIVE_LOW], SLOW_HZ);
        assert!(!chip.interrupt_pin());
        transfer(&mut chip, &[INT_STATUS | READ, 0], SLOW_HZ);
        assert!(chip.interrupt_pin());
    }

    #[test]
    fn the_sample_rate_is_divided() {
        let mut chip = awake();
        let first = chip.next_event().unwrap();
        chip.sample(None);
        chip.tick(first + PULSE_TICKS);
        assert_eq!(chip.next_event(), Some(first + TICKS_PER_S / 1000));
        transfer(&mut chip, &[SMPLRT_DIV, 4], SLOW_HZ);
        chip.sample(None);
        chip.tick(first + TICKS_PER_S);
        assert_eq!(chip.next_event(), Some(first + TICKS_PER_S / 1000 * 6));
    }

    #[test]
    fn a_range_that_the_counts_are_not_for_is_noticed() {
        let mut chip = awake();
        transfer(&mut chip, &[GYRO_CONFIG, 0], SLOW_HZ);
        chip.sample(None);
        assert!(transfer(&mut chip, &[ACCEL_XOUT_H | READ, 0], FAST_HZ)[1].is_err());
    }
}
