//! How a motion that has left its prediction comes back to it: what a model's brakes and springs do to a small
//! departure of an axis. Over a few milliseconds it does not count; over a window of half a second a brake of 5 1/s
//! lets nine tenths of a rate's departure die away, and the gravity of a bench turns an angle's into a rate.

use super::Window;
use super::body::Turning;
use super::force_track::ForceAndSpin;
use super::model::Model;
use super::windowed_log::{Driven, WindowedLog};
use crate::axis::Axis;

/// A departure d of an axis' angle goes on by d'' = - stiffness d - damping d'.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Restoring {
    pub(crate) stiffness_1_s2: f64,
    pub(crate) damping_1_s: f64,
}

/// Departures on either side of the measured state between which the moments' change is taken: of an angle, rad, and of
/// a rate, rad/s. As large as departures are, so that of dry friction it is the mean that counts.
const DEPARTURE: [f64; 2] = [0.05, 0.1];
/// The motion is looked at so many times a window, evenly.
const LOOKS: usize = 2;

impl Restoring {
    /// A departure of angle and rate so much later.
    pub(crate) fn after(&self, [angle_rad, rate_rad_s]: [f64; 2], duration_s: f64) -> [f64; 2] {
        let kept = if self.damping_1_s == 0.0 { 1.0 } else { libm::exp(-self.damping_1_s * duration_s) };
        let turned_back = self.stiffness_1_s2 * angle_rad * duration_s;
        [angle_rad + duration_s * rate_rad_s, kept * rate_rad_s - turned_back]
    }
}

impl WindowedLog<'_> {
    /// Of an axis over a window, along what was measured.
    pub(crate) fn restoring(&self, driven: &Driven, window: &Window, axis: Axis) -> Restoring {
        if !driven.model.restores {
            return Restoring::default();
        }
        let rows = window.end - window.start;
        let mut sum = Restoring::default();
        for look in 0..LOOKS {
            let row = window.start + (2 * look + 1) * rows / (2 * LOOKS);
            let [a, b, c, d, e, f, ..] = self.measured_state(&driven.model, row);
            let motors = ForceAndSpin { force: driven.track.at_row(row), ..ForceAndSpin::default() };
            let state = [a, b, c, d, e, f];
            let [by_angle, by_rate] = driven.model.answers_to_departure(self.rows()[row], &state, &motors, axis);
            sum.stiffness_1_s2 -= by_angle / LOOKS as f64;
            sum.damping_1_s -= by_rate / LOOKS as f64;
        }
        sum
    }
}

impl Model {
    /// Change of an axis' angular acceleration with its own angle, 1/s^2, and with its own rate, 1/s.
    fn answers_to_departure(&self, time_s: f64, state: &Turning, motors: &ForceAndSpin, axis: Axis) -> [f64; 2] {
        let acceleration = |place: usize, by: f64| {
            let mut moved = *state;
            moved[place] += by;
            self.body.derivative(time_s, &moved, motors, &self.moments, [0.0; 3])[3 + axis.index()]
        };
        let slope = |place: usize, by: f64| (acceleration(place, by) - acceleration(place, -by)) / (2.0 * by);
        [slope(axis.index(), DEPARTURE[0]), slope(3 + axis.index(), DEPARTURE[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The exact motion of a departure under a spring and a brake, in steps of a log's rows.
    #[test]
    fn a_departure_swings_and_dies_away() {
        let own = Restoring { stiffness_1_s2: 12.0, damping_1_s: 3.0 };
        let step_s = 0.004;
        let mut departure = [0.1, 0.0];
        for _ in 0..125 {
            departure = own.after(departure, step_s);
        }
        // x'' = -12 x - 3 x', x(0) = 0.1: poles -1.5 +- 3.1225 i
        let (time_s, omega) = (125.0 * step_s, (12.0f64 - 2.25).sqrt());
        let decay = 0.1 * (-1.5 * time_s).exp();
        let angle = decay * ((omega * time_s).cos() + 1.5 / omega * (omega * time_s).sin());
        let rate = -decay * 12.0 / omega * (omega * time_s).sin();
        // of first order in steps of 4 ms
        assert!((departure[0] - angle).abs() < 0.02 * 0.1, "{departure:?} {angle}");
        assert!((departure[1] - rate).abs() < 0.02 * 0.35, "{departure:?} {rate}");
        assert_eq!(Restoring::default().after([0.1, 0.5], 0.1), [0.1 + 0.1 * 0.5, 0.5]);
    }
}
