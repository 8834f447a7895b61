//! What instructions and literals from flash cost beyond their execution. RM0090 section 3.5.2, "Adaptive real-time
//! memory accelerator (ART)": lines of 128 bits; prefetch of the next line; an instruction cache of 64 lines and a data
//! cache of 8, least recently used out first.
//!
//! A line that is nowhere costs the wait states that are set. With prefetch the next line is on its way while this one
//! runs, so that it costs only what is left of them.

use crate::memory::FLASH;

const LINE_SHIFT: u32 = 4;
pub(crate) const INSTRUCTION_LINES: usize = 64;
pub(crate) const DATA_LINES: usize = 8;
const NOWHERE: u8 = u8::MAX;

/// FLASH_ACR (section 3.9.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AccessControl(pub(crate) u32);

impl AccessControl {
    fn wait_states(self) -> u64 {
        u64::from(self.0 & 0xf)
    }
    pub(crate) fn prefetches(self) -> bool {
        self.0 >> 8 & 1 != 0
    }
    fn caches_instructions(self) -> bool {
        self.0 >> 9 & 1 != 0
    }
    fn caches_data(self) -> bool {
        self.0 >> 10 & 1 != 0
    }
}

/// Lines that are kept, in a ring from the one used last to the one used longest ago.
#[derive(Clone, Debug)]
struct Cache {
    slots: Vec<Slot>,
    capacity: usize,
    /// Slot of every line of flash.
    slot_of: Vec<u8>,
    /// The one used last; before it in the ring is the oldest.
    latest: u8,
}

/// A line between those that were used right before and right after it.
#[derive(Clone, Copy, Debug)]
struct Slot {
    line: u32,
    older: u8,
    newer: u8,
}

impl Cache {
    fn new(capacity: usize) -> Self {
        let lines = (FLASH.size >> LINE_SHIFT) as usize;
        Self { slots: Vec::with_capacity(capacity), capacity, slot_of: vec![NOWHERE; lines], latest: 0 }
    }

    fn forget(&mut self) {
        self.slots.clear();
        self.slot_of.fill(NOWHERE);
        self.latest = 0;
    }

    /// Was it there? It is now.
    fn touch(&mut self, line: u32) -> bool {
        let slot = self.slot_of[line as usize];
        if slot != NOWHERE {
            self.make_latest(slot);
            return true;
        }
        if self.slots.len() < self.capacity {
            self.insert_latest(line);
        } else {
            // the ring's turn by one makes the oldest the latest
            let oldest = self.slots[usize::from(self.latest)].newer;
            let slot = &mut self.slots[usize::from(oldest)];
            self.slot_of[slot.line as usize] = NOWHERE;
            slot.line = line;
            self.latest = oldest;
            self.slot_of[line as usize] = oldest;
        }
        false
    }

    /// A slot of its own for a line, behind the latest.
    fn insert_latest(&mut self, line: u32) {
        let place = self.slots.len() as u8;
        self.slots.push(Slot { line, older: place, newer: place });
        self.slot_of[line as usize] = place;
        if place > 0 {
            self.link_behind_latest(place);
        }
        self.latest = place;
    }

    fn make_latest(&mut self, place: u8) {
        if place == self.latest {
            return;
        }
        let Slot { older, newer, .. } = self.slots[usize::from(place)];
        self.slots[usize::from(older)].newer = newer;
        self.slots[usize::from(newer)].older = older;
        self.link_behind_latest(place);
        self.latest = place;
    }

    /// Between the latest and the oldest, which follow each other in the ring.
    fn link_behind_latest(&mut self, place: u8) {
        let (latest, oldest) = (self.latest, self.slots[usize::from(self.latest)].newer);
        self.slots[usize::from(latest)].newer = place;
        self.slots[usize::from(oldest)].older = place;
        let slot = &mut self.slots[usize::from(place)];
        (slot.older, slot.newer) = (latest, oldest);
    }
}

/// The accelerator's state.
#[derive(Clone, Debug)]
pub(crate) struct FlashTiming {
    control: AccessControl,
    instructions: Cache,
    data: Cache,
    /// The line that the core runs from.
    current: Option<u32>,
}

impl Default for FlashTiming {
    fn default() -> Self {
        Self {
            control: AccessControl(0),
            instructions: Cache::new(INSTRUCTION_LINES),
            data: Cache::new(DATA_LINES),
            current: None,
        }
    }
}

impl FlashTiming {
    /// What the register holds from now on.
    pub(crate) fn set(&mut self, control: AccessControl) {
        if control == self.control {
            return;
        }
        if !control.caches_instructions() || control.0 >> 11 & 1 != 0 {
            self.instructions.forget();
        }
        if !control.caches_data() || control.0 >> 12 & 1 != 0 {
            self.data.forget();
        }
        self.control = control;
    }

