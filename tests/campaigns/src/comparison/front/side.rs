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

/// A controller with N parameters, and how its points are measured.
pub struct Side<'a, const N: usize> {
    /// All points that were measured, in their order.
    pub points: Vec<Point<N>>,
    evaluate: Box<dyn FnMut(&[f64; N]) -> Option<Measured> + 'a>,
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

    /// The point of the front at which the columns' sum, in their scales, is least.
    pub fn balanced(&self) -> Option<usize> {
        let cost = |place: usize| self.points[place].measured.map_or(f64::MAX, |point| point.cost(&[1.0; 6]));
        self.front().into_iter().min_by(|&a, &b| cost(a).total_cmp(&cost(b)))
    }
}
