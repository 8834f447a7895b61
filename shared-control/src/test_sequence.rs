//! The thesis' test sequence (section 5.2) as the board flies it: hover, then eight positions with a hover after each.
//!
//! The thesis gives no times: 1.75 s for every hover and every position is the project's choice.

use crate::signals::Setpoint;

/// Duration of each hover and each position, µs.
const SEGMENT_US: u64 = 1_750_000;
/// Positions as (roll, pitch), degrees.
const POSITIONS_DEG: [(f32, f32); 8] =
    [(30.0, 0.0), (-30.0, 0.0), (0.0, 30.0), (0.0, -30.0), (30.0, 30.0), (30.0, -30.0), (-30.0, 30.0), (-30.0, -30.0)];
/// Duration of it all, µs.
pub const DURATION_US: u64 = 17 * SEGMENT_US;

/// Set-point at a time since the start, with the throttle at which the vehicle hovers; none once it is over.
pub fn at(since_start_us: u64, hover_throttle: f32) -> Option<Setpoint> {
    if since_start_us >= DURATION_US {
        return None;
    }
    let segment = (since_start_us / SEGMENT_US) as usize;
    // even segments are hover
    let position = if segment % 2 == 1 { POSITIONS_DEG.get(segment / 2) } else { None };
    let (roll_deg, pitch_deg) = position.copied().unwrap_or((0.0, 0.0));
    Some(Setpoint {
        roll_rad: roll_deg.to_radians(),
        pitch_rad: pitch_deg.to_radians(),
        yaw_rate_rad_s: 0.0,
        throttle: hover_throttle,
        acro_rad_s: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_position_has_its_time_and_hover_comes_between() {
        assert_eq!(DURATION_US, 29_750_000);
        for segment in 0..17u64 {
            for offset_us in [0, 1, SEGMENT_US - 1] {
                let setpoint = at(segment * SEGMENT_US + offset_us, 0.5).unwrap();
                let hovers = setpoint.roll_rad == 0.0 && setpoint.pitch_rad == 0.0;
                assert_eq!(hovers, segment % 2 == 0);
                assert!(setpoint.throttle == 0.5 && setpoint.yaw_rate_rad_s == 0.0);
            }
        }
        // thesis, section 5.2: each axis by itself, then both together, in units of 30 degrees
        let (single, both) = ([(1, 0), (-1, 0), (0, 1), (0, -1)], [(1, 1), (1, -1), (-1, 1), (-1, -1)]);
        for (position, (roll, pitch)) in (0..).zip(single.into_iter().chain(both)) {
            let setpoint = at((2 * position + 1) * SEGMENT_US, 0.5).unwrap();
            let is = |angle_rad: f32, units: i8| (angle_rad - 30f32.to_radians() * f32::from(units)).abs() < 1e-6;
            assert!(is(setpoint.roll_rad, roll) && is(setpoint.pitch_rad, pitch), "{position}: {setpoint:?}");
        }
        assert_eq!(at(DURATION_US, 0.5), None);
        assert_eq!(at(u64::MAX, 0.5), None);
    }
}
