//! A log in body axes that are turned about yaw. A plus frame is an X in axes that lie between its arms: turned by 45
//! degrees its motors stand in the corners, where this project's stand, and nothing else about it is special.

use super::{Column, Log, LogError, LogErrorKind};
use crate::statistics::wrapped;

/// By how much the axes of a plus frame are turned, so that its front motor is the front left one of an X, deg.
pub(super) const PLUS_DEG: f64 = 45.0;

impl Log {
    /// The same log in body axes that are turned about yaw by an angle, clockwise seen from above, so that the new
    /// forward axis points to what was that much right of ahead.
    ///
    /// # Errors
    /// Of roll and pitch, or of x and y, it has only one.
    pub fn turned(mut self, by_deg: f64) -> Result<Log, LogError> {
        if by_deg == 0.0 {
            return Ok(self);
        }
        let by_rad = by_deg.to_radians();
        if let Some(names) = self.turn(by_rad) {
            let message = format!(
                "the frame can't be turned by {by_deg} degrees: of {names} the log has only one, and either becomes \
                 part of both"
            );
            let kind = LogErrorKind::NotTurned(message);
            return Err(LogError { file: self.path, line: None, column: None, kind });
        }
        if let Some(sent) = &mut self.sent_commands {
            sent.turn(by_rad);
        }
        self.notes.push(format!(
            "body axes turned by {by_deg} degrees about yaw, where the motors stand as an X: roll, pitch, x and y are \
             those of the turned axes"
        ));
        Ok(self)
    }

    /// Turns all that has a direction in the body; the names of a pair of which only one is there, if so.
    fn turn(&mut self, by_rad: f64) -> Option<&'static str> {
        for (names, [first, second, _]) in [
            ("p and q", &mut self.rate_rad_s),
            ("acceleration along x and y", &mut self.accel_body_m_s2),
            ("roll_cmd and pitch_cmd", &mut self.axis_command),
            ("roll_stick and pitch_stick", &mut self.stick),
        ] {
            match (first, second) {
                (Some(along), Some(across)) => turn_vectors(along, across, by_rad),
                (None, None) => {}
                _ => return Some(names),
            }
        }
        let angles = [("roll and pitch angles", &mut self.angle_rad), ("references", &mut self.reference_rad)];
        for (names, of) in angles {
            match of {
                [Some(_), Some(_), _] => turn_angles(of, by_rad),
                [None, None, yaw] => yaw.iter_mut().flatten().for_each(|yaw| *yaw = wrapped(*yaw + by_rad)),
                _ => return Some(names),
            }
        }
        (self.axes[0] != self.axes[1]).then_some("roll and pitch")
    }
}

/// Parts of vectors along and across, in the turned axes.
fn turn_vectors(along: &mut [f64], across: &mut [f64], by_rad: f64) {
    let (sin, cos) = libm::sincos(by_rad);
    for (x, y) in along.iter_mut().zip(across) {
        (*x, *y) = (cos * *x + sin * *y, cos * *y - sin * *x);
    }
}

/// Euler angles Z-Y-X of R(roll, pitch, yaw) Rz(by). Without a yaw angle roll and pitch are the same.
fn turn_angles(angles: &mut [Column; 3], by_rad: f64) {
    let (sin, cos) = libm::sincos(by_rad);
    let [Some(roll), Some(pitch), yaw] = angles else { return };
    for row in 0..roll.len().min(pitch.len()) {
        let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (libm::sincos(roll[row]), libm::sincos(pitch[row]));
        // how far each body axis points down
        let down = [-sin_pitch, cos_pitch * sin_roll, cos_pitch * cos_roll];
        let turned = [cos * down[0] + sin * down[1], cos * down[1] - sin * down[0], down[2]];
        (roll[row], pitch[row]) = (libm::atan2(turned[1], turned[2]), -libm::asin(turned[0].clamp(-1.0, 1.0)));
        if let Some(yaw) = yaw {
            // the new forward axis, over the ground, from the old heading
            let ahead = cos * cos_pitch + sin * sin_roll * sin_pitch;
            yaw[row] = wrapped(yaw[row] + libm::atan2(sin * cos_roll, ahead));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    /// A log of one row.
    fn one(angles: [f64; 3], rates: [f64; 3]) -> Log {
        let columns = |of: [f64; 3]| of.map(|value| Some(vec![value]));
        Log {
            axes: [true; 3],
            time_s: vec![0.0],
            angle_rad: columns(angles),
            reference_rad: columns(angles),
            rate_rad_s: columns(rates),
            accel_body_m_s2: columns(rates),
            ..Log::default()
        }
    }

    fn row(columns: &[Column; 3]) -> [f64; 3] {
        columns.clone().map(|column| column.unwrap()[0])
    }

    #[test]
    fn the_attitude_is_that_of_the_turned_axes() {
        for (roll, pitch, yaw, by_deg) in
            [(0.3, -0.4, 2.0, 45.0), (-1.2, 0.9, -3.0, -30.0), (0.0, 1.4, 0.5, 135.0), (0.2, 0.1, 3.1, 45.0)]
        {
            let turned = one([roll, pitch, yaw], [1.0, 2.0, 3.0]).turned(by_deg).unwrap();
            let by = Rotation3::from_euler_angles(0.0, 0.0, f64::to_radians(by_deg));
            let expected = Rotation3::from_euler_angles(roll, pitch, yaw) * by;
            let [roll, pitch, yaw] = row(&turned.angle_rad);
            let found = Rotation3::from_euler_angles(roll, pitch, yaw);
            assert!((expected.matrix() - found.matrix()).norm() < 1e-12, "{by_deg}");
            assert_eq!(row(&turned.reference_rad), [roll, pitch, yaw]);
            // a vector is the same one, seen from the turned axes
            let vector = by.inverse() * nalgebra::Vector3::new(1.0, 2.0, 3.0);
            let [x, y, z] = row(&turned.rate_rad_s);
            assert!((vector - nalgebra::Vector3::new(x, y, z)).norm() < 1e-12);
            assert_eq!(row(&turned.accel_body_m_s2), [x, y, z]);
        }
    }

    #[test]
    fn half_of_a_pair_is_no_direction() {
        let mut log = one([0.1; 3], [0.0; 3]);
        log.rate_rad_s[1] = None;
        let message = log.turned(45.0).unwrap_err().to_string();
        assert!(message.contains("of p and q the log has only one"), "{message}");
        let mut log = one([0.1; 3], [0.0; 3]);
        log.axes[1] = false;
        assert!(log.turned(45.0).is_err());
        let log = one([0.1; 3], [0.0; 3]);
        assert_eq!(log.clone().turned(0.0).unwrap(), log);
    }
}
