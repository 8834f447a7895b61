//! How an IMU sits on the vehicle: what it feels if its board is not mounted level.

/// Roll and pitch that an IMU shows while the vehicle is level, rad: the IMU is the body turned by pitch, then by roll.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seat {
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
}

impl Seat {
    /// From degrees, as one reads them off a level.
    pub fn of_deg(roll_deg: f64, pitch_deg: f64) -> Self {
        Self { roll_rad: roll_deg.to_radians(), pitch_rad: pitch_deg.to_radians() }
    }

    /// A body vector in the IMU's axes; one that sits straight changes no bit.
    pub(crate) fn felt(&self, body: [f64; 3]) -> [f64; 3] {
        if *self == Self::default() {
            return body;
        }
        let [x, y, z] = body;
        let (sin, cos) = self.pitch_rad.sin_cos();
        let (x, z) = (x * cos - z * sin, x * sin + z * cos);
        let (sin, cos) = self.roll_rad.sin_cos();
        [x, y * cos + z * sin, z * cos - y * sin]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A level vehicle's force is (0, 0, -g); one at roll a and pitch b feels g (sin b, -sin a cos b, -cos a cos b).
    #[test]
    fn what_it_feels_on_a_level_vehicle_is_that_of_a_tilted_one() {
        let seat = Seat::of_deg(4.0, -3.0);
        let ((sin_a, cos_a), (sin_b, cos_b)) = (seat.roll_rad.sin_cos(), seat.pitch_rad.sin_cos());
        let expected = [9.8 * sin_b, -9.8 * sin_a * cos_b, -9.8 * cos_a * cos_b];
        let felt = seat.felt([0.0, 0.0, -9.8]);
        assert!(felt.iter().zip(expected).all(|(felt, expected)| (felt - expected).abs() < 1e-12), "{felt:?}");
        assert_eq!(Seat::default().felt([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]);
    }
}
