extern crate std;

use super::confidence::{AXES, Learnt};
use super::*;
use crate::lagged_axis::{AxisMotion, LagStep};
use crate::torque_observer::{DisturbanceAlert, ObserverConfig, Pace};
use crate::vehicle::Actuation;
use proptest::prelude::*;

const STEP_S: f32 = 0.0025;
const MODEL_KG_M2: f32 = 0.0115;
const DELAY_S: f32 = 0.00225;
/// Parts of a control step in which the body is integrated.
const SLICES: usize = 200;

/// A body with a gain and a lag, whose motors are told what turns it as the reference does.
struct Flight {
    gain: [f32; AXES],
    lag_s: f32,
    noise_rad_s: f32,
    config: LearningConfig,
    observer_config: ObserverConfig,
    learning: LearningState,
    observer: ObserverState,
    body: [AxisMotion; AXES],
    told_nm: std::vec::Vec<[f32; AXES]>,
    random: u32,
}

impl Flight {
    fn new(gain: [f32; AXES], lag_s: f32, noise_rad_s: f32) -> Self {
        let circumstances = Circumstances {
            inertia_kg_m2: [MODEL_KG_M2; AXES],
            delay_s: DELAY_S,
            reference_max_rad_s2: [20.0; AXES],
            step_s: STEP_S,
            pitch_inertia: PitchInertia { level_kg_m2: MODEL_KG_M2, rolled_kg_m2: MODEL_KG_M2 },
        };
        let pace = Pace { bandwidth_rad_s: 0.0, alert: DisturbanceAlert::Never, step_s: STEP_S };
        let actuation = Actuation { delay_s: 0.0, lag_s: 0.03 };
        Self {
            gain,
            lag_s,
            noise_rad_s,
            config: LearningConfig::new(&circumstances),
            observer_config: ObserverConfig::new([MODEL_KG_M2; 3], [0.3; 3], &actuation, pace).unwrap(),
            learning: LearningState::default(),
            observer: ObserverState::default(),
            body: [AxisMotion::default(); AXES],
            told_nm: std::vec::Vec::new(),
            random: 1,
        }
    }

