//! How fast the lock-step goes: computing time, hence shown and never compared.

use std::time::Duration;

/// Round trips of one flight.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    round_trips: Vec<Duration>,
}

impl Timing {
    /// Takes the time between a message and its answer.
    pub fn add(&mut self, round_trip: Duration) {
        self.round_trips.push(round_trip);
    }

    /// Number of round trips.
    pub fn len(&self) -> usize {
        self.round_trips.len()
    }

    /// True without any.
    pub fn is_empty(&self) -> bool {
        self.round_trips.is_empty()
    }

    /// The time that this share (0..1) of the round trips stays within, s; none without any.
    pub fn quantile_s(&self, share: f64) -> Option<f64> {
        let mut sorted = self.round_trips.clone();
        sorted.sort_unstable();
        let last = sorted.len().checked_sub(1)?;
        let at = (share.clamp(0.0, 1.0) * last as f64).round() as usize;
        sorted.get(at).map(Duration::as_secs_f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_the_sorted_times() {
        let mut timing = Timing::default();
        assert_eq!(timing.quantile_s(0.5), None);
        for ms in [9, 1, 5, 3, 7] {
            timing.add(Duration::from_millis(ms));
        }
        assert_eq!([0.0, 0.5, 1.0].map(|share| timing.quantile_s(share)), [Some(0.001), Some(0.005), Some(0.009)]);
    }
}
