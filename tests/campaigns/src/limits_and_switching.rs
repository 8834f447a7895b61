//! Flights through large steps of roll and pitch, and what of them is worth a table.

use std::fmt::{self, Display, Formatter};

use shared_control::config::Controller;
use sil_host::controller_file::{ControllerChoice, TuningChange};
use sil_host::flight::{FlightSetup, RunSummary};
use sil_host::metrics::AxisMetrics;
use sil_host::model::VehicleModel;
use sil_host::scenario::{Scenario, Waypoint};

/// Time between set-points, s.
const SEGMENT_S: f64 = 1.75;

/// Level first, then one position (roll, pitch), degrees, after the other.
pub fn route(positions_deg: &[(f64, f64)], throttle: Option<f64>) -> Scenario {
    let all: Vec<_> = [(0.0, 0.0)].iter().chain(positions_deg).copied().collect();
    let waypoints = all.iter().enumerate().map(|(index, (roll_deg, pitch_deg))| Waypoint {
        roll_rad: roll_deg.to_radians(),
        pitch_rad: pitch_deg.to_radians(),
        throttle,
        ..Waypoint::level(index as f64 * SEGMENT_S)
    });
    Scenario { name: "steps".into(), duration_s: all.len() as f64 * SEGMENT_S, waypoints: waypoints.collect() }
}

/// Means over flights that differ in the sensors' noise; arrays are roll, pitch. Not a number where a figure does not
/// exist in each of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flown {
    /// Root mean square of the error against the raw reference.
    pub rms_deg: [f64; 2],
    /// Overshoot in % of a step.
    pub overshoot_pct: [f64; 2],
    /// Time until the error stays within 3 degrees.
    pub settling_s: [f64; 2],
    /// Error before the next step.
    pub steady_deg: [f64; 2],
    /// RMS distance from the straight way between two set-points, in the plane of roll and pitch.
    pub aside_deg: f64,
    /// Mean |command - base|.
    pub effort: f64,
    /// Samples with a motor at a limit.
    pub saturated_pct: f64,
    /// Mean change of the motors' mean lift (in equilibrium) from what the throttle requests.
    pub lift_changed_pct: f64,
    /// Steps that the cascade flew.
    pub fallbacks: f64,
}

impl Flown {
    /// Flies a scenario with the MPC, once for each seed.
    pub fn mean(model: &VehicleModel, tuning: TuningChange, scenario: &Scenario, seeds: u64) -> Self {
        let mut mean = Self::default();
        for seed in 0..seeds {
            let setup = FlightSetup {
                model: model.clone(),
                controller_model: None,
                choice: ControllerChoice { tuning, ..ControllerChoice::nominal(Controller::Mpc) },
                scenario: scenario.clone(),
                seed,
            };
            mean.add(&setup, 1.0 / seeds as f64);
        }
        mean
    }

    fn add(&mut self, setup: &FlightSetup, share: f64) {
        let flight = setup.fly().expect("a configuration that flies");
        let RunSummary { axes, effort, saturated_pct, mpc, .. } = flight.summary;
        for (axis, metrics) in [axes.roll, axes.pitch].iter().enumerate() {
            let AxisMetrics { overshoot_pct, settling_time_s, steady_error_deg, rms_error_deg, .. } = *metrics;
            self.rms_deg[axis] += share * rms_error_deg;
            self.overshoot_pct[axis] += share * overshoot_pct.unwrap_or(f64::NAN);
            self.settling_s[axis] += share * settling_time_s.unwrap_or(f64::NAN);
            self.steady_deg[axis] += share * steady_error_deg.unwrap_or(f64::NAN);
        }
        self.aside_deg += share * aside_deg(&flight.record.reference_rad, &flight.record.angle_rad);
        self.effort += share * effort;
        self.saturated_pct += share * saturated_pct;
        self.lift_changed_pct += share * lift_changed_pct(&setup.model, &setup.scenario, &flight.record.commands);
        self.fallbacks += share * f64::from(mpc.expect("an MPC flew").fallbacks);
    }

    /// Head of a table whose rows are flights.
    pub const TABLE_HEAD: &str = "| | RMS, deg | overshoot, % | settling, s | steady error, deg | aside, deg | effort \
        | at a limit, % | lift changed, % | fallbacks |\n\
        |---|---|---|---|---|---|---|---|---|---|";
}

/// The cells of its row.
impl Display for Flown {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let number = |value: f64, decimals: usize| {
            if value.is_finite() { format!("{value:.decimals$}") } else { "-".into() }
        };
        let both =
            |[roll, pitch]: [f64; 2], decimals| format!("{} / {}", number(roll, decimals), number(pitch, decimals));
        write!(
            f,
            "{} | {} | {} | {} | {:.1} | {:.3} | {:.0} | {:.1} | {:.0} |",
            both(self.rms_deg, 2),
            both(self.overshoot_pct, 1),
            both(self.settling_s, 2),
            both(self.steady_deg, 2),
            self.aside_deg,
            self.effort,
            self.saturated_pct,
            self.lift_changed_pct,
            self.fallbacks
        )
    }
}

fn aside_deg(reference_rad: &[[f64; 2]], angle_rad: &[[f64; 3]]) -> f64 {
    let (mut from, mut to, mut sum) = (reference_rad[0], reference_rad[0], 0.0);
    for (reference, angle) in reference_rad.iter().zip(angle_rad) {
        if *reference != to {
            (from, to) = (to, *reference);
        }
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
        let beside = (angle[0] - from[0]) * way[1] - (angle[1] - from[1]) * way[0];
        if length > 0.0 {
            sum += (beside / length) * (beside / length);
        }
    }
    (sum / reference_rad.len() as f64).sqrt().to_degrees()
}

fn lift_changed_pct(model: &VehicleModel, scenario: &Scenario, commands: &[[f64; 4]]) -> f64 {
    let lift_n = |command: f64| model.propulsion.equilibrium(command).lift_n;
    let asked_n = lift_n(scenario.waypoints[0].throttle.unwrap_or(model.base_command));
    let mean_n = |motors: &[f64; 4]| motors.iter().map(|command| lift_n(*command)).sum::<f64>() / 4.0;
    let changes = commands.iter().map(|motors| (mean_n(motors) / asked_n - 1.0).abs());
    100.0 * changes.sum::<f64>() / commands.len() as f64
}
