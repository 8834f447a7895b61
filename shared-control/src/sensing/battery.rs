//! From the counts of the battery's converter to volts.

/// Volts per count on a Pixhawk 1: 12 bits of 3.3 V behind the power module's divider of 10.1 (ArduPilot's value for
/// the 3DR power module; PX4 takes 10.18, so that a single board may be off by a percent).
pub const PIXHAWK1_V_PER_COUNT: f32 = 3.3 / 4096.0 * 10.1;

/// Below this nothing that could turn a motor is connected, V: a board fed over USB alone reads its divider's leakage.
pub const ABSENT_BELOW_V: f32 = 2.0;

/// Mean voltage of some conversions, V; zero of none.
pub fn voltage_v(counts: impl Iterator<Item = u16>, volts_per_count: f32) -> f32 {
    // 12 bits each: no sum of less than a million of them overflows
    let (sum, conversions) =
        counts.fold((0u32, 0u32), |(sum, n), count| (sum.saturating_add(u32::from(count)), n.saturating_add(1)));
    if conversions == 0 { 0.0 } else { sum as f32 / conversions as f32 * volts_per_count }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_full_cells_and_no_battery() {
        // 12.6 V / 10.1 of 3.3 V are 1548.4 counts: the mean of these
        let counts = [1548, 1549, 1548, 1549, 1548, 1548, 1548, 1549];
        let volts = voltage_v(counts.into_iter(), PIXHAWK1_V_PER_COUNT);
        // half a count is 4 mV
        assert!((volts - 12.6).abs() < 4e-3, "{volts}");
        assert_eq!(voltage_v(core::iter::empty(), PIXHAWK1_V_PER_COUNT), 0.0);
        assert!(voltage_v([3, 5].into_iter(), PIXHAWK1_V_PER_COUNT) < ABSENT_BELOW_V);
        assert!((voltage_v([4095].into_iter(), PIXHAWK1_V_PER_COUNT) - 33.3).abs() < 0.1);
    }
}
