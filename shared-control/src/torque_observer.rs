//! What turns the vehicle and is not measured: the motors' torque and the disturbance, per Euler axis (roll, pitch,
//! heading), and with them the state at the time at which the next plan will act.
//!
//! A Luenberger observer on rate and disturbance torque. Its input is what the mixer delivered, not what was requested,
//! on its way through the actuation's delay and the motors' lag ([`crate::lagged_axis`]); so it cannot wind up. From
//! step to step
//!
//! ```text
//!   rate        <- rate predicted + l1 (measured - predicted)            l1 = 1 - p^2
//!   disturbance <- disturbance + l2 J/dt (measured - predicted)          l2 = (1 - p)^2
//! ```
//! puts both poles of the error at p = exp(-bandwidth dt): the observer is as fast as the bandwidth says, and does not
//! overshoot. These are the steady gains of the Kalman filter for a torque that walks at random (an alpha-beta filter),
//! but for its damping. Where the tuning says so, an error that noise does not explain raises the gains for a while
//! ([`alert`]). It runs whoever flies, so that the controller can change without a jump.
//!
//! A gyro that is late (its low-pass, notches) is a delay of the actuation to whoever sees nothing else: state and
//! prediction are then those of the time at which the rate was true.

pub mod alert;

use alert::{AlertRule, AlertState, Gains};

use crate::elementary::{exp, limit};
use crate::lagged_axis::{AxisMotion, LagStep};
use crate::record::state_words::StateWords;
use crate::vehicle::Actuation;

/// Most control steps that a delay of the actuation may last.
pub const DELAY_STEPS_MAX: usize = 16;

/// Delivered torques that are kept: with a delay of n steps and a bit, n + 2 act between now and the next plan.
const TORQUES_KEPT: usize = DELAY_STEPS_MAX + 2;

/// When the observer raises its gains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DisturbanceAlert {
    /// Never: one bandwidth.
    #[default]
    Never,
    /// When the error of the rate is significant.
    Significant,
    /// As often as it may, whatever the error: the state in which margins are measured.
    Always,
}

/// What a loop asks of the observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// How fast a disturbance is found in calm, rad/s; 0 for no estimate.
    pub bandwidth_rad_s: f32,
    /// When it is to be found faster.
    pub alert: DisturbanceAlert,
    /// Control step, s.
    pub step_s: f32,
}

/// The observer, made once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserverConfig {
    /// Roll, pitch, heading.
    axes: [AxisConfig; 3],
    /// Whole control steps in the delay.
    delay_steps: usize,
    whole_step: LagStep,
    /// The part of a step that the delay has beyond whole steps, and the rest of that step.
    late_part: LagStep,
    rest: LagStep,
    alert: AlertRule,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct AxisConfig {
    inertia_kg_m2: f32,
    disturbance_max_nm: f32,
}

/// What it remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObserverState {
    /// Roll, pitch, heading.
    axes: [AxisState; 3],
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct AxisState {
    rate_rad_s: f32,
    motor_nm: f32,
    disturbance_nm: f32,
    alert: AlertState,
    /// In the last steps, the latest first.
    delivered_nm: [f32; TORQUES_KEPT],
}

impl ObserverConfig {
    /// For a vehicle and a loop; arrays are roll, pitch, heading. With a bandwidth of zero there is no estimate: the
    /// disturbance stays zero. None if the delay is longer than [`DELAY_STEPS_MAX`] steps.
    pub fn new(
        inertia_kg_m2: [f32; 3],
        disturbance_max_nm: [f32; 3],
        actuation: &Actuation,
        Pace { bandwidth_rad_s, alert, step_s }: Pace,
    ) -> Option<Self> {
        let steps = actuation.delay_s / step_s;
        if !(0.0..=DELAY_STEPS_MAX as f32).contains(&steps) {
            return None;
        }
        let delay_steps = steps as usize;
        let late_s = limit(actuation.delay_s - delay_steps as f32 * step_s, 0.0, step_s);
        let calm = Gains::of_double_pole(exp(-bandwidth_rad_s * step_s), step_s);
        let mut axes = inertia_kg_m2.map(|inertia_kg_m2| AxisConfig { inertia_kg_m2, disturbance_max_nm: 0.0 });
        for (axis, max_nm) in axes.iter_mut().zip(disturbance_max_nm) {
            axis.disturbance_max_nm = max_nm;
        }
        Some(Self {
            axes,
            delay_steps,
            whole_step: LagStep::new(step_s, actuation.lag_s),
            late_part: LagStep::new(late_s, actuation.lag_s),
            rest: LagStep::new(step_s - late_s, actuation.lag_s),
            alert: AlertRule::new(alert, calm, step_s),
        })
    }
}

