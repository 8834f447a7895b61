//! What an accelerometer beside the centre of gravity feels of the rotation.
//!
//! ```text
//!   f = w x (w x r) + dw/dt x r          r: the IMU's place, w: the rate, body axes
//! ```

use crate::vehicle::cross;

/// An IMU's place, and the rate that it saw last.
#[derive(Clone, Debug)]
pub(super) struct Lever {
    position_body_m: [f64; 3],
    before: Option<(u64, [f64; 3])>,
}

impl Lever {
    pub(super) fn new(position_body_m: [f64; 3]) -> Self {
        Self { position_body_m, before: None }
    }

    /// Beside the specific force of the centre of gravity, m/s^2; the angular acceleration is that since the reading
    /// before.
    pub(super) fn felt_m_s2(&mut self, time_us: u64, rate_rad_s: [f64; 3]) -> [f64; 3] {
        let acceleration_rad_s2 = match self.before {
            Some((before_us, before_rad_s)) if time_us > before_us => {
                let span_s = (time_us - before_us) as f64 * 1e-6;
                core::array::from_fn(|axis| (rate_rad_s[axis] - before_rad_s[axis]) / span_s)
            }
            _ => [0.0; 3],
        };
        self.before = Some((time_us, rate_rad_s));
        let inward = cross(rate_rad_s, cross(rate_rad_s, self.position_body_m));
        let along = cross(acceleration_rad_s2, self.position_body_m);
        core::array::from_fn(|axis| inward[axis] + along[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 cm ahead of the axis of a spin of 16 rad/s: 5.12 m/s^2 towards it, and 0.02 m of what the spin gains.
    #[test]
    fn a_spin_is_felt_towards_its_axis_and_its_change_across() {
        let mut lever = Lever::new([0.02, 0.0, -0.03]);
        assert_eq!(lever.felt_m_s2(0, [0.0, 0.0, 15.0]), [-4.5, 0.0, 0.0]);
        let [x, y, z] = lever.felt_m_s2(1000, [0.0, 0.0, 16.0]);
        assert!((x + 5.12).abs() < 1e-12 && (y - 20.0).abs() < 1e-9 && z.abs() < 1e-12, "{x} {y} {z}");
    }
}
