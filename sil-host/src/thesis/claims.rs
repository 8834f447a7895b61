//! What chapters 4 and 5 say in words, held against flights of our own.

use rayon::prelude::*;
use serde::Serialize;

use super::fidelity::{Pair, fly};
use super::printed::device;
use crate::controller_file::{ControllerChoice, TuningChange};
use crate::cosim::record::FlightRecord;
use crate::effects::{Effect, MotorLag};
use crate::flight::{FlightSetup, SetupError};
use crate::margins::Margins;
use crate::model::{Rig, SensorNoise, VehicleModel};
use crate::scenario::Scenario;
use crate::statistics::mean_absolute_deviation;

/// What became of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It is so here too.
    Confirmed,
    /// It is not.
    NotConfirmed,
    /// What it is about is not to be had here.
    NotTried,
}

/// A sentence of the thesis and what we find.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// Section.
    pub section: &'static str,
    /// What it says, in our words.
    pub says: &'static str,
    /// What became of it.
    pub verdict: Verdict,
    /// The numbers.
    pub found: String,
}

/// The MPC with another prediction horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HorizonRow {
    /// Steps of 10 ms.
    pub horizon: usize,
    /// Largest tilt of pitch in the test sequence, which asks for 30, degrees.
    pub pitch_max_deg: f64,
    /// Mean overshoot of pitch, %.
    pub overshoot_pct: Option<f64>,
    /// Roll and pitch in hover; none where the loop oscillates by itself.
    pub margins: Option<[Margins; 2]>,
    /// The same with the lag of a real F450's motors ([`real_lag_s`]), of which the controller does not know.
    pub margins_with_lag: Option<[Margins; 2]>,
}

/// Lag of the motors of the F450 that flies free, where it hovers, s. The thesis' motors have a twentieth of it,
/// because of the rotor inertia that it prints.
pub fn real_lag_s() -> f64 {
    let free = VehicleModel::nominal(Rig::Free);
    let hover = free.propulsion.equilibrium(free.base_command);
    device(&free).map_or(0.0, |device| device.lag_s(hover.speed_rad_s))
}

const HORIZONS: [usize; 5] = [10, 15, 20, 25, 30];
/// The thesis found the first unstable and flew the second.
const UNSTABLE_HORIZON: usize = 20;
const FLOWN_HORIZON: usize = 30;
/// Controllers differ noteworthily if their angles differ by more, mean over the flight, degrees: what the noise of the
/// attitude alone makes is 0.1, what the thesis calls a decent fidelity 2.
const NOTEWORTHY_DEG: f64 = 0.5;
/// An overshoot below this share of a step is none, %.
const OVERSHOOT_MIN_PCT: f64 = 1.0;

/// The thesis' MPC with shorter horizons.
///
/// # Errors
/// [`SetupError`]: none of these is refused.
pub fn horizon_rows(mpc: ControllerChoice) -> Result<Vec<HorizonRow>, SetupError> {
    let of = |horizon| {
        let tuning = TuningChange { mpc_horizon: Some(horizon), ..mpc.tuning };
        let setup = FlightSetup {
            model: balanced(),
            controller_model: None,
            choice: ControllerChoice { tuning, ..mpc },
            scenario: Scenario::test_sequence(),
            seed: 0,
        };
        let record = setup.fly()?.record;
        let lag = MotorLag { time_constant_s: real_lag_s() };
        let model = VehicleModel { effects: vec![Effect::MotorLag(lag)], ..balanced() };
        let lagging = FlightSetup { model, controller_model: Some(balanced()), ..setup.clone() };
        Ok(HorizonRow {
            horizon,
            pitch_max_deg: record.angle_of(1).iter().fold(0.0, |most: f64, angle| most.max(angle.abs())).to_degrees(),
            overshoot_pct: FlightSetup::axes(&record).pitch.overshoot_pct,
            margins: setup.margins()?,
            margins_with_lag: lagging.margins()?,
        })
    };
    HORIZONS.into_par_iter().map(of).collect()
}

