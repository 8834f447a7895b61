//! The whole comparison: tuning on some draws, flights on others, tables.

use serde::Serialize;
use sil_host::model::Rig;

use super::contender::Contender;
use super::contenders::{self, Shaping};
use super::draw::{Draw, NOMINAL_LAG_S};
use super::front::{self, study::Budget};
use super::hover::{self, Hover, LeastMargins};
use super::stability::{Vehicle, eigenvalues, lift_gain, spectral_radius};
use super::statistics::median;
use super::table::{self, Result};
use super::weather::{WEATHERS, Weather};

/// Draws that decide.
pub const DRAWS: u64 = 200;
/// Draws on which controllers are tuned: other ones.
pub const TUNING_DRAWS: u64 = 50;
const TUNING_FIRST: u64 = 1000;
/// Values of the cost that the search of each controller may request.
pub const EVALUATIONS: usize = 40;
const SEARCH_SEED: u64 = 1;

/// Draws and evaluations of each controller in the scan of shapings.
const SCAN_DRAWS: u64 = 8;
const SCAN_EVALUATIONS: usize = 20;
/// Shapings of the scan: gain, 1/s, and acceleration share.
const SCAN: [(f64, f64); 4] = [(7.1, 1.76), (9.0, 1.6), (12.0, 1.4), (20.0, 1.0)];

/// Draws of the Pareto study: the first on which controllers are tuned.
const FRONT_DRAWS: u64 = 8;
/// Points of each controller in it: 67.
const FRONT_BUDGET: Budget = Budget { per_preference: 6, goals: 6, per_goal: 6 };
/// Draws whose margins are measured beside the flights of the chosen points.
const MARGIN_DRAWS: usize = 32;

/// How many of the contenders are flown in every weather: the three that were tuned, and the MPC without alerts.
const CONTENDERS_IN_WEATHER: usize = 4;

/// Lags beyond the model's own, s, and throttles of the table of spectral radii.
const LAGS_S: [f64; 6] = [0.0, 0.01, 0.02, 0.03, 0.04, 0.05];
const THROTTLES: [f64; 5] = [0.35, 0.425, 0.5, 0.6, 0.7];

/// The first draws of those that decide.
pub fn draws(count: u64) -> Vec<Draw> {
    (0..count).map(Draw::new).collect()
}

fn tuning_draws(count: u64) -> Vec<Draw> {
    (TUNING_FIRST..TUNING_FIRST + count).map(Draw::new).collect()
}

/// Tunes the controllers for RMS and overshoot, and gives their files: MPC, cascade, INDI.
pub fn tune() -> [String; 3] {
    let draws = tuning_draws(TUNING_DRAWS);
    let (mpc, cascade) = (contenders::mpc(&contenders::SHAPING), contenders::cascade(&contenders::SHAPING));
    let indi = contenders::indi(&contenders::SHAPING);
    let indi_found = indi.tune(&draws, EVALUATIONS, SEARCH_SEED);
    let mpc_found = mpc.tune(&draws, EVALUATIONS, SEARCH_SEED);
    let cascade_found = cascade.tune(&draws, EVALUATIONS, SEARCH_SEED);
    let commented = |file: String, cost: f64, first: f64| {
        format!(
            "# Tuned by `controller_comparison tune`: {EVALUATIONS} evaluations on {TUNING_DRAWS} draws took the cost \
             from {first:.3} to {cost:.3} degrees.\n{file}"
        )
    };
    [
        commented(mpc.file(&mpc_found.point), mpc_found.cost, mpc_found.history[0]),
        commented(cascade.file(&cascade_found.point), cascade_found.cost, cascade_found.history[0]),
        commented(indi.file(&indi_found.point), indi_found.cost, indi_found.history[0]),
    ]
}

