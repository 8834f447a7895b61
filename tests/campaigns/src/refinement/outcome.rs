//! Intervals held against the truth.

use std::fmt;

use sil_host::model::{Rig, VehicleModel};
use sil_host::refinement::{Constant, Order, refine};

use super::Drawn;

/// A constant that was found.
#[derive(Clone, Debug)]
pub struct Held {
    /// Its key.
    pub key: &'static str,
    /// What was drawn.
    pub truth: f64,
    /// What was found.
    pub value: f64,
    /// With its interval.
    pub interval: [f64; 2],
}

/// What became of a drawn bench.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Its seed.
    pub seed: u64,
    /// The constants found.
    pub held: Vec<Held>,
    /// Those of another form than drawn.
    pub missing: Vec<&'static str>,
}

impl Held {
    /// Whether the interval has the truth within it.
    pub fn is_right(&self) -> bool {
        (self.interval[0]..=self.interval[1]).contains(&self.truth)
    }

    /// Half of the interval, in percent of the truth.
    fn half_pct(&self) -> f64 {
        50.0 * (self.interval[1] - self.interval[0]) / self.truth.abs()
    }
}

impl Outcome {
    /// Refines a drawn bench. A line through the origin says of an offset that it is 0 and gives it no interval.
    ///
    /// # Panics
    /// The bench is refused.
    pub fn of(drawn: &Drawn) -> Self {
        let base = VehicleModel::nominal(Rig::Gimbal);
        let refined = refine(&drawn.benches(), &base, &Order::default());
        let refined = refined.unwrap_or_else(|error| panic!("seed {}: {error}", drawn.seed));
        let (mut held, mut missing) = (Vec::new(), Vec::new());
        for (key, truth) in drawn.truths() {
            // a saturating map has gains of another meaning
            let is_drawn = |constant: &&Constant| constant.key == key && constant.form != "saturating";
            match refined.constants.iter().find(is_drawn) {
                Some(found) => held.push(Held { key, truth, value: found.value, interval: found.interval }),
                None if truth == 0.0 => {}
                None => missing.push(key),
            }
        }
        Self { seed: drawn.seed, held, missing }
    }
}

/// All outcomes as a table.
pub struct Total<'a>(pub &'a [Outcome]);

impl Total<'_> {
    /// Intervals that are right, in percent of all.
    pub fn right_pct(&self) -> f64 {
        pct(&self.0.iter().flat_map(|outcome| &outcome.held).collect::<Vec<_>>())
    }

    /// The same by key, with how many there are.
    pub fn by_key(&self) -> Vec<(&'static str, usize, f64)> {
        let keys = Drawn::new(0).truths().into_iter().map(|(key, _)| key);
        keys.map(|key| {
            let of_key: Vec<&Held> =
                self.0.iter().flat_map(|outcome| &outcome.held).filter(|held| held.key == key).collect();
            (key, of_key.len(), pct(&of_key))
        })
        .collect()
    }
}

fn pct(held: &[&Held]) -> f64 {
    100.0 * held.iter().filter(|held| held.is_right()).count() as f64 / held.len() as f64
}

impl fmt::Display for Total<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "| constant | found in | intervals right, % | median half width, % |\n|---|---|---|---|")?;
        for (key, count, right) in self.by_key() {
            let of_key = self.0.iter().flat_map(|outcome| &outcome.held).filter(|held| held.key == key);
            let mut halves: Vec<f64> = of_key.map(Held::half_pct).filter(|half| half.is_finite()).collect();
            halves.sort_by(f64::total_cmp);
            let half = halves.get(halves.len() / 2).copied().unwrap_or(f64::NAN);
            writeln!(out, "| `{key}` | {count} | {right:.1} | {half:.2} |")?;
        }
        let missing: usize = self.0.iter().map(|outcome| outcome.missing.len()).sum();
        let count: usize = self.0.iter().map(|outcome| outcome.held.len()).sum();
        writeln!(
            out,
            "\n{} benches, {count} intervals, {:.1} % right; {missing} constants of another form than drawn",
            self.0.len(),
            self.right_pct()
        )?;
        for outcome in self.0.iter().filter(|outcome| !outcome.missing.is_empty()) {
            writeln!(out, "  bench {}: not found {}", outcome.seed, outcome.missing.join(", "))?;
        }
        Ok(())
    }
}
