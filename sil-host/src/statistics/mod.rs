//! The statistics that people use to see how far and where a prediction is off: [`mean_absolute_deviation`] is the
//! thesis' measure for a closed loop (table 5.1); [`Agreement`], [`Correlogram`], [`ConditionalError`] and
//! [`amplitude_spectrum`] are of one quantity.

mod agreement;
mod condition;
mod deviation;
mod digits;
mod f_distribution;
mod linear;
mod median;
#[cfg(test)]
pub(crate) mod noise_source;
mod robust_fit;
mod spectrum;
mod whiteness;

pub use agreement::{Agreement, TheilSplit};
pub use condition::{Bin, ConditionalError};
pub use deviation::mean_absolute_deviation;
pub(crate) use deviation::{variance, wrapped};
pub(crate) use digits::decimals;
pub(crate) use f_distribution::{f_exceeded, student_95};
pub(crate) use linear::{Cholesky, dot, dots};
pub(crate) use median::{median, median_step};
pub(crate) use robust_fit::{RobustFit, robust_fit};
pub use spectrum::amplitude_spectrum;
pub use whiteness::{Correlogram, InputCorrelation, LjungBox, chi_square_99, input_correlation};
