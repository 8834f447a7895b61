//! What is an alert and what is none, and how soon a torque is found after one.

extern crate std;

use super::super::{DisturbanceAlert, ObserverConfig, ObserverState, Pace};
use super::*;
use crate::lagged_axis::{AxisMotion, LagStep};
use crate::vehicle::Actuation;

const STEP_S: f32 = 0.0025;
const INERTIA_KG_M2: f32 = 0.0115;
const LAG_S: f32 = 0.03;
const TORQUE_NM: f32 = 0.1;
const BANDWIDTH_RAD_S: f32 = 10.0;

fn config(alert: DisturbanceAlert) -> ObserverConfig {
    let actuation = Actuation { delay_s: 0.0, lag_s: LAG_S };
    let pace = Pace { bandwidth_rad_s: BANDWIDTH_RAD_S, alert, step_s: STEP_S };
    ObserverConfig::new([INERTIA_KG_M2; 3], [1.0; 3], &actuation, pace).unwrap()
}

/// A generator of Lehmer's (Park and Miller's constants), and the sum of twelve of its numbers: nearly normal.
struct Noise(u64);

impl Noise {
    fn normal(&mut self) -> f32 {
        let mut uniform = || {
            self.0 = self.0 * 48_271 % 0x7fff_ffff;
            self.0 as f32 / 0x7fff_ffff as f32
        };
        (0..12).map(|_| uniform()).sum::<f32>() - 6.0
    }
}

/// A body under the demands and torques of each step, with noise on its gyro; what was estimated about roll, and
/// whether it was alert.
fn flown(
    alert: DisturbanceAlert,
    authority: f32,
    deviation_rad_s: f32,
    inputs: impl Iterator<Item = (f32, f32)>,
) -> std::vec::Vec<(f32, bool)> {
    let config = config(alert);
    let (mut state, mut body, mut noise) = (ObserverState::default(), AxisMotion::default(), Noise(1));
    let step = LagStep::new(STEP_S, LAG_S);
    let one = |(demand_nm, outside_nm): (f32, f32)| {
        let rate_rad_s = body.rate_rad_s + deviation_rad_s * noise.normal();
        state.update(&config, [rate_rad_s, 0.0, 0.0], [demand_nm, 0.0, 0.0], [0.0; 3]);
        body = step.advance(&body, authority * demand_nm, outside_nm, INERTIA_KG_M2);
        (state.disturbance_nm()[0], state.is_alert(&config)[0])
    };
    inputs.map(one).collect()
}

/// A loop of 200 Hz is alert after a torque has set in, one of 100 Hz never.
#[test]
fn a_slow_loop_is_never_alert() {
    let is_alert = |step_s: f32| {
        let rule = AlertRule::new(DisturbanceAlert::Significant, Gains::of_double_pole(0.9, step_s), step_s);
        let mut state = AlertState::default();
        (0..400).any(|step| {
            rule.gains(&mut state, if step < 300 { 0.0 } else { 1.0 }, 0.0);
            rule.is_alert(&state)
        })
    };
    assert!(is_alert(STEP_MAX_S) && !is_alert(0.01));
}

fn step_at(onset: usize, steps: usize) -> impl Iterator<Item = (f32, f32)> {
    (0..steps).map(move |step| (0.0, if step < onset { 0.0 } else { TORQUE_NM }))
}

