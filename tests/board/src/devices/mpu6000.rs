//! The MPU-6000 on SPI. InvenSense register map RM-MPU-6000A-00, rev. 4.2, by section; product specification 6.2 for
//! the bus.
//!
//! It samples when its own clock says so and keeps the counts that the world gives it. Those are for +-2000 deg/s and
//! +-8 g: another range has no model. How it comes up is [`super::mpu6000_start`]'s.

use super::Counts;
use super::mpu6000_start::Start;
use crate::time::{TICKS_PER_S, Ticks};

const PRODUCT_ID: u8 = 0x0c;
const SMPLRT_DIV: u8 = 0x19;
const CONFIG: u8 = 0x1a;
const GYRO_CONFIG: u8 = 0x1b;
const ACCEL_CONFIG: u8 = 0x1c;
const INT_PIN_CFG: u8 = 0x37;
const INT_ENABLE: u8 = 0x38;
const INT_STATUS: u8 = 0x3a;
const ACCEL_XOUT_H: u8 = 0x3b;
const TEMP_OUT_H: u8 = 0x41;
const SIGNAL_PATH_RESET: u8 = 0x68;
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
/// All three of SIGNAL_PATH_RESET (4.24).
const ALL_PATHS: u8 = 0b111;
/// From the last clock edge to the rise of chip select, at register speed (product specification, section 6.8).
const SELECT_HOLD: Ticks = crate::time::TICKS_PER_US / 2;
/// Said of a shorter one.
pub const SELECT_HOLD_TOO_SHORT: &str =
    "MPU6000 deselected within 500 ns of the last clock edge (PS-MPU-6000A section 6.8, tHD.CS)";
/// Warming from 25 deg C by as much as PX4 logs show, within minutes; 340 counts a degree, 0 at 36.53 (4.19).
const COLD_C: f64 = 25.0;
const WARMING_C: f64 = 15.0;
const WARMING_S: f64 = 120.0;

/// Two generations are in the field. PX4's mpu6000.h lists their PRODUCT_ID; in the first, revision C, the ranges of
/// the accelerometer are twice those of the register map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mpu6000Revision {
    /// C5.
    C,
    /// D8.
    #[default]
    D,
    /// None: a clone of the board has an MPU-9250 in its place (RM-MPU-9250A: WHO_AM_I 0x71).
    Mpu9250,
    /// None: an ICM-20608 (DS-000081: WHO_AM_I 0xaf).
    Icm20608,
}

impl Mpu6000Revision {
    fn product_id(self) -> u8 {
        match self {
            Self::C => 0x55,
            Self::D => 0x58,
            Self::Mpu9250 | Self::Icm20608 => 0,
        }
    }

