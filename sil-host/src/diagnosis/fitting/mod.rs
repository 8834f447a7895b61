//! From a log in windows to the values of some effects: residuals and slopes by multiple `shooting` from a
//! `start_state` per window, turned into innovations (`axis_filter`) where more than the sensors is uncertain
//! (`process_noise`, commands lost between rows: `sampling`), and least squares (`fit`, within the numbers' ranges:
//! `bounded_step`, lag and delay along what they nearly have in common: `lag_and_delay`).

pub(in crate::diagnosis) mod axis_filter;
pub(in crate::diagnosis) mod bounded_step;
pub(in crate::diagnosis) mod carried_noise;
pub(in crate::diagnosis) mod eigen;
pub(in crate::diagnosis) mod fit;
pub(in crate::diagnosis) mod hints;
mod innovation;
mod lag_and_delay;
mod left_out;
pub(in crate::diagnosis) mod linearisation;
pub(in crate::diagnosis) mod process_noise;
pub(in crate::diagnosis) mod round;
pub(in crate::diagnosis) mod sampling;
mod scatter;
pub(in crate::diagnosis) mod shifted;
pub(in crate::diagnosis) mod shooting;
