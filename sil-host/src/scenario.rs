//! What is flown: set-points over time. The thesis' test sequence (section 5.2) and scripts in TOML.

use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use crate::document::with_hint;

/// Duration of each hover and each position of the test sequence, s (the thesis gives no times; docs/rig.md does).
const TEST_SEGMENT_S: f64 = 1.75;

/// Positions of the test sequence as (roll, pitch), degrees; a hover goes before each and after the last.
const TEST_POSITIONS_DEG: [(f64, f64); 8] =
    [(30.0, 0.0), (-30.0, 0.0), (0.0, 30.0), (0.0, -30.0), (30.0, 30.0), (30.0, -30.0), (-30.0, 30.0), (-30.0, -30.0)];

/// Longest flight that is simulated, s.
pub const DURATION_MAX_S: f64 = 3600.0;

/// What is requested from a point in time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// From when on, s.
    pub start_s: f64,
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Rate of the heading, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Collective command; the model's base command where none is given.
    pub throttle: Option<f64>,
    /// Height above the start that a pilot holds by the throttle, m; none flies the collective command as it is. Free
    /// flight.
    pub climb_m: Option<f64>,
}

impl Waypoint {
    /// Level from a time on, nothing else requested.
    pub fn level(start_s: f64) -> Waypoint {
        Waypoint { start_s, roll_rad: 0.0, pitch_rad: 0.0, yaw_rate_rad_s: 0.0, throttle: None, climb_m: None }
    }
}

/// A flight: waypoints in order of time, the first at zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// What it is called in reports.
    pub name: String,
    /// When it ends, s.
    pub duration_s: f64,
    /// Set-points.
    pub waypoints: Vec<Waypoint>,
}