impl ObserverState {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { axes } = self;
        for AxisState { rate_rad_s, motor_nm, disturbance_nm, alert, delivered_nm } in axes {
            words.numbers(&[*rate_rad_s, *motor_nm, *disturbance_nm]);
            alert.record(words);
            words.numbers(delivered_nm);
        }
    }

    /// Where nothing is known but the rates: the motors stand still.
    pub fn at(rate_rad_s: [f32; 3]) -> Self {
        Self { axes: rate_rad_s.map(|rate_rad_s| AxisState { rate_rad_s, ..AxisState::default() }) }
    }

    /// Estimated disturbance torque, N m (roll, pitch, heading).
    pub fn disturbance_nm(&self) -> [f32; 3] {
        self.axes.map(|axis| axis.disturbance_nm)
    }

    /// Whether the gains are raised (roll, pitch, heading).
    pub fn is_alert(&self, config: &ObserverConfig) -> [bool; 3] {
        self.axes.map(|axis| config.alert.is_alert(&axis.alert))
    }

    /// Rates where it has brought them, rad/s (roll, pitch, heading).
    pub fn rate_rad_s(&self) -> [f32; 3] {
        self.axes.map(|axis| axis.rate_rad_s)
    }

    /// One control step on, with the rates measured now (roll, pitch, heading, rad/s) and the torques that are
    /// delivered from now to the next step, N m; `known_nm` is the torque from outside that needs no estimate, such as
    /// gravity's on a mass off the axes. A rate that is no number says nothing: then only the model goes on.
    pub fn update(
        &mut self,
        config: &ObserverConfig,
        rate_rad_s: [f32; 3],
        delivered_nm: [f32; 3],
        known_nm: [f32; 3],
    ) {
        let inputs = rate_rad_s.into_iter().zip(delivered_nm).zip(known_nm);
        for ((axis, axis_config), ((rate_rad_s, delivered_nm), known_nm)) in
            self.axes.iter_mut().zip(&config.axes).zip(inputs)
        {
            axis.update(config, axis_config, rate_rad_s, known_nm);
            axis.push(if delivered_nm.is_finite() { delivered_nm } else { 0.0 });
        }
    }

    /// Where the axes are when a plan that is requested now begins to act: one step and the delay from now, by the
    /// torques that are under way, the disturbance and the known torque. `angle_rad` and `rate_rad_s` are those of now.
    pub fn at_next_plan(
        &self,
        config: &ObserverConfig,
        angle_rad: [f32; 3],
        rate_rad_s: [f32; 3],
        known_nm: [f32; 3],
    ) -> [AxisMotion; 3] {
        let mut motions = [AxisMotion::default(); 3];
        let now = angle_rad.into_iter().zip(rate_rad_s).zip(known_nm);
        let axes = self.axes.iter().zip(&config.axes).zip(now);
        for (motion, ((axis, axis_config), ((angle_rad, rate_rad_s), known_nm))) in motions.iter_mut().zip(axes) {
            let now = AxisMotion { angle_rad, rate_rad_s, motor_nm: axis.motor_nm };
            *motion = axis.at_next_plan(config, axis_config, &now, known_nm);
        }
        motions
    }
}

impl AxisState {
    fn update(&mut self, config: &ObserverConfig, axis: &AxisConfig, measured_rad_s: f32, known_nm: f32) {
        let outside_nm = self.disturbance_nm + known_nm;
        let last = AxisMotion { angle_rad: 0.0, rate_rad_s: self.rate_rad_s, motor_nm: self.motor_nm };
        let [early_nm, late_nm] = self.acting_nm(config.delay_steps);
        let middle = config.late_part.advance(&last, early_nm, outside_nm, axis.inertia_kg_m2);
        let predicted = config.rest.advance(&middle, late_nm, outside_nm, axis.inertia_kg_m2);
        self.motor_nm = predicted.motor_nm;
        self.rate_rad_s = predicted.rate_rad_s;
        let error_rad_s = measured_rad_s - predicted.rate_rad_s;
        if error_rad_s.is_finite() {
            let motor_rad_s = config.whole_step.duration_s / axis.inertia_kg_m2 * predicted.motor_nm;
            let gains = config.alert.gains(&mut self.alert, error_rad_s, motor_rad_s);
            let disturbance_nm = self.disturbance_nm + gains.acceleration_1_s * axis.inertia_kg_m2 * error_rad_s;
            self.disturbance_nm = limit(disturbance_nm, -axis.disturbance_max_nm, axis.disturbance_max_nm);
            self.rate_rad_s += gains.rate * error_rad_s;
        }
    }

