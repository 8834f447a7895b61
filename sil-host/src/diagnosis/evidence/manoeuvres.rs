//! Manoeuvres that might separate what a log could not, the plainest first: scripts that `sil fly --script` flies.

use crate::scenario::{Scenario, Waypoint};

/// A flight and what it is, for a person: "fly ...".
pub(in crate::diagnosis) struct Manoeuvre {
    pub(in crate::diagnosis) in_words: &'static str,
    pub(in crate::diagnosis) scenario: Scenario,
    /// The earlier one that it repeats, four times: even of a drift it tells at most the cube of four times as much.
    pub(in crate::diagnosis) repeats: Option<usize>,
}

/// One set-point: how long, s; roll and pitch, degrees; collective command, where it is not the model's.
type Leg = (f64, f64, f64, Option<f64>);

/// Where the steps of both axes stand among them.
const BOTH_AXES: usize = 3;

/// All of them, the plainest first.
pub(in crate::diagnosis) fn manoeuvres() -> Vec<Manoeuvre> {
    let flown =
        |name: &str, in_words, legs: &[Leg]| Manoeuvre { in_words, scenario: scenario(name, legs), repeats: None };
    let steps = |half_s: f64, angles: &[(f64, f64)]| -> Vec<Leg> {
        angles.iter().map(|(roll_deg, pitch_deg)| (half_s, *roll_deg, *pitch_deg, None)).collect()
    };
    let single = |roll: f64, pitch: f64, half_s: f64, repeats: usize| {
        let once = [(0.0, 0.0), (roll, pitch), (0.0, 0.0), (-roll, -pitch)];
        steps(half_s, &once.repeat(repeats))
    };
    let both = [(0.0, 0.0), (30.0, 30.0), (-30.0, 30.0), (-30.0, -30.0), (30.0, -30.0)];
    let stairs: Vec<f64> = [0.0, 15.0, 30.0, 45.0, 30.0, 15.0, 0.0, -15.0, -30.0, -45.0, -30.0, -15.0].into();
    vec![
        flown("level", "level for 14 s", &[(14.0, 0.0, 0.0, None)]),
        flown("roll steps", "steps of roll to 20 degrees to either side for 14 s", &single(20.0, 0.0, 0.875, 4)),
        flown("pitch steps", "steps of pitch to 20 degrees up and down for 14 s", &single(0.0, 20.0, 0.875, 4)),
        flown("both axes", "steps of roll and pitch together to 30 degrees for 15 s", &steps(1.0, &both.repeat(3))),
        flown("roll doublets", "quick reversals of roll, 25 degrees, for 14 s", &single(25.0, 0.0, 0.35, 10)),
        flown("pitch doublets", "quick reversals of pitch, 25 degrees, for 14 s", &single(0.0, 25.0, 0.35, 10)),
        flown("roll sweep", "reversals of roll, 15 degrees, ever faster for 15 s", &sweep(15.0, 0.0)),
        flown("pitch sweep", "reversals of pitch, 15 degrees, ever faster for 15 s", &sweep(0.0, 15.0)),
        flown(
            "roll stairs",
            "roll in stairs of 15 degrees from -45 to 45, 1.5 s each",
            &steps(1.5, &stairs.iter().map(|roll| (*roll, 0.0)).collect::<Vec<_>>()),
        ),
        flown(
            "pitch stairs",
            "pitch in stairs of 15 degrees from -45 to 45, 1.5 s each",
            &steps(1.5, &stairs.iter().map(|pitch| (0.0, *pitch)).collect::<Vec<_>>()),
        ),
        flown("throttle", "steps of roll and pitch to 20 degrees at three throttles, 8 s each", &throttles()),
        Manoeuvre {
            repeats: Some(BOTH_AXES),
            ..flown("long", "steps of roll and pitch to 30 degrees for 60 s", &steps(1.0, &both.repeat(12)))
        },
    ]
}

/// Reversals with ever shorter halves, from 1.2 s to 0.15 s.
fn sweep(roll_deg: f64, pitch_deg: f64) -> Vec<Leg> {
    let mut legs = Vec::new();
    let (mut half_s, mut sign): (f64, f64) = (1.2, 1.0);
    while half_s > 0.15 {
        legs.push((half_s, sign * roll_deg, sign * pitch_deg, None));
        // hundredths are enough for a script
        half_s = (92.0 * half_s).round() / 100.0;
        sign = -sign;
    }
    legs
}

fn throttles() -> Vec<Leg> {
    let angles =
        [(0.0, 0.0), (20.0, 0.0), (-20.0, 0.0), (0.0, 20.0), (0.0, -20.0), (20.0, 20.0), (-20.0, -20.0), (0.0, 0.0)];
    let at = |throttle: f64| angles.map(|(roll_deg, pitch_deg)| (1.0, roll_deg, pitch_deg, Some(throttle)));
    [0.35, 0.45, 0.6].into_iter().flat_map(at).collect()
}

fn scenario(name: &str, legs: &[Leg]) -> Scenario {
    let (mut waypoints, mut start_s) = (Vec::new(), 0.0);
    for (duration_s, roll_deg, pitch_deg, throttle) in legs {
        waypoints.push(Waypoint {
            roll_rad: roll_deg.to_radians(),
            pitch_rad: pitch_deg.to_radians(),
            throttle: *throttle,
            ..Waypoint::level(start_s)
        });
        start_s += duration_s;
    }
    Scenario { name: name.to_owned(), duration_s: start_s, waypoints }
}