    /// Cycles that the core waits while it runs `length` bytes from `start`, which take it `cycles` by themselves.
    pub(crate) fn run(&mut self, start: u32, length: u32, cycles: u64) -> u64 {
        let Some(first) = line(start) else { return 0 };
        let last = line(start + length.max(1) - 1).unwrap_or(first);
        let line_cycles = cycles / u64::from(last - first + 1);
        (first..=last).map(|line| self.fetch(line, line_cycles)).sum()
    }

    /// `line_cycles`: what the line before took, about.
    fn fetch(&mut self, line: u32, line_cycles: u64) -> u64 {
        let before = self.current.replace(line);
        if before == Some(line) {
            return 0;
        }
        if self.control.caches_instructions() && self.instructions.touch(line) {
            return 0;
        }
        let follows = before.is_some_and(|before| line == before + 1);
        let already = if follows && self.control.prefetches() { line_cycles } else { 0 };
        self.control.wait_states().saturating_sub(already)
    }

    /// Cycles for a word that is read from flash as data.
    pub(crate) fn read(&mut self, address: u32) -> u64 {
        let Some(line) = line(address) else { return 0 };
        if self.control.caches_data() && self.data.touch(line) { 0 } else { self.control.wait_states() }
    }
}

fn line(address: u32) -> Option<u32> {
    FLASH.contains(address, 1).then(|| (address - FLASH.start) >> LINE_SHIFT)
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT_168_MHZ: u32 = 5;
    const PREFETCH: u32 = 1 << 8;
    const CACHES: u32 = 0b11 << 9;
    /// A line of eight short instructions.
    const LINE: u32 = 16;

    fn with(control: u32) -> FlashTiming {
        let mut timing = FlashTiming::default();
        timing.set(AccessControl(control));
        timing
    }

    /// Straight-line code of so many lines, once.
    fn straight(timing: &mut FlashTiming, lines: u32) -> u64 {
        (0..lines).map(|line| timing.run(FLASH.start + line * LINE, LINE, 8)).sum()
    }

    #[test]
    fn straight_code_waits_at_every_line_and_not_at_all_with_prefetch() {
        // 5 wait states on 8 instructions: 1.6 cycles each, as section 3.5.2 draws it; 8 cycles hide them
        assert_eq!(straight(&mut with(AT_168_MHZ), 100), 500);
        assert_eq!(straight(&mut with(AT_168_MHZ | PREFETCH), 100), 5);
        // long instructions: 4 cycles a line hide 4 of 5
        let mut timing = with(AT_168_MHZ | PREFETCH);
        assert_eq!((0..100).map(|line| timing.run(FLASH.start + line * LINE, LINE, 4)).sum::<u64>(), 5 + 99);
    }

    #[test]
    fn a_loop_that_fits_runs_from_the_cache_and_one_that_does_not_never() {
        for (lines, again) in [(64, 0), (65, 65 * 5)] {
            let mut timing = with(AT_168_MHZ | CACHES);
            assert_eq!(straight(&mut timing, lines), u64::from(lines) * 5);
            assert_eq!(straight(&mut timing, lines), again, "{lines} lines");
        }
    }

    /// Against a list that is searched and sorted by use.
    #[test]
    fn the_line_that_was_used_longest_ago_goes_first() {
        let (mut cache, mut list, mut seed) = (Cache::new(4), Vec::new(), 1_u32);
        for _ in 0..10_000 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let touched = seed >> 16 & 7;
            let place = list.iter().position(|line| *line == touched);
            assert_eq!(cache.touch(touched), place.is_some());
            match place {
                Some(place) => drop(list.remove(place)),
                None if list.len() == 4 => drop(list.remove(0)),
                None => {}
            }
            list.push(touched);
        }
    }

    #[test]
    fn literals_have_eight_lines_of_their_own() {
        let mut timing = with(AT_168_MHZ | CACHES);
        let mut read = |lines: u32| (0..lines).map(|line| timing.read(FLASH.start + line * LINE)).sum::<u64>();
        assert_eq!((read(8), read(8)), (40, 0));
        assert_eq!((read(9), read(9)), (5, 45));
    }

    #[test]
    fn other_memory_and_no_wait_states_cost_nothing() {
        let mut timing = with(AT_168_MHZ);
        assert_eq!(timing.run(0x2000_0000, 64, 32) + timing.read(0x1000_0000), 0);
        assert_eq!(straight(&mut with(0), 10), 0);
    }

    #[test]
    fn switching_a_cache_off_empties_it() {
        let mut timing = with(AT_168_MHZ | CACHES);
        straight(&mut timing, 4);
        timing.set(AccessControl(AT_168_MHZ));
        timing.set(AccessControl(AT_168_MHZ | CACHES));
        assert_eq!(straight(&mut timing, 4), 20);
    }
}