/// Gains of a memory of n are the line through n samples by least squares: with them alone, begun at n = 2, any line is
/// met at once, and noise leaves what the textbook's variance says, 12 sigma^2 / (h^2 n (n^2 - 1)).
#[test]
fn a_memory_is_the_line_of_least_squares() {
    let deviation = 0.01f32;
    let (mut squares, runs) = (0.0f32, 2000);
    let mut noise = Noise(7);
    for _ in 0..runs {
        let samples: [f32; 12] = core::array::from_fn(|k| 0.3 + 8.0 * STEP_S * k as f32 + deviation * noise.normal());
        let (mut rate, mut acceleration) = (samples[0], 0.0);
        for (n, sample) in (2u32..).zip(&samples[1..]) {
            let gains = Gains::of_memory(n, STEP_S);
            rate += STEP_S * acceleration;
            let error = sample - rate;
            rate += gains.rate * error;
            acceleration += gains.acceleration_1_s * error;
        }
        squares += (acceleration - 8.0) * (acceleration - 8.0);
    }
    let n = 12.0f32;
    let expected = 12.0 * deviation * deviation / (STEP_S * STEP_S * n * (n * n - 1.0));
    // of 2000 squares the mean scatters by 3 %
    let found = squares / runs as f32;
    assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
}

/// A torque that sets in is found to a tenth within eight steps, where the observer of calm takes 160.
#[test]
fn what_sets_in_is_found_at_once() {
    let onset = 800;
    let alert = flown(DisturbanceAlert::Significant, 1.0, 0.0, step_at(onset, 1200));
    let calm = flown(DisturbanceAlert::Never, 1.0, 0.0, step_at(onset, 1200));
    let near = |found: &[(f32, bool)]| {
        let last_off = found.iter().rposition(|(nm, _)| (nm - TORQUE_NM).abs() > 0.1 * TORQUE_NM);
        last_off.unwrap() - onset
    };
    assert!(near(&alert) <= 8, "{}", near(&alert));
    // critically damped: (1 + x) exp(-x) = 0.1 at x = 3.89, and 0.0025 * 10 a step
    assert!((150..165).contains(&near(&calm)), "{}", near(&calm));
    assert!(alert[..onset].iter().all(|(_, is_alert)| !is_alert), "calm before");
    assert!(alert[onset + 4].1 && !alert.last().unwrap().1, "alert then, and calm in the end");
}

/// An hour of a gyro's noise, whatever its size, is no alert; a torque that stands out of it is one.
#[test]
fn noise_is_no_alert() {
    for deviation_rad_s in [0.0, 0.001, 0.005, 0.02] {
        let hour = flown(DisturbanceAlert::Significant, 1.0, deviation_rad_s, step_at(usize::MAX, 3600 * 400));
        let alerts = hour.iter().filter(|(_, is_alert)| *is_alert).count();
        assert_eq!(alerts, 0, "{deviation_rad_s}");
    }
    let found = flown(DisturbanceAlert::Significant, 1.0, 0.005, step_at(2000, 2040));
    assert!(found[2000..2006].iter().any(|(_, is_alert)| *is_alert));
}

/// Motors that give a fifth more or less than the model says are no alert, however they are driven.
#[test]
fn a_model_that_is_a_little_wrong_is_no_alert() {
    for authority in [0.8, 1.2] {
        for period in [20, 80, 300] {
            let driven = (0..4000).map(|step| (if step / period % 2 == 0 { 0.3 } else { -0.3 }, 0.0));
            let found = flown(DisturbanceAlert::Significant, authority, 0.005, driven);
            assert!(found.iter().all(|(_, is_alert)| !is_alert), "{authority} {period}");
        }
    }
}

/// Alerts of one axis are a pause apart, kept up or significant all the time.
#[test]
fn alerts_are_a_pause_apart() {
    let pause = (PAUSE_S / STEP_S) as usize;
    // a step each 1.1 s
    let shaken = |_| (0..4000usize).map(|step| (0.0, if step / 450 % 2 == 0 { 0.3 } else { -0.3 }));
    for rule in [DisturbanceAlert::Always, DisturbanceAlert::Significant] {
        let found = flown(rule, 1.0, 0.0, shaken(()));
        let begins: std::vec::Vec<usize> =
            (1..found.len()).filter(|&step| found[step].1 && !found[step - 1].1).collect();
        assert!(begins.len() > 5, "{rule:?} {begins:?}");
        assert!(begins.windows(2).all(|pair| pair[1] - pair[0] >= pause), "{rule:?} {begins:?}");
    }
}