/// A script that can't be flown.
#[derive(Debug, thiserror::Error)]
pub enum ScriptError {
    /// The file can't be read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// It isn't TOML of the expected form; the message has line and column.
    #[error("{file}: {message}")]
    Malformed {
        /// The file.
        file: String,
        /// What and where.
        message: String,
    },
    /// A value makes no sense.
    #[error("{file}:{line}: [[step]] number {step}: {problem}")]
    Step {
        /// The file.
        file: String,
        /// The line in which the step begins, counted from 1.
        line: usize,
        /// Which step, counted from 1.
        step: usize,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// The duration makes no sense.
    #[error("{file}: duration_s must be above the last step's at_s and at most {DURATION_MAX_S} s")]
    Duration {
        /// The file.
        file: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScriptFile {
    #[serde(default)]
    name: Option<String>,
    duration_s: f64,
    #[serde(default, rename = "step")]
    steps: Vec<Spanned<ScriptStep>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScriptStep {
    at_s: f64,
    #[serde(default)]
    roll_deg: f64,
    #[serde(default)]
    pitch_deg: f64,
    #[serde(default)]
    yaw_rate_deg_s: f64,
    #[serde(default)]
    throttle: Option<f64>,
    #[serde(default)]
    climb_m: Option<f64>,
}

impl Scenario {
    /// The thesis' nine-position test sequence, 29.75 s.
    pub fn test_sequence() -> Self {
        let hover = (0.0, 0.0);
        let positions = TEST_POSITIONS_DEG.iter().flat_map(|&position| [hover, position]).chain([hover]);
        let waypoints: Vec<_> = positions
            .enumerate()
            .map(|(index, (roll_deg, pitch_deg))| Waypoint {
                roll_rad: roll_deg.to_radians(),
                pitch_rad: pitch_deg.to_radians(),
                ..Waypoint::level(index as f64 * TEST_SEGMENT_S)
            })
            .collect();
        Self {
            name: "test sequence (thesis section 5.2)".into(),
            duration_s: waypoints.len() as f64 * TEST_SEGMENT_S,
            waypoints,
        }
    }

    /// Level all the time.
    pub fn hover(duration_s: f64) -> Self {
        Self { name: "hover".into(), duration_s, waypoints: vec![Waypoint::level(0.0)] }
    }

    /// Reads a script.
    ///
    /// # Errors
    /// [`ScriptError`], with the file and the place.
    pub fn load(path: &Path) -> Result<Self, ScriptError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text, &file),
            Err(source) => Err(ScriptError::Unreadable { file, source }),
        }
    }

    /// Reads a script's text; `file` is what messages call it.
    ///
    /// # Errors
    /// [`ScriptError`], with the place.
    pub fn parse(text: &str, file: &str) -> Result<Self, ScriptError> {
        let script: ScriptFile = toml::from_str(text)
            .map_err(|error| ScriptError::Malformed { file: file.into(), message: with_hint(&error.to_string()) })?;
        let mut waypoints = vec![Waypoint::level(0.0)];
        for (index, step) in script.steps.iter().enumerate() {
            let line = 1 + text[..step.span().start].matches('\n').count();
            let problem = |problem| ScriptError::Step { file: file.into(), line, step: index + 1, problem };
            let step = step.get_ref();
            if step.at_s.is_nan() || step.at_s < waypoints[waypoints.len() - 1].start_s {
                return Err(problem("at_s must be zero or more and not before the step above"));
            }
            if !((-180.0..=180.0).contains(&step.roll_deg) && (-90.0..=90.0).contains(&step.pitch_deg)) {
                return Err(problem("roll_deg must be within +-180 and pitch_deg within +-90"));
            }
            if !(-720.0..=720.0).contains(&step.yaw_rate_deg_s) {
                return Err(problem("yaw_rate_deg_s must be within +-720"));
            }
            if step.throttle.is_some_and(|throttle| !(0.0..=1.0).contains(&throttle)) {
                return Err(problem("throttle must be within 0 and 1"));
            }
            if step.climb_m.is_some_and(|climb_m| !(-100.0..=100.0).contains(&climb_m)) {
                return Err(problem("climb_m must be within +-100"));
            }
            waypoints.push(Waypoint {
                start_s: step.at_s,
                roll_rad: step.roll_deg.to_radians(),
                pitch_rad: step.pitch_deg.to_radians(),
                yaw_rate_rad_s: step.yaw_rate_deg_s.to_radians(),
                throttle: step.throttle,
                climb_m: step.climb_m,
            });
        }
        let last_s = waypoints[waypoints.len() - 1].start_s;
        if !(script.duration_s > last_s && script.duration_s <= DURATION_MAX_S) {
            return Err(ScriptError::Duration { file: file.into() });
        }
        let name = script.name.unwrap_or_else(|| file.to_owned());
        Ok(Self { name, duration_s: script.duration_s, waypoints })
    }

    /// The script that [`Scenario::parse`] reads back.
    pub fn to_script(&self) -> String {
        let mut script =
            format!("name = {}\nduration_s = {}\n", toml::Value::from(self.name.as_str()), self.duration_s);
        // every script begins level
        let implied = usize::from(self.waypoints.first() == Some(&Waypoint::level(0.0)));
        for waypoint in &self.waypoints[implied..] {
            // nine digits: degrees of a radian that was degrees
            let degrees = |angle_rad: f64| (1e9 * angle_rad.to_degrees()).round() / 1e9;
            script.push_str(&format!("\n[[step]]\nat_s = {}\n", waypoint.start_s));
            for (key, value) in [
                ("roll_deg", degrees(waypoint.roll_rad)),
                ("pitch_deg", degrees(waypoint.pitch_rad)),
                ("yaw_rate_deg_s", degrees(waypoint.yaw_rate_rad_s)),
            ] {
                if value != 0.0 {
                    script.push_str(&format!("{key} = {value}\n"));
                }
            }
            if let Some(throttle) = waypoint.throttle {
                script.push_str(&format!("throttle = {throttle}\n"));
            }
            if let Some(climb_m) = waypoint.climb_m {
                script.push_str(&format!("climb_m = {climb_m}\n"));
            }
        }
        script
    }

    /// The set-point in force at a time.
    pub fn at(&self, time_s: f64) -> Waypoint {
        let next = self.waypoints.partition_point(|waypoint| waypoint.start_s <= time_s);
        self.waypoints[next.saturating_sub(1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_sequence_is_the_specs() {
        let sequence = Scenario::test_sequence();
        assert_eq!(sequence.duration_s, 29.75);
        assert_eq!(sequence.waypoints.len(), 17);
        assert_eq!(sequence.at(0.0).roll_rad, 0.0);
        assert!((sequence.at(1.75).roll_rad.to_degrees() - 30.0).abs() < 1e-12);
        assert_eq!(sequence.at(3.6).roll_rad, 0.0);
        assert!((sequence.at(27.0).pitch_rad.to_degrees() + 30.0).abs() < 1e-12);
        assert_eq!(sequence.at(28.1).pitch_rad, 0.0);
    }

    #[test]
    fn a_scenario_is_written_as_a_script_and_read_back() {
        let mut sequence = Scenario { name: "a \"test\"".into(), ..Scenario::test_sequence() };
        sequence.waypoints[3].throttle = Some(0.4);
        sequence.waypoints[4].yaw_rate_rad_s = -0.3;
        let back = Scenario::parse(&sequence.to_script(), "s.toml").unwrap();
        assert_eq!((&back.name, back.duration_s), (&sequence.name, sequence.duration_s));
        for time_s in (0..297).map(|k| 0.1 * f64::from(k)) {
            let (back, sequence) = (back.at(time_s), sequence.at(time_s));
            assert_eq!((back.start_s, back.throttle), (sequence.start_s, sequence.throttle));
            let near = |a: f64, b: f64| (a - b).abs() < 1e-10;
            assert!(near(back.roll_rad, sequence.roll_rad) && near(back.pitch_rad, sequence.pitch_rad));
            assert!(near(back.yaw_rate_rad_s, sequence.yaw_rate_rad_s));
        }
        // once written, it stays as it is: other processes compare the texts
        for scenario in [back.clone(), Scenario::hover(2.0)] {
            assert_eq!(Scenario::parse(&scenario.to_script(), "s.toml").unwrap(), scenario);
        }
    }

    #[test]
    fn a_script_is_read_and_bad_ones_name_the_place() {
        let good = "duration_s = 3.0\n[[step]]\nat_s = 1.0\nroll_deg = 10\nthrottle = 0.4\n";
        let scenario = Scenario::parse(good, "s.toml").unwrap();
        assert!((scenario.at(1.5).roll_rad - 10f64.to_radians()).abs() < 1e-12);
        assert_eq!(scenario.at(0.5).throttle, None);
        for (text, expected) in [
            ("duration_s = 3.0\n[[step]]\nat_s = 1\nrol_deg = 3\n", "line 4"),
            ("duration_s = 3.0\n[[step]]\nat_s = 2\n[[step]]\nat_s = 1\n", "s.toml:4: [[step]] number 2"),
            ("duration_s = 3.0\n[[step]]\nat_s = nan\n", "number 1"),
            ("duration_s = 3.0\n[[step]]\nat_s = 1\nthrottle = 50\n", "throttle must be within 0 and 1"),
            ("duration_s = 3.0\n[[step]]\nat_s = 5\n", "duration_s must be above"),
            ("", "duration_s"),
        ] {
            let message = Scenario::parse(text, "s.toml").unwrap_err().to_string();
            assert!(message.contains(expected) && message.contains("s.toml"), "{message}");
        }
    }
}
