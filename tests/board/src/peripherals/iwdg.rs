//! Independent watchdog. RM0090 section 21.4. It counts LSI cycles, whose rate a chip has for itself, 17 to 47 kHz.

use super::{Peripheral, Unmodelled};
use crate::time::{TICKS_PER_S, Ticks};

const KEY_RELOAD: u32 = 0xaaaa;
const KEY_ACCESS: u32 = 0x5555;
const KEY_START: u32 = 0xcccc;
/// Nominal (data sheet of the STM32F427, table 43).
pub(crate) const LSI_HZ: u64 = 32_000;
/// Slowest and fastest chip (same table).
pub const LSI_RANGE_HZ: [u64; 2] = [17_000, 47_000];

#[derive(Clone, Debug)]
pub(crate) struct Iwdg {
    lsi_hz: u64,
    prescaler: u32,
    reload: u32,
    unlocked: bool,
    fed_at: Option<Ticks>,
}

impl Iwdg {
    pub(crate) fn new(lsi_hz: u64) -> Self {
        Self { lsi_hz, prescaler: 0, reload: 0xfff, unlocked: false, fed_at: None }
    }

    /// Its oscillator.
    pub(crate) fn lsi_hz(&self) -> u64 {
        self.lsi_hz
    }

    /// Another chip's, from the next feeding on.
    pub(crate) fn set_lsi_hz(&mut self, lsi_hz: u64) {
        self.lsi_hz = lsi_hz;
    }

    /// Has it run out?
    pub(crate) fn bites(&self, now: Ticks) -> bool {
        self.next_event().is_some_and(|at| at <= now)
    }
}

impl Peripheral for Iwdg {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        match offset {
            0x0 => Ok(0),
            0x4 => Ok(self.prescaler),
            0x8 => Ok(self.reload),
            // new values are taken at once
            0xc => Ok(0),
            _ => Err(Unmodelled("IWDG register")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        match (offset, value) {
            (0x0, KEY_START) => {
                self.fed_at.get_or_insert(now);
            }
            (0x0, KEY_RELOAD) => self.fed_at = self.fed_at.map(|_| now),
            (0x0, _) => {}
            (0x4, _) if self.unlocked => self.prescaler = value & 7,
            (0x8, _) if self.unlocked => self.reload = value & 0xfff,
            (0x4 | 0x8, _) => return Err(Unmodelled("IWDG setting without its key")),
            _ => return Err(Unmodelled("IWDG register")),
        }
        if offset == 0 {
            self.unlocked = value == KEY_ACCESS;
        }
        Ok(())
    }

    fn next_event(&self) -> Option<Ticks> {
        let cycles = (4u64 << self.prescaler.min(6)) * (u64::from(self.reload) + 1);
        self.fed_at.map(|at| at + cycles * TICKS_PER_S / self.lsi_hz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unfed_it_bites_when_its_count_is_out() {
        let mut dog = Iwdg::new(LSI_HZ);
        for (offset, value) in [(0, KEY_ACCESS), (4, 0), (8, 239), (0, KEY_START)] {
            dog.write(offset, value, 0).unwrap();
        }
        // 240 * 4 / 32 kHz
        let limit = TICKS_PER_S * 30 / 1000;
        assert!(!dog.bites(limit - 1));
        assert!(dog.bites(limit));
        dog.write(0, KEY_RELOAD, limit / 2).unwrap();
        assert!(!dog.bites(limit));
    }

    #[test]
    fn its_limit_is_the_chips_own() {
        for (lsi_hz, limit_us) in [(17_000, 56_470), (32_000, 30_000), (47_000, 20_425)] {
            let mut dog = Iwdg::new(lsi_hz);
            for (offset, value) in [(0, KEY_ACCESS), (4, 0), (8, 239), (0, KEY_START)] {
                dog.write(offset, value, 0).unwrap();
            }
            assert_eq!(dog.next_event().unwrap() / crate::time::TICKS_PER_US, limit_us, "{lsi_hz}");
        }
    }

    #[test]
    fn settings_need_the_key() {
        assert!(Iwdg::new(LSI_HZ).write(4, 1, 0).is_err());
    }
}