    fn push(&mut self, mut torque_nm: f32) {
        for kept_nm in &mut self.delivered_nm {
            core::mem::swap(kept_nm, &mut torque_nm);
        }
    }

    /// Torques delivered `delay_steps` + 1 and `delay_steps` steps before the latest.
    fn acting_nm(&self, delay_steps: usize) -> [f32; 2] {
        [delay_steps + 1, delay_steps].map(|steps| self.delivered_nm.get(steps).copied().unwrap_or(0.0))
    }

    fn at_next_plan(&self, config: &ObserverConfig, axis: &AxisConfig, now: &AxisMotion, known_nm: f32) -> AxisMotion {
        let outside_nm = self.disturbance_nm + known_nm;
        let [first_nm, _] = self.acting_nm(config.delay_steps);
        let begun = config.late_part.advance(now, first_nm, outside_nm, axis.inertia_kg_m2);
        let under_way = self.delivered_nm.iter().take(config.delay_steps + 1).rev();
        under_way.fold(begun, |motion, torque_nm| {
            config.whole_step.advance(&motion, *torque_nm, outside_nm, axis.inertia_kg_m2)
        })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    const STEP_S: f32 = 0.0025;
    const INERTIA_KG_M2: f32 = 0.0115;

    fn observer(delay_s: f32, lag_s: f32, bandwidth_rad_s: f32) -> ObserverConfig {
        let actuation = Actuation { delay_s, lag_s };
        let pace = Pace { bandwidth_rad_s, alert: DisturbanceAlert::Never, step_s: STEP_S };
        ObserverConfig::new([INERTIA_KG_M2; 3], [0.2; 3], &actuation, pace).unwrap()
    }

    /// A body behind a delay, in slices of ten microseconds.
    #[derive(Clone)]
    struct Body {
        motion: AxisMotion,
        /// Per control step.
        demands_nm: std::vec::Vec<f32>,
        delay_slices: usize,
        slice: LagStep,
        slices_run: usize,
    }

    const SLICES_PER_STEP: usize = 250;

    impl Body {
        fn new(delay_slices: usize, lag_s: f32) -> Self {
            let slice = LagStep::new(STEP_S / SLICES_PER_STEP as f32, lag_s);
            Self { motion: AxisMotion::default(), demands_nm: std::vec::Vec::new(), delay_slices, slice, slices_run: 0 }
        }

        fn run(&mut self, slices: usize, disturbance_nm: f32) {
            for now in self.slices_run..self.slices_run + slices {
                let given = now.checked_sub(self.delay_slices).map(|then| self.demands_nm[then / SLICES_PER_STEP]);
                self.motion = self.slice.advance(&self.motion, given.unwrap_or(0.0), disturbance_nm, INERTIA_KG_M2);
            }
            self.slices_run += slices;
        }
    }

    proptest! {
        /// Whatever the delay and the lag: the prediction is where the body really is when the next plan acts.
        #[test]
        fn the_next_plan_acts_where_it_was_said(
            delay_slices in 0usize..4000,
            lag_s in prop_oneof![Just(0.0f32), 0.002f32..0.1],
            demands in proptest::collection::vec(-0.1f32..0.1, 60),
        ) {
            let delay_s = delay_slices as f32 / SLICES_PER_STEP as f32 * STEP_S;
            let config = observer(delay_s, lag_s, 0.0);
            let mut state = ObserverState::default();
            let mut body = Body::new(delay_slices, lag_s);
            for demand_nm in demands {
                let AxisMotion { angle_rad, rate_rad_s, .. } = body.motion;
                state.update(&config, [rate_rad_s; 3], [demand_nm; 3], [0.0; 3]);
                body.demands_nm.push(demand_nm);
                let mut later = body.clone();
                later.run(SLICES_PER_STEP + delay_slices, 0.0);
                let later = later.motion;
                for said in state.at_next_plan(&config, [angle_rad; 3], [rate_rad_s; 3], [0.0; 3]) {
                    // thousands of slices, each rounded
                    prop_assert!((said.rate_rad_s - later.rate_rad_s).abs() < 2e-4, "{said:?} {later:?}");
                    prop_assert!((said.angle_rad - later.angle_rad).abs() < 2e-5, "{said:?} {later:?}");
                    prop_assert!((said.motor_nm - later.motor_nm).abs() < 2e-5, "{said:?} {later:?}");
                }
                body.run(SLICES_PER_STEP, 0.0);
            }
        }

        /// Any numbers in, numbers within the bound out.
        #[test]
        fn bad_data_is_survived(rates in proptest::collection::vec(any::<f32>(), 50), torque in any::<f32>()) {
            let config = observer(0.004, 0.03, 30.0);
            let mut state = ObserverState::default();
            for rate in rates {
                state.update(&config, [rate; 3], [torque; 3], [0.0; 3]);
                prop_assert!(state.disturbance_nm().iter().all(|disturbance| disturbance.abs() <= 0.2));
            }
        }
    }

    /// A torque that sets in is found, on all axes alike, in the bandwidth's own time and without overshoot; lag and
    /// delay in between mislead nobody who knows them.
    #[test]
    fn a_disturbance_is_found_as_fast_as_the_bandwidth_says() {
        let config = observer(0.006, 0.03, 20.0);
        let mut state = ObserverState::default();
        let mut body = Body::new(600, 0.03);
        for step in 0..400u16 {
            // the motors do something all the while
            let demand_nm = if step / 40 % 2 == 0 { 0.05 } else { -0.05 };
            state.update(&config, [body.motion.rate_rad_s; 3], [demand_nm; 3], [0.0; 3]);
            let disturbance_nm = if step < 100 { 0.0 } else { 0.1 };
            body.demands_nm.push(demand_nm);
            body.run(SLICES_PER_STEP, disturbance_nm);
            // critically damped: 1 - (1 + w t) exp(-w t), to within what one sample more or less makes
            let since = 20.0 * STEP_S * (f32::from(step) - 100.0);
            let expected = if since <= 0.0 { 0.0 } else { 0.1 * (1.0 - (1.0 + since) * (-since).exp()) };
            for found in state.disturbance_nm() {
                assert!((found - expected).abs() < 0.003, "step {step}: {found} for {expected}");
            }
        }
    }

    /// Begun in the middle of a turn that nothing disturbs, it finds no disturbance.
    #[test]
    fn it_begins_at_the_rates_that_it_is_given() {
        let config = observer(0.0, 0.0, 20.0);
        let rate_rad_s = [1.0, -2.0, 0.5];
        let mut state = ObserverState::at(rate_rad_s);
        for _ in 0..100 {
            state.update(&config, rate_rad_s, [0.0; 3], [0.0; 3]);
            assert!(state.disturbance_nm().iter().all(|found_nm| found_nm.abs() < 1e-6), "{state:?}");
        }
    }

    /// What is estimated and what is known act alike until the next plan does.
    #[test]
    fn the_next_plan_begins_where_all_torques_from_outside_lead() {
        let config = observer(0.0, 0.0, 20.0);
        let mut state = ObserverState::default();
        let mut rate_rad_s = 0.0;
        for _ in 0..400 {
            state.update(&config, [rate_rad_s; 3], [0.0; 3], [0.0; 3]);
            rate_rad_s += 0.1 / INERTIA_KG_M2 * STEP_S;
        }
        assert!(state.disturbance_nm().iter().all(|found_nm| (found_nm - 0.1).abs() < 1e-3), "{state:?}");
        for known_nm in [-0.1, 0.0, 0.05] {
            for there in state.at_next_plan(&config, [0.3; 3], [0.2; 3], [known_nm; 3]) {
                let acceleration = (0.1 + known_nm) / INERTIA_KG_M2;
                assert!((there.rate_rad_s - (0.2 + acceleration * STEP_S)).abs() < 3e-4, "{there:?}");
                let angle_rad = 0.3 + 0.2 * STEP_S + 0.5 * acceleration * STEP_S * STEP_S;
                assert!((there.angle_rad - angle_rad).abs() < 1e-6, "{there:?}");
            }
        }
    }

    #[test]
    fn it_is_bounded_and_without_bandwidth_there_is_none() {
        for (bandwidth_rad_s, expected) in [(20.0, -0.2), (0.0, 0.0)] {
            let config = observer(0.0, 0.0, bandwidth_rad_s);
            let (mut state, mut body) = (ObserverState::default(), Body::new(0, 0.0));
            for _ in 0..400 {
                state.update(&config, [body.motion.rate_rad_s; 3], [0.0; 3], [0.0; 3]);
                body.demands_nm.push(0.0);
                body.run(SLICES_PER_STEP, -0.5);
            }
            assert_eq!(state.disturbance_nm(), [expected; 3]);
        }
    }

    #[test]
    fn a_delay_beyond_what_is_kept_is_refused() {
        let new = |delay_s| {
            let actuation = Actuation { delay_s, lag_s: 0.0 };
            let pace = Pace { bandwidth_rad_s: 10.0, alert: DisturbanceAlert::Never, step_s: STEP_S };
            ObserverConfig::new([1.0; 3], [1.0; 3], &actuation, pace)
        };
        assert!(new(0.04).is_some() && new(0.0401).is_none() && new(-0.001).is_none() && new(f32::NAN).is_none());
    }
}