fn balanced() -> VehicleModel {
    VehicleModel { noise: SensorNoise::NONE, ..VehicleModel::nominal(Rig::Gimbal) }
}

/// All of them. `copter` is the cascade with the gains that explain table 5.1, `cascade` this project's.
///
/// # Errors
/// [`SetupError`]: no controller here is refused.
pub fn claims(
    [mpc, copter, cascade]: [&Pair; 3],
    horizons: &[HorizonRow],
    pid: ControllerChoice,
) -> Result<Vec<Claim>, SetupError> {
    let mut claims = vec![iterations(&mpc.simulated)];
    claims.extend(horizon(horizons));
    claims.push(slower_cascade(&cascade.simulated, pid)?);
    claims.extend([
        overshoots([mpc, copter]),
        drawn_to_one_side("5.3.1", "under the MPC the ring draws pitch to the negative side", &mpc.tested),
        overshoot_by_direction(&mpc.tested),
        less_apparent([mpc, copter]),
        overshoots_in_the_test(copter),
    ]);
    Ok(claims)
}

fn claim(section: &'static str, says: &'static str, verdict: Verdict, found: String) -> Claim {
    Claim { section, says, verdict, found }
}

fn if_so(is_so: bool) -> Verdict {
    if is_so { Verdict::Confirmed } else { Verdict::NotConfirmed }
}

fn iterations(record: &FlightRecord) -> Claim {
    let most = record.planning.iterations_max;
    claim(
        "4.4",
        "stopped after 70 iterations Midaco is nearly as good as unstopped; after 50 the loop is unstable",
        Verdict::NotTried,
        format!("Midaco is not free; the exact solver here ends after {most} iterations at most"),
    )
}

fn horizon(rows: &[HorizonRow]) -> Option<Claim> {
    let row = |horizon| rows.iter().find(|row| row.horizon == horizon);
    let (short, flown) = (row(UNSTABLE_HORIZON)?, row(FLOWN_HORIZON)?);
    let held = |margins: &Option<[Margins; 2]>| match margins {
        Some([_, pitch]) => format!("holds with {:.0} ms of delay margin in pitch", pitch.delay_ms.unwrap_or(f64::NAN)),
        None => "oscillates".to_owned(),
    };
    let lag_ms = 1e3 * real_lag_s();
    Some(claim(
        "4.4",
        "a prediction horizon of 20 steps is unstable, one of 30 is not",
        if_so(short.margins_with_lag.is_none() && flown.margins_with_lag.is_some()),
        format!(
            "on motors with the lag of a real F450's, {lag_ms:.0} ms, 20 {} and 30 {}; on the thesis' motors, whose \
             rotors have a tenth of a real one's inertia, 20 {}",
            held(&short.margins_with_lag),
            held(&flown.margins_with_lag),
            held(&short.margins)
        ),
    ))
}

fn slower_cascade(at_400: &FlightRecord, pid: ControllerChoice) -> Result<Claim, SetupError> {
    let at_100 = fly(balanced(), ControllerChoice { rate_hz: 100, ..pid })?;
    let differ_deg = [0, 1].map(|axis| {
        let every_fourth: Vec<f64> = at_400.angle_of(axis).into_iter().step_by(4).collect();
        let rows = every_fourth.len().min(at_100.len());
        let deviation = mean_absolute_deviation(&every_fourth[..rows], &at_100.angle_of(axis)[..rows]);
        deviation.unwrap_or(f64::NAN).to_degrees()
    });
    let [roll, pitch] = differ_deg;
    Ok(claim(
        "5.4",
        "the PID flies alike at 100 and at 400 Hz",
        if_so(roll.max(pitch) < NOTEWORTHY_DEG),
        format!("this project's cascade: its angles differ by {roll:.2} and {pitch:.2} degrees in the mean"),
    ))
}

/// Mean overshoots of roll and pitch, %.
fn overshoot_pct(record: &FlightRecord) -> [f64; 2] {
    let axes = FlightSetup::axes(record);
    [axes.roll, axes.pitch].map(|axis| axis.overshoot_pct.unwrap_or(f64::NAN))
}

