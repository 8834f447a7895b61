//! From motor commands to timer counts: the last arithmetic before the pin, here so that the firmware has none.
//!
//! Two timers of a Pixhawk 1 count for this: TIM3 beats the loop, TIM1 makes the pulses (RM0090 sections 17 and 18).
//! Both hang on the same oscillator, so periods that are whole multiples of each other, in cycles, keep their phase for
//! ever.

use crate::elementary::limit;
use crate::signals::MotorCommands;

/// Clock of the timer that beats the loop (TIM3), Hz.
pub const LOOP_TIMER_HZ: u32 = 84_000_000;
/// Clock of the timer that makes the pulses (TIM1), Hz.
pub const PULSE_TIMER_HZ: u32 = 168_000_000;

/// Most that a 16-bit timer divides by, and most that it counts to: its registers hold one less.
const SIXTEEN_BITS: u32 = 65_536;

/// Pulse that an ESC expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PulseKind {
    /// 1000 to 2000 us, repeated at a rate of its own.
    Pwm,
    /// 125 to 250 us, one pulse per step.
    OneShot125,
}

/// How a 16-bit timer that counts up makes a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimerPeriod {
    /// Cycles of the timer's clock per tick, 1 to 65,536.
    pub division: u32,
    /// Ticks per period, 1 to 65,536.
    pub ticks: u32,
}

impl TimerPeriod {
    /// The smallest division with which a period of `clock_hz / rate_hz` fits into 16 bits and comes out exactly; if
    /// none below twice the smallest does, the smallest, and the nearest period. A rate of 0 counts as 1.
    pub fn new(clock_hz: u32, rate_hz: u32) -> Self {
        let rate_hz = rate_hz.max(1);
        let cycles = rounded_quotient(clock_hz, rate_hz);
        let smallest = cycles.div_ceil(SIXTEEN_BITS).clamp(1, SIXTEEN_BITS);
        let exact = |division: &u32| clock_hz.is_multiple_of(rate_hz) && cycles.is_multiple_of(*division);
        let division = (smallest..2 * smallest).find(exact).unwrap_or(smallest);
        Self { division, ticks: rounded_quotient(cycles, division).clamp(1, SIXTEEN_BITS) }
    }

    /// The period in cycles of the timer's clock.
    pub fn cycles(&self) -> u32 {
        self.division.saturating_mul(self.ticks)
    }

    /// For the prescaler register.
    pub fn prescaler(&self) -> u16 {
        register(self.division)
    }

    /// For the auto-reload register.
    pub fn reload(&self) -> u16 {
        register(self.ticks)
    }

    /// The count at which so much of the period is left, us; 0 if the period is not that long.
    pub fn count_before_end(&self, clock_hz: u32, time_us: u32) -> u16 {
        let ticks = (clock_hz / 1_000_000).saturating_mul(time_us) / self.division.max(1);
        self.ticks.saturating_sub(ticks).min(SIXTEEN_BITS - 1) as u16
    }
}

/// The nearest whole number to a quotient; the divisor is not 0.
fn rounded_quotient(dividend: u32, divisor: u32) -> u32 {
    let (quotient, rest) = (dividend / divisor, dividend % divisor);
    quotient + u32::from(rest >= divisor - rest)
}

