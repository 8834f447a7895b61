//! What a point of the study is judged by: the columns of the comparison, each as small as can be, within limits on the
//! margins.

use serde::Serialize;
use sil_host::metrics::mean;

use crate::comparison::contender::{Contender, Figures};
use crate::comparison::draw::Draw;
use crate::comparison::hover::{self, LeastMargins, Push};
use crate::comparison::weather::Weather;

/// Least delay margin and greatest peak sensitivity, in both states of an observer that has two.
const DELAY_MARGIN_MIN_MS: f64 = 10.0;
const SENSITIVITY_PEAK_MAX: f64 = 2.0;
/// How far a torque step may throw what is chosen, in the mean over the draws, degrees: the cascade that was tuned for
/// RMS is thrown 0.31 on the nominal vehicle.
const PEAK_MAX_DEG: f64 = 0.3;
/// Delay margin beyond which more counts for nothing, ms: as far as an observer's alerts are tested.
const DELAY_MARGIN_ENOUGH_MS: f64 = 30.0;
/// Cost of what is beyond a limit, in the scales of the columns: of a millisecond, and of a tenth of the sensitivity.
const BEYOND_LIMIT: f64 = 20.0;

/// A column of the study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// What tables call it.
    pub name: &'static str,
    /// Differences below this count as none.
    pub resolution: f64,
    /// Differences of this size weigh alike over the columns.
    pub scale: f64,
}

/// Columns of the study.
pub const COLUMNS: [Column; 6] = [
    Column { name: "RMS, deg", resolution: 0.001, scale: 0.1 },
    // a tenth of a degree of RMS for 1 %, as in the cost of the search for one column
    Column { name: "overshoot, %", resolution: 0.1, scale: 1.0 },
    Column { name: "settling, s", resolution: 0.001, scale: 0.02 },
    Column { name: "peak after 0.1 N m, deg", resolution: 0.01, scale: 0.1 },
    Column { name: "command deviation", resolution: 0.0001, scale: 0.005 },
    Column { name: "delay margin, ms", resolution: 0.1, scale: 3.0 },
];

/// Less is better in each.
pub type Columns = [f64; COLUMNS.len()];

/// Figures of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Means over the draws of the test sequence, in each weather of the study.
    pub rms_deg: f64,
    /// Of the steps of both axes, %.
    pub overshoot_pct: f64,
    /// Of the steps of both axes, s.
    pub settling_s: f64,
    /// Mean over the draws of the largest roll after a torque step of 0.1 N m.
    pub peak_deg: f64,
    /// Mean over the draws of the deviation of the motors' commands at hover.
    pub command_deviation: f64,
    /// The smaller of roll's and pitch's on the nominal vehicle, and of both states of the observer.
    pub delay_margin_ms: f64,
    /// The greater, likewise.
    pub sensitivity_peak: f64,
}

impl Measured {
    /// Flies in these weathers and measures; none of what can't be flown, leaves the numbers, or oscillates by itself.
    pub fn of(contender: &Contender, draws: &[Draw], weathers: &[Weather]) -> Option<Self> {
        if !contender.can_fly() {
            return None;
        }
        let calm = LeastMargins::of_both(&hover::margins_in_calm(contender)?)?;
        // alerts need as much time again, and what is beyond a limit in calm is so whatever they do
        let is_within = calm.delay_ms >= DELAY_MARGIN_MIN_MS && calm.sensitivity_peak <= SENSITIVITY_PEAK_MAX;
        let alert = if is_within { hover::margins_in_alert(contender).unwrap_or(calm) } else { calm };
        let flights: Vec<Figures> = weathers.iter().flat_map(|&weather| contender.fly_all(draws, weather)).collect();
        let pushes = hover::push_all(contender, draws);
        let flown = |figure: fn(&Figures) -> f64| mean(&flights.iter().map(figure).collect::<Vec<_>>());
        let pushed = |figure: fn(&Push) -> f64| mean(&pushes.iter().map(figure).collect::<Vec<_>>());
        let measured = Self {
            rms_deg: flown(|flight| flight.rms_deg),
            overshoot_pct: flown(|flight| flight.overshoot_pct),
            settling_s: flown(|flight| flight.settling_s),
            peak_deg: pushed(|push| push.peak_deg),
            command_deviation: pushed(|push| push.command_deviation),
            delay_margin_ms: calm.delay_ms.min(alert.delay_ms),
            sensitivity_peak: calm.sensitivity_peak.max(alert.sensitivity_peak),
        };
        measured.columns().iter().all(|column| column.is_finite()).then_some(measured)
    }

