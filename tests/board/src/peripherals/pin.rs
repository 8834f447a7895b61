//! What a pin of the chip does to the wire at it, and how fast. RM0090 section 8.3; data sheet of the STM32F427
//! (DocID024030), tables "I/O static characteristics" and "I/O AC characteristics".

/// What a pin does to its wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Drive {
    /// A transistor holds this level, some 25 Ohm.
    Strong(bool),
    /// A pull of 30 to 50 kOhm towards this level: anything stronger wins.
    Weak(bool),
    /// Nothing: high impedance.
    None,
}

impl Drive {
    /// The level that a wire takes to which nothing else is connected; none if it floats.
    pub(crate) fn level(self) -> Option<bool> {
        match self {
            Self::Strong(level) | Self::Weak(level) => Some(level),
            Self::None => None,
        }
    }
}

/// The capacitance of the wire and of what is connected to it. The board's is not in any document: each end of this
/// range is tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Load {
    /// 10 pF: a short trace and one input.
    Light,
    /// 30 to 50 pF, for which the data sheet gives its limits.
    #[default]
    Heavy,
}

/// OSPEEDR of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Speed {
    Low,
    Medium,
    High,
    VeryHigh,
}

impl Speed {
    /// By the two bits of OSPEEDR.
    pub(crate) fn from_bits(bits: u32) -> Self {
        [Self::Low, Self::Medium, Self::High, Self::VeryHigh][(bits & 3) as usize]
    }

    /// From 10 to 90 % of the supply, at most, ns. At the lowest speed the data sheet has one figure for all loads; a
    /// light one is taken to be five times as fast.
    pub(crate) fn edge_ns(self, load: Load) -> f64 {
        match (self, load) {
            (Self::Low, Load::Heavy) => 100.0,
            (Self::Low, Load::Light) => 20.0,
            (Self::Medium, Load::Heavy) => 10.0,
            (Self::Medium, Load::Light) => 6.0,
            (Self::High, Load::Heavy) => 6.0,
            (Self::High, Load::Light) => 4.0,
            (Self::VeryHigh, Load::Heavy) => 4.0,
            (Self::VeryHigh, Load::Light) => 2.5,
        }
    }

    /// Fastest wave that the pin makes, Hz, at 2.7 V and more.
    pub(crate) fn frequency_max_hz(self, load: Load) -> u64 {
        match (self, load) {
            (Self::Low, Load::Heavy) => 4_000_000,
            (Self::Low, Load::Light) => 8_000_000,
            (Self::Medium, Load::Heavy) => 25_000_000,
            (Self::Medium, Load::Light) => 50_000_000,
            (Self::High, Load::Heavy) => 50_000_000,
            (Self::High, Load::Light) => 100_000_000,
            (Self::VeryHigh, Load::Heavy) => 100_000_000,
            (Self::VeryHigh, Load::Light) => 180_000_000,
        }
    }
}

/// How long a pulse stays beyond the far chip's threshold of 70 % of the supply (CMOS inputs), ns; none if it never
/// gets there. The edge is taken as a straight line: 80 % of the supply in the edge's time.
pub(crate) fn width_at_far_end_ns(width_ns: f64, edge_ns: f64) -> Option<f64> {
    let (there, back) = (0.7 / 0.8 * edge_ns, 0.3 / 0.8 * edge_ns);
    (width_ns >= there).then_some(width_ns - there + back)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pulse_shorter_than_its_own_edge_never_arrives() {
        // two stores in a row at 168 MHz are 12 to 18 ns apart
        assert_eq!(width_at_far_end_ns(15.0, Speed::Low.edge_ns(Load::Heavy)), None);
        assert_eq!(width_at_far_end_ns(15.0, Speed::Low.edge_ns(Load::Light)), None);
        let fast = width_at_far_end_ns(15.0, Speed::VeryHigh.edge_ns(Load::Heavy)).unwrap();
        assert!((fast - 13.0).abs() < 1e-9, "{fast}");
    }

    #[test]
    fn a_long_pulse_loses_half_an_edge() {
        let width = width_at_far_end_ns(1000.0, 100.0).unwrap();
        assert!((width - 950.0).abs() < 1e-9, "{width}");
    }

    #[test]
    fn each_speed_is_faster_than_the_one_below_and_a_light_load_than_a_heavy_one() {
        for load in [Load::Light, Load::Heavy] {
            let speeds = [0, 1, 2, 3].map(Speed::from_bits);
            assert!(speeds.windows(2).all(|two| two[0].edge_ns(load) > two[1].edge_ns(load)));
            assert!(speeds.windows(2).all(|two| two[0].frequency_max_hz(load) < two[1].frequency_max_hz(load)));
        }
        for speed in [0, 1, 2, 3].map(Speed::from_bits) {
            assert!(speed.edge_ns(Load::Light) < speed.edge_ns(Load::Heavy));
            assert!(speed.frequency_max_hz(Load::Light) > speed.frequency_max_hz(Load::Heavy));
        }
    }
}
