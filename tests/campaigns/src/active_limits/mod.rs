//! The MPC while the motors are at their limits: where they never will be, where one free input is surely stable, and
//! what comes of states from which ten of them have to reach the limits. The figures of docs/mpc-against-cascade.md,
//! "With active limits".

pub mod law;
pub mod one_input;
pub mod quiet_set;
pub mod regulation;
pub mod thrown;

use serde::Serialize;
use shared_control::mpc::MpcSettings;
use shared_control::mpc::schedule::Schedule;
use sil_host::control_setup::{mpc_settings, vehicle_parameters};
use sil_host::scenario::Scenario;

use crate::comparison::contender::Contender;
use crate::comparison::contenders;
use crate::comparison::draw::Draw;
use law::{ClosedLoop, plan_rows};
use quiet_set::QuietSet;
use regulation::{Regulation, Settled};
use thrown::Thrown;

/// Chance with which a bound of a sampled share may be wrong.
const DOUBT: f64 = 1e-3;

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub struct Findings {
    /// Of roll and pitch: the quiet set of ten free inputs, half of the motors left to the other axis.
    pub quiet: [Reach; 2],
    /// Of roll and pitch: the quiet set of one free input with the axis' own limits.
    pub one_quiet: [Reach; 2],
    /// Of roll and pitch: the certificate of one free input.
    pub one_certain: [Reach; 2],
    /// Of roll and pitch: the least share of the law's torque in it.
    pub one_share: [f64; 2],
    /// Ten free inputs from states outside.
    pub settled: Vec<Settled>,
    /// The whole of what flies.
    pub thrown: Vec<Thrown>,
}

/// How far a set reaches along each component with the others at rest.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Reach {
    /// Degrees.
    pub angle_deg: f64,
    /// Rad/s.
    pub rate_rad_s: f64,
    /// Of the motors' torque, N m.
    pub motor_nm: f64,
}

impl Reach {
    fn of(set: &QuietSet) -> Self {
        Self { angle_deg: set.reach(0).to_degrees(), rate_rad_s: set.reach(1), motor_nm: set.reach(2) }
    }
}

fn contender() -> Contender {
    let [mpc, _] = contenders::tuned();
    mpc
}

/// Settings of the MPC that is flown, with its level linearisation alone.
pub fn flown() -> MpcSettings {
    let contender = contender();
    let setup = contender.setup(&Draw::nominal(0), &Scenario::test_sequence());
    let settings = mpc_settings(&setup.known_model(), &setup.tuning(), contender.choice.rate_hz);
    MpcSettings { schedule: Schedule::SINGLE, ..settings }
}

/// The MPC at the nominal vehicle's hover.
pub fn regulation() -> Regulation {
    let contender = contender();
    let known = contender.setup(&Draw::nominal(0), &Scenario::test_sequence()).known_model();
    let lift_n = vehicle_parameters(&known).lift_curve.lift(known.base_command as f32);
    Regulation::new(&flown(), f64::from(contender.choice.rate_hz), f64::from(lift_n))
}

/// Works it all out, with so many samples on each kind of body, and throws.
///
/// # Panics
/// If the nominal loops are not stable.
pub fn find(samples: u64, throws: u64) -> Findings {
    let (regulation, settings) = (regulation(), flown());
    let believed = regulation.believed();
    let one_input = [0, 1].map(|axis| {
        let plan = plan_rows::<1>(&settings, axis);
        let looped = ClosedLoop::new(&believed[axis], &believed[axis], &plan, regulation.control_step_s());
        let most_nm = regulation.torque_max_nm[axis];
        let quiet = QuietSet::new(&looped, &QuietSet::widest_falls(&looped, most_nm), most_nm);
        let (certain, share) = one_input::widest(&looped, most_nm).expect("a stable loop");
        (Reach::of(&quiet.expect("a stable loop")), Reach::of(&certain), share)
    });
    Findings {
        quiet: [0, 1].map(|axis| Reach::of(&regulation.quiet_set(axis, &believed[axis]).expect("a stable loop"))),
        one_quiet: one_input.map(|(quiet, ..)| quiet),
        one_certain: one_input.map(|(_, certain, _)| certain),
        one_share: one_input.map(|(.., share)| share),
        settled: [0.0, 0.2].map(|off_by| regulation.settle(samples, off_by)).to_vec(),
        thrown: thrown::throw(&contender(), throws),
    }
}

/// The share of all that at most may be lost where none of so many samples was, but for a chance of `DOUBT`:
/// 1 - DOUBT^(1/n).
pub fn lost_at_most(samples: u64) -> f64 {
    -libm::expm1(libm::log(DOUBT) / samples as f64)
}

/// As tables.
pub fn tables(findings: &Findings) -> String {
    let mut text = String::from(
        "| set | roll alone: angle, deg | rate, rad/s | motors' torque, N m | pitch alone: angle, deg | rate, rad/s | \
         motors' torque, N m |\n|---|---|---|---|---|---|---|\n",
    );
    for (name, reaches) in [
        ("ten free inputs, no limit ever reached", &findings.quiet),
        ("one free input, no limit ever reached", &findings.one_quiet),
        ("one free input, surely stable", &findings.one_certain),
    ] {
        let cells =
            reaches.map(|reach| format!("{:.2} | {:.2} | {:.3}", reach.angle_deg, reach.rate_rad_s, reach.motor_nm));
        text += &format!("| {name} | {} |\n", cells.join(" | "));
    }
    let [roll, pitch] = findings.one_share;
    text += &format!("\nLeast share of the one input's law: roll {roll:.3}, pitch {pitch:.3}.\n");
    text += "\n| bodies off by | samples | not come to rest | surely less than, % | time: median, longest, s | \
             plans at a limit, % | largest angle, deg |\n|---|---|---|---|---|---|---|\n";
    for row in &findings.settled {
        let [median, longest] = row.time_s;
        let bound = if row.lost == 0 { format!("{:.4}", 100.0 * lost_at_most(row.samples)) } else { "-".to_owned() };
        text += &format!(
            "| {:.0} % | {} | {} | {bound} | {median:.2}, {longest:.2} | {:.0} | {:.0} |\n",
            100.0 * row.off_by,
            row.samples,
            row.lost,
            row.limited_pct,
            row.widest_rad.to_degrees(),
        );
    }
    text +=
        "\n| thrown up to, deg | flights | not level again | samples with a motor at a limit, % |\n|---|---|---|---|\n";
    for row in &findings.thrown {
        let end = row.up_to_deg.map_or("more".to_owned(), |end| format!("{end:.0}"));
        text += &format!("| {end} | {} | {} | {:.1} |\n", row.flights, row.lost, row.limited_pct);
    }
    text
}

#[cfg(test)]
mod tests;
