//! Does the MPC learn the vehicle that it flies, and does it fly better for that? The figures of docs/learning.md.

pub mod flight;

use rayon::prelude::*;
use serde::Serialize;
use sil_host::model::Rig;
use sil_host::scenario::Scenario;

use crate::comparison::weather::Weather;
use flight::{Change, Knows, Outcome, Tuned, Vehicle};

/// One line: many vehicles under one controller in one weather.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// `gimbal` or `free`.
    pub rig: &'static str,
    /// Whose gains.
    pub tuned: Tuned,
    /// What blows.
    pub weather: Weather,
    /// Vehicles.
    pub vehicles: usize,
    /// Those that changed their model at all, %.
    pub changed_pct: f64,
    /// First change since the reference's first step, median and 95th percentile, s.
    pub first_s: [f64; 2],
    /// Errors at the first change, 95th percentile, %: gain of roll, lag.
    pub first_error_pct: [f64; 2],
    /// Errors at the end, 95th percentile, %: gain of the worse axis, lag.
    pub last_error_pct: [f64; 2],
    /// Ranges that hold the truth at a change, %: gains, lag.
    pub holds_pct: [f64; 2],
    /// Proposals that were refused, %.
    pub refused_pct: f64,
    /// RMS from 5 s on, mean over the vehicles, degrees: wrong model, right model, learning.
    pub rms_deg: [f64; 3],
    /// Of what the wrong model costs, what learning gives back, %; where it costs more than a hundredth.
    pub recovered_pct: f64,
    /// Vehicles on which the wrong model costs that.
    pub costly: usize,
    /// RMS with learning over that of the better of both models, the largest, %.
    pub worst_pct: f64,
    /// The same over that of the wrong model alone.
    pub worst_beside_wrong_pct: f64,
    /// Vehicles on which the right model, and learning, is more than 1 % worse than the wrong one.
    pub worse_than_wrong: [usize; 2],
    /// Flights that ended upside down or nowhere: wrong model, right model, learning.
    pub lost: [usize; 3],
    /// Those of learning that the wrong model did not lose.
    pub lost_by_learning: usize,
}

/// Rigs and controllers.
pub const LINES: [(Rig, Tuned); 5] = [
    (Rig::Gimbal, Tuned::Shipped),
    (Rig::Gimbal, Tuned::Compared),
    (Rig::Gimbal, Tuned::Quick),
    (Rig::Free, Tuned::Shipped),
    (Rig::Free, Tuned::Quick),
];

/// Every rig, controller and weather: so many vehicles each.
pub fn rows(vehicles: u64) -> Vec<Row> {
    let mut rows = Vec::new();
    for (rig, tuned) in LINES {
        for weather in [Weather::Still, Weather::Gusts] {
            rows.push(row(rig, tuned, weather, 1..=vehicles));
        }
    }
    rows
}

/// One line of the table.
pub fn row(rig: Rig, tuned: Tuned, weather: Weather, seeds: std::ops::RangeInclusive<u64>) -> Row {
    let scenario = Scenario::test_sequence();
    let flights: Vec<(Vehicle, [Outcome; 3])> = seeds
        .into_par_iter()
        .map(|seed| {
            let vehicle = Vehicle::drawn(seed, rig);
            let fly = |knows| vehicle.fly(rig, tuned, knows, weather, &scenario);
            (vehicle, [Knows::Wrong, Knows::Right, Knows::Learns].map(fly))
        })
        .collect();
    summarise((rig, tuned, weather), &flights)
}

