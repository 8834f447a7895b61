//! Which exception runs next: pending, active, priorities. ARMv7-M ARM B1.5 and B3.4; lines are level-sensitive
//! (B3.4.1).
//!
//! Priorities have 4 bits (PM0214 section 4.3.7). Priority grouping is not modelled: all bits preempt.

/// Exceptions of the core come first, then the interrupts of the STM32F427 (RM0090 table 62: 0 to 90).
pub(crate) const FIRST_INTERRUPT: u8 = 16;
const INTERRUPTS: usize = 91;
const COUNT: usize = FIRST_INTERRUPT as usize + INTERRUPTS;

pub(crate) const NMI: u8 = 2;
pub(crate) const HARD_FAULT: u8 = 3;
pub(crate) const MEMORY_FAULT: u8 = 4;
pub(crate) const BUS_FAULT: u8 = 5;
pub(crate) const USAGE_FAULT: u8 = 6;
pub(crate) const SV_CALL: u8 = 11;
pub(crate) const PEND_SV: u8 = 14;
pub(crate) const SYS_TICK: u8 = 15;

/// Priority of code that nothing holds back.
const THREAD_PRIORITY: i16 = 256;
const PRIORITY_BITS: u8 = 0xf0;

/// What the core masks at the moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Masks {
    pub(crate) primask: bool,
    pub(crate) faultmask: bool,
    pub(crate) basepri: u8,
}

/// State of every exception, a bit each.
#[derive(Clone, Debug)]
pub(crate) struct Exceptions {
    pending: u128,
    active: u128,
    enabled: u128,
    lines: u128,
    priority: [u8; COUNT],
}

impl Default for Exceptions {
    fn default() -> Self {
        // those without an enable bit are always on
        let always = [NMI, HARD_FAULT, SV_CALL, PEND_SV, SYS_TICK].iter().fold(0, |bits, number| bits | bit(*number));
        Self { pending: 0, active: 0, enabled: always, lines: 0, priority: [0; COUNT] }
    }
}

fn bit(number: u8) -> u128 {
    1 << number
}

/// The bit of an exception in the levels of all lines, if it is requested.
pub(crate) fn line(number: u8, high: bool) -> u128 {
    u128::from(high) << number
}

/// The bit of an interrupt there.
pub(crate) fn interrupt_line(interrupt: u8, high: bool) -> u128 {
    line(FIRST_INTERRUPT + interrupt, high)
}

fn numbers(mut bits: u128) -> impl Iterator<Item = u8> {
    std::iter::from_fn(move || {
        let number = bits.trailing_zeros() as u8;
        bits &= bits.wrapping_sub(1);
        (number < 128).then_some(number)
    })
}

impl Exceptions {
    /// The levels of all lines, a bit for each exception. One pends when it rises, and again on return while it is
    /// still high.
    pub(crate) fn set_lines(&mut self, lines: u128) {
        self.pending |= lines & !self.lines;
        self.lines = lines;
    }

    pub(crate) fn pend(&mut self, number: u8) {
        self.pending |= bit(number);
    }

    /// By software; a line that is high keeps its interrupt pending.
    pub(crate) fn unpend(&mut self, number: u8) {
        self.pending &= !bit(number) | self.lines;
    }

    pub(crate) fn is_pending(&self, number: u8) -> bool {
        self.pending & bit(number) != 0
    }

    pub(crate) fn is_active(&self, number: u8) -> bool {
        self.active & bit(number) != 0
    }

    pub(crate) fn enable(&mut self, number: u8, on: bool) {
        self.enabled = if on { self.enabled | bit(number) } else { self.enabled & !bit(number) };
    }

    pub(crate) fn is_enabled(&self, number: u8) -> bool {
        self.enabled & bit(number) != 0
    }

    pub(crate) fn set_priority(&mut self, number: u8, priority: u8) {
        if let Some(slot) = self.priority.get_mut(usize::from(number)) {
            *slot = priority & PRIORITY_BITS;
        }
    }

    pub(crate) fn priority_byte(&self, number: u8) -> u8 {
        self.priority.get(usize::from(number)).copied().unwrap_or_default()
    }

    fn priority_of(&self, number: u8) -> i16 {
        match number {
            1 => -3,
            NMI => -2,
            HARD_FAULT => -1,
            _ => i16::from(self.priority_byte(number)),
        }
    }

    /// Priority of what runs, masks left out (ARMv7-M ARM B1.5.4).
    fn active_priority(&self) -> i16 {
        numbers(self.active).map(|number| self.priority_of(number)).min().unwrap_or(THREAD_PRIORITY)
    }

    pub(crate) fn execution_priority(&self, masks: Masks) -> i16 {
        let mut priority = self.active_priority();
        if masks.basepri & PRIORITY_BITS != 0 {
            priority = priority.min(i16::from(masks.basepri & PRIORITY_BITS));
        }
        if masks.primask {
            priority = priority.min(0);
        }
        if masks.faultmask {
            priority = priority.min(-1);
        }
        priority
    }

