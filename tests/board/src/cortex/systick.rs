//! SysTick: a 24-bit counter down from a reload value. ARMv7-M ARM B3.3. Runs from the core's clock only.

use crate::time::Ticks;

const ENABLE: u32 = 1;
const INTERRUPT: u32 = 1 << 1;
const CORE_CLOCK: u32 = 1 << 2;
const COUNT_FLAG: u32 = 1 << 16;

#[derive(Clone, Debug, Default)]
pub(crate) struct SysTick {
    control: u32,
    reload: u32,
    /// When the counter last was (or would have been) at the reload value.
    origin: Ticks,
    wrapped: bool,
}

impl SysTick {
    /// Brings it up to `now`; true if it reached zero and wants its exception.
    pub(crate) fn tick(&mut self, now: Ticks, core_ticks: Ticks) -> bool {
        let Some(due) = self.next_event(core_ticks) else { return false };
        if due > now {
            return false;
        }
        let period = self.period(core_ticks);
        self.origin += (now - self.origin) / period * period;
        self.wrapped = true;
        self.control & INTERRUPT != 0
    }

    pub(crate) fn next_event(&self, core_ticks: Ticks) -> Option<Ticks> {
        let runs = self.control & ENABLE != 0 && self.reload != 0;
        runs.then(|| self.origin + self.period(core_ticks))
    }

    fn period(&self, core_ticks: Ticks) -> Ticks {
        (u64::from(self.reload) + 1) * core_ticks
    }

    pub(crate) fn read(&mut self, offset: u32, now: Ticks, core_ticks: Ticks) -> Option<u32> {
        match offset {
            0x0 => {
                let flag = if std::mem::take(&mut self.wrapped) { COUNT_FLAG } else { 0 };
                Some(self.control | flag)
            }
            0x4 => Some(self.reload),
            0x8 if self.control & ENABLE == 0 => Some(0),
            0x8 => Some(self.reload - ((now - self.origin) / core_ticks).min(u64::from(self.reload)) as u32),
            // no reference clock, no calibration
            0xc => Some(1 << 31),
            _ => None,
        }
    }

    /// `None` for what is not modelled: the external reference clock.
    pub(crate) fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Option<()> {
        match offset {
            0x0 => {
                if value & ENABLE != 0 && value & CORE_CLOCK == 0 {
                    return None;
                }
                if value & ENABLE != 0 && self.control & ENABLE == 0 {
                    self.origin = now;
                }
                self.control = value & 7;
            }
            0x4 => self.reload = value & 0xff_ffff,
            0x8 => {
                self.origin = now;
                self.wrapped = false;
            }
            _ => return None,
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_fires_every_reload_plus_one_cycles() {
        let mut systick = SysTick::default();
        systick.write(4, 167_999, 0);
        systick.write(0, 7, 1000);
        assert_eq!(systick.next_event(2), Some(1000 + 336_000));
        assert!(!systick.tick(1000 + 335_999, 2));
        assert!(systick.tick(1000 + 336_000, 2));
        assert_eq!(systick.next_event(2), Some(1000 + 672_000));
        assert_eq!(systick.read(8, 1000 + 336_000 + 20, 2), Some(167_989));
        assert_eq!(systick.read(0, 0, 2), Some(7 | COUNT_FLAG));
    }
}
