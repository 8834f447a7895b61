//! How uncertain fitted numbers are, by what they would be had a part of the flight been another: the fit is made again
//! without each of two to eight parts of its windows, one after the other in time, and the numbers' scatter is carried
//! over to the whole (the jackknife with groups left out: Shao and Tu, The Jackknife and Bootstrap, 1995, section 2.3).
//!
//! The scatter of the windows' wishes at one optimum (`scatter`) says the same as long as a fit is linear in its
//! numbers. On a real log it is not always: a delay and a lag change places, a brake comes and goes with a trim, and
//! what the whole log pins down hangs on one manoeuvre of it.

use rayon::prelude::*;

use crate::diagnosis::fitting::fit::{Fit, Nominal, values_from};
use crate::diagnosis::fitting::round::Round;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::statistics::dot;

/// Most parts of the windows, each left out once.
const PARTS_MAX: usize = 8;
/// One says nothing of a scatter.
const PARTS_MIN: usize = 2;
/// Windows that a part has: of one, a fault of its start state would be all that is left out.
const WINDOWS_USUAL: usize = 2;
/// Of so few windows each is a part all the same.
const PARTS_USUAL: usize = 4;
/// A scatter of few parts is known badly, and more often too small than too large: Student's 97.5 % quantiles at 1 to 7
/// degrees of freedom, for two parts and more, over that of the most.
const OF_FEW: [f64; PARTS_MAX - PARTS_MIN + 1] =
    [12.706 / 2.365, 4.303 / 2.365, 3.182 / 2.365, 2.776 / 2.365, 2.571 / 2.365, 2.447 / 2.365, 1.0];

/// All numbers of a fit without each part of its windows, less their mean.
#[derive(Clone, Debug, Default)]
pub(super) struct LeftOut {
    departures: Vec<Vec<f64>>,
}

impl LeftOut {
    /// A fit to some windows, made again from its own values on; nothing for one window or a fit without numbers.
    pub(super) fn of(found: &Fit<'_>, shooting: &Shooting<'_>, nominal: Nominal<'_>, windows: &[usize]) -> LeftOut {
        if windows.len() < PARTS_MIN || found.size() == 0 {
            return LeftOut::default();
        }
        let parts = (windows.len() / WINDOWS_USUAL).clamp(PARTS_USUAL.min(windows.len()), PARTS_MAX);
        // all of them begin at the same numbers and start states
        let first = Round::first(shooting, nominal, found.terms.clone(), &found.starts, windows);
        let without = |part: usize| -> Vec<f64> {
            let is_in = |place: usize| place * parts / windows.len() != part;
            let others: Vec<usize> =
                windows.iter().enumerate().filter(|(place, _)| is_in(*place)).map(|(_, window)| *window).collect();
            values_from(shooting, nominal, first.only(is_in), &others)
        };
        LeftOut::from_values((0..parts).into_par_iter().with_max_len(1).map(without).collect())
    }

    fn from_values(values: Vec<Vec<f64>>) -> LeftOut {
        let count = values.len() as f64;
        let size = values.first().map_or(0, Vec::len);
        let mean: Vec<f64> = (0..size).map(|i| values.iter().map(|values| values[i]).sum::<f64>() / count).collect();
        let departure = |values: Vec<f64>| values.iter().zip(&mean).map(|(value, mean)| value - mean).collect();
        LeftOut { departures: values.into_iter().map(departure).collect() }
    }