    fn who_am_i(self) -> u8 {
        match self {
            Self::C | Self::D => 0x68,
            Self::Mpu9250 => 0x71,
            Self::Icm20608 => 0xaf,
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Mpu6000 {
    registers: [u8; REGISTERS],
    revision: Mpu6000Revision,
    start: Start,
    powered_at: Ticks,
    /// The last byte that went over the bus ended then, if it was at register speed.
    last_slow_byte: Option<Ticks>,
    next_sample: Ticks,
    pulse_end: Option<Ticks>,
    /// The register that the running transfer is at, and whether it reads.
    transfer: Option<(u8, bool)>,
    selected: bool,
    /// A test has turned its settings: its counts then follow its ranges.
    upset: bool,
    /// What it holds in a register whatever is written.
    stuck: Option<(u8, u8)>,
}

impl Default for Mpu6000 {
    fn default() -> Self {
        Self {
            registers: reset_values(Mpu6000Revision::default()),
            revision: Mpu6000Revision::default(),
            start: Start::default(),
            powered_at: 0,
            last_slow_byte: None,
            next_sample: 0,
            pulse_end: None,
            transfer: None,
            selected: false,
            upset: false,
            stuck: None,
        }
    }
}

fn reset_values(revision: Mpu6000Revision) -> [u8; REGISTERS] {
    let mut registers = [0; REGISTERS];
    registers[usize::from(PRODUCT_ID)] = revision.product_id();
    registers[usize::from(PWR_MGMT_1)] = SLEEP;
    registers[usize::from(WHO_AM_I)] = revision.who_am_i();
    registers
}

impl Mpu6000 {
    fn register(&self, register: u8) -> u8 {
        self.registers[usize::from(register)]
    }

    /// Switches its supply.
    pub(crate) fn power(&mut self, on: bool, now: Ticks) {
        if on == self.start.is_powered() {
            return;
        }
        let (mut start, revision, selected) = (self.start, self.revision, self.selected);
        start.power(on, now);
        *self = Self { start, revision, powered_at: now, selected, ..Self::default() };
        self.registers = reset_values(revision);
    }

    /// A dip of its supply that nobody else noticed: as after power-on, asleep.
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

    /// How it comes up.
    pub(crate) fn start_mut(&mut self) -> &mut Start {
        &mut self.start
    }

    /// Another chip is soldered in.
    pub(crate) fn set_revision(&mut self, revision: Mpu6000Revision) {
        self.revision = revision;
        self.registers[usize::from(PRODUCT_ID)] = revision.product_id();
        self.registers[usize::from(WHO_AM_I)] = revision.who_am_i();
    }

    /// Chip select; a transfer begins when it falls.
    ///
    /// # Errors
    /// If it rises too soon after the last byte.
    pub(crate) fn select(&mut self, low: bool, now: Ticks) -> Result<(), &'static str> {
        if low == self.selected {
            return Ok(());
        }
        self.transfer = None;
        self.selected = low;
        match self.last_slow_byte.take() {
            Some(end) if !low && now < end + SELECT_HOLD => Err(SELECT_HOLD_TOO_SHORT),
            _ => Ok(()),
        }
    }

    /// One byte each way, at this clock. An error says why what comes out is not to be relied upon.
    pub(crate) fn exchange(&mut self, byte: u8, clock_hz: u64, now: Ticks) -> Result<u8, &'static str> {
        self.last_slow_byte = (clock_hz <= REGISTER_CLOCK_MAX_HZ).then_some(now);
        if !self.start.hears(now) {
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
        if !self.start.answers(now) {
            // all transfers come as zero; a reset gets through
            if !reads && register == PWR_MGMT_1 && byte & DEVICE_RESET != 0 {
                self.start.reset(now);
            }
            return Ok(0);
        }
        if register > INT_STATUS && is_data && reads && !self.upset && !self.has_the_counts_ranges() {
            return Err("MPU6000 ranges other than 2000 deg/s and 8 g");
        }
        if reads {
            return Ok(self.read(register, now));
        }
        self.write(register, byte, now);
        Ok(0)
    }

    /// Are the data to be relied upon that a transfer reads which begins with this byte?
    ///
    /// # Errors
    /// If a reset has left the signal paths undefined.
    pub(crate) fn check_data_after(&self, first: u8) -> Result<(), &'static str> {
        let reads_data = first & READ != 0 && (INT_STATUS..=0x48).contains(&(first & !READ));
        if self.transfer.is_none() && reads_data { self.start.check_data() } else { Ok(()) }
    }

    /// Revision C has 8 g where the register map says 4, and 16 where it says 8: half the counts.
    fn has_the_counts_ranges(&self) -> bool {
        let range = self.register(ACCEL_CONFIG) >> 3 & 3;
        let right = range == 2 || self.revision == Mpu6000Revision::C && range == 1;
        self.register(GYRO_CONFIG) >> 3 & 3 == 3 && right
    }

    fn accel_divisor(&self) -> i16 {
        let is_16_g = self.revision == Mpu6000Revision::C && self.register(ACCEL_CONFIG) >> 3 & 3 == 2;
        if is_16_g { 2 } else { 1 }
    }

    /// The world's counts are for 2000 deg/s; half the range has twice the counts, up to full scale (4.4).
    fn at_gyro_range(&self, count: i16) -> i16 {
        let range = self.register(GYRO_CONFIG) >> 3 & 3;
        (i32::from(count) << (3 - range)).clamp(i16::MIN.into(), i16::MAX.into()) as i16
    }

    /// The thermometer's counts.
    fn temperature(&self, now: Ticks) -> i16 {
        let age_s = now.saturating_sub(self.powered_at) as f64 / TICKS_PER_S as f64;
        let celsius = COLD_C + WARMING_C * (1.0 - (-age_s / WARMING_S).exp());
        ((celsius - 36.53) * 340.0) as i16
    }

    fn read(&mut self, register: u8, now: Ticks) -> u8 {
        let value = match register {
            TEMP_OUT_H => self.temperature(now).to_be_bytes()[0],
            0x42 => self.temperature(now).to_be_bytes()[1],
            _ => self.register(register),
        };
        // 4.17: reading the status clears it, or any read if so configured (4.15)
        if register == INT_STATUS || self.register(INT_PIN_CFG) & CLEARED_BY_ANY_READ != 0 {
            self.registers[usize::from(INT_STATUS)] = 0;
        }
        value
    }

    fn write(&mut self, register: u8, value: u8, now: Ticks) {
        match register {
            PWR_MGMT_1 if value & DEVICE_RESET != 0 => {
                self.registers = reset_values(self.revision);
                self.pulse_end = None;
                self.start.reset(now);
            }
            SIGNAL_PATH_RESET if value & ALL_PATHS == ALL_PATHS => self.start.reset_paths(now),
            SIGNAL_PATH_RESET => {}
            PWR_MGMT_1 => {
                let slept = self.register(PWR_MGMT_1) & SLEEP != 0;
                self.registers[usize::from(PWR_MGMT_1)] = value;
                if slept && value & SLEEP == 0 {
                    self.next_sample = now + self.period();
                }
            }
            PRODUCT_ID | WHO_AM_I | INT_STATUS..=0x48 => {}
            // 4.30: the reset bits of USER_CTRL clear themselves
            USER_CTRL => self.registers[usize::from(USER_CTRL)] = value & 0xf0,
            _ => self.registers[usize::from(register)] = value,
        }
        if let Some((register, value)) = self.stuck {
            self.registers[usize::from(register)] = value;
        }
    }

    /// 4.2 and 4.3: the gyro's rate is 8 kHz, or 1 kHz with the low-pass on, divided by 1 + SMPLRT_DIV.
    fn period(&self) -> Ticks {
        let rate_hz = if matches!(self.register(CONFIG) & 7, 0 | 7) { 8000 } else { 1000 };
        TICKS_PER_S / rate_hz * (u64::from(self.register(SMPLRT_DIV)) + 1)
    }

    fn is_awake(&self) -> bool {
        self.start.is_powered() && self.register(PWR_MGMT_1) & SLEEP == 0
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
            let accel = accel.map(|count| count / self.accel_divisor());
            let gyro = gyro.map(|count| self.at_gyro_range(count));
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
        chip.select(true, TICKS_PER_S).unwrap();
        let answers = bytes.iter().map(|byte| chip.exchange(*byte, clock_hz, TICKS_PER_S)).collect();
        chip.select(false, 2 * TICKS_PER_S).unwrap();
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
        let mut bytes = answers.into_iter().map(Result::unwrap).collect::<Vec<_>>();
        let temperature = i16::from_be_bytes([bytes.remove(8), bytes.remove(8)]);
        assert_eq!(bytes, [0, 1, 0, 0, 0, 0, 0xf0, 0, 0, 1, 0xff, 0xfe, 0x12, 0x34]);
        // 25 deg C, a second after power
        assert!((f64::from(temperature) / 340.0 + 36.53 - 25.1).abs() < 0.1, "{temperature}");
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

    #[test]
    fn revision_c_has_twice_the_range() {
        for (revision, id, config, z) in [
            (Mpu6000Revision::D, 0x58, 0x10, -4096),
            (Mpu6000Revision::C, 0x55, 0x10, -2048),
            (Mpu6000Revision::C, 0x55, 0x08, -4096),
        ] {
            let mut chip = awake();
            chip.set_revision(revision);
            assert_eq!(transfer(&mut chip, &[PRODUCT_ID | READ, 0], SLOW_HZ)[1], Ok(id));
            transfer(&mut chip, &[ACCEL_CONFIG, config], SLOW_HZ);
            chip.sample(Some(Counts { gyro: [0; 3], accel: [0, 0, -4096] }));
            let answers = transfer(&mut chip, &[0x3f | READ, 0, 0], FAST_HZ);
            assert_eq!(i16::from_be_bytes([answers[1].unwrap(), answers[2].unwrap()]), z, "{revision:?} {config:#x}");
        }
    }

    #[test]
    fn select_holds_for_500_ns_behind_slow_bytes_only() {
        for (clock_hz, wait, allowed) in
            [(SLOW_HZ, SELECT_HOLD - 1, false), (SLOW_HZ, SELECT_HOLD, true), (FAST_HZ, 1, true)]
        {
            let mut chip = awake();
            chip.select(true, TICKS_PER_S).unwrap();
            chip.exchange(INT_STATUS | READ, clock_hz, TICKS_PER_S).unwrap();
            assert_eq!(chip.select(false, TICKS_PER_S + wait).is_ok(), allowed, "{clock_hz} {wait}");
        }
    }

    #[test]
    fn after_a_device_reset_data_want_the_signal_paths_reset() {
        let mut chip = awake();
        transfer(&mut chip, &[PWR_MGMT_1, DEVICE_RESET], SLOW_HZ);
        let later = 2 * TICKS_PER_S;
        let at = |chip: &mut Mpu6000, bytes: &[u8], now| {
            chip.select(true, now).unwrap();
            let last = bytes.iter().map(|byte| chip.exchange(*byte, SLOW_HZ, now)).last().unwrap();
            chip.select(false, now + TICKS_PER_S / 100).unwrap();
            last
        };
        for (register, value) in [(GYRO_CONFIG, 0x18), (ACCEL_CONFIG, 0x10)] {
            at(&mut chip, &[register, value], later).unwrap();
        }
        assert!(chip.check_data_after(ACCEL_XOUT_H | READ).is_err());
        assert!(chip.check_data_after(WHO_AM_I | READ).is_ok());
        at(&mut chip, &[SIGNAL_PATH_RESET, ALL_PATHS], later).unwrap();
        assert!(chip.check_data_after(ACCEL_XOUT_H | READ).is_ok());
        assert!(at(&mut chip, &[ACCEL_XOUT_H | READ, 0], later + TICKS_PER_S).is_ok());
    }
}
