//! One quantity's readings in order of time, and its value at any instant.

use super::super::GAP_STEPS;
use super::super::error::LogErrorKind;
use super::super::quantity::Quantity;
use super::super::recording::{Stream, StreamColumn};
use crate::statistics::{median_step, wrapped};

/// Readings that are out of order or out of range are an accident up to this share of all.
const ACCIDENTS_MAX: f64 = 0.01;

/// How a quantity goes on between two readings.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Between {
    /// Held until the next, though not across a gap.
    Held,
    /// Held, however long it takes: a reference is in force until another comes.
    HeldForEver,
    /// On the straight line.
    Line,
    /// On the straight line, however long it takes, and held beyond both ends.
    SlowLine,
    /// The short way round, on the cubic through the neighbours.
    Angle,
}

impl Between {
    fn of(quantity: Quantity) -> Between {
        match quantity {
            Quantity::Motor(_) | Quantity::Command(_) | Quantity::Thrust => Between::Held,
            Quantity::Reference(_) | Quantity::Stick(_) => Between::HeldForEver,
            Quantity::Angle(_) => Between::Angle,
            Quantity::Battery => Between::SlowLine,
            _ => Between::Line,
        }
    }
}

/// The readings of one quantity.
pub(super) struct Readings<'a> {
    pub(super) quantity: Quantity,
    /// The fields that they were made of.
    pub(super) source: &'a str,
    pub(super) between: Between,
    /// Increasing, s.
    pub(super) time_s: Vec<f64>,
    pub(super) value: Vec<f64>,
    /// A longer step than this is a gap, s.
    pub(super) gap_s: f64,
}

impl<'a> Readings<'a> {
    /// Those of a column that are there; none where they are fewer than two. Notes say what was left out.
    ///
    /// # Errors
    /// More of them than an accident explains lie outside of what the quantity can be.
    pub(super) fn of(
        stream: &'a Stream,
        column: &'a StreamColumn,
        notes: &mut Vec<String>,
    ) -> Result<Option<Readings<'a>>, LogErrorKind> {
        let range = column.quantity.range();
        let there = stream.time_s.iter().zip(&column.value).filter(|(_, value)| value.is_finite());
        let all = there.clone().count();
        let (time_s, value): (Vec<f64>, Vec<f64>) = there.clone().filter(|(_, value)| range.contains(value)).unzip();
        let outside = all - value.len();
        if outside as f64 > ACCIDENTS_MAX * all as f64 + 1.0 {
            let first = there.clone().find(|(_, value)| !range.contains(value));
            let (time_s, value) = first.map_or((0.0, 0.0), |(time_s, value)| (*time_s, *value));
            let (name, min, max) = (column.quantity.name(), range.start(), range.end());
            return Err(LogErrorKind::MostlyOutOfRange(format!(
                "{outside} of {all} readings lie outside of {min}..{max} as {name}, the first {value} at {time_s} s"
            )));
        }
        if outside > 0 {
            notes.push(format!("{}: {outside} of {all} readings left out, outside of what they can be", column.source));
        }
        let Some(median_s) = median_step(&time_s) else { return Ok(None) };
        let (gap_s, between) = (GAP_STEPS * median_s, Between::of(column.quantity));
        Ok(Some(Readings { quantity: column.quantity, source: &column.source, between, time_s, value, gap_s }))
    }

    /// Usual number of readings per second.
    pub(super) fn rate_hz(&self) -> f64 {
        GAP_STEPS / self.gap_s
    }

    /// Times of the first and last reading, s.
    pub(super) fn span_s(&self) -> [f64; 2] {
        [self.time_s.first(), self.time_s.last()].map(|time_s| time_s.copied().unwrap_or_default())
    }

    /// Its value at an instant; none before the first reading, after the last, or in a gap.
    pub(super) fn at(&self, time_s: f64) -> Option<f64> {
        let after = self.time_s.partition_point(|reading_s| *reading_s <= time_s);
        let is_slow = self.between == Between::SlowLine;
        let Some(before) = after.checked_sub(1) else {
            return self.value.first().copied().filter(|_| is_slow);
        };
        let (start_s, start) = (self.time_s[before], self.value[before]);
        let is_held = match self.between {
            Between::HeldForEver => true,
            Between::Held => time_s - start_s <= self.gap_s,
            _ => start_s == time_s,
        };
        if is_held {
            return Some(start);
        }
        if self.between == Between::Held {
            return None;
        }
        let Some(end_s) = self.time_s.get(after) else {
            return is_slow.then_some(start);
        };
        let (duration_s, change) = (end_s - start_s, self.change(before));
        if duration_s > self.gap_s && !is_slow {
            return None;
        }
        let share = (time_s - start_s) / duration_s;
        let line = start + share * change;
        if self.between != Between::Angle {
            return Some(line);
        }
        // Hermite's cubic is the straight line and a bend, which is 0 where both slopes are the line's
        let bend = (1.0 - share) * (duration_s * self.slope(before, before) - change)
            - share * (duration_s * self.slope(after, before) - change);
        Some(wrapped(line + share * (1.0 - share) * bend))
    }

    /// From a reading to the next.
    fn change(&self, reading: usize) -> f64 {
        let change = self.value[reading + 1] - self.value[reading];
        if self.between == Between::Angle { wrapped(change) } else { change }
    }

    /// Slope at a reading, by its neighbours on both sides; that of a step beside it where there is a gap or an end on
    /// the other.
    fn slope(&self, reading: usize, step: usize) -> f64 {
        let is_regular =
            |step: usize| self.time_s.get(step + 1).is_some_and(|end_s| end_s - self.time_s[step] <= self.gap_s);
        let first = if reading > 0 && is_regular(reading - 1) { reading - 1 } else { step };
        let last = if is_regular(reading) { reading } else { step };
        let change: f64 = (first..=last).map(|step| self.change(step)).sum();
        change / (self.time_s[last + 1] - self.time_s[first])
    }
}

