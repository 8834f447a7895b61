//! What a flight teaches comes into use, with the firmware's parts and by its rules.

use std::mem;

use mavlink::dialects::common::MavSeverity;
use shared_control::flight_core::FlightCore;
use shared_control::params::Params;
use shared_control::setup::Setup;

use super::SimulatedBoard;
use crate::cosim::idle_learning::{IdleLearning, Prepared, TunedBy};

/// What idle time makes of lessons.
pub(super) struct Learner {
    idle: IdleLearning,
    prepared: Option<Prepared>,
    /// Looks of which nobody has been told yet begin here.
    told: usize,
}

impl Learner {
    /// For parameters that have come into use; none where they let nothing be learnt.
    pub(super) fn new(params: &Params, setup: &Setup) -> Option<Self> {
        let idle = IdleLearning::new(setup.vehicle, TunedBy::Parameters(*params));
        setup.config.learning.is_some().then_some(Self { idle, prepared: None, told: 0 })
    }
}

impl SimulatedBoard {
    /// Before a step: takes what has been prepared.
    pub(super) fn learn(&mut self, time_us: u64) {
        let Some(learner) = &mut self.learner else { return };
        let Some(Prepared { taught, planner, .. }) = learner.prepared.take_if(|prepared| prepared.at_us <= time_us)
        else {
            return;
        };
        FlightCore::learn(&mut self.setup.config, &mut self.state, &taught);
        if let Some(flying) = &mut self.planner {
            flying.take_over(planner);
        }
        let words = learner.idle.flown().to_string();
        self.telemetry.text(MavSeverity::MAV_SEVERITY_INFO, &words);
    }

    /// After a step: looks at what was learnt, and says once why something may not fly.
    pub(super) fn work_in_idle_time(&mut self, time_us: u64) {
        let Some(learner) = &mut self.learner else { return };
        if let Some(prepared) = learner.idle.work(&self.setup.config, &self.state, time_us) {
            learner.prepared = Some(prepared);
        }
        let looks = learner.idle.looks();
        let reason = |at: usize| looks.get(at).and_then(|look| look.refusal.as_ref());
        if let Some(refusal) = reason(learner.told) {
            let before = learner.told.checked_sub(1).and_then(reason);
            if before.map(mem::discriminant) != Some(mem::discriminant(refusal)) {
                self.telemetry.text(MavSeverity::MAV_SEVERITY_INFO, &refusal.to_string());
            }
        }
        learner.told = looks.len();
    }
}
