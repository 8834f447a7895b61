//! The motor outputs as four ESCs see them.

use shared_control::output::PulseKind;

use crate::peripherals::timer::Pulse;
use crate::time::{TICKS_PER_US, Ticks};

/// Rounding of a pulse to ticks of the image's timer.
const TOLERANCE: Ticks = TICKS_PER_US;

/// What came so far.
#[derive(Clone, Debug)]
pub struct Pulses {
    /// Shortest pulse that the ESCs know, which is command 0; twice as long is command 1.
    disarmed: Ticks,
    last: [Option<Pulse>; 4],
    last_live_end: Ticks,
    shortest: Option<Ticks>,
}

impl Pulses {
    pub(crate) fn new(kind: PulseKind) -> Self {
        let disarmed = match kind {
            PulseKind::Pwm => 1000 * TICKS_PER_US,
            PulseKind::OneShot125 => 125 * TICKS_PER_US,
        };
        Self { disarmed, last: [None; 4], last_live_end: 0, shortest: None }
    }

    /// Takes a pulse of a motor (0 to 3); returns the command that the ESC understands.
    pub(crate) fn take(&mut self, motor: usize, pulse: Pulse) -> f64 {
        self.last[motor] = Some(pulse);
        if pulse.width > self.disarmed + TOLERANCE {
            self.last_live_end = self.last_live_end.max(pulse.rise + pulse.width);
        }
        self.shortest = Some(self.shortest.map_or(pulse.width, |width| width.min(pulse.width)));
        (pulse.width as f64 / self.disarmed as f64 - 1.0).clamp(0.0, 1.0)
    }

    /// How many of these pulses make one of PWM.
    pub(crate) fn parts_of_pwm(&self) -> Ticks {
        1000 * TICKS_PER_US / self.disarmed
    }

    /// The last one of motors 1 to 4, once it has ended.
    pub fn last(&self) -> [Option<Pulse>; 4] {
        self.last
    }

    /// End of the last one on any output.
    pub fn last_end(&self) -> Ticks {
        self.last.iter().flatten().map(|pulse| pulse.rise + pulse.width).max().unwrap_or(0)
    }

    /// End of the last one that let a motor turn.
    pub fn last_live_end(&self) -> Ticks {
        self.last_live_end
    }

    /// Was any cut shorter than the disarmed pulse? ESCs take such a one for noise, or for a throttle of another kind.
    pub fn cut(&self) -> bool {
        self.shortest.is_some_and(|shortest| shortest + TOLERANCE < self.disarmed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disarmed_pulse_turns_nothing_and_a_shorter_one_was_cut() {
        let pulse = |rise, us| Pulse { channel: 0, rise, width: us * TICKS_PER_US };
        let mut pulses = Pulses::new(PulseKind::Pwm);
        assert_eq!(pulses.take(1, pulse(0, 1500)), 0.5);
        assert_eq!(pulses.take(1, pulse(1_000_000, 1000)), 0.0);
        assert_eq!((pulses.last_live_end(), pulses.last_end()), (504_000, 1_336_000));
        assert!(!pulses.cut());
        pulses.take(2, pulse(2_000_000, 400));
        assert!(pulses.cut());
    }
}
