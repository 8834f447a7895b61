//! Which values a field of the table can take.

/// Values that a field can take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// All from the first to the second.
    Range(u16, u16),
    /// One or the other.
    Either(u16, u16),
}

impl Allowed {
    /// Is this one of them?
    pub fn contains(self, value: u16) -> bool {
        match self {
            Allowed::Range(least, most) => (least..=most).contains(&value),
            Allowed::Either(one, other) => value == one || value == other,
        }
    }
}

impl core::fmt::Display for Allowed {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Allowed::Range(least, most) => write!(f, "{least} to {most}"),
            Allowed::Either(one, other) => write!(f, "{one} or {other}"),
        }
    }
}
