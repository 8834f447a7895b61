//! `sil` without arguments: the thesis' experiment in a few seconds, with one report about all of it.

use std::io::IsTerminal;
use std::path::Path;

use shared_control::config::Controller;
use sil_host::answer::diagnosis::first_screen;
use sil_host::answer::flight::flown::fly_one;
use sil_host::answer::{comparison, diagnosis as answer_of, flight};
use sil_host::comparison::compare;
use sil_host::controller_file::ControllerChoice;
use sil_host::diagnosis;
use sil_host::flight::FlightSetup;
use sil_host::log;
use sil_host::model::{Rig, VehicleModel};
use sil_host::prediction::Subject;
use sil_host::report::{Page, Section};
use sil_host::scenario::Scenario;

use super::output::emphasised;
use super::progress_line::ProgressLine;
use super::{Failure, bad_input, failed, make_folder, print, write_file};

/// The rig log that ships: synthetic, flown by the thesis' MPC (100 Hz, M = 1) on a ring that is off balance.
/// Made by `sil synth --effect "cg_offset:axis=pitch,cos_moment_nm=0.2" --rate 100 --control-rate 100 --seed 5`
/// with `--controller` the file below.
const RIG_LOG: &str = include_str!("../../demonstration/rig-log.csv");
/// What the log is called in messages.
const RIG_LOG_NAME: &str = "rig-log.csv (bundled)";
/// What flew it.
const RIG_LOG_CONTROLLER: &str = include_str!("../../demonstration/thesis-mpc.toml");

const REPORT: &str = "out/report.html";

pub fn run() -> Result<(), Failure> {
    // before some seconds of computing
    make_folder(Path::new(REPORT))?;
    print("1. The thesis' test sequence on the simulated testbed, PID cascade against MPC\n\n")?;
    let model = VehicleModel::nominal(Rig::Gimbal);
    let flown = [Controller::Cascade, Controller::Mpc]
        .into_iter()
        .map(|controller| {
            let choice = ControllerChoice::nominal(controller);
            let scenario = Scenario::test_sequence();
            let setup = FlightSetup { model: model.clone(), controller_model: None, choice, scenario, seed: 0 };
            fly_one(choice.name(), setup)
        })
        .collect::<Result<Vec<_>, _>>()
        .map_err(bad_input)?;
    print(flight::text::summary_text(&flown))?;

    print("2. A rig log compared with the simulation\n\n")?;
    let log = log::parse(RIG_LOG_NAME, RIG_LOG, None).map_err(failed)?;
    let controller = ControllerChoice::parse(RIG_LOG_CONTROLLER, "thesis-mpc.toml").map_err(failed)?;
    let subject = Subject::Vehicle(&model);
    let compared = compare(&log, &subject, Some(controller)).map_err(bad_input)?;
    print(comparison::text::summary_text(&log, &compared, &subject))?;

    print("\n3. What the simulation gets wrong\n")?;
    let answer = {
        let line = ProgressLine::new();
        let (known, effort) = (diagnosis::Known::default(), diagnosis::Effort::Quick);
        diagnosis::diagnose_observed(&log, &subject, &known, effort, &|progress| line.show(progress))
            .map_err(bad_input)?
    };
    print(answer_of::text::verdict_text(&answer, emphasised))?;

    let page = Page::new(first_screen::headline(&answer)).about(
        "Demonstration: a rig log compared with the simulation, and the cause of the disagreement. The log is \
         synthetic: it was made with a ring that is off balance, as the thesis suspected of its own.",
    );
    let page = first_screen::first_screen(page, &log, &answer);
    let diagnosis = answer_of::page::sections(&log, &answer);
    let comparison = comparison::page::sections(&log, &compared).into_iter().map(Section::folded);
    let flights = flight::page::sections(&flown).into_iter();
    let page = diagnosis.into_iter().chain(comparison).chain(flights).fold(page, Page::section);
    let page =
        page.provenance("Command", "sil").provenance("Seed", "0").provenance("Version", env!("CARGO_PKG_VERSION"));
    write_file(Path::new(REPORT), page.to_html().as_bytes())?;
    show(Path::new(REPORT))
}

/// Says where the report is, and opens it where somebody is looking.
fn show(report: &Path) -> Result<(), Failure> {
    let place = std::fs::canonicalize(report).unwrap_or_else(|_| report.to_owned());
    let has_screen = cfg!(not(target_os = "linux"))
        || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    let opened = std::io::stdout().is_terminal() && has_screen && open::that_detached(&place).is_ok();
    let opening = if opened { " (opening in the browser)" } else { "" };
    print(format!(
        "\nreport  {}{opening}\nnext    sil diagnose --help, sil fly --help, sil synth --help\n",
        place.display()
    ))
}