fn overshoots([mpc, copter]: [&Pair; 2]) -> Claim {
    let ([roll, pitch], [slow_roll, slow_pitch]) = (overshoot_pct(&mpc.simulated), overshoot_pct(&copter.simulated));
    claim(
        "5.4",
        "simulated, the MPC overshoots, most in pitch, and the PID does not",
        if_so(pitch > OVERSHOOT_MIN_PCT && pitch > roll && slow_roll < pitch && slow_pitch < pitch),
        format!(
            "MPC {roll:.1} % in roll, {pitch:.1} % in pitch; Copter's cascade {slow_roll:.1} and {slow_pitch:.1} %"
        ),
    )
}

/// Mean of pitch where its reference is level, degrees.
fn level_pitch_deg(record: &FlightRecord) -> f64 {
    let level: Vec<f64> = record
        .angle_of(1)
        .into_iter()
        .zip(record.reference_of(1))
        .filter(|(_, reference)| *reference == 0.0)
        .map(|(angle, _)| angle)
        .collect();
    (level.iter().sum::<f64>() / level.len().max(1) as f64).to_degrees()
}

fn drawn_to_one_side(section: &'static str, says: &'static str, record: &FlightRecord) -> Claim {
    let mean_deg = level_pitch_deg(record);
    claim(
        section,
        says,
        if_so(mean_deg < -1.0),
        format!("{mean_deg:.1} degrees in the mean where the reference is level"),
    )
}

/// How far pitch goes past its target, mean over the steps up and over those down, degrees; below zero it stays short.
fn past_target_deg(record: &FlightRecord) -> [f64; 2] {
    let (angle, reference) = (record.angle_of(1), record.reference_of(1));
    let mut starts: Vec<usize> = (1..reference.len()).filter(|&row| reference[row] != reference[row - 1]).collect();
    starts.push(reference.len());
    let mut past = [Vec::new(), Vec::new()];
    for pair in starts.windows(2) {
        let (begin, end) = (pair[0], pair[1]);
        let is_down = reference[begin] < reference[begin - 1];
        let sign = if is_down { -1.0 } else { 1.0 };
        let of_row = |row: usize| sign * (angle[row] - reference[row]);
        past[usize::from(is_down)].push((begin..end).map(of_row).fold(f64::NEG_INFINITY, f64::max).to_degrees());
    }
    past.map(|degrees| degrees.iter().sum::<f64>() / degrees.len().max(1) as f64)
}

fn overshoot_by_direction(record: &FlightRecord) -> Claim {
    let [up, down] = past_target_deg(record);
    let upward =
        if up < 0.0 { format!("stays {:.1} degrees short", -up) } else { format!("goes {up:.1} degrees past") };
    claim(
        "5.3.1",
        "in the test pitch hardly overshoots upward, and much downward",
        if_so(up < 1.0 && down > 3.0),
        format!("upward the MPC {upward}, downward it goes {down:.1} past its target"),
    )
}

fn less_apparent([mpc, copter]: [&Pair; 2]) -> Claim {
    let (mpc, pid) = (level_pitch_deg(&mpc.tested), level_pitch_deg(&copter.tested));
    claim(
        "5.3.2",
        "the PID is drawn to the same side, less than the MPC",
        if_so(pid < -1.0 && pid > mpc),
        format!("Copter's cascade {pid:.1} degrees in the mean, the MPC {mpc:.1}"),
    )
}

fn overshoots_in_the_test(copter: &Pair) -> Claim {
    let [_, down] = past_target_deg(&copter.tested);
    let [_, simulated] = past_target_deg(&copter.simulated);
    claim(
        "5.3.2",
        "in the test the PID overshoots far in pitch, simulated it does not",
        if_so(down > 3.0 && simulated < 1.0),
        format!(
            "Copter's cascade goes past its target downward by {down:.1} degrees in the test, {simulated:.1} simulated"
        ),
    )
}
