//! From motor commands to timer counts: the last arithmetic before the pin, here so that the firmware has none.

use crate::elementary::limit;
use crate::signals::MotorCommands;

/// Pulse that an ESC expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PulseKind {
    /// 1000 to 2000 us, repeated at a rate of its own.
    Pwm,
    /// 125 to 250 us, one pulse per step.
    OneShot125,
}

/// How commands become pulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputConfig {
    /// Kind of pulse.
    pub kind: PulseKind,
    /// Timer ticks per microsecond after the prescaler.
    pub ticks_per_us: f32,
}

impl OutputConfig {
    /// Shortest pulse, us: what a disarmed ESC gets, and command 0.
    pub fn pulse_min_us(&self) -> f32 {
        match self.kind {
            PulseKind::Pwm => 1000.0,
            PulseKind::OneShot125 => 125.0,
        }
    }

    /// Length of a pulse, whole us, rounded down.
    pub fn pulse_us(&self, compare_counts: u16) -> u16 {
        // `as` saturates
        (f32::from(compare_counts) / self.ticks_per_us) as u16
    }

    /// Compare values of motors 1 to 4. Not armed: the shortest pulse, whatever is commanded.
    pub fn compare_counts(&self, commands: &MotorCommands, armed: bool) -> [u16; 4] {
        let shortest_us = self.pulse_min_us();
        commands.0.map(|command| {
            let share = if armed { limit(command, 0.0, 1.0) } else { 0.0 };
            // `as` truncates and saturates; half a tick more rounds to nearest
            (shortest_us * (1.0 + share) * self.ticks_per_us + 0.5) as u16
        })
    }
}

/// Smallest division of the timer clock with which a period fits into 16 bits; at least 1.
pub fn prescaler(timer_clock_hz: u32, rate_hz: u32) -> u32 {
    let ticks = timer_clock_hz / if rate_hz == 0 { 1 } else { rate_hz };
    ticks.div_ceil(65_536).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_span_the_range_of_their_kind() {
        let pwm = OutputConfig { kind: PulseKind::Pwm, ticks_per_us: 24.0 };
        let commands = MotorCommands([0.0, 0.5, 1.0, 7.0]);
        assert_eq!(pwm.compare_counts(&commands, true), [24_000, 36_000, 48_000, 48_000]);
        assert_eq!(pwm.compare_counts(&commands, false), [24_000; 4]);
        let one_shot = OutputConfig { kind: PulseKind::OneShot125, ticks_per_us: 168.0 };
        assert_eq!(one_shot.compare_counts(&commands, true), [21_000, 31_500, 42_000, 42_000]);
        assert_eq!(pwm.compare_counts(&MotorCommands([f32::NAN; 4]), true), [24_000; 4]);
    }

    #[test]
    fn prescaler_is_the_smallest_that_fits() {
        assert_eq!(prescaler(168_000_000, 400), 7);
        assert_eq!(prescaler(168_000_000, 50), 52);
        assert_eq!(prescaler(168_000_000, 10_000), 1);
        for rate in [50u32, 100, 333, 400, 490] {
            let p = prescaler(168_000_000, rate);
            assert!(168_000_000 / rate / p <= 65_536 && (p == 1 || 168_000_000 / rate / (p - 1) > 65_535));
        }
    }
}
