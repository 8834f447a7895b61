//! Four channels of a scope on AUX 1 to 4, behind the level shifters.

use emulated_board::time::{TICKS_PER_US, Ticks};
use emulated_board::{Flight, MILLISECOND};

/// A pulse on a line.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// 1 to 4.
    pub aux: usize,
    pub rise: Ticks,
    pub width: Ticks,
}

impl Seen {
    pub fn since_ms(&self, from: Ticks) -> f64 {
        (self.rise - from) as f64 / MILLISECOND as f64
    }

    fn width_us(&self) -> f64 {
        self.width as f64 / TICKS_PER_US as f64
    }

    /// Does a motor turn by it?
    fn is_live(&self) -> bool {
        self.width_us() > 1001.0
    }
}

/// All that was on the lines, in the order of the pulses' ends.
#[derive(Clone, Debug)]
pub struct Scope {
    pub pulses: Vec<Seen>,
}

/// From power-on.
#[derive(Clone, Copy, Debug)]
pub struct Early {
    /// For how long lines were high before the image took them.
    pub high_ms: f64,
    /// Until the first disarmed pulse.
    pub first_pulse_ms: f64,
}

impl Scope {
    /// What was recorded; TIM1's channels 4 to 1 are AUX 1 to 4.
    pub fn of(flight: &Flight) -> Self {
        let vehicle = flight.vehicle.borrow();
        let seen = vehicle.line_pulses().iter();
        Self { pulses: seen.map(|p| Seen { aux: 4 - p.channel, rise: p.rise, width: p.width }).collect() }
    }

    /// The pulses that rose in this time.
    pub fn between(&self, from: Ticks, to: Ticks) -> Self {
        let within = self.pulses.iter().filter(|pulse| (from..to).contains(&pulse.rise));
        Self { pulses: within.copied().collect() }
    }

    pub fn since_power_on(&self) -> Early {
        let ms = |ticks: Ticks| ticks as f64 / MILLISECOND as f64;
        let first = self.pulses.iter().find(|pulse| (pulse.width_us() - 1000.0).abs() < 1.0).expect("a pulse");
        let before = self.pulses.iter().filter(|pulse| pulse.rise < first.rise && pulse.aux == first.aux);
        Early { high_ms: before.map(|pulse| ms(pulse.width)).sum(), first_pulse_ms: ms(first.rise) }
    }

    fn of_aux(&self, aux: usize) -> impl Iterator<Item = &Seen> {
        self.pulses.iter().filter(move |pulse| pulse.aux == aux)
    }

    pub fn all_are(&self, width_us: u64) -> bool {
        let wanted = width_us as f64;
        (1..=4).all(|aux| self.of_aux(aux).count() > 0)
            && self.pulses.iter().all(|pulse| (pulse.width_us() - wanted).abs() < 0.5)
    }

    /// Of the first, to a microsecond.
    pub fn width_us(&self) -> u64 {
        self.pulses.first().map_or(0, |pulse| pulse.width_us().round() as u64)
    }

    /// From one pulse of AUX 1 to the next.
    pub fn period_ms(&self) -> f64 {
        let rises: Vec<_> = self.of_aux(1).map(|pulse| pulse.rise).collect();
        let [first, .., last] = rises[..] else { return 0.0 };
        (last - first) as f64 / (rises.len() - 1) as f64 / MILLISECOND as f64
    }

    /// Between the first and the last rise of the latest pulses, us.
    pub fn apart_us(&self) -> f64 {
        let rises = (1..=4).filter_map(|aux| self.of_aux(aux).last().map(|pulse| pulse.rise));
        let (first, last) = rises.fold((Ticks::MAX, 0), |(first, last), rise| (first.min(rise), last.max(rise)));
        (last - first) as f64 / TICKS_PER_US as f64
    }

    /// Outputs with pulses that turn a motor: number, longest pulse in us, for how long in ms.
    pub fn live(&self) -> Vec<(usize, u64, f64)> {
        let of_aux = |aux: usize| {
            let live: Vec<_> = self.of_aux(aux).filter(|pulse| pulse.is_live()).collect();
            let (first, last) = (live.first()?, live.last()?);
            let longest_us = live.iter().map(|pulse| pulse.width_us().round() as u64).max()?;
            Some((aux, longest_us, last.since_ms(first.rise)))
        };
        (1..=4).filter_map(of_aux).collect()
    }

    pub fn first_live(&self) -> Option<Seen> {
        self.pulses.iter().find(|pulse| pulse.is_live()).copied()
    }

    /// Mean width of AUX 1 to 4, us.
    pub fn mean_us(&self) -> [f64; 4] {
        [1, 2, 3, 4].map(|aux| {
            let (sum, count) = self.of_aux(aux).fold((0.0, 0.0), |(sum, n), pulse| (sum + pulse.width_us(), n + 1.0));
            sum / count
        })
    }

    /// The longest time from one disarmed pulse of AUX 1 to the next, ms.
    pub fn longest_gap_ms(&self) -> f64 {
        let disarmed = self.of_aux(1).filter(|pulse| (pulse.width_us() - 1000.0).abs() < 1.0);
        let rises: Vec<_> = disarmed.map(|pulse| pulse.rise).collect();
        let gaps = rises.windows(2).map(|two| (two[1] - two[0]) as f64 / MILLISECOND as f64);
        gaps.fold(0.0, f64::max)
    }
}
