//! The order of the study: the same searches for both controllers, in turn, each with the same number of points.

use super::measured::Columns;
use super::side::Side;

/// Weights of the columns: each preference once, then all alike. What is preferred counts four times.
const PREFERENCES: [Columns; 5] = [
    [4.0, 4.0, 1.0, 1.0, 1.0, 1.0],
    [1.0, 1.0, 4.0, 1.0, 1.0, 1.0],
    [1.0, 1.0, 1.0, 4.0, 1.0, 1.0],
    [1.0, 1.0, 1.0, 1.0, 4.0, 4.0],
    [1.0; 6],
];

/// How many points are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// By each preference.
    pub per_preference: usize,
    /// Goals among the other side's front.
    pub goals: usize,
    /// For each goal.
    pub per_goal: usize,
}

impl Budget {
    /// Points of a side in all, the start included.
    pub fn points(&self) -> usize {
        1 + PREFERENCES.len() * self.per_preference + self.goals * self.per_goal
    }
}

/// Searches by preferences first, then each side for what the other has and it does not; the first side is the last to
/// move.
pub fn run<const A: usize, const B: usize>(ours: &mut Side<'_, A>, theirs: &mut Side<'_, B>, budget: &Budget) {
    let mut seeds = 1..;
    let mut seed = || seeds.next().unwrap_or(0);
    for weights in &PREFERENCES {
        let seed = seed();
        theirs.search(|measured| measured.cost(weights), budget.per_preference, seed);
        ours.search(|measured| measured.cost(weights), budget.per_preference, seed);
    }
    for _ in 0..budget.goals {
        let seed = seed();
        theirs.strive(ours, budget.per_goal, seed);
        ours.strive(theirs, budget.per_goal, seed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::front::measured::Measured;

    const BUDGET: Budget = Budget { per_preference: 10, goals: 4, per_goal: 10 };

    /// A controller that trades RMS for noise along a curve, whose other parameter is best at 1; `ahead` is how much
    /// better it is than another.
    fn trade(at: &[f64; 2], ahead: f64) -> Option<Measured> {
        let [speed, other] = at.map(libm::exp);
        let off = (other - 1.0) * (other - 1.0);
        Some(Measured {
            rms_deg: 8.0 + 0.1 / speed + off - ahead,
            overshoot_pct: 1.0,
            settling_s: 0.35 + off,
            peak_deg: 0.3,
            command_deviation: 0.01 * speed + 0.01 * off,
            delay_margin_ms: 20.0 - 2.0 * speed,
            sensitivity_peak: 1.2 + 0.2 * speed,
        })
    }

    fn both(ahead: f64) -> [Side<'static, 2>; 2] {
        let mut ours = Side::new([0.5, 0.5], move |at| trade(at, ahead));
        let mut theirs = Side::new([0.5, 0.5], |at| trade(at, 0.0));
        run(&mut ours, &mut theirs, &BUDGET);
        [ours, theirs]
    }

    /// Both spend the same, end within the limits, and a second study is the first again.
    #[test]
    fn both_sides_spend_the_same_and_do_the_same_again() {
        let [ours, theirs] = both(0.3);
        assert_eq!([ours.points.len(), theirs.points.len()], [BUDGET.points(); 2]);
        for side in [&ours, &theirs] {
            assert!(side.front().len() > 3, "{:?}", side.front());
            assert!(side.front().iter().all(|&place| side.points[place].measured.unwrap().is_within_limits()));
        }
        let [again, _] = both(0.3);
        assert_eq!(ours.points, again.points);
    }

    /// Who is ahead by three scales of a column comes to dominate what the other finds, and is dominated nowhere.
    #[test]
    fn the_better_side_dominates_and_not_the_other_way_round() {
        let [ours, theirs] = both(0.3);
        let beaten = |by: &Side<'_, 2>, side: &Side<'_, 2>| {
            let front = side.front();
            let points = front.iter().filter_map(|&place| side.points[place].measured);
            (points.filter(|point| !by.dominating(point).is_empty()).count(), front.len())
        };
        let (beaten_of_theirs, all) = beaten(&ours, &theirs);
        assert!(3 * beaten_of_theirs >= 2 * all, "{beaten_of_theirs} of {all}");
        assert_eq!(beaten(&theirs, &ours).0, 0);
    }

    #[test]
    fn what_cannot_be_measured_is_left() {
        let half = |at: &[f64; 2]| if at[0] > 0.6 { None } else { trade(at, 0.0) };
        let mut side = Side::new([0.59, 0.0], half);
        side.search(|measured| measured.cost(&[1.0; 6]), 20, 1);
        assert!(side.balanced().is_some_and(|place| side.points[place].at[0] <= 0.6));
    }
}