/// Puts a stream in order of time: a reading whose stamp is not after the one before replaces that one if it is after
/// the one before that, and is left out else; one that is the one before to the bit was written twice, and is no
/// accident. Gives how many readings are gone.
///
/// # Errors
/// They are more than an accident explains: the clock runs back.
pub(super) fn put_in_order(stream: &mut Stream) -> Result<usize, LogErrorKind> {
    let mut kept: Vec<usize> = Vec::with_capacity(stream.time_s.len());
    let (mut first_back, mut twice) = (None, 0);
    let is_same = |a: usize, b: usize| {
        let bits = |reading: usize| stream.columns.iter().map(move |column| column.value[reading].to_bits());
        stream.time_s[a] == stream.time_s[b] && bits(a).eq(bits(b))
    };
    for (reading, time_s) in stream.time_s.iter().enumerate().filter(|(_, time_s)| time_s.is_finite()) {
        let at = |place: usize| kept.len().checked_sub(place).map(|at| stream.time_s[kept[at]]);
        if at(1).is_some_and(|last_s| *time_s <= last_s) {
            first_back = first_back.or(Some((reading, at(1).unwrap_or_default(), *time_s)));
            if kept.last().is_some_and(|last| is_same(*last, reading)) {
                twice += 1;
                continue;
            }
            if at(2).is_some_and(|earlier_s| *time_s <= earlier_s) {
                continue;
            }
            kept.pop();
        }
        kept.push(reading);
    }
    let gone = stream.time_s.len() - kept.len();
    // a clock that stands still writes more than every other reading twice
    let accidents = if 2 * twice > stream.time_s.len() { gone } else { gone - twice };
    if accidents as f64 > ACCIDENTS_MAX * stream.time_s.len() as f64 + 1.0 {
        let (reading, before, now) = first_back.unwrap_or_default();
        return Err(LogErrorKind::TimeRunsBack { reading, before, now, gone });
    }
    stream.time_s = kept.iter().map(|reading| stream.time_s[*reading]).collect();
    for column in &mut stream.columns {
        column.value = kept.iter().map(|reading| column.value[*reading]).collect();
    }
    Ok(gone)
}