fn summarise((rig, tuned, weather): (Rig, Tuned, Weather), flights: &[(Vehicle, [Outcome; 3])]) -> Row {
    let firsts: Vec<(&Vehicle, &Outcome, &Change)> = flights
        .iter()
        .filter_map(|(vehicle, [_, _, learns])| {
            let first = learns.changes.iter().find(|change| change.refused.is_none())?;
            Some((vehicle, learns, first))
        })
        .collect();
    let all: Vec<&Change> = flights.iter().flat_map(|(_, [_, _, learns])| &learns.changes).collect();
    let error_pct = |found: f64, truth: f64| 100.0 * (found / truth - 1.0).abs();
    let of_firsts =
        |error: &dyn Fn(&(&Vehicle, &Outcome, &Change)) -> f64| firsts.iter().map(error).collect::<Vec<_>>();
    let seconds = of_firsts(&|(_, _, change)| change.after_s);
    let holds = |places: std::ops::Range<usize>| {
        let told: Vec<bool> =
            all.iter().flat_map(|change| &change.holds[places.clone()]).filter_map(|held| *held).collect();
        share_pct(told.iter().filter(|held| **held).count(), told.len())
    };
    let rms = |k: usize| flights.iter().map(move |(_, outcomes)| outcomes[k].late_rms_deg);
    let costly: Vec<[f64; 3]> = flights
        .iter()
        .map(|(_, outcomes)| [0, 1, 2].map(|k| outcomes[k].late_rms_deg))
        .filter(|[wrong, right, _]| *wrong > 1.01 * right)
        .collect();
    let is_lost = |outcome: &Outcome| !(outcome.late_rms_deg.is_finite() && outcome.tilt_deg < 90.0);
    let count = |of: &dyn Fn(&[Outcome; 3]) -> bool| flights.iter().filter(|(_, outcomes)| of(outcomes)).count();
    let of_costly = |of: fn(&[f64; 3]) -> f64| costly.iter().map(of).sum::<f64>();
    let largest = |of: fn([f64; 3]) -> f64| {
        let each = flights.iter().map(|(_, outcomes)| of([0, 1, 2].map(|k| outcomes[k].late_rms_deg)));
        100.0 * each.fold(0.0, f64::max)
    };
    Row {
        rig: rig.name(),
        tuned,
        weather,
        vehicles: flights.len(),
        changed_pct: share_pct(firsts.len(), flights.len()),
        first_s: [quantile(seconds.clone(), 0.5), quantile(seconds, 0.95)],
        first_error_pct: [
            quantile(of_firsts(&|(vehicle, _, change)| error_pct(change.gain[0], vehicle.gain[0])), 0.95),
            quantile(of_firsts(&|(_, learns, change)| error_pct(change.lag_s, learns.true_lag_s)), 0.95),
        ],
        last_error_pct: [
            quantile(
                of_firsts(&|(vehicle, learns, _)| {
                    let of = |axis: usize| error_pct(learns.model[axis], vehicle.gain[axis]);
                    of(0).max(of(1))
                }),
                0.95,
            ),
            quantile(of_firsts(&|(_, learns, _)| error_pct(learns.model[2], learns.true_lag_s)), 0.95),
        ],
        holds_pct: [holds(0..2), holds(2..3)],
        refused_pct: share_pct(all.iter().filter(|change| change.refused.is_some()).count(), all.len()),
        rms_deg: [0, 1, 2].map(|k| rms(k).sum::<f64>() / flights.len() as f64),
        recovered_pct: 100.0 * of_costly(|[wrong, _, learns]| wrong - learns)
            / of_costly(|[wrong, right, _]| wrong - right),
        costly: costly.len(),
        worst_pct: largest(|[wrong, right, learns]| learns / wrong.max(right) - 1.0),
        worst_beside_wrong_pct: largest(|[wrong, _, learns]| learns / wrong - 1.0),
        worse_than_wrong: [1, 2].map(|k| count(&|outcomes| outcomes[k].late_rms_deg > 1.01 * outcomes[0].late_rms_deg)),
        lost: [0, 1, 2].map(|k| count(&|outcomes| is_lost(&outcomes[k]))),
        lost_by_learning: count(&|[wrong, _, learns]| is_lost(learns) && !is_lost(wrong)),
    }
}

fn share_pct(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole as f64
}

/// The value below which that share lies; no number of none.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = ((values.len() as f64 * share).ceil() as usize).saturating_sub(1);
    values.get(place).copied().unwrap_or(f64::NAN)
}

/// What is found, as Markdown.
pub fn table_of_learning(rows: &[Row]) -> String {
    let mut text = String::from(
        "| rig | tuning | air | vehicles | changed, % | first change: median, 95 %, s | roll's gain, lag then, % \
         | gain, lag at the end, % | ranges that hold: gain, lag, % | refused, % |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        text += &format!(
            "| {} | {} | {} | {} | {:.0} | {:.2}, {:.2} | {:.1}, {:.1} | {:.1}, {:.1} | {:.0}, {:.0} | {:.0} |\n",
            row.rig,
            row.tuned.name(),
            row.weather.name(),
            row.vehicles,
            row.changed_pct,
            row.first_s[0],
            row.first_s[1],
            row.first_error_pct[0],
            row.first_error_pct[1],
            row.last_error_pct[0],
            row.last_error_pct[1],
            row.holds_pct[0],
            row.holds_pct[1],
            row.refused_pct,
        );
    }
    text
}

/// What it is worth, as Markdown.
pub fn table_of_flying(rows: &[Row]) -> String {
    let mut text = String::from(
        "| rig | tuning | air | RMS, deg: wrong model | right model | learning | costly vehicles \
         | of their loss given back, % | worst beside both, % | worst beside the wrong model, % \
         | vehicles beyond 1 %: right model, learning | lost: wrong, right, learning (alone) |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let [wrong, right, learns] = row.rms_deg;
        text += &format!(
            "| {} | {} | {} | {wrong:.2} | {right:.2} | {learns:.2} | {} | {:.0} | {:+.1} | {:+.1} | {}, {} \
             | {}, {}, {} ({}) |\n",
            row.rig,
            row.tuned.name(),
            row.weather.name(),
            row.costly,
            row.recovered_pct,
            row.worst_pct,
            row.worst_beside_wrong_pct,
            row.worse_than_wrong[0],
            row.worse_than_wrong[1],
            row.lost[0],
            row.lost[1],
            row.lost[2],
            row.lost_by_learning,
        );
    }
    text
}