/// Both controllers, tuned a little at several shapings of the reference.
pub fn scan() -> String {
    let draws = tuning_draws(SCAN_DRAWS);
    let header = ["shaping gain, 1/s", "acceleration share", "cost MPC, deg", "cost cascade, deg", "sum"];
    let mut text = table::row(header.map(Into::into)) + &table::rule(header.len() - 1);
    for (gain_1_s, acceleration_share) in SCAN {
        let shaping = Shaping { gain_1_s, acceleration_share };
        let mpc = contenders::mpc(&shaping).tune(&draws, SCAN_EVALUATIONS, SEARCH_SEED).cost;
        let cascade = contenders::cascade(&shaping).tune(&draws, SCAN_EVALUATIONS, SEARCH_SEED).cost;
        let costs = [mpc, cascade, mpc + cascade].map(|cost| format!("{cost:.3}"));
        text += &table::row([format!("{gain_1_s}"), format!("{acceleration_share}")].into_iter().chain(costs));
    }
    text
}

/// The Pareto study of MPC and cascade.
pub fn front(rig: Rig) -> front::Outcome {
    front::study(rig, &tuning_draws(FRONT_DRAWS), &FRONT_BUDGET)
}

/// The tables of the study.
pub fn front_report(outcome: &front::Outcome) -> String {
    let [mpc, cascade] = &outcome.rows;
    [
        format!("### The two fronts, on {FRONT_DRAWS} draws\n"),
        front::table::summary(&outcome.rows),
        "### The cascade's front\n".into(),
        front::table::front(cascade, "MPC"),
        "### The MPC's front\n".into(),
        front::table::front(mpc, "cascade"),
    ]
    .join("\n")
}

/// A few contenders, over draws that nobody has tuned on.
#[derive(Clone, Debug, Serialize)]
pub struct Shown {
    /// What they are called together.
    pub title: &'static str,
    /// Each in all weathers.
    pub results: Vec<Result>,
    /// Margins in calm of the first draws, of each.
    pub margins: Vec<Vec<LeastMargins>>,
}

/// The points that were chosen from the fronts, over this many draws.
pub fn chosen(count: u64) -> Shown {
    show("Chosen points", &contenders::tuned(), count, &WEATHERS[1..])
}

/// In free flight, those chosen from the fronts there and those that follow from the vehicle. The vibration's figures
/// are of the gimbal.
pub fn in_free_flight(count: u64) -> Shown {
    show("In free flight", &contenders::in_free_flight(), count, &[Weather::TorqueSteps, Weather::Gusts])
}

/// What ships, where nobody chooses anything: the two as they follow from the vehicle, on the gimbal and in free
/// flight, over the first `count` draws.
pub fn shipped(count: u64) -> [Shown; 2] {
    [("What ships, on the gimbal", Rig::Gimbal), ("What ships, in free flight", Rig::Free)]
        .map(|(title, rig)| show(title, &contenders::shipped(rig), count, &[Weather::TorqueSteps, Weather::Gusts]))
}

fn show(title: &'static str, contenders: &[Contender], count: u64, weathers: &[Weather]) -> Shown {
    let draws = draws(count);
    let margin_draws = &draws[..draws.len().min(MARGIN_DRAWS)];
    Shown {
        title,
        results: contenders.iter().map(|contender| result(contender, &draws, weathers)).collect(),
        margins: contenders.iter().map(|contender| hover::margins_all(contender, margin_draws)).collect(),
    }
}

/// Their tables.
pub fn shown_report(shown: &Shown) -> String {
    let Shown { title, results, margins } = shown;
    let count = |count: Option<usize>| count.unwrap_or(0);
    [
        format!(
            "### {title} over {} unseen draws: median / 95th percentile\n",
            count(results.first().map(|of| of.flights.len()))
        ),
        table::flights(results),
        "### Their differences with paired 95 % intervals\n".into(),
        table::differences(results),
        "### In weather\n".into(),
        table::weather(results),
        "### A torque step of 0.1 N m about roll on every drawn vehicle: median / 95th percentile\n".into(),
        table::pushes(results),
        format!(
            "### Margins in calm over {} draws, the worse of roll and pitch: median / worst twentieth\n",
            count(margins.first().map(Vec::len))
        ),
        table::margins(results.iter().map(|result| result.name).zip(margins)),
        "### At hover, nominal vehicle: roll / pitch\n".into(),
        table::hover(results.iter().map(|result| (result.name, &result.hover))),
    ]
    .join("\n")
}

