//! One controller's side of the study: all its points so far, and searches that begin at the best of them.

use std::collections::BTreeSet;

use super::dominance;
use super::measured::{Columns, Measured};
use crate::comparison::search;

/// A point of the search: logarithms of the parameters, and what was measured there, if anything can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<const N: usize> {
    /// Where.
    pub at: [f64; N],
    /// Figures.
    pub measured: Option<Measured>,
}

/// Measures a point.
type Evaluate<'a, const N: usize> = dyn FnMut(&[f64; N]) -> Option<Measured> + 'a;

/// A controller with N parameters, and how its points are measured.
pub struct Side<'a, const N: usize> {
    /// All points that were measured, in their order.
    pub points: Vec<Point<N>>,
    evaluate: Box<Evaluate<'a, N>>,
    /// Places in the other side's list of points that were goals.
    goals: BTreeSet<usize>,
}

impl<'a, const N: usize> Side<'a, N> {
    /// With its first point measured.
    pub fn new(start: [f64; N], evaluate: impl FnMut(&[f64; N]) -> Option<Measured> + 'a) -> Self {
        let mut side = Self { points: Vec::new(), evaluate: Box::new(evaluate), goals: BTreeSet::new() };
        side.measure(&start);
        side
    }

    fn measure(&mut self, at: &[f64; N]) -> Option<Measured> {
        let measured = (self.evaluate)(at);
        self.points.push(Point { at: *at, measured });
        measured
    }

    /// Minimises a cost from the point at which it is least so far, with this many new points.
    pub fn search(&mut self, cost: impl Fn(&Measured) -> f64, new_points: usize, seed: u64) {
        let cost_of = |measured: Option<Measured>| measured.as_ref().map_or(f64::NAN, &cost);
        let best = self.points.iter().min_by(|a, b| {
            let [a, b] = [a, b].map(|point| Some(cost_of(point.measured)).filter(|cost| !cost.is_nan()));
            a.unwrap_or(f64::MAX).total_cmp(&b.unwrap_or(f64::MAX))
        });
        let Some(&Point { at: start, measured: known }) = best else { return };
        let mut known = Some(cost_of(known));
        // the search's first value is the start's, which is known
        search::minimise(start, 1 + new_points, seed, |at| known.take().unwrap_or_else(|| cost_of(self.measure(at))));
    }

    /// Places in the list of points of those within the limits that none of them dominates.
    pub fn front(&self) -> Vec<usize> {
        let within: Vec<(usize, Columns)> = self
            .points
            .iter()
            .enumerate()
            .filter_map(|(place, point)| Some((place, point.measured.filter(Measured::is_within_limits)?.columns())))
            .collect();
        let columns: Vec<Columns> = within.iter().map(|(_, columns)| *columns).collect();
        dominance::front(&columns).into_iter().map(|index| within[index].0).collect()
    }

    /// Goes for the point of the other side's front that this side is furthest from dominating, of those that were no
    /// goal yet; of all if each was one.
    pub fn strive<const M: usize>(&mut self, other: &Side<'_, M>, new_points: usize, seed: u64) {
        let goals: Vec<(usize, Measured)> =
            other.front().into_iter().filter_map(|place| Some((place, other.points[place].measured?))).collect();
        let is_new = |place: &usize| !self.goals.contains(place);
        let any_new = goals.iter().any(|(place, _)| is_new(place));
        let eligible = goals.into_iter().filter(|(place, _)| !any_new || is_new(place));
        let Some((place, goal)) = eligible.max_by(|(_, a), (_, b)| self.nearest(a).total_cmp(&self.nearest(b))) else {
            return;
        };
        self.goals.insert(place);
        self.search(|measured| measured.shortfall(&goal), new_points, seed);
    }

    /// The least shortfall from a goal so far.
    fn nearest(&self, goal: &Measured) -> f64 {
        let measured = self.points.iter().filter_map(|point| point.measured);
        measured.map(|measured| measured.shortfall(goal)).fold(f64::MAX, f64::min)
    }

    /// Places of this side's points within the limits that dominate a point.
    pub fn dominating(&self, point: &Measured) -> Vec<usize> {
        let columns = point.columns();
        let front = self.front().into_iter();
        let beats = |&place: &usize| {
            let measured = self.points[place].measured;
            measured.is_some_and(|measured| dominance::dominates(&measured.columns(), &columns))
        };
        front.filter(beats).collect()
    }

    /// The point of the front at which the columns' sum, in their scales, is least, of those that a torque step throws
    /// no farther than it may; of all if there is none.
    pub fn balanced(&self) -> Option<usize> {
        let key = |place: usize| {
            let measured = self.points[place].measured;
            measured.map_or((true, f64::MAX), |point| (!point.is_thrown_little(), point.cost(&[1.0; 6])))
        };
        let order = |a: usize, b: usize| {
            let ((a_is_thrown, a_cost), (b_is_thrown, b_cost)) = (key(a), key(b));
            a_is_thrown.cmp(&b_is_thrown).then(a_cost.total_cmp(&b_cost))
        };
        self.front().into_iter().min_by(|&a, &b| order(a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: Measured = Measured {
        rms_deg: 8.0,
        overshoot_pct: 1.0,
        settling_s: 0.35,
        peak_deg: 0.3,
        command_deviation: 0.02,
        delay_margin_ms: 15.0,
        sensitivity_peak: 1.9,
    };

    fn side_of(points: &[Measured]) -> Side<'_, 1> {
        let points = points.iter().map(|&measured| Point { at: [0.0], measured: Some(measured) }).collect();
        Side { points, evaluate: Box::new(|_| None), goals: BTreeSet::new() }
    }

    /// A sum that is less does not make up for a peak beyond what a torque step may do, unless no point keeps that.
    #[test]
    fn what_is_chosen_is_thrown_little_where_any_is() {
        let thrown = Measured { peak_deg: 0.4, rms_deg: 7.0, ..POINT };
        let slower = Measured { rms_deg: 8.2, settling_s: 0.34, ..POINT };
        assert_eq!(side_of(&[thrown, POINT, slower]).balanced(), Some(1));
        let farther = Measured { peak_deg: 0.5, rms_deg: 6.95, ..POINT };
        assert_eq!(side_of(&[farther, thrown]).balanced(), Some(1));
        assert_eq!(side_of(&[Measured { sensitivity_peak: 2.1, ..POINT }]).balanced(), None);
    }

    #[test]
    fn a_point_is_dominated_by_those_that_are_ahead_of_it() {
        let ahead = Measured { rms_deg: 7.9, ..POINT };
        let elsewhere = Measured { rms_deg: 8.1, settling_s: 0.3, ..POINT };
        assert_eq!(side_of(&[ahead, elsewhere]).dominating(&POINT), [0]);
        assert_eq!(side_of(&[ahead, elsewhere]).front(), [0, 1]);
    }
}
