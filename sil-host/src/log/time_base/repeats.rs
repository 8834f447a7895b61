//! Readings that are none: where a controller logs faster than its estimator or its sensor driver turns, or a logger
//! writes a row before the next reading is there, the last one stands in the log again. Taken for a reading it says
//! that the vehicle stood still, and then jumped; an attitude that is held for two rows of three is late by one, too.
//!
//! The readings of all axes repeat themselves at once then, to the last bit. Those of a single axis may do so by
//! chance, where they are coarse.

use super::super::quantity::Quantity;
use super::super::recording::{Stream, StreamColumn};

/// Fewer than this share of all are an accident, and change nothing.
const SHARE_MIN: f64 = 0.05;
/// So few stretches say nothing of what is usual.
const STRETCHES_MIN: usize = 10;
/// A stretch is the sensor that stands still, not a slower one, where it is so many times as long as the usual one.
const STRETCHES_MAX: usize = 4;

/// Readings that come together.
struct Group {
    name: &'static str,
    has: fn(Quantity) -> bool,
    /// So many of a hundred of them must be different ones: coarse readings may repeat themselves by chance, above all
    /// an attitude's at rest.
    different_pct: usize,
}

const GROUPS: [Group; 2] = [
    Group { name: "rates", has: |quantity| matches!(quantity, Quantity::Rate(_)), different_pct: 50 },
    Group { name: "angles", has: |quantity| matches!(quantity, Quantity::Angle(_)), different_pct: 95 },
];

/// Does a stream have readings that are none?
pub(in crate::log) fn has_repeats(stream: &Stream) -> bool {
    let mut notes = Vec::new();
    take_out(&mut stream.clone(), &mut notes);
    !notes.is_empty()
}

/// Takes them out; notes say how many. Of a row that is written twice the gyro tells, and its angles count no more.
pub(super) fn take_out(stream: &mut Stream, notes: &mut Vec<String>) {
    let mut remaining: Vec<usize> = (0..stream.time_s.len()).collect();
    for Group { name, has, different_pct } in GROUPS {
        let of_group: Vec<&StreamColumn> = stream.columns.iter().filter(|column| has(column.quantity)).collect();
        let is_there = |reading: &&usize| of_group.iter().all(|column| column.value[**reading].is_finite());
        let there: Vec<usize> = remaining.iter().filter(is_there).copied().collect();
        let read = |column: &&StreamColumn| there.iter().map(|reading| column.value[*reading]).collect();
        let values: Vec<Vec<f64>> = of_group.iter().map(read).collect();
        if values.iter().any(|column| is_coarse(column, different_pct)) {
            continue;
        }
        let repeats: Vec<usize> = repeats(&values).into_iter().map(|place| there[place]).collect();
        if repeats.is_empty() {
            continue;
        }
        let (count, all) = (repeats.len(), there.len());
        notes.push(format!("{count} of {all} readings of {name} repeat the ones before, were held, and are left out"));
        for column in stream.columns.iter_mut().filter(|column| has(column.quantity)) {
            repeats.iter().for_each(|reading| column.value[*reading] = f64::NAN);
        }
        remaining.retain(|reading| repeats.binary_search(reading).is_err());
    }
}

/// Which readings of several columns only repeat the ones before; none where that is chance, an accident or a sensor
/// that stands still.
fn repeats(columns: &[Vec<f64>]) -> Vec<usize> {
    let [first, _, ..] = columns else { return Vec::new() };
    let is_repeat = |reading: usize| columns.iter().all(|column| column[reading] == column[reading - 1]);
    let mut stretches: Vec<Vec<usize>> = Vec::new();
    for reading in (1..first.len()).filter(|reading| is_repeat(*reading)) {
        match stretches.last_mut() {
            Some(stretch) if stretch.last() == Some(&(reading - 1)) => stretch.push(reading),
            _ => stretches.push(vec![reading]),
        }
    }
    if stretches.len() < STRETCHES_MIN {
        return Vec::new();
    }
    let mut lengths: Vec<usize> = stretches.iter().map(Vec::len).collect();
    lengths.sort_unstable();
    let usual = lengths.get(lengths.len() / 2).copied().unwrap_or_default();
    let held: Vec<usize> = stretches.into_iter().filter(|of| of.len() <= STRETCHES_MAX * usual).flatten().collect();
    if (held.len() as f64) < SHARE_MIN * first.len() as f64 { Vec::new() } else { held }
}

