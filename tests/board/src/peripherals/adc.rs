//! Analog-to-digital converter ADC1. RM0090 section 13.13. Regular sequences started by software, once or without end,
//! 12 bits, right-aligned, read by DMA or by the core. Injected channels, triggers, watchdog and interrupts have no
//! model.
//!
//! Conversions are caught up with whenever the board is looked at: nothing waits for one of them.

use super::{Peripheral, Unmodelled};
use crate::time::{TICKS_PER_S, TICKS_PER_US, Ticks};

const EOC: u32 = 1 << 1;
const STRT: u32 = 1 << 4;
const OVR: u32 = 1 << 5;

const SCAN: u32 = 1 << 8;
const ADON: u32 = 1;
const CONT: u32 = 1 << 1;
const DMA: u32 = 1 << 8;
const DDS: u32 = 1 << 9;
const EOCS: u32 = 1 << 10;
const SWSTART: u32 = 1 << 30;
const USED_CONTROL_2: u32 = ADON | CONT | DMA | DDS | EOCS | SWSTART;

/// The registers that all three converters share.
const COMMON_CONTROL: u32 = 0x304;
const PRESCALER: u32 = 0b11 << 16;

/// Sampling takes this many cycles by SMPx, then twelve bits take one each.
const SAMPLE_CYCLES: [u64; 8] = [3, 15, 28, 56, 84, 112, 144, 480];
const BIT_CYCLES: u64 = 12;
/// Data sheet, table 74: 36 MHz, and 3 us from ADON until it is stable.
const CLOCK_MAX_HZ: u64 = 36_000_000;
const START_TICKS: Ticks = 3 * TICKS_PER_US;

#[derive(Clone, Debug, Default)]
pub(crate) struct Adc {
    bus_cycle: Ticks,
    status: u32,
    control: [u32; 2],
    sample_times: [u32; 2],
    sequence: [u32; 3],
    common: u32,
    data: u32,
    /// A result that neither the core nor DMA has fetched.
    waiting: bool,
    stable_at: Ticks,
    /// Place in the sequence of the conversion under way, and its end.
    converting: Option<(u32, Ticks)>,
}

impl Adc {
    pub(crate) fn set_bus_cycle(&mut self, cycle: Ticks) {
        self.bus_cycle = cycle;
    }

    fn channel(&self, place: u32) -> u32 {
        // SQR3 holds the first six, SQR2 the next
        let register = self.sequence[2 - (place / 6) as usize];
        register >> (5 * (place % 6)) & 0x1f
    }

    fn last_place(&self) -> u32 {
        if self.control[0] & SCAN != 0 { self.sequence[0] >> 20 & 0xf } else { 0 }
    }

    fn conversion_ticks(&self, place: u32) -> Ticks {
        let channel = self.channel(place);
        // SMPR2 is for channels 0 to 9
        let (register, index) = if channel < 10 { (1, channel) } else { (0, channel - 10) };
        let sampling = SAMPLE_CYCLES[(self.sample_times[register] >> (3 * index) & 7) as usize];
        (sampling + BIT_CYCLES) * self.clock_ticks()
    }

    fn clock_ticks(&self) -> Ticks {
        self.bus_cycle * (2 + 2 * u64::from((self.common & PRESCALER) >> 16))
    }

    /// The channel of a conversion that has ended by now. Its result goes to [`Adc::result`].
    pub(crate) fn converted(&self, now: Ticks) -> Option<u32> {
        let (place, end) = self.converting?;
        (end <= now).then(|| self.channel(place))
    }

    /// What that channel's voltage was, in counts.
    pub(crate) fn result(&mut self, counts: u16) {
        let Some((place, end)) = self.converting.take() else { return };
        let is_last = place == self.last_place();
        if self.waiting && self.control[1] & (DMA | EOCS) != 0 {
            // the converter stops until software has cleared this (section 13.8.1)
            self.status |= OVR;
            return;
        }
        self.data = u32::from(counts);
        self.waiting = true;
        if is_last || self.control[1] & EOCS != 0 {
            self.status |= EOC;
        }
        let next = if is_last { 0 } else { place + 1 };
        if !is_last || self.control[1] & CONT != 0 {
            self.converting = Some((next, end + self.conversion_ticks(next)));
        }
    }

    pub(crate) fn requests_dma(&self) -> bool {
        self.control[1] & DMA != 0 && self.waiting && self.status & OVR == 0
    }

    /// When the conversion under way ends.
    pub(crate) fn next_end(&self) -> Option<Ticks> {
        self.converting.map(|(_, end)| end)
    }

    fn write_control_2(&mut self, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        if value & !USED_CONTROL_2 != 0 {
            return Err(Unmodelled("ADC other than right-aligned and started by software"));
        }
        if value & (DMA | DDS) == DMA {
            return Err(Unmodelled("ADC with DMA that ends after a block"));
        }
        if value & ADON != 0 && self.control[1] & ADON == 0 {
            self.stable_at = now + START_TICKS;
        }
        self.control[1] = value & !SWSTART;
        if value & ADON == 0 {
            self.converting = None;
        } else if value & SWSTART != 0 {
            self.start(now)?;
        }
        Ok(())
    }

