//! The thesis' case (sections 5.3.1 and 5.3.3) from the log to the better controller: the ring's centre of gravity is
//! off, the nominal simulation of the closed loop misses the measured pitch by eight degrees, and nobody knows why.
//!
//! ```text
//!   ring off balance --> logs of the thesis' MPC and of the cascade --> diagnosis --> extended model
//!                                                                         '--> closed loop, simulated against the log:
//!                                                                              before and after
//!   extended model --> what the controllers know --> flights of the same vehicle: tracking, before and after
//! ```

use std::fmt;

use shared_control::config::Controller;
use sil_host::controller_file::ControllerChoice;
use sil_host::diagnosis::{ClosedLoops, Diagnosis, Effort, Known, diagnose_flown_by, extended_model};
use sil_host::flight::{FlightSetup, RunSummary};
use sil_host::log::Log;
use sil_host::model::{Rig, VehicleModel};
use sil_host::scenario::Scenario;
use sil_host::synthesis::Synthesis;
use sil_host::thesis::{RING_MOMENT_NM, off_balance, thesis_mpc};

/// Seed of the logs.
const SEED: u64 = 1;

/// A log of the test sequence at the controller's rate, with noise.
pub fn log_of(model: VehicleModel, choice: ControllerChoice) -> Log {
    let synthesis = Synthesis { choice, log_rate_hz: choice.rate_hz, seed: SEED, blind: true, ..Synthesis::of(model) };
    synthesis.log().expect("a flight")
}

/// A log and what the diagnosis makes of it.
pub struct Diagnosed {
    /// What flew.
    pub controller: &'static str,
    /// The answer.
    pub answer: Diagnosis,
    /// Simulated against the log, before and after.
    pub closed_loop: ClosedLoops,
    /// The extended model.
    pub extended: VehicleModel,
}

impl Diagnosed {
    /// Diagnoses the log of a controller on the off-balance rig; the nominal model is all that is known.
    ///
    /// # Panics
    /// If the log can't be diagnosed.
    pub fn new(controller: &'static str, choice: ControllerChoice) -> Self {
        let nominal = VehicleModel::nominal(Rig::Gimbal);
        let log = log_of(off_balance(RING_MOMENT_NM), choice);
        let (known, effort) = (Known::default(), Effort::Quick);
        let answer = diagnose_flown_by(&log, &nominal, choice, &known, effort, &|_| ()).expect("a whole log");
        let closed_loop = answer.closed_loop.expect("a log with references");
        let extended = extended_model(&nominal, &answer).expect("effects of the gimbal");
        Self { controller, answer, closed_loop, extended }
    }
}

impl fmt::Display for Diagnosed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ClosedLoops { nominal, extended } = self.closed_loop;
        writeln!(
            f,
            "| {} | {:.2} | {:.2} | {:.2} | {:.2} |",
            self.controller,
            nominal.roll_mean_abs_deg,
            nominal.pitch_mean_abs_deg,
            extended.roll_mean_abs_deg,
            extended.pitch_mean_abs_deg
        )
    }
}

/// Tracking of one controller on the off-balance rig.
pub struct Tracking {
    /// What flew.
    pub controller: &'static str,
    /// It knew the nominal model.
    pub before: RunSummary,
    /// It knew the extended one.
    pub after: RunSummary,
}

impl Tracking {
    /// Flies the test sequence twice.
    ///
    /// # Panics
    /// If a controller can't fly.
    pub fn new(controller: &'static str, choice: ControllerChoice, extended: &VehicleModel) -> Self {
        let fly = |controller_model| {
            let setup = FlightSetup {
                model: off_balance(RING_MOMENT_NM),
                controller_model,
                choice,
                scenario: Scenario::test_sequence(),
                seed: SEED,
            };
            setup.fly().expect("a flight").summary
        };
        Self { controller, before: fly(None), after: fly(Some(extended.clone())) }
    }
}

impl fmt::Display for Tracking {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cells = [&self.before, &self.after].map(|run| {
            format!(
                "{:.2} | {:.2} | {:.2}",
                run.axes.roll.rms_error_deg,
                run.axes.pitch.rms_error_deg,
                run.axes.pitch.steady_error_deg.unwrap_or(f64::NAN)
            )
        });
        writeln!(f, "| {} | {} | {} |", self.controller, cells[0], cells[1])
    }
}

/// The three controllers of the tracking table: the thesis' MPC, the project's own (offset-free), the cascade.
pub fn controllers() -> [(&'static str, ControllerChoice); 3] {
    [
        ("the thesis' MPC", thesis_mpc().expect("a controller file")),
        ("offset-free MPC", ControllerChoice::nominal(Controller::Mpc)),
        ("cascade", ControllerChoice::nominal(Controller::Cascade)),
    ]
}
