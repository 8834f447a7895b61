//! The clock of a Blackbox log. Its counter of microseconds has 32 bits and begins again after 71 minutes; and where a
//! controller's clock is set back, as a simulated one's may be, the frames before and after are as good as ever, but
//! nobody knows how long it took in between: the later ones begin a new stretch, behind a gap. A few frames whose
//! stamps fit to neither side are damaged, and are left out.

use std::ops::Range;

use super::super::GAP_STEPS;
use super::super::runs::runs;
use crate::statistics::median;

/// The counter begins again here, us.
const COUNTER_US: f64 = 4_294_967_296.0;
/// No logger misses frames for longer, us: the same bound as blackbox-tools'.
const LONGEST_US: f64 = 10e6;
/// Time from the last frame before the clock was set back to the first one after it, us: a gap at any rate of frames.
const BETWEEN_US: f64 = 1e6;
/// Stamps that go on over fewer frames than an I frame's usual interval are an accident, no clock.
const RUN_FRAMES_MIN: usize = 32;

/// Makes the clock go on where it began again or was set back; a note for each time that it was set back. Stamps that
/// fit to no clock are no numbers then.
pub(super) fn continued(time_us: &mut [f64]) -> Vec<String> {
    count_on(time_us);
    let runs = going_on(time_us);
    let notes = set_forward(time_us, &runs);
    strike_strays(time_us, &runs);
    notes
}

/// Frames over which the stamps go on.
fn going_on(time_us: &[f64]) -> Vec<Range<usize>> {
    runs(time_us.len(), |frame| (0.0..LONGEST_US).contains(&(time_us[frame] - time_us[frame - 1])))
}

/// Moves each run that a clock began which was set back behind the one before, and all that follow it.
fn set_forward(time_us: &mut [f64], runs: &[Range<usize>]) -> Vec<String> {
    let gap_us = GAP_STEPS * usual_step(time_us);
    let (mut later_us, mut notes) = (0.0, Vec::new());
    let mut before: Option<[f64; 2]> = None;
    for run in runs {
        let stamps = &mut time_us[run.clone()];
        let ends = |stamps: &[f64]| match stamps {
            [first, second, .., last_but_one, last] if stamps.len() >= RUN_FRAMES_MIN => {
                Some([*first, *second, *last_but_one, *last])
            }
            _ => None,
        };
        if let (Some([last_but_one_us, last_us]), Some([first_us, second_us, ..])) = (before, ends(stamps)) {
            let (start_us, next_us) = (first_us + later_us, second_us + later_us);
            // one wild stamp at either end of the runs is no clock that was set back
            if next_us <= last_but_one_us && last_us - start_us > gap_us {
                later_us = last_us + BETWEEN_US - first_us;
                notes.push(format!(
                    "the clock was set back by {:.3} s at {:.3} s: what follows is a new stretch, {} s later",
                    1e-6 * (last_us - start_us),
                    1e-6 * last_us,
                    1e-6 * BETWEEN_US
                ));
            }
        }
        stamps.iter_mut().for_each(|stamp_us| *stamp_us += later_us);
        before = ends(stamps).map(|[.., last_but_one_us, last_us]| [last_but_one_us, last_us]).or(before);
    }
    notes
}

/// Makes the stamps of short runs no numbers that do not lie between those of the clocks' runs beside them.
fn strike_strays(time_us: &mut [f64], runs: &[Range<usize>]) {
    let is_clock = |run: &&Range<usize>| run.len() >= RUN_FRAMES_MIN;
    for (place, run) in runs.iter().enumerate().filter(|(_, run)| !is_clock(run)) {
        let before_us = runs[..place].iter().rev().find(is_clock).map(|run| time_us[run.end - 1]);
        let after_us = runs[place + 1..].iter().find(is_clock).map(|run| time_us[run.start]);
        let (first_us, last_us) = (time_us[run.start], time_us[run.end - 1]);
        if before_us.is_some_and(|before_us| first_us <= before_us)
            || after_us.is_some_and(|after_us| last_us >= after_us)
        {
            time_us[run.clone()].fill(f64::NAN);
        }
    }
}

/// Counts on where the counter began again.
fn count_on(time_us: &mut [f64]) {
    let mut rounds_us = 0.0;
    let mut last_us: Option<f64> = None;
    for stamp_us in time_us {
        // the frames between two whole ones are told by differences, which lead beyond the counter's end
        let counter_us = stamp_us.rem_euclid(COUNTER_US);
        if last_us.is_some_and(|last_us| counter_us < last_us && counter_us + COUNTER_US - last_us < LONGEST_US) {
            rounds_us += COUNTER_US;
        }
        *stamp_us = counter_us + rounds_us;
        last_us = Some(counter_us);
    }
}

/// The usual one of the steps forward, us; NaN without any.
fn usual_step(time_us: &[f64]) -> f64 {
    median(time_us.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steady(from_us: f64, frames: u32) -> Vec<f64> {
        (0..frames).map(|frame| from_us + 500.0 * f64::from(frame)).collect()
    }

    #[test]
    fn a_clock_may_be_set_back_more_than_once() {
        let mut time_us = [steady(5e6, 100), steady(4e6, 100), steady(0.0, 100)].concat();
        assert_eq!(continued(&mut time_us).len(), 2);
        let steps: Vec<f64> = time_us.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let expected = |row: usize| if row == 99 || row == 199 { BETWEEN_US } else { 500.0 };
        assert!(steps.iter().enumerate().all(|(row, step)| (step - expected(row)).abs() < 1e-6), "{steps:?}");
    }

    #[test]
    fn wild_stamps_and_gaps_are_no_clock_that_is_set_back() {
        let good = [steady(1e6, 100), steady(9e6, 100)].concat();
        for (frames, stamp_us) in [
            (50..51, 0.0),
            (50..51, 5e6),
            (99..100, 2e7),
            (100..101, 0.0),
            (120..121, 1e9),
            (0..5, 1e9),
            (120..125, 1e9),
        ] {
            let mut time_us = good.clone();
            time_us[frames.clone()].iter_mut().for_each(|time_us| *time_us += stamp_us);
            time_us[frames.start] = stamp_us;
            assert_eq!(continued(&mut time_us), Vec::<String>::new(), "{frames:?} {stamp_us}");
            for frame in (0..200).filter(|frame| !frames.contains(frame)) {
                assert_eq!(time_us[frame], good[frame], "{frames:?} {stamp_us}");
            }
            // whoever puts them in order leaves out one that is wild, but believes several
            assert!(frames.len() == 1 || time_us[frames].iter().all(|stamp_us| stamp_us.is_nan()), "{time_us:?}");
        }
        // nor are a few frames out of order
        let mut time_us = [steady(1e6, 100), steady(1e6 + 98.0 * 500.0, 100)].concat();
        assert!(continued(&mut time_us).is_empty());
    }

    #[test]
    fn the_counter_goes_on_beyond_its_32_bits() {
        let mut time_us = steady(2.0 * COUNTER_US - 50.0 * 500.0, 100);
        let expected = steady(COUNTER_US - 50.0 * 500.0, 100);
        time_us.iter_mut().for_each(|stamp_us| *stamp_us %= COUNTER_US);
        assert_eq!(continued(&mut time_us), Vec::<String>::new());
        assert_eq!(time_us, expected);
    }
}
