//! What a form costs where it is used: time per value.

use std::hint::black_box;
use std::time::Instant;

use crate::refinement::Fitted;

/// Values that are computed to measure the time of one: some milliseconds in all.
const VALUES: u32 = 100_000;

/// Time of one value, ns, over the readings in turn. For the terminal and JSON alone: it differs from run to run.
pub(super) fn evaluation_ns(fitted: &Fitted, over: &[f64]) -> f64 {
    if over.is_empty() {
        return f64::NAN;
    }
    let begin = Instant::now();
    let mut sum = 0.0;
    for index in 0..VALUES as usize {
        sum += fitted.value(black_box(over[index % over.len()]));
    }
    black_box(sum);
    begin.elapsed().as_secs_f64() * 1e9 / f64::from(VALUES)
}