    /// The highest pending one, lowest number first among equals.
    pub(crate) fn highest_pending(&self) -> Option<u8> {
        numbers(self.pending & self.enabled).min_by_key(|number| (self.priority_of(*number), *number))
    }

    /// The exception to be taken now.
    pub(crate) fn due(&self, masks: Masks) -> Option<u8> {
        let next = self.highest_pending()?;
        (self.priority_of(next) < self.execution_priority(masks)).then_some(next)
    }

    /// Does WFI end? PRIMASK does not count (B1.5.19).
    pub(crate) fn wakes(&self, masks: Masks) -> bool {
        self.due(Masks { primask: false, ..masks }).is_some()
    }

    /// A fault goes to its handler, or, where that is off or not above what runs, to HardFault; none if neither can.
    pub(crate) fn fault_target(&self, fault: u8, masks: Masks) -> Option<u8> {
        let now = self.execution_priority(masks);
        [fault, HARD_FAULT].into_iter().find(|target| self.is_enabled(*target) && self.priority_of(*target) < now)
    }

    pub(crate) fn activate(&mut self, number: u8) {
        self.pending &= !bit(number);
        self.active |= bit(number);
    }

    /// On return; a line that is still high pends anew.
    pub(crate) fn deactivate(&mut self, number: u8) {
        self.active &= !bit(number);
        self.pending |= self.lines & bit(number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: Masks = Masks { primask: false, faultmask: false, basepri: 0 };

    fn with_two() -> Exceptions {
        let mut exceptions = Exceptions::default();
        for (interrupt, priority) in [(28, 0x60), (40, 0x40)] {
            exceptions.enable(FIRST_INTERRUPT + interrupt, true);
            exceptions.set_priority(FIRST_INTERRUPT + interrupt, priority);
        }
        exceptions
    }

    #[test]
    fn the_lower_number_of_priority_preempts_equals_do_not() {
        let mut exceptions = with_two();
        exceptions.set_lines(interrupt_line(28, true));
        assert_eq!(exceptions.due(FREE), Some(44));
        exceptions.activate(44);
        exceptions.set_lines(interrupt_line(28, true) | interrupt_line(40, true));
        assert_eq!(exceptions.due(FREE), Some(56));
        exceptions.set_priority(56, 0x60);
        assert_eq!(exceptions.due(FREE), None);
    }

    #[test]
    fn masks_hold_back_what_they_should() {
        let mut exceptions = with_two();
        exceptions.set_lines(interrupt_line(28, true));
        assert_eq!(exceptions.due(Masks { basepri: 0x60, ..FREE }), None);
        assert_eq!(exceptions.due(Masks { basepri: 0x70, ..FREE }), Some(44));
        assert_eq!(exceptions.due(Masks { primask: true, ..FREE }), None);
        assert!(exceptions.wakes(Masks { primask: true, ..FREE }));
        assert!(!exceptions.wakes(Masks { basepri: 0x40, ..FREE }));
        exceptions.pend(NMI);
        assert_eq!(exceptions.due(Masks { faultmask: true, ..FREE }), Some(NMI));
    }

    #[test]
    fn a_level_pends_again_on_return_an_edge_does_not() {
        let mut exceptions = with_two();
        exceptions.set_lines(interrupt_line(28, true));
        exceptions.activate(44);
        // software cannot clear what its line holds
        exceptions.deactivate(44);
        assert!(exceptions.is_pending(44));
        exceptions.unpend(44);
        assert!(exceptions.is_pending(44));
        exceptions.set_lines(0);
        exceptions.activate(44);
        exceptions.deactivate(44);
        assert!(!exceptions.is_pending(44));
    }

    #[test]
    fn a_level_that_falls_while_its_handler_runs_does_not_come_again() {
        let mut exceptions = with_two();
        exceptions.set_lines(interrupt_line(28, true));
        exceptions.activate(44);
        // still high when it is looked at again; then the handler serves it
        exceptions.set_lines(interrupt_line(28, true));
        exceptions.set_lines(0);
        exceptions.deactivate(44);
        assert!(!exceptions.is_pending(44));
    }

    #[test]
    fn faults_escalate_until_there_is_nothing_left() {
        let mut exceptions = Exceptions::default();
        assert_eq!(exceptions.fault_target(BUS_FAULT, FREE), Some(HARD_FAULT));
        exceptions.enable(BUS_FAULT, true);
        assert_eq!(exceptions.fault_target(BUS_FAULT, FREE), Some(BUS_FAULT));
        assert_eq!(exceptions.fault_target(BUS_FAULT, Masks { primask: true, ..FREE }), Some(HARD_FAULT));
        exceptions.activate(HARD_FAULT);
        assert_eq!(exceptions.fault_target(BUS_FAULT, FREE), None);
    }
}