    /// Variance of a linear function of the numbers; 0 where nothing was left out.
    pub(super) fn variance_along(&self, slope: &[f64]) -> f64 {
        let count = self.departures.len();
        let Some(of_few) = count.checked_sub(PARTS_MIN).and_then(|more| OF_FEW.get(more)) else { return 0.0 };
        let squares: f64 = self.departures.iter().map(|departure| dot(departure, slope)).map(|d| d * d).sum();
        squares * (count - 1) as f64 / count as f64 * of_few * of_few
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Axis;
    use crate::diagnosis::fitted::Fitted;
    use crate::diagnosis::fitting::fit::{Term, all_values, fit};
    use crate::diagnosis::simulated_bench::Bench;
    use crate::log::Log;
    use crate::prediction::Subject;
    use crate::sensors::random::RandomStream;

    /// 16 s of a bench, with a lag that the model below has to find.
    fn log() -> Log {
        Bench { rows: 3_200, lag_s: 0.03, delay_s: 0.0, gusts_rad_s2: 2.0 }.log(RandomStream::new(8, "left out"))
    }

    #[test]
    fn a_fit_without_a_part_is_that_of_the_other_windows_alone() {
        let (log, subject) = (log(), Subject::Axes);
        let shooting = subject.shooting(&log, &subject.noise(&log)).unwrap();
        let is_fitted = |effect: &Fitted| ["torque_bias", "motor_lag", "actuation_delay"].contains(&effect.name());
        let others = Fitted::hypotheses(&subject.scope(&log)).into_iter().filter(is_fitted);
        let effects: Vec<Fitted> = [Fitted::InputGain(Axis::Roll)].into_iter().chain(others).collect();
        let terms = effects.iter().map(|effect| Term { effect, values: effect.beginning(&[0.02, 0.01]) }).collect();
        let nominal = || subject.model(&log);
        let (starts, windows) = (shooting.log.measured_starts(&nominal()), shooting.log.in_use());
        let found = fit(&shooting, &nominal, terms, &starts, &windows);
        let without = |part: usize| {
            let others = windows.iter().enumerate().filter(|(place, _)| place * PARTS_MAX / windows.len() != part);
            let others: Vec<usize> = others.map(|(_, window)| *window).collect();
            all_values(&fit(&shooting, &nominal, found.terms.clone(), &found.starts, &others).terms)
        };
        let expected = LeftOut::from_values((0..PARTS_MAX).map(without).collect());
        let left_out = LeftOut::of(&found, &shooting, &nominal, &windows);
        assert!(windows.len() >= PARTS_MAX * WINDOWS_USUAL, "{}", windows.len());
        assert_eq!(left_out.departures, expected.departures);
        // and they do differ
        assert!(left_out.departures.iter().all(|of_part| of_part[0] != 0.0), "{:?}", left_out.departures);
    }

    #[test]
    fn the_mean_of_parts_scatters_as_its_parts_do() {
        // the mean without a part: its variance by the jackknife is that of the mean of all parts
        let mut random = RandomStream::new(4, "left out");
        let mut claimed = 0.0;
        for _ in 0..400 {
            let parts: Vec<f64> = (0..PARTS_MAX).map(|_| random.normal()).collect();
            let sum: f64 = parts.iter().sum();
            let values = parts.iter().map(|part| vec![(sum - part) / (PARTS_MAX - 1) as f64, 0.0]).collect();
            claimed += LeftOut::from_values(values).variance_along(&[1.0, 5.0]) / 400.0;
        }
        // of 400 variances with seven degrees of freedom each the mean is known to 2.7 %; four times that
        assert!((claimed * PARTS_MAX as f64 - 1.0).abs() < 0.11, "{claimed}");
    }

    #[test]
    fn few_parts_lie_outside_no_more_often_than_many() {
        let mut random = RandomStream::new(5, "few left out");
        for count in PARTS_MIN..=PARTS_MAX {
            let is_outside = |_: &usize| {
                let parts: Vec<f64> = (0..count).map(|_| random.normal()).collect();
                let sum: f64 = parts.iter().sum();
                let values = parts.iter().map(|part| vec![(sum - part) / (count - 1) as f64]).collect();
                (sum / count as f64).abs() > 2.365 * LeftOut::from_values(values).variance_along(&[1.0]).sqrt()
            };
            let outside = (0..4000).filter(is_outside).count();
            // 5 % of 4000 are known to 14; four times that
            assert!((144..=256).contains(&outside), "{outside} with {count} parts");
        }
    }

    #[test]
    fn what_changes_places_is_certain_together() {
        let values = (0..PARTS_MAX).map(|part| vec![0.01 + 0.001 * part as f64, 0.02 - 0.001 * part as f64]).collect();
        let left_out = LeftOut::from_values(values);
        assert!(left_out.variance_along(&[1.0, 0.0]) > 1e-5);
        assert!(left_out.variance_along(&[1.0, 1.0]) < 1e-20);
        assert_eq!(LeftOut::default().variance_along(&[1.0, 1.0]), 0.0);
    }
}
