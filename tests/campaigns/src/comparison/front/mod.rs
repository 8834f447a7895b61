//! MPC and cascade tuned for all columns at once, as a Pareto study: RMS, overshoot, settling, torque steps, noise on
//! the motors and the delay margin, with the same number of points for each.
//!
//! ```text
//!  candidates -> study (searches of both sides in turn) -> points -> front -> tables, the balanced point of each
//!                  `-- measured: flights over draws, hover, margins
//! ```

pub mod candidates;
pub mod dominance;
pub mod measured;
pub mod side;
pub mod study;
pub mod table;

use serde::Serialize;
use sil_host::model::Rig;

use super::draw::Draw;
use super::tuning::Tunable;
use super::weather::Weather;
use measured::Measured;
use side::Side;
use study::Budget;

/// A point of the study as a row.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Whose.
    pub controller: &'static str,
    /// Its place in the order in which the controller's points were measured.
    pub number: usize,
    /// Whether it is on the controller's front.
    pub on_front: bool,
    /// Whether it is the balanced one of that front.
    pub is_balanced: bool,
    /// The other controller's points that dominate it; of points on the front.
    pub dominated_by: Vec<usize>,
    /// Names and values of the parameters, those of roll.
    pub parameters: Vec<(&'static str, f64)>,
    /// Figures; none of what can't be flown or oscillates.
    pub measured: Option<Measured>,
}

/// What a study gives: rows of the MPC and of the cascade, and the files of their balanced points.
pub struct Outcome {
    /// MPC, cascade.
    pub rows: [Vec<Row>; 2],
    /// MPC, cascade; none without a point within the limits.
    pub files: [Option<String>; 2],
}

/// Weathers of the study: free flight has been told of gusts and torque steps too.
pub const fn weathers(rig: Rig) -> &'static [Weather] {
    match rig {
        Rig::Gimbal => &[Weather::Still],
        Rig::Free => &[Weather::Still, Weather::TorqueSteps, Weather::Gusts],
    }
}

/// The study over these draws.
pub fn study(rig: Rig, draws: &[Draw], budget: &Budget) -> Outcome {
    let (mpc, cascade) = (candidates::mpc(rig), candidates::cascade(rig));
    let mut ours = side_of(&mpc, draws);
    let mut theirs = side_of(&cascade, draws);
    study::run(&mut ours, &mut theirs, budget);
    Outcome {
        rows: [rows(&mpc, &ours, &theirs), rows(&cascade, &theirs, &ours)],
        files: [file(&mpc, &ours, draws.len()), file(&cascade, &theirs, draws.len())],
    }
}

fn side_of<'a, const N: usize>(tunable: &'a Tunable<N>, draws: &'a [Draw]) -> Side<'a, N> {
    let mut count = 0;
    Side::new(tunable.start(), move |at| {
        let measured = Measured::of(&tunable.contender(at), draws, weathers(tunable.rig));
        count += 1;
        eprintln!("{} {count:4}: {measured:?}", tunable.name);
        measured
    })
}

fn rows<const A: usize, const B: usize>(tunable: &Tunable<A>, side: &Side<'_, A>, other: &Side<'_, B>) -> Vec<Row> {
    let (front, balanced) = (side.front(), side.balanced());
    let row = |(number, point): (usize, &side::Point<A>)| {
        let on_front = front.contains(&number);
        Row {
            controller: tunable.name,
            number,
            on_front,
            is_balanced: balanced == Some(number),
            dominated_by: point.measured.filter(|_| on_front).map_or_else(Vec::new, |point| other.dominating(&point)),
            parameters: tunable.values(&point.at).collect(),
            measured: point.measured,
        }
    };
    side.points.iter().enumerate().map(row).collect()
}

fn file<const N: usize>(tunable: &Tunable<N>, side: &Side<'_, N>, draws: usize) -> Option<String> {
    let place = side.balanced()?;
    let all = side.points.len();
    Some(format!(
        "# Chosen by `controller_comparison front{}`: point {place} of {all}, each measured on {draws} draws.\n{}",
        if tunable.rig == Rig::Free { " free" } else { "" },
        tunable.file(&side.points[place].at)
    ))
}
