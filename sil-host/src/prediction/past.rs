//! States a little back in time, for an attitude that is reported late.

use super::body::Turning;

/// States with their times, earliest first; none where no report is late.
pub(super) struct Past {
    pub(super) states: Vec<(f64, Turning)>,
}

impl Past {
    #[inline]
    pub(super) fn remember(&mut self, time_s: f64, state: &Turning) {
        if !self.states.is_empty() {
            self.states.push((time_s, *state));
        }
    }

    /// The state whose attitude is reported now, where reports are late.
    #[inline]
    pub(super) fn seen(&self, now: &Turning, now_s: f64, delay_s: f64) -> Turning {
        if self.states.is_empty() { *now } else { self.earlier(now, now_s - delay_s) }
    }

    /// The state at a time in the past: a straight line between neighbours corrected by their rates (angles of the
    /// gimbal and of separate axes; when free the body's rates stand in, to the accuracy of half a step).
    fn earlier(&self, now: &Turning, at_s: f64) -> Turning {
        let after = self.states.partition_point(|(time_s, _)| *time_s < at_s);
        let (Some((t1, x1)), Some((t0, x0))) = (self.states.get(after), self.states.get(after.wrapping_sub(1))) else {
            return self.states.first().map_or(*now, |(time_s, state)| drifted(state, at_s - time_s));
        };
        let (h, s) = (t1 - t0, (at_s - t0) / (t1 - t0));
        let mut seen = *x0;
        for i in 0..3 {
            // Hermite's cubic; its slope terms act on h/4 of the difference of rates at most
            let (s2, s3) = (s * s, s * s * s);
            seen[i] = (2.0 * s3 - 3.0 * s2 + 1.0) * x0[i]
                + (s3 - 2.0 * s2 + s) * h * x0[3 + i]
                + (3.0 * s2 - 2.0 * s3) * x1[i]
                + (s3 - s2) * h * x1[3 + i];
        }
        seen
    }
}

fn drifted(state: &Turning, by_s: f64) -> Turning {
    let mut drifted = *state;
    for i in 0..3 {
        drifted[i] += by_s * state[3 + i];
    }
    drifted
}
