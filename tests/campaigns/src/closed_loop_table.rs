//! The page docs/closed-loop.md: the figures of the closed loop under each effect of the catalogue, every one in the
//! size of its example.

use std::fmt::Write;

use rayon::prelude::*;
use shared_control::config::Controller;
use sil_host::controller_file::ControllerChoice;
use sil_host::effects::Effect;
use sil_host::flight::{FlightSetup, RunSummary};
use sil_host::metrics::AxisMetrics;
use sil_host::model::{Rig, VehicleModel};
use sil_host::scenario::Scenario;

/// Where the page is.
pub const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/closed-loop.md");
/// Seed of every flight.
const SEED: u64 = 1;
const RATE_HZ: u32 = 400;
const SLOW_RATE_HZ: u32 = 100;
/// Effects under which the slow rate is flown too, which is late itself.
const LATE: [&str; 2] = ["actuation_delay", "motor_lag"];

const HEAD: &str = "# The closed loop under each effect

Written by `cargo run --release -p campaigns --bin closed_loop_table -- --write`, checked in CI: do not edit.

The thesis' test sequence, 30 s, with default tuning and the same noise, once without an effect and once with each
effect of the catalogue in the size of its example; at 100 Hz too where an effect comes late, as that rate does. The
controllers take the vehicle for nominal. Roll / pitch, means over the steps of an axis, errors of the true angle
against the raw reference; *settling* is the time until the error stays within 3 degrees, and - where a step never does;
*effort* is the mean |command - base|; *fallbacks* are steps that the cascade flew in the MPC's place.
";

const TABLE_HEAD: &str =
    "| effect | controller | overshoot, % | settling, s | steady error, deg | RMS, deg | effort | fallbacks |
|---|---|---|---|---|---|---|---|
";

/// The page as the code makes it.
pub fn page() -> String {
    let rigs =
        [("On the gimbal", Rig::Gimbal, true), ("In free flight, what has no meaning on the gimbal", Rig::Free, false)];
    let tables = rigs.map(|(title, rig, is_complete)| {
        let asked = Effect::CATALOGUE
            .iter()
            .filter(|entry| entry.rigs.contains(&rig) && (is_complete || !entry.rigs.contains(&Rig::Gimbal)));
        let flights: Vec<Row> =
            std::iter::once(None).chain(asked.map(|entry| Some((entry.name, entry.example)))).flat_map(rows).collect();
        let lines: Vec<String> = flights.par_iter().map(|row| row.line(rig)).collect();
        format!("\n## {title}\n\n{TABLE_HEAD}{}", lines.concat())
    });
    HEAD.to_owned() + &tables.concat()
}

/// A flight.
struct Row {
    effect: Option<&'static str>,
    controller: Controller,
    rate_hz: u32,
}

fn rows(effect: Option<(&'static str, &'static str)>) -> Vec<Row> {
    let both = effect.is_none_or(|(name, _)| LATE.contains(&name));
    let rates = if both { &[RATE_HZ, SLOW_RATE_HZ][..] } else { &[RATE_HZ] };
    let controllers = [Controller::Cascade, Controller::Mpc];
    let all = rates.iter().flat_map(|rate_hz| controllers.map(|controller| (controller, *rate_hz)));
    all.map(|(controller, rate_hz)| Row { effect: effect.map(|(_, text)| text), controller, rate_hz }).collect()
}

impl Row {
    fn line(&self, rig: Rig) -> String {
        let effects = self.effect.map(|text| Effect::parse(text, rig).expect("an example of the catalogue"));
        let setup = FlightSetup {
            model: VehicleModel { effects: effects.into_iter().collect(), ..VehicleModel::nominal(rig) },
            controller_model: None,
            choice: ControllerChoice { rate_hz: self.rate_hz, ..ControllerChoice::nominal(self.controller) },
            scenario: Scenario::test_sequence(),
            seed: SEED,
        };
        let RunSummary { axes, effort, mpc, controller, .. } = setup.fly().expect("a nominal controller").summary;
        let both = |decimals: usize, figure: fn(&AxisMetrics) -> Option<f64>| {
            let cell = |axis: &AxisMetrics| figure(axis).map_or("-".to_owned(), |value| format!("{value:.decimals$}"));
            format!("{} / {}", cell(&axes.roll), cell(&axes.pitch))
        };
        let effect = self.effect.map_or("none".to_owned(), |text| format!("`{text}`"));
        let mut line = format!("| {effect} | {controller} at {} Hz |", self.rate_hz);
        for cell in [
            both(1, |axis| axis.overshoot_pct),
            both(2, |axis| axis.settling_time_s),
            both(2, |axis| axis.steady_error_deg),
            both(2, |axis| Some(axis.rms_error_deg)),
            format!("{effort:.3}"),
            mpc.map_or("-".to_owned(), |mpc| mpc.fallbacks.to_string()),
        ] {
            let _ = write!(line, " {cell} |");
        }
        line + "\n"
    }
}
