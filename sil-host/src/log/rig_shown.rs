//! Does a log say that nothing held its vehicle? A model of the testbed says nothing of a free flight, and the reverse.

use super::{Log, Quantity, sanity};
use crate::axis::Axis;
use crate::model::Rig;

/// What a log says of its rig, and by what it says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RigShown {
    /// True of a free flight; false where something carried the vehicle.
    pub is_free: bool,
    /// "its height", ...
    pub by: &'static str,
}

impl Log {
    /// What the map says, else the head of the file, else its columns, else its accelerometer, else that it is a flight
    /// controller's own; `None` where nothing tells.
    pub fn rig_shown(&self) -> Option<RigShown> {
        let says = |words: &str| self.comments.iter().any(|comment| comment.to_lowercase().contains(words));
        let has = |quantity: Quantity| self.column(quantity).is_some();
        let shown = |is_free, by| Some(RigShown { is_free, by });
        if let Some(rig) = self.rig {
            return shown(rig == Rig::Free, "its map");
        }
        if says("free flight") {
            return shown(true, "its head");
        }
        if says("gimbal") {
            return shown(false, "its head");
        }
        if has(Quantity::Height) {
            return shown(true, "its height");
        }
        if Axis::ALL.into_iter().any(|axis| has(Quantity::Velocity(axis))) {
            return shown(true, "its velocity");
        }
        match sanity::is_held(self) {
            Some(true) => shown(false, "its accelerometer, which shows gravity whatever the motors do"),
            Some(false) => shown(true, "its accelerometer, which shows the motors' lift alone"),
            None if self.flight_controller.is_some() => shown(true, "the flight controller that wrote it"),
            None => None,
        }
    }

    /// Does it say that nothing held what flew?
    pub fn shows_free_flight(&self) -> bool {
        self.rig_shown().is_some_and(|shown| shown.is_free)
    }

    /// Is it a free flight with the commands of four motors, of which a vehicle can be identified?
    pub fn shows_a_vehicle(&self) -> bool {
        self.motors().is_some() && self.shows_free_flight()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_that_says_so_is_believed() {
        let flown = Log { height_m: Some(vec![1.0]), comments: vec!["free flight".to_owned()], ..Log::default() };
        assert!(flown.shows_free_flight());
        assert!(!Log { rig: Some(Rig::Gimbal), ..flown }.shows_free_flight());
        assert!(!Log::default().shows_free_flight());
        assert!(Log { rig: Some(Rig::Free), ..Log::default() }.shows_free_flight());
    }

    /// 20 s of roll swinging by 0.3 rad, with what an accelerometer shows along y.
    fn swinging(along_y: impl Fn(f64) -> f64) -> Log {
        let time_s: Vec<f64> = (0..2000).map(|row| 0.01 * f64::from(row)).collect();
        let roll: Vec<f64> = time_s.iter().map(|t| 0.3 * libm::sin(4.0 * t + 0.1 * t * t)).collect();
        let noise = |row: usize| 0.05 * libm::sin(37.0 * row as f64);
        let y = roll.iter().enumerate().map(|(row, roll)| along_y(*roll) + noise(row)).collect();
        let rows = time_s.len();
        Log {
            axes: [true, true, false],
            angle_rad: [Some(roll), Some(vec![0.0; rows]), None],
            accel_body_m_s2: [Some((0..rows).map(noise).collect()), Some(y), Some(vec![-9.81; rows])],
            time_s,
            ..Log::default()
        }
    }

    #[test]
    fn the_accelerometer_tells_a_rig_from_a_flight() {
        let held = swinging(|roll| -9.81 * libm::sin(roll));
        assert!(!held.rig_shown().unwrap().is_free);
        let free = swinging(|_| 0.0);
        assert!(free.rig_shown().unwrap().is_free);
        // what the file's head says stands above
        let said = Log { comments: vec!["model: F450 on the gimbal, specific device".to_owned()], ..free.clone() };
        assert_eq!(said.rig_shown(), Some(RigShown { is_free: false, by: "its head" }));
    }

    /// Steps that are held, and by then drag shows half of what gravity shows on a rig.
    #[test]
    fn the_drag_of_a_short_flight_is_not_taken_for_a_rig() {
        let roll = |row: usize| [0.0, 0.5, 0.0, -0.5, 0.0][row / 175];
        let along_y = |drag_1_s: f64| {
            let mut speed_m_s = 0.0;
            let mut felt_m_s2 = |row: usize| {
                speed_m_s += 0.01 * (9.81 * libm::sin(roll(row)) - drag_1_s * speed_m_s);
                -drag_1_s * speed_m_s + 0.05 * libm::sin(37.0 * row as f64)
            };
            (0..800).map(&mut felt_m_s2).collect::<Vec<f64>>()
        };
        let whole = swinging(|_| 0.0);
        let first = |column: &Option<Vec<f64>>| column.as_ref().map(|column| column[..800].to_vec());
        let [x, _, z] = whole.accel_body_m_s2.each_ref().map(first);
        for drag_1_s in [0.3, 0.45, 0.6] {
            let accel_body_m_s2 = [x.clone(), Some(along_y(drag_1_s)), z.clone()];
            let angle_rad = [Some((0..800).map(roll).collect()), Some(vec![0.0; 800]), None];
            let time_s = whole.time_s[..800].to_vec();
            let log = Log { angle_rad, accel_body_m_s2, time_s, axes: whole.axes, ..Log::default() };
            assert_eq!(log.rig_shown().map(|shown| shown.is_free), Some(true), "{drag_1_s}");
        }
    }

    #[test]
    fn height_or_velocity_mean_free_flight_and_silence_means_nothing() {
        assert_eq!(Log::default().rig_shown(), None);
        let height = Log { height_m: Some(vec![1.0]), ..Log::default() };
        assert_eq!(height.rig_shown(), Some(RigShown { is_free: true, by: "its height" }));
        let own = Log { flight_controller: Some("PX4".to_owned()), ..Log::default() };
        assert!(own.rig_shown().unwrap().is_free);
    }
}
