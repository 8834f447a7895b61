//! Where the instructions go: each activation of an exception by itself, without what interrupted it.

use std::collections::BTreeMap;

use crate::time::Ticks;

/// Instructions of every activation so far.
#[derive(Clone, Debug, Default)]
pub struct Profile {
    /// What runs, and what it interrupted, innermost last: exception and instructions so far.
    running: Vec<(u8, u32)>,
    ended: BTreeMap<u8, Vec<u32>>,
    asleep: Ticks,
}

impl Profile {
    pub(crate) fn enter(&mut self, exception: u8) {
        self.running.push((exception, 0));
    }

    pub(crate) fn leave(&mut self) {
        if let Some((exception, instructions)) = self.running.pop() {
            self.ended.entry(exception).or_default().push(instructions);
        }
    }

    pub(crate) fn execute(&mut self, instructions: u64) {
        if let Some((_, count)) = self.running.last_mut() {
            *count += instructions as u32;
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
        self.ended.clear();
        self.asleep = 0;
    }

    /// Instructions of each activation of an interrupt (0 is the first beyond the core's own exceptions) that has
    /// ended, in the order in which they ended.
    pub fn of_interrupt(&self, interrupt: u8) -> &[u32] {
        let exception = interrupt + crate::cortex::exceptions::FIRST_INTERRUPT;
        self.ended.get(&exception).map_or(&[], Vec::as_slice)
    }

    /// Interrupts that ran, in ascending order.
    pub fn interrupts(&self) -> impl Iterator<Item = u8> {
        let first = crate::cortex::exceptions::FIRST_INTERRUPT;
        self.ended.keys().filter_map(move |exception| exception.checked_sub(first))
    }

    /// Time in which the core slept.
    pub fn asleep(&self) -> Ticks {
        self.asleep
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_interrupts_is_not_counted_twice() {
        let mut profile = Profile::default();
        profile.execute(1000);
        profile.enter(20);
        profile.execute(3);
        profile.enter(30);
        profile.execute(50);
        profile.leave();
        profile.execute(4);
        profile.leave();
        profile.enter(20);
        profile.execute(1);
        profile.leave();
        assert_eq!((profile.of_interrupt(4), profile.of_interrupt(14)), (&[7, 1][..], &[50][..]));
        assert_eq!(profile.interrupts().collect::<Vec<_>>(), [4, 14]);
    }

    #[test]
    fn a_reset_ends_nothing() {
        let mut profile = Profile::default();
        profile.enter(20);
        profile.reset();
        profile.execute(7);
        profile.leave();
        assert!(profile.of_interrupt(4).is_empty());
    }
}
