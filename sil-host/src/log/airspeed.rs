//! How the air passes a vehicle that flies free: along its x and y axes.
//!
//! A log says so by the vehicle's velocity over the ground and its heading, as if the air stood still. Where it has
//! none the accelerometer says it: along the rotors' plane it feels nothing but their drag, which is in proportion to
//! the airspeed, so much a second (Faessler, Franchi and Scaramuzza, RA-L 3(2), 2018: 0.4 to 0.5 N s/m per kilogram).

use super::Log;
use crate::axis::Axis;
use crate::model::VehicleModel;

/// Half the time of a mean of the accelerometer, s: an IMU beside the centre of gravity feels how the vehicle's rates
/// change, of which half a second leaves little.
const MEAN_HALF_S: f64 = 0.25;

impl Log {
    /// Does it say how the air passes what flies free?
    pub(crate) fn shows_airspeed(&self) -> bool {
        self.horizontal_velocity_m_s().zip(self.heading_rad()).is_some() || self.felt_in_plane_m_s2().is_some()
    }

    /// Per row, velocity against the air along the body's x and y axes, m/s; empty where the log does not say. Of the
    /// attitude only the heading is looked at, measured or else requested: a vehicle that holds it to 5 degrees has
    /// these within a tenth of each other.
    pub(crate) fn airspeed_m_s(&self) -> Vec<[f64; 2]> {
        if let (Some([north, east]), Some(heading)) = (self.horizontal_velocity_m_s(), self.heading_rad()) {
            let of_row = |row: usize| {
                let (sin, cos) = libm::sincos(heading[row]);
                [cos * north[row] + sin * east[row], cos * east[row] - sin * north[row]]
            };
            return (0..self.rows()).map(of_row).collect();
        }
        let Some(felt) = self.felt_in_plane_m_s2() else { return Vec::new() };
        let [x, y] = felt.map(|along| mean_about(&self.time_s, along));
        let of_felt = |felt_m_s2: f64| -felt_m_s2 / VehicleModel::USUAL_ROTOR_DRAG_1_S;
        x.into_iter().zip(y).map(|(x, y)| [of_felt(x), of_felt(y)]).collect()
    }

    fn horizontal_velocity_m_s(&self) -> Option<[&[f64]; 2]> {
        let [Some(north), Some(east), _] = &self.velocity_ned_m_s else { return None };
        Some([north, east])
    }

    fn heading_rad(&self) -> Option<&[f64]> {
        let yaw = Axis::Yaw.index();
        self.angle_rad[yaw].as_deref().or(self.reference_rad[yaw].as_deref())
    }

    fn felt_in_plane_m_s2(&self) -> Option<[&[f64]; 2]> {
        let [Some(x), Some(y), _] = &self.accel_body_m_s2 else { return None };
        Some([x, y])
    }
}

/// Means of the readings about each row.
fn mean_about(time_s: &[f64], readings: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    sums.extend(readings.iter().map(|reading| {
        sum += reading;
        sum
    }));
    let (mut from, mut to) = (0, 0);
    let mut of_row = |at_s: &f64| {
        while time_s[from] < at_s - MEAN_HALF_S {
            from += 1;
        }
        while to < time_s.len() && time_s[to] <= at_s + MEAN_HALF_S {
            to += 1;
        }
        (sums[to] - sums[from]) / (to - from) as f64
    };
    time_s.iter().map(&mut of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vehicle_that_flies_where_it_looks_has_air_from_ahead() {
        let heading = [0.0_f64, 0.7, -2.0, 3.1];
        let velocity = |of: fn(f64) -> f64| Some(heading.iter().map(|yaw| 3.0 * of(*yaw)).collect());
        let mut log = Log {
            time_s: vec![0.0, 1.0, 2.0, 3.0],
            velocity_ned_m_s: [velocity(libm::cos), velocity(libm::sin), None],
            ..Log::default()
        };
        assert!(!log.shows_airspeed() && log.airspeed_m_s().is_empty());
        log.reference_rad[2] = Some(heading.to_vec());
        assert!(log.shows_airspeed());
        for [forward, right] in log.airspeed_m_s() {
            assert!((forward - 3.0).abs() < 1e-12 && right.abs() < 1e-12);
        }
        // what was measured stands above what was requested: looking north it goes to the right where east is
        log.angle_rad[2] = Some(vec![0.0; 4]);
        assert!((log.airspeed_m_s()[1][1] - 3.0 * libm::sin(0.7)).abs() < 1e-12);
    }

    /// 0.9 m/s^2 to the rear is drag of 2 m/s; what changes sign from row to row is none.
    #[test]
    fn without_velocity_the_air_is_felt() {
        let time_s: Vec<f64> = (0..200).map(|row| 0.01 * f64::from(row)).collect();
        let shaking = (0..200).map(|row| -0.9 + if row % 2 == 0 { 3.0 } else { -3.0 }).collect();
        let accel_body_m_s2 = [Some(shaking), Some(vec![0.45; 200]), None];
        let log = Log { time_s, accel_body_m_s2, ..Log::default() };
        assert!(log.shows_airspeed());
        for [x, y] in log.airspeed_m_s() {
            assert!((x - 2.0).abs() < 0.3 && (y + 1.0).abs() < 1e-9, "{x} {y}");
        }
    }
}
