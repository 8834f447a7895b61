//! What the core remembers between steps.

use super::coasting::Coasting;
use super::output::TorqueSource;
use crate::attitude::angle::{AngleState, RateTarget};
use crate::attitude::rate::RateState;
use crate::frames::{EulerAngles, q_world_from_euler};
use crate::learning::LearningState;
use crate::learning::adoption::LearntModel;
use crate::learning::lesson::Lesson;
use crate::mixer::MixResult;
use crate::motor_loss::{MotorLoss, Stage};
use crate::record::state_words::{STATE_WORDS, StateWords};
use crate::sensing::estimator::EstimatorState;
use crate::sensing::imu_select::ImuPairState;
use crate::signals::{Plan, PlanReport, Setpoint, StepInput, Wrench};
use crate::supervisor::Arming;
use crate::supervisor::battery_watch::BatteryWatch;
use crate::supervisor::flight_watch::FlightWatch;
use crate::supervisor::throttle::Handover;
use crate::supervisor::touchdown::Touchdown;
use crate::torque_observer::ObserverState;

/// All that the core remembers between steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Steps made.
    pub step: u32,
    pub(super) imus: ImuPairState,
    pub(super) estimator: EstimatorState,
    pub(super) arming: Arming,
    pub(super) setpoint: SetpointState,
    pub(super) angle: AngleState,
    pub(super) rate: RateState,
    pub(super) rate_target: RateTarget,
    pub(super) observer: ObserverState,
    pub(super) planning: PlanningState,
    pub(super) watch: FlightWatch,
    pub(super) touchdown: Touchdown,
    pub(super) coasting: Coasting,
    /// A battery was connected at some time since start.
    pub(super) battery_seen: bool,
    pub(super) battery: BatteryWatch,
    pub(super) last_wrench: Wrench,
    pub(super) last_mix: MixResult,
    pub(super) last_source: TorqueSource,
    pub(super) motor_loss: MotorLoss,
    pub(super) learning: LearningState,
    /// How often what was learnt was taken, and after which step the last lesson was.
    pub(super) taught: [u32; 2],
    /// The model that flies, where it was learnt.
    pub(super) learnt_model: Option<LearntModel>,
    /// Exchanges of the configuration since start.
    pub(super) exchanges: u32,
}

impl State {
    /// All of it as words, of which every target makes the same.
    pub fn words(&self) -> [u32; STATE_WORDS] {
        let mut words = StateWords::EMPTY;
        self.record(&mut words);
        words.words
    }

    pub(super) fn record(&self, words: &mut StateWords) {
        let Self {
            step,
            imus,
            estimator,
            arming,
            setpoint,
            angle,
            rate,
            rate_target,
            observer,
            planning,
            watch,
            touchdown,
            coasting,
            battery_seen,
            battery,
            last_wrench: Wrench { lift_per_motor_n, torque_body_nm },
            last_mix,
            last_source,
            motor_loss,
            learning,
            taught,
            learnt_model,
            exchanges,
        } = self;
        words.word(*step);
        imus.record(words);
        estimator.record(words);
        arming.record(words);
        setpoint.record(words);
        angle.record(words);
        rate.record(words);
        rate_target.record(words);
        observer.record(words);
        planning.record(words);
        watch.record(words);
        touchdown.record(words);
        coasting.record(words);
        words.word(u32::from(*battery_seen));
        battery.record(words);
        words.number(*lift_per_motor_n);
        words.numbers(torque_body_nm);
        last_mix.record(words);
        words.word(last_source.number());
        motor_loss.record(words);
        learning.record(words);
        taught.iter().for_each(|word| words.word(*word));
        let LearntModel { gain, lag_s } = learnt_model.unwrap_or(LearntModel { gain: [0.0; 2], lag_s: 0.0 });
        words.word(u32::from(learnt_model.is_some()));
        words.numbers(&gain);
        words.number(lag_s);
        words.word(*exchanges);
    }

    /// How often another configuration was taken since start.
    pub fn exchanges(&self) -> u32 {
        self.exchanges
    }

    /// Whether a motor is lost.
    pub fn motor_loss(&self) -> Stage {
        self.motor_loss.stage()
    }