/// Flights of a contender over draws, in these weathers too, and all else that is told of it.
pub fn result(contender: &Contender, draws: &[Draw], weathers: &[Weather]) -> Result {
    let flights = contender.fly_all(draws, Weather::Still);
    let rms: Vec<f64> = flights.iter().map(|figures| figures.rms_deg).collect();
    eprintln!("{}: median RMS {:.3} deg", contender.name, median(&rms));
    Result {
        name: contender.name,
        flights,
        weather: weathers.iter().map(|weather| (*weather, contender.fly_all(draws, *weather))).collect(),
        pushes: hover::push_all(contender, draws),
        eigenvalues: [0, 1].map(|axis| eigenvalues(contender, axis, &Vehicle::nominal())),
        law: contender.law(),
        hover: Hover::of(contender),
    }
}

/// Every contender over this many draws; the first ones in all weathers.
pub fn results(count: u64) -> Vec<Result> {
    let draws = draws(count);
    let weathers = |index| if index < CONTENDERS_IN_WEATHER { &WEATHERS[1..] } else { &[] };
    let all = contenders::all();
    all.iter().enumerate().map(|(index, contender)| result(contender, &draws, weathers(index))).collect()
}

/// Every table of these results.
pub fn report(results: &[Result]) -> String {
    let count = results.first().map_or(0, |result| result.flights.len());
    let [mpc, cascade] = contenders::tuned_for_rms();
    // parts that act at a bound only leave the linear loop as it is
    let mut linear: Vec<Result> = Vec::new();
    for result in results {
        if !result.eigenvalues[0].is_empty() && linear.iter().all(|other| other.eigenvalues != result.eigenvalues) {
            linear.push(result.clone());
        }
    }
    [
        format!("### Flights over {count} draws: median / 95th percentile\n"),
        table::flights(results),
        "### Differences with paired 95 % intervals\n".into(),
        table::differences(results),
        "### The same in weather\n".into(),
        table::weather(&results[..results.len().min(CONTENDERS_IN_WEATHER)]),
        "### A torque step of 0.1 N m about roll on every drawn vehicle: median / 95th percentile\n".into(),
        table::pushes(results),
        "### At hover, nominal vehicle: roll / pitch\n".into(),
        table::hover(results.iter().map(|result| (result.name, &result.hover))),
        "### At hover in free flight, nominal F450 with the tuning that follows from it: roll / pitch\n".into(),
        hover_in_free_flight(),
        "### Eigenvalues at hover, nominal vehicle\n".into(),
        table::eigenvalues(&linear),
        "### Laws where no bound is active\n".into(),
        table::laws(&linear),
        "### Spectral radius of the MPC's loop, the worse of roll and pitch\n".into(),
        radii(&mpc),
        "### The same of the cascade\n".into(),
        radii(&cascade),
    ]
    .join("\n")
}

fn hover_in_free_flight() -> String {
    let all = contenders::in_free_flight();
    let hovers: Vec<Hover> = all.iter().map(Hover::of).collect();
    table::hover(all.iter().map(|contender| contender.name).zip(&hovers))
}

/// Spectral radii over true lag and throttle of a controller that believes in the nominal vehicle.
fn radii(contender: &Contender) -> String {
    let header = THROTTLES.map(|throttle| format!("throttle {throttle}, lift gain {:.3}", lift_gain(throttle)));
    let mut text = table::row(["lag, ms".to_owned()].into_iter().chain(header)) + &table::rule(THROTTLES.len());
    for lag_s in LAGS_S {
        let name = if lag_s == NOMINAL_LAG_S { "**30**".into() } else { format!("{:.0}", 1e3 * lag_s) };
        let cells = THROTTLES.map(|throttle| {
            let vehicle = Vehicle { lag_s, throttle, authority: 1.0 };
            format!("{:.4}", spectral_radius(contender, &vehicle))
        });
        text += &table::row([name].into_iter().chain(cells));
    }
    text
}
