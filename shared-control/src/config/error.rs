//! What is refused, and by which name.

/// A value that can't be flown with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConfigError {
    /// Not a finite number above zero.
    NotPositive(&'static str),
    /// Not a finite number of zero or more.
    Negative(&'static str),
    /// Beyond what the core is made for.
    OutOfRange(&'static str),
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            ConfigError::NotPositive(name) => write!(f, "{name} must be a finite number above zero"),
            ConfigError::Negative(name) => write!(f, "{name} must be a finite number, zero or more"),
            ConfigError::OutOfRange(name) => write!(f, "{name} is out of range"),
        }
    }
}

impl core::error::Error for ConfigError {}

pub(super) fn positive(name: &'static str, value: f32) -> Result<(), ConfigError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(ConfigError::NotPositive(name)) }
}

pub(super) fn not_negative(name: &'static str, value: f32) -> Result<(), ConfigError> {
    if value.is_finite() && value >= 0.0 { Ok(()) } else { Err(ConfigError::Negative(name)) }
}
