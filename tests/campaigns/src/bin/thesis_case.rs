//! `cargo run --release -p campaigns --bin thesis_case`.

use campaigns::thesis_case::{Diagnosed, Tracking, controllers, log_of};
use clap::Parser;
use shared_control::config::Controller;
use sil_host::comparison::compare;
use sil_host::controller_file::ControllerChoice;
use sil_host::model::{Rig, VehicleModel};
use sil_host::prediction::Subject;
use sil_host::thesis::{RING_MOMENT_NM, off_balance, thesis_mpc};

/// Moments of the ring around the one that the case is made of, N m.
const MOMENTS_NM: [f64; 7] = [0.05, 0.1, 0.15, 0.18, 0.2, 0.22, 0.25];

/// The tables of docs/thesis-case.md.
#[derive(Parser)]
struct Arguments {}

fn main() {
    Arguments::parse();
    let mpc = thesis_mpc().expect("a controller file");
    println!("Nominal closed loop of the thesis' MPC against its log, mean deviation, degrees\n");
    println!("| ring, N m | roll | pitch |\n|---|---|---|");
    for moment_nm in MOMENTS_NM.into_iter().chain([RING_MOMENT_NM]) {
        let model = VehicleModel::nominal(Rig::Gimbal);
        let log = log_of(off_balance(moment_nm), mpc);
        let comparison = compare(&log, &Subject::Vehicle(&model), Some(mpc)).expect("a whole log");
        let deviation = comparison.closed_loop.expect("a log with references").deviation;
        println!("| {moment_nm} | {:.2} | {:.2} |", deviation.roll_mean_abs_deg, deviation.pitch_mean_abs_deg);
    }
    let logs = [("the thesis' MPC", mpc), ("cascade", ControllerChoice::nominal(Controller::Cascade))];
    let diagnosed = logs.map(|(name, choice)| Diagnosed::new(name, choice));
    println!("\n| log of | nominal: roll | pitch | extended: roll | pitch |\n|---|---|---|---|---|");
    for one in &diagnosed {
        print!("{one}");
    }
    for one in &diagnosed {
        println!("\n{}: {:?}", one.controller, one.answer.verdict);
        for finding in &one.answer.findings {
            println!("  {:.1} % {}", finding.gain_pct, finding.statement);
        }
    }
    println!(
        "\n| controller | nominal: roll RMS | pitch RMS | pitch steady \
         | extended: roll RMS | pitch RMS | pitch steady |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, choice) in controllers() {
        print!("{}", Tracking::new(name, choice, &diagnosed[0].extended));
    }
}