/// What a register holds for a number from 1 to 65,536: one less.
fn register(number: u32) -> u16 {
    number.saturating_sub(1).min(SIXTEEN_BITS - 1) as u16
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
    /// PWM at 400 Hz on TIM1.
    pub const PWM_400_HZ: OutputConfig = OutputConfig { kind: PulseKind::Pwm, ticks_per_us: 24.0 };

    /// Pulses of a kind on a timer of this clock with this period.
    pub fn new(kind: PulseKind, clock_hz: u32, period: &TimerPeriod) -> Self {
        // both whole numbers are exact in f32: MHz, and at most 65,536
        let cycles_per_us = (clock_hz / 1_000_000) as f32;
        Self { kind, ticks_per_us: cycles_per_us / period.division as f32 }
    }

    /// Shortest pulse, us: what a disarmed ESC gets, and command 0.
    pub fn pulse_min_us(&self) -> f32 {
        match self.kind {
            PulseKind::Pwm => 1000.0,
            PulseKind::OneShot125 => 125.0,
        }
    }

    /// Length of a pulse, to the nearest us.
    pub fn pulse_us(&self, compare_counts: u16) -> u16 {
        // `as` saturates
        (f32::from(compare_counts) / self.ticks_per_us + 0.5) as u16
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn pulses_span_the_range_of_their_kind() {
        let pwm = OutputConfig::PWM_400_HZ;
        let commands = MotorCommands([0.0, 0.5, 1.0, 7.0]);
        assert_eq!(pwm.compare_counts(&commands, true), [24_000, 36_000, 48_000, 48_000]);
        assert_eq!(pwm.compare_counts(&commands, false), [24_000; 4]);
        let one_shot = OutputConfig { kind: PulseKind::OneShot125, ticks_per_us: 168.0 };
        assert_eq!(one_shot.compare_counts(&commands, true), [21_000, 31_500, 42_000, 42_000]);
        assert_eq!(pwm.compare_counts(&MotorCommands([f32::NAN; 4]), true), [24_000; 4]);
    }

    #[test]
    fn known_periods() {
        let period = |clock_hz, rate_hz| {
            let TimerPeriod { division, ticks } = TimerPeriod::new(clock_hz, rate_hz);
            (division, ticks)
        };
        assert_eq!(period(PULSE_TIMER_HZ, 400), (7, 60_000));
        assert_eq!(period(LOOP_TIMER_HZ, 400), (4, 52_500));
        // 13 would fit, but 840,000 is no multiple of it
        assert_eq!(period(LOOP_TIMER_HZ, 100), (14, 60_000));
        assert_eq!(period(PULSE_TIMER_HZ, 50), (56, 60_000));
        // no division makes 168 MHz / 490 exact
        assert_eq!(period(PULSE_TIMER_HZ, 490), (6, 57_143));
        assert_eq!(period(PULSE_TIMER_HZ, 10_000), (1, 16_800));
        let default = TimerPeriod::new(PULSE_TIMER_HZ, 400);
        assert_eq!(OutputConfig::new(PulseKind::Pwm, PULSE_TIMER_HZ, &default), OutputConfig::PWM_400_HZ);
        assert_eq!((default.prescaler(), default.reload()), (6, 59_999));
        assert_eq!(default.count_before_end(PULSE_TIMER_HZ, 500), 48_000);
        assert_eq!(default.count_before_end(PULSE_TIMER_HZ, 3000), 0);
    }

    /// A period of all that 16 bits count to: its registers and compare values stay within 16 bits.
    #[test]
    fn the_longest_period_fits_its_registers() {
        let longest = TimerPeriod { division: SIXTEEN_BITS, ticks: SIXTEEN_BITS };
        assert_eq!((longest.prescaler(), longest.reload()), (u16::MAX, u16::MAX));
        assert_eq!(longest.count_before_end(PULSE_TIMER_HZ, 0), u16::MAX);
        let shortest = TimerPeriod { division: 1, ticks: 1 };
        assert_eq!((shortest.prescaler(), shortest.reload()), (0, 0));
        // what no timer can do is as near as a register comes
        let beyond = TimerPeriod { division: 100_000, ticks: 0 };
        assert_eq!((beyond.prescaler(), beyond.reload()), (u16::MAX, 0));
    }

    proptest! {
        #[test]
        fn any_period_fits_and_is_the_nearest(clock_hz in 1u32.., rate_hz: u32) {
            let period = TimerPeriod::new(clock_hz, rate_hz);
            prop_assert!((1..=SIXTEEN_BITS).contains(&period.division) && (1..=SIXTEEN_BITS).contains(&period.ticks));
            let wanted = f64::from(clock_hz) / f64::from(rate_hz.max(1));
            if wanted >= 1.0 {
                // to the nearest cycle, then to the nearest tick
                let error = (f64::from(period.cycles()) - wanted).abs();
                prop_assert!(error <= 0.5 * f64::from(period.division) + 0.5, "{error} of {wanted}");
            }
        }
    }

    /// Every rate that a person can choose: the period fits, no smaller division would do, both ends of a pulse fit
    /// into the period, and its steps are fine enough.
    #[test]
    fn every_pwm_rate_has_room_for_its_pulses() {
        for rate_hz in 50..=490 {
            let period = TimerPeriod::new(PULSE_TIMER_HZ, rate_hz);
            let rate_is_hz = f64::from(PULSE_TIMER_HZ) / f64::from(period.cycles());
            assert!((rate_is_hz / f64::from(rate_hz) - 1.0).abs() < 1e-5, "{rate_hz}: {rate_is_hz}");
            let fits = |division: u32| PULSE_TIMER_HZ / rate_hz <= SIXTEEN_BITS * division;
            let exact = |division: u32| PULSE_TIMER_HZ.is_multiple_of(rate_hz * division);
            let is_exact = exact(period.division);
            assert!((1..period.division).all(|smaller| !fits(smaller) || is_exact && !exact(smaller)), "{rate_hz}");
            let output = OutputConfig::new(PulseKind::Pwm, PULSE_TIMER_HZ, &period);
            let [shortest, longest, ..] = output.compare_counts(&MotorCommands([0.0, 1.0, 0.0, 0.0]), true);
            assert!(u32::from(longest) < period.ticks, "{rate_hz}");
            // an ESC resolves about 1 us
            assert!(longest - shortest >= 1500, "{rate_hz}: {} steps", longest - shortest);
            assert_eq!((output.pulse_us(shortest), output.pulse_us(longest)), (1000, 2000));
        }
    }

    #[test]
    fn both_loop_rates_have_one_shot_pulses() {
        for (rate_hz, steps) in [(100, 750), (400, 3000)] {
            let period = TimerPeriod::new(PULSE_TIMER_HZ, rate_hz);
            let output = OutputConfig::new(PulseKind::OneShot125, PULSE_TIMER_HZ, &period);
            let [shortest, longest, ..] = output.compare_counts(&MotorCommands([0.0, 1.0, 0.0, 0.0]), true);
            assert_eq!((longest - shortest, output.pulse_us(shortest), output.pulse_us(longest)), (steps, 125, 250));
        }
    }
}