/// Are fewer than so many of a hundred readings, repeated ones counted once, different from all others?
fn is_coarse(column: &[f64], different_pct: usize) -> bool {
    let mut readings: Vec<f64> = column.to_vec();
    readings.dedup();
    let all = readings.len();
    readings.sort_by(f64::total_cmp);
    readings.dedup();
    100 * readings.len() < different_pct * all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Axis;
    use crate::statistics::noise_source::NoiseSource;

    fn stream(columns: Vec<(Quantity, Vec<f64>)>) -> Stream {
        let time_s = (0..columns[0].1.len()).map(|reading| reading as f64 * 0.004).collect();
        let column = |(quantity, value)| StreamColumn { quantity, source: String::new(), value };
        Stream { name: "rows".into(), time_s, columns: columns.into_iter().map(column).collect() }
    }

    /// White readings, each of which stands so many times.
    fn held(times: usize, seed: u64) -> Vec<f64> {
        let mut noise = NoiseSource::new(seed);
        let fresh: Vec<f64> = (0..100).map(|_| noise.normal()).collect();
        (0..100 * times).map(|reading| fresh[reading / times]).collect()
    }

    fn left_out(stream: &Stream, column: usize) -> usize {
        stream.columns[column].value.iter().filter(|value| value.is_nan()).count()
    }

    #[test]
    fn held_attitudes_are_left_out_and_the_gyro_stays() {
        let [roll, pitch, rate] =
            [Quantity::Angle(Axis::Roll), Quantity::Angle(Axis::Pitch), Quantity::Rate(Axis::Roll)];
        let mut log = stream(vec![(roll, held(3, 1)), (pitch, held(3, 2)), (rate, held(1, 3).repeat(3))]);
        let before = log.clone();
        let mut notes = Vec::new();
        take_out(&mut log, &mut notes);
        assert_eq!(notes, ["200 of 300 readings of angles repeat the ones before, were held, and are left out"]);
        assert_eq!([0, 1, 2].map(|column| left_out(&log, column)), [200, 200, 0]);
        for (column, was) in log.columns.iter().zip(&before.columns) {
            let kept = column.value.iter().zip(&was.value).filter(|(value, _)| !value.is_nan());
            assert!(kept.clone().all(|(value, was)| value == was) && kept.count() >= 100);
        }
    }

    #[test]
    fn chance_accidents_and_a_sensor_that_stands_still_change_nothing() {
        let [roll, pitch] = [Quantity::Rate(Axis::Roll), Quantity::Rate(Axis::Pitch)];
        let coarse = |seed| held(1, seed).repeat(3).iter().map(|value| (2.0 * value).round()).collect::<Vec<f64>>();
        // one of a hundred is written twice
        let accident = |seed| {
            let mut readings = held(1, seed).repeat(3);
            (50..300).step_by(100).for_each(|reading| readings[reading] = readings[reading - 1]);
            readings
        };
        // the last quarter of a second
        let stuck = |seed| [held(1, seed).repeat(3), vec![0.5; 60]].concat();
        // a single axis' is no row's
        for (one, other) in [
            (coarse(1), coarse(2)),
            (accident(3), accident(4)),
            (stuck(5), stuck(6)),
            (held(3, 7), held(1, 8).repeat(3)),
        ] {
            let mut log = stream(vec![(roll, one), (pitch, other)]);
            let before = log.clone();
            let mut notes = Vec::new();
            take_out(&mut log, &mut notes);
            assert_eq!((log, notes), (before, Vec::new()));
        }
    }
}