    /// The columns, the delay margin negative, in whole steps of their resolution.
    pub fn columns(&self) -> Columns {
        let delay_margin_ms = self.delay_margin_ms.min(DELAY_MARGIN_ENOUGH_MS);
        let values = [
            self.rms_deg,
            self.overshoot_pct,
            self.settling_s,
            self.peak_deg,
            self.command_deviation,
            -delay_margin_ms,
        ];
        core::array::from_fn(|index| (values[index] / COLUMNS[index].resolution).round() * COLUMNS[index].resolution)
    }

    /// Whether it keeps the limits on the margins.
    pub fn is_within_limits(&self) -> bool {
        self.beyond_limits() == 0.0
    }

    /// Whether a torque step throws it no farther than it may throw what is chosen.
    pub fn is_thrown_little(&self) -> bool {
        self.peak_deg <= PEAK_MAX_DEG
    }

    /// Cost of what is beyond them, zero within.
    fn beyond_limits(&self) -> f64 {
        let delay = (DELAY_MARGIN_MIN_MS - self.delay_margin_ms).max(0.0);
        let sensitivity = (self.sensitivity_peak - SENSITIVITY_PEAK_MAX).max(0.0) / 0.1;
        BEYOND_LIMIT * (delay + sensitivity)
    }

    /// Weighted sum of the columns in their scales.
    pub fn cost(&self, weights: &Columns) -> f64 {
        let columns = self.columns();
        let of = |index: usize| weights[index] * columns[index] / COLUMNS[index].scale;
        (0..columns.len()).map(of).sum::<f64>() + self.beyond_limits()
    }

    /// How far it is from dominating `goal`: the column that is furthest behind, in scales, and a little of the others,
    /// so that all of them go on once none is behind (Wierzbicki's achievement function).
    pub fn shortfall(&self, goal: &Measured) -> f64 {
        let (columns, goal) = (self.columns(), goal.columns());
        let behind: Columns = core::array::from_fn(|index| (columns[index] - goal[index]) / COLUMNS[index].scale);
        behind.iter().copied().fold(f64::MIN, f64::max) + 0.1 * mean(&behind) + self.beyond_limits()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::front::dominance::dominates;

    const GOAL: Measured = Measured {
        rms_deg: 8.0,
        overshoot_pct: 1.0,
        settling_s: 0.35,
        peak_deg: 0.4,
        command_deviation: 0.02,
        delay_margin_ms: 15.0,
        sensitivity_peak: 1.9,
    };

    #[test]
    fn more_delay_margin_is_better_up_to_what_is_enough() {
        let of = |delay_margin_ms| Measured { delay_margin_ms, ..GOAL }.columns();
        assert!(dominates(&of(16.0), &of(15.0)));
        assert_eq!(of(31.0), of(45.0));
        assert!(!dominates(&of(15.04), &of(15.0)), "less than the resolution");
    }

    /// No shortfall is left exactly where the goal is dominated by more than a column is worth.
    #[test]
    fn without_shortfall_the_goal_is_dominated() {
        let better = Measured { rms_deg: 7.9, settling_s: 0.34, ..GOAL };
        assert!(better.shortfall(&GOAL) < 0.0 && dominates(&better.columns(), &GOAL.columns()));
        let mixed = Measured { settling_s: 0.37, ..better };
        assert!(mixed.shortfall(&GOAL) > 0.9, "one scale behind in settling, half of one ahead in RMS");
    }

    #[test]
    fn what_is_beyond_a_limit_costs_more_than_any_column_gives() {
        let beyond = Measured { sensitivity_peak: 2.1, rms_deg: 7.0, ..GOAL };
        assert!(!beyond.is_within_limits() && GOAL.is_within_limits());
        assert!(beyond.cost(&[1.0; 6]) > GOAL.cost(&[1.0; 6]) && beyond.shortfall(&GOAL) > 0.0);
    }
}
