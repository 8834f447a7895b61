//! External interrupts. RM0090 section 12.3. Edges of 16 pin lines (which port: SYSCFG) and 7 inner ones.

use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

const LINES: u32 = 0x7f_ffff;

#[derive(Clone, Debug, Default)]
pub(crate) struct Exti {
    interrupt_mask: u32,
    event_mask: u32,
    rising: u32,
    falling: u32,
    pending: u32,
    levels: u32,
    /// Lines whose level is known: those that were selected when levels came last.
    known: u32,
}

impl Exti {
    /// The levels of the lines that are [`selected`](Self::selected); an edge pends. What the level was before a line
    /// was selected makes no edge.
    pub(crate) fn set_levels(&mut self, levels: u32) {
        let (rises, falls) = (levels & !self.levels, self.levels & !levels);
        self.pending |= (rises & self.rising | falls & self.falling) & self.known;
        (self.levels, self.known) = (levels, self.selected());
    }

    /// Lines of which an edge pends.
    pub(crate) fn selected(&self) -> u32 {
        self.rising | self.falling
    }

    /// Is the interrupt of any line of this set wanted?
    pub(crate) fn requests(&self, lines: u32) -> bool {
        self.pending & self.interrupt_mask & lines != 0
    }
}

impl Peripheral for Exti {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        Ok(match offset {
            0x00 => self.interrupt_mask,
            0x04 => self.event_mask,
            0x08 => self.rising,
            0x0c => self.falling,
            0x10 => 0,
            0x14 => self.pending,
            _ => return Err(Unmodelled("EXTI register")),
        })
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x00 => self.interrupt_mask = value & LINES,
            0x04 if value != 0 => return Err(Unmodelled("EXTI events")),
            0x04 => self.event_mask = 0,
            0x08 => self.rising = value & LINES,
            0x0c => self.falling = value & LINES,
            0x10 => self.pending |= value & self.interrupt_mask,
            0x14 => self.pending &= !value,
            _ => return Err(Unmodelled("EXTI register")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_selected_edge_pends_and_one_clears_it_by_writing_it() {
        let mut exti = Exti::default();
        exti.write(0x08, 1 << 15, 0).unwrap();
        exti.write(0x00, 1 << 15, 0).unwrap();
        exti.set_levels(0);
        exti.set_levels(1 << 15);
        assert!(exti.requests(0xfc00));
        // it stays pending until software clears it, whatever the level does
        exti.set_levels(0);
        assert!(exti.requests(0xfc00));
        exti.write(0x14, 1 << 15, 0).unwrap();
        assert!(!exti.requests(0xfc00));
        exti.set_levels(0);
        assert!(!exti.requests(0xfc00));
    }

    #[test]
    fn a_masked_line_pends_without_an_interrupt() {
        let mut exti = Exti::default();
        exti.write(0x0c, 1, 0).unwrap();
        exti.set_levels(1);
        exti.set_levels(0);
        assert_eq!(exti.read(0x14, 0).unwrap(), 1);
        assert!(!exti.requests(1));
    }

    #[test]
    fn a_level_from_before_the_selection_is_no_edge() {
        let mut exti = Exti::default();
        exti.write(0x00, 1, 0).unwrap();
        exti.write(0x08, 1, 0).unwrap();
        exti.set_levels(1);
        assert!(!exti.requests(1));
        exti.set_levels(0);
        exti.set_levels(1);
        assert!(exti.requests(1));
    }
}