    /// What idle time is to be given of what is learnt of the vehicle.
    pub fn lesson(&self) -> Lesson {
        self.learning.lesson(self.step)
    }

    /// How often what was learnt was taken since start, and after which step the last lesson was.
    pub fn taught(&self) -> [u32; 2] {
        self.taught
    }

    /// What the controllers follow: the set-point that was demanded, or what stands in for it without a link.
    pub fn flown_setpoint(&self) -> Setpoint {
        self.setpoint.flown
    }

    /// The attitude is known to be another one, level in heading. For tests that begin in the middle of something.
    pub fn set_attitude(&mut self, roll_rad: f32, pitch_rad: f32) {
        let angles = EulerAngles { roll_rad, pitch_rad, yaw_rad: 0.0 };
        self.estimator.set_attitude(q_world_from_euler(angles));
    }

    /// The shaped reference, rad (roll, pitch, yaw).
    pub fn shaped_reference_rad(&self) -> [f32; 3] {
        self.angle.reference.map(|axis| axis.angle_rad)
    }

    /// Moves the rate loop's integrals (body axes, rad/s^2). For a replay of another controller's log: an integral
    /// collects what noise the log does not hold, and nothing else brings it back.
    pub fn shift_rate_integral(&mut self, by_rad_s2: [f32; 3]) {
        self.rate.shift_integral(by_rad_s2);
    }

    /// Estimated disturbance torque, N m (roll, pitch, heading).
    pub fn disturbance_nm(&self) -> [f32; 3] {
        self.observer.disturbance_nm()
    }
}

/// The set-point that is flown, and what came instead of one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SetpointState {
    /// What the controllers follow.
    pub(super) flown: Setpoint,
    /// The last one made of finite numbers, and when.
    pub(super) good: Setpoint,
    good_us: u64,
    /// Steps whose set-point was not.
    pub(super) rejected: u32,
    handover: Handover,
}

impl SetpointState {
    fn record(&self, words: &mut StateWords) {
        let Self { flown, good, good_us, rejected, handover: Handover { pending, ceiling } } = self;
        flown.record(words);
        good.record(words);
        words.time_us(*good_us);
        words.word(*rejected);
        words.word(u32::from(*pending));
        words.number(*ceiling);
    }

    /// What is flown now.
    pub(super) fn fly(&mut self, sink_throttle: f32, arming: Arming, time_us: u64, step_s: f32) {
        self.flown = self.handover.setpoint(sink_throttle, arming, (&self.good, &self.flown), time_us, step_s);
    }

    /// Keeps the last good one while what comes is no number. Returns the good one's age, µs.
    pub(super) fn take(&mut self, input: &StepInput) -> u64 {
        if input.setpoint.is_finite() {
            (self.good, self.good_us) = (input.setpoint, input.time_us);
        } else {
            self.rejected = self.rejected.saturating_add(1);
        }
        input.time_us.saturating_sub(self.good_us)
    }
}

/// What is remembered of the plans.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PlanningState {
    /// The last step requested a plan.
    pub(super) asked: bool,
    fallbacks: u32,
    deadline_misses: u32,
}

impl PlanningState {
    pub(super) fn record(&self, words: &mut StateWords) {
        let Self { asked, fallbacks, deadline_misses } = self;
        words.word(u32::from(*asked));
        words.word(*fallbacks);
        words.word(*deadline_misses);
    }

    /// Counts a step: the plan that came in time for it, if any, and who made its torque.
    pub(super) fn report(&mut self, plan: Option<&Plan>, source: TorqueSource) -> PlanReport {
        let is_fallback = matches!(source, TorqueSource::CascadeNoPlan | TorqueSource::CascadeUnsolved(_));
        self.fallbacks = self.fallbacks.saturating_add(u32::from(is_fallback));
        self.deadline_misses = self.deadline_misses.saturating_add(u32::from(self.asked && plan.is_none()));
        PlanReport {
            status: plan.map(|plan| plan.status),
            iterations: plan.map_or(0, |plan| plan.iterations),
            duration_us: plan.map_or(0, |plan| plan.duration_us),
            fallbacks: self.fallbacks,
            deadline_misses: self.deadline_misses,
        }
    }
}