    /// Uniform, -1 to 1.
    fn noise(&mut self) -> f32 {
        self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.random >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    /// One step with a torque on both axes, a torque from outside, and the reference's rates.
    fn step(&mut self, told_nm: [f32; AXES], outside_nm: f32, reference_rad_s: [f32; AXES], seen: bool) {
        let mut rate_rad_s = [0.0; 3];
        for axis in 0..AXES {
            rate_rad_s[axis] = self.body[axis].rate_rad_s + self.noise_rad_s * self.noise();
        }
        if !seen {
            rate_rad_s = [f32::NAN; 3];
        }
        self.observer.update(&self.observer_config, rate_rad_s, [told_nm[0], told_nm[1], 0.0], [0.0; 3]);
        let shown = Shown {
            observer: &self.observer,
            rate_rad_s,
            gain_share: [1.0; AXES],
            known_nm: [0.0; 3],
            reference_rad_s: [reference_rad_s[0], reference_rad_s[1], 0.0],
            seen,
        };
        self.learning.update(&self.config, &shown);
        self.told_nm.push(told_nm);
        let late = (DELAY_S / STEP_S * SLICES as f32) as usize;
        let slice = LagStep::new(STEP_S / SLICES as f32, self.lag_s);
        let now = (self.told_nm.len() - 1) * SLICES;
        for at in now..now + SLICES {
            let told_nm = at.checked_sub(late).map_or([0.0; AXES], |then| self.told_nm[then / SLICES]);
            for axis in 0..AXES {
                let inertia_kg_m2 = MODEL_KG_M2 / self.gain[axis];
                self.body[axis] = slice.advance(&self.body[axis], told_nm[axis], outside_nm, inertia_kg_m2);
            }
        }
    }

    /// Steps of roll, then of pitch, forth and back; a torque from outside that stays.
    fn manoeuvres(&mut self, steps: usize) {
        for step in 0..steps {
            let axis = step / 200 % 2;
            let phase = step % 200;
            // a fifth of a second forth, a fifth back: at rest after it
            let push_rad_s2 = match phase {
                0..40 => 15.0,
                40..80 => -15.0,
                _ => 0.0,
            };
            let (mut told_nm, mut reference_rad_s) = ([0.0; AXES], [0.0; AXES]);
            told_nm[axis] = MODEL_KG_M2 * push_rad_s2;
            reference_rad_s[axis] = 15.0 * STEP_S * phase.min(80usize.saturating_sub(phase)) as f32;
            self.step(told_nm, 0.02, reference_rad_s, true);
        }
    }
}

fn holds(learnt: &Learnt, gain: [f32; AXES], lag_s: f32) -> bool {
    let gains = learnt.gain.iter().zip(gain);
    learnt.lag_s.holds(lag_s) && gains.into_iter().all(|(range, gain)| range.is_some_and(|range| range.holds(gain)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Gain and lag are found within 5 % (a short lag within 2 ms), whatever they are, under a torque that nobody knows
    /// and with a bad gyro's noise.
    #[test]
    fn gain_and_lag_are_found(
        roll in 0.5f32..1.8,
        pitch in 0.5f32..1.8,
        lag_s in 0.008f32..0.09,
        noise_rad_s in 0.0f32..0.01,
    ) {
        let mut flight = Flight::new([roll, pitch], lag_s, noise_rad_s);
        flight.manoeuvres(800);
        let learnt = flight.learning.learnt().unwrap();
        prop_assert!(holds(&learnt, [roll, pitch], lag_s), "{learnt:?}");
        prop_assert!((learnt.lag_s.best - lag_s).abs() < 0.002f32.max(0.05 * lag_s), "{learnt:?}");
        for (range, gain) in learnt.gain.iter().zip([roll, pitch]) {
            prop_assert!((range.unwrap().best / gain - 1.0).abs() < 0.05, "{learnt:?}");
        }
    }
}

/// Whatever the motors do while the reference rests: nothing is learnt, and nothing that was learnt is forgotten.
#[test]
fn hover_teaches_nothing() {
    let mut flight = Flight::new([0.7, 1.4], 0.045, 0.003);
    for step in 0..4000u16 {
        let torque_nm = if step % 7 < 3 { 0.05 } else { -0.04 };
        flight.step([torque_nm; AXES], -0.03, [0.0; AXES], true);
    }
    assert_eq!(flight.learning.learnt(), None);
    flight.manoeuvres(800);
    // what the last manoeuvre leaves
    for _ in 0..100 {
        flight.step([0.0; AXES], 0.02, [0.0; AXES], true);
    }
    let before = flight.learning.learnt().unwrap();
    for step in 0..4000u16 {
        let torque_nm = if step % 7 < 3 { 0.05 } else { -0.04 };
        flight.step([torque_nm; AXES], -0.03, [0.0; AXES], true);
    }
    assert_eq!(flight.learning.learnt(), Some(before));
}

/// An axis that was not moved has no gain, and the other one tells the lag.
#[test]
fn an_axis_at_rest_is_not_spoken_of() {
    let mut flight = Flight::new([0.7, 1.4], 0.045, 0.002);
    for step in 0..200usize {
        let push = if step < 40 { 15.0 } else if step < 80 { -15.0 } else { 0.0 };
        let reference_rad_s = 15.0 * STEP_S * step.min(80usize.saturating_sub(step)) as f32;
        // what the filters take to settle comes first
        if step == 0 {
            flight.learning.rest(&flight.config);
            for _ in 0..300 {
                flight.step([0.0; AXES], 0.0, [0.0; AXES], true);
            }
        }
        flight.step([MODEL_KG_M2 * push, 0.0], 0.0, [reference_rad_s, 0.0], true);
    }
    let learnt = flight.learning.learnt().unwrap();
    assert!((learnt.lag_s.best - 0.045).abs() < 0.003, "{learnt:?}");
    assert!((learnt.gain[0].unwrap().best - 0.7).abs() < 0.03, "{learnt:?}");
    assert!(learnt.gain[1].is_none_or(|gain| gain.half_width_share().abs() > 0.2), "{learnt:?}");
}

/// A gyro that went blind in between costs time only.
#[test]
fn what_was_not_seen_does_not_count() {
    let mut flight = Flight::new([0.7, 1.4], 0.045, 0.002);
    flight.manoeuvres(800);
    let before = flight.learning;
    for _ in 0..50 {
        flight.step([0.1; AXES], 0.0, [3.0, -3.0], false);
    }
    flight.manoeuvres(150);
    assert_eq!(flight.learning.learnt(), before.learnt());
    flight.manoeuvres(1600);
    assert!(holds(&flight.learning.learnt().unwrap(), [0.7, 1.4], 0.045), "{:?}", flight.learning.learnt());
}