    fn start(&mut self, now: Ticks) -> Result<(), Unmodelled> {
        if now < self.stable_at {
            return Err(Unmodelled("ADC started before it is stable"));
        }
        if TICKS_PER_S / self.clock_ticks().max(1) > CLOCK_MAX_HZ {
            return Err(Unmodelled("ADC clock above 36 MHz"));
        }
        self.status |= STRT;
        self.converting.get_or_insert((0, now + self.conversion_ticks(0)));
        Ok(())
    }
}

impl Peripheral for Adc {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        Ok(match offset {
            0x00 => self.status,
            0x04 | 0x08 => self.control[(offset / 4 - 1) as usize],
            0x0c | 0x10 => self.sample_times[((offset - 0x0c) / 4) as usize],
            0x2c..=0x34 => self.sequence[((offset - 0x2c) / 4) as usize],
            0x4c => {
                // reading the data clears EOC (section 13.13.1)
                self.waiting = false;
                self.status &= !EOC;
                self.data
            }
            COMMON_CONTROL => self.common,
            _ => return Err(Unmodelled("ADC register")),
        })
    }

    fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x00 => self.status &= value,
            0x04 if value & !SCAN != 0 => return Err(Unmodelled("ADC interrupts, injected channels, fewer bits")),
            0x04 => self.control[0] = value,
            0x08 => self.write_control_2(value, now)?,
            0x0c | 0x10 => self.sample_times[((offset - 0x0c) / 4) as usize] = value,
            0x2c if value >> 20 & 0xf >= 12 => return Err(Unmodelled("ADC sequence of more than twelve")),
            0x2c..=0x34 => self.sequence[((offset - 0x2c) / 4) as usize] = value,
            COMMON_CONTROL if value & !PRESCALER != 0 => return Err(Unmodelled("ADC common modes")),
            COMMON_CONTROL => self.common = value,
            _ => return Err(Unmodelled("ADC register")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Ticks = 4 * 8;

    /// At 84 MHz / 8, channel 2 sampled for 480 cycles; these bits of CR2 besides ADON.
    fn running(control_2: u32) -> Adc {
        let mut adc = Adc::default();
        adc.set_bus_cycle(4);
        for (offset, value) in [(COMMON_CONTROL, PRESCALER), (0x10, 7 << 6), (0x34, 2), (0x08, control_2 | ADON)] {
            adc.write(offset, value, 0).unwrap();
        }
        adc.write(0x08, control_2 | ADON | SWSTART, START_TICKS).unwrap();
        adc
    }

    #[test]
    fn a_conversion_takes_its_sampling_time_and_twelve_cycles() {
        let mut adc = running(0);
        let end = START_TICKS + 492 * CYCLE;
        assert_eq!(adc.converted(end - 1), None);
        assert_eq!(adc.converted(end), Some(2));
        adc.result(1234);
        assert_eq!(adc.read(0x00, end).unwrap(), STRT | EOC);
        assert_eq!(adc.read(0x4c, end).unwrap(), 1234);
        assert_eq!(adc.read(0x00, end).unwrap(), STRT);
        // it was one only
        assert_eq!(adc.next_end(), None);
    }

    #[test]
    fn without_end_it_asks_dma_after_each_and_overruns_if_nobody_comes() {
        let mut adc = running(CONT | DMA | DDS);
        let end = adc.next_end().unwrap();
        adc.result(1);
        assert!(adc.requests_dma());
        assert_eq!(adc.next_end(), Some(end + 492 * CYCLE));
        assert_eq!(adc.read(0x4c, 0).unwrap(), 1);
        assert!(!adc.requests_dma());
        adc.result(2);
        adc.result(3);
        assert_eq!(adc.read(0x00, 0).unwrap() & OVR, OVR);
        assert!(!adc.requests_dma());
        assert_eq!(adc.next_end(), None);
    }

    #[test]
    fn a_scan_goes_through_its_channels() {
        let mut adc = Adc::default();
        adc.set_bus_cycle(4);
        for (offset, value) in [(0x04, SCAN), (0x2c, 1 << 20), (0x34, 2 | 3 << 5), (COMMON_CONTROL, PRESCALER)] {
            adc.write(offset, value, 0).unwrap();
        }
        adc.write(0x08, ADON | CONT | DMA | DDS, 0).unwrap();
        adc.write(0x08, ADON | CONT | DMA | DDS | SWSTART, START_TICKS).unwrap();
        let channels: Vec<_> = (0..4)
            .map(|_| {
                let channel = adc.converted(TICKS_PER_S).unwrap();
                adc.result(0);
                adc.read(0x4c, 0).unwrap();
                channel
            })
            .collect();
        assert_eq!(channels, [2, 3, 2, 3]);
    }

    #[test]
    fn what_silicon_would_not_do_is_refused() {
        let mut adc = Adc::default();
        adc.set_bus_cycle(4);
        adc.write(0x08, ADON, 0).unwrap();
        assert!(adc.write(0x08, ADON | SWSTART, START_TICKS - 1).is_err());
        // 84 MHz / 2
        assert!(adc.write(0x08, ADON | SWSTART, START_TICKS).is_err());
        assert!(adc.write(0x08, ADON | 1 << 11, 0).is_err());
        assert!(adc.write(0x04, 1 << 5, 0).is_err());
    }
}
