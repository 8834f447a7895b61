//! A number with its uncertainty.

use std::fmt;

use serde::Serialize;

use crate::statistics::decimals;

/// A number with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub std: f64,
}

impl Estimate {
    /// As many decimals as the uncertainty leaves; none where there is no uncertainty.
    pub fn decimals(&self) -> Option<usize> {
        (self.std > 0.0).then(|| decimals(self.std, 2, 12))
    }
}

/// Value and uncertainty with as many digits as that leaves, very small ones with their power of ten; what is exact
/// without one.
impl fmt::Display for Estimate {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.std == 0.0 && (self.value == 0.0 || self.value.abs() >= 1e-5) {
            return write!(out, "{}", (self.value * 1e6).round() / 1e6);
        }
        let size = libm::log10(self.value.abs().max(self.std)).floor();
        let exponent = if size.is_finite() && size < -5.0 { size as i32 } else { 0 };
        let unit = libm::exp10(f64::from(exponent));
        let scaled = Estimate { value: self.value / unit, std: self.std / unit };
        let digits = scaled.decimals().unwrap_or(6);
        let power = if exponent == 0 { String::new() } else { format!("e{exponent}") };
        write!(out, "{:.digits$}{power} +- {:.digits$}{power}", scaled.value, scaled.std)
    }
}
