//! Where the instructions go: each activation of an exception by itself, without what interrupted it.

use std::collections::BTreeMap;

use crate::cpu::Ran;
use crate::time::Ticks;

/// Instructions and cycles of every activation so far.
#[derive(Clone, Debug, Default)]
pub struct Profile {
    /// What runs, and what it interrupted, innermost last: exception, instructions and cycles so far.
    running: Vec<(u8, u32, u32)>,
    instructions: BTreeMap<u8, Vec<u32>>,
    cycles: BTreeMap<u8, Vec<u32>>,
    asleep: Ticks,
}

impl Profile {
    pub(crate) fn enter(&mut self, exception: u8) {
        self.running.push((exception, 0, 0));
    }

    pub(crate) fn leave(&mut self) {
        if let Some((exception, instructions, cycles)) = self.running.pop() {
            self.instructions.entry(exception).or_default().push(instructions);
            self.cycles.entry(exception).or_default().push(cycles);
        }
    }

    pub(crate) fn execute(&mut self, ran: Ran) {
        if let Some((_, instructions, cycles)) = self.running.last_mut() {
            *instructions += ran.instructions as u32;
            *cycles += ran.cycles as u32;
        }
    }

    pub(crate) fn sleep(&mut self, duration: Ticks) {
        self.asleep += duration;
    }

    /// What runs does not end any more.
    pub(crate) fn reset(&mut self) {
        self.running.clear();
    }

    /// Forgets what has ended.
    pub(crate) fn restart(&mut self) {
        self.instructions.clear();
        self.cycles.clear();
        self.asleep = 0;
    }

    /// Instructions of each activation of an interrupt (0 is the first beyond the core's own exceptions) that has
    /// ended, in the order in which they ended.
    pub fn of_interrupt(&self, interrupt: u8) -> &[u32] {
        of(&self.instructions, interrupt)
    }

    /// Cycles of the same, waits for flash included.
    pub fn cycles_of_interrupt(&self, interrupt: u8) -> &[u32] {
        of(&self.cycles, interrupt)
    }

    /// Instructions and cycles of each activation of SysTick.
    pub fn of_sys_tick(&self) -> [&[u32]; 2] {
        let exception = crate::cortex::exceptions::SYS_TICK;
        [&self.instructions, &self.cycles].map(|ended| ended.get(&exception).map_or(&[][..], Vec::as_slice))
    }

    /// Interrupts that ran, in ascending order.
    pub fn interrupts(&self) -> impl Iterator<Item = u8> {
        let first = crate::cortex::exceptions::FIRST_INTERRUPT;
        self.instructions.keys().filter_map(move |exception| exception.checked_sub(first))
    }

    /// Time in which the core slept.
    pub fn asleep(&self) -> Ticks {
        self.asleep
    }
}

fn of(ended: &BTreeMap<u8, Vec<u32>>, interrupt: u8) -> &[u32] {
    let exception = interrupt + crate::cortex::exceptions::FIRST_INTERRUPT;
    ended.get(&exception).map_or(&[], Vec::as_slice)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many instructions, of three cycles each.
    fn ran(instructions: u64) -> Ran {
        Ran { instructions, cycles: 3 * instructions }
    }

    #[test]
    fn what_interrupts_is_not_counted_twice() {
        let mut profile = Profile::default();
        profile.execute(ran(1000));
        profile.enter(20);
        profile.execute(ran(3));
        profile.enter(30);
        profile.execute(ran(50));
        profile.leave();
        profile.execute(ran(4));
        profile.leave();
        profile.enter(20);
        profile.execute(ran(1));
        profile.leave();
        assert_eq!((profile.of_interrupt(4), profile.of_interrupt(14)), (&[7, 1][..], &[50][..]));
        assert_eq!(profile.cycles_of_interrupt(4), [21, 3]);
        assert_eq!(profile.interrupts().collect::<Vec<_>>(), [4, 14]);
    }

    #[test]
    fn a_reset_ends_nothing() {
        let mut profile = Profile::default();
        profile.enter(20);
        profile.reset();
        profile.execute(ran(7));
        profile.leave();
        assert!(profile.of_interrupt(4).is_empty());
    }
}
