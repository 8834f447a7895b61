//! Which values a field of the table can take, and how they lie in its 16 bits.

/// Values that a field can take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// All from the first to the second.
    Range(u16, u16),
    /// One or the other.
    Either(u16, u16),
    /// All up to this on both sides of zero; two's complement in the field's bits.
    Signed(i16),
}

impl Allowed {
    /// Is this one of them?
    pub fn contains(self, bits: u16) -> bool {
        match self {
            Allowed::Range(least, most) => (least..=most).contains(&bits),
            Allowed::Either(one, other) => bits == one || bits == other,
            Allowed::Signed(most) => (bits as i16).unsigned_abs() <= most.unsigned_abs(),
        }
    }

    /// The least and the largest of them.
    pub fn ends(self) -> (i32, i32) {
        match self {
            Allowed::Range(least, most) => (least.into(), most.into()),
            Allowed::Either(one, other) => (one.min(other).into(), one.max(other).into()),
            Allowed::Signed(most) => (-i32::from(most), most.into()),
        }
    }

    /// The number that a field's bits are.
    pub fn number(self, bits: u16) -> i32 {
        match self {
            Allowed::Range(..) | Allowed::Either(..) => i32::from(bits),
            Allowed::Signed(_) => i32::from(bits as i16),
        }
    }

    /// The bits of a number; none where it is not whole or not allowed.
    pub fn bits(self, number: f32) -> Option<u16> {
        // `as` truncates and saturates, and makes 0 of what is no number
        let whole = number as i32;
        let bits = whole as u16;
        (whole as f32 == number && self.number(bits) == whole && self.contains(bits)).then_some(bits)
    }
}

impl core::fmt::Display for Allowed {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Allowed::Range(least, most) => write!(f, "{least} to {most}"),
            Allowed::Either(one, other) => write!(f, "{one} or {other}"),
            Allowed::Signed(most) => write!(f, "-{most} to {most}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_bits_are_each_others_reverse() {
        for (allowed, number, bits) in [
            (Allowed::Range(2, 9), 9.0, Some(9)),
            (Allowed::Range(0, u16::MAX), 65535.0, Some(65535)),
            (Allowed::Range(0, u16::MAX), -1.0, None),
            (Allowed::Range(0, u16::MAX), 65536.0, None),
            (Allowed::Either(100, 400), 250.0, None),
            (Allowed::Signed(1000), -1000.0, Some(0xFC18)),
            (Allowed::Signed(1000), 1000.0, Some(1000)),
            (Allowed::Signed(1000), -1001.0, None),
            (Allowed::Signed(1000), 64536.0, None),
            (Allowed::Signed(1000), 0.5, None),
            (Allowed::Signed(1000), f32::NAN, None),
        ] {
            assert_eq!(allowed.bits(number), bits, "{allowed}: {number}");
            assert!(bits.is_none_or(|bits| allowed.number(bits) as f32 == number));
        }
    }
}
