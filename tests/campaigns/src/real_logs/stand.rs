//! A real 3-DoF stand (Sharif University), the nearest cousin of the thesis' gimbal: what each run's answer says of one
//! vehicle's constants, the same across runs and controllers or not, beside the two sets that its authors published.

use std::fmt;

use sil_host::axis::Axis;
use sil_host::diagnosis::{BaseTerm, Diagnosis, Estimate, Verdict, diagnose};

use super::scoreboard::entries;

/// Rotor speed of a full command: 6000 rpm, rad/s.
const FULL_SPEED_RAD_S: f64 = 628.32;

/// A constant of one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constant {
    /// Angular acceleration per difference of squared rotor speeds, 1e-5.
    Gain,
    /// Gravity's moment over the inertia, 1/s^2: m g h / J, positive where the centre of gravity is above the pivot.
    Gravity,
    /// Gravity's moment at level over the inertia, rad/s^2.
    Trim,
    /// Viscous friction over the inertia, 1/s.
    Viscous,
    /// Dry friction over the inertia, rad/s^2.
    Dry,
    /// Lag and delay together, ms.
    Late,
}

impl Constant {
    /// All of them, as the table has them.
    pub const ALL: [Constant; 6] =
        [Constant::Gain, Constant::Gravity, Constant::Trim, Constant::Viscous, Constant::Dry, Constant::Late];

    /// What an answer says of it; none where the answer does not have it.
    fn told(self, answer: &Diagnosis, axis: Axis) -> Option<Estimate> {
        let number = |effect: &str, name: &str| {
            let is_it = |term: &&BaseTerm| term.effect == effect && term.axis == Some(axis.name());
            answer.base.iter().find(is_it).and_then(|term| term.parameters.get(name)).copied()
        };
        let scaled = |by: f64| move |own: Estimate| Estimate { value: by * own.value, std: by.abs() * own.std };
        match self {
            Constant::Gain => number("input_gain", "gain_rad_s2").map(scaled(1e5 / FULL_SPEED_RAD_S.powi(2))),
            Constant::Gravity => number("cg_offset", "sin_moment_rad_s2").map(scaled(-1.0)),
            Constant::Trim => number("torque_bias", "torque_rad_s2"),
            Constant::Viscous => number("viscous_friction", "coefficient_1_s"),
            Constant::Dry => number("coulomb_friction", "torque_rad_s2"),
            Constant::Late => answer.lateness_s.map(scaled(1e3)),
        }
    }

    /// By the authors' two sets (m, J, arm, h, b, motors' lag and delay, friction of the bearings; the logs' README).
    /// Neither has a trim.
    pub fn published(self, axis: Axis) -> [Option<f64>; 2] {
        struct Set {
            mass_kg: f64,
            inertia_kg_m2: [f64; 2],
            arm_m: f64,
            height_m: f64,
        }
        const SETS: [Set; 2] = [
            Set { mass_kg: 1.074, inertia_kg_m2: [0.02839, 0.03066], arm_m: 0.2, height_m: 0.02 },
            Set { mass_kg: 1.774, inertia_kg_m2: [0.029_759_8, 0.029_856_5], arm_m: 0.295, height_m: 0.0078 },
        ];
        SETS.map(|set| {
            let inertia_kg_m2 = *set.inertia_kg_m2.get(axis.index())?;
            match self {
                Constant::Gain => Some(1.10794 * set.arm_m / inertia_kg_m2),
                Constant::Gravity => Some(set.mass_kg * 9.81 * set.height_m / inertia_kg_m2),
                // loads of 1.27 and 1.07 kg on bearings of 0.01 m with a coefficient of 0.002
                Constant::Dry => Some(0.002 * 9.81 * 0.01 * [1.272, 1.074].get(axis.index())? / inertia_kg_m2),
                Constant::Late => Some(170.0),
                Constant::Trim | Constant::Viscous => None,
            }
        })
    }
}

/// A run and what is told of roll and pitch.
pub struct Run {
    /// The log's name, which begins with its controller.
    pub name: String,
    /// False where the answer says that the log does not show what the commands do: nothing of it is to be relied on.
    pub is_shown: bool,
    /// Axis, each constant in order, and the fit of its rate on windows that nothing was fitted to, %.
    pub axes: Vec<(Axis, [Option<Estimate>; Constant::ALL.len()], f64)>,
}

/// All runs in closed loop that drive roll or pitch; none where the logs are absent.
///
/// # Panics
/// The logs are there and can't be diagnosed.
pub fn runs() -> Vec<Run> {
    let is_driven = |name: &str| name.starts_with("cl_");
    let entries = entries().into_iter().filter(|entry| entry.vehicle == "sharif" && is_driven(&entry.name));
    let run = |entry: super::scoreboard::Entry| {
        let log = entry.log();
        let answer = diagnose(&log, &entry.subject()).expect("a log with windows");
        let of_axis = |axis: Axis| {
            let rate = ["p", "q"][axis.index()];
            let fit_pct = answer.statistics.iter().find(|channel| channel.quantity == rate);
            let fit_pct = fit_pct.and_then(|channel| channel.extended.agreement.fit_pct).unwrap_or(f64::NAN);
            (axis, Constant::ALL.map(|constant| constant.told(&answer, axis)), fit_pct)
        };
        let axes = [Axis::Roll, Axis::Pitch].into_iter().filter(|axis| log.axes[axis.index()]).map(of_axis).collect();
        Run { name: entry.name, is_shown: answer.verdict != Verdict::NotShown, axes }
    };
    entries.map(run).collect()
}

/// One constant of an axis over all runs that show it.
pub struct Across {
    /// How many runs tell it.
    pub runs: usize,
    /// Mean, weighted by each run's variance and that between the runs (DerSimonian and Laird, Controlled Clinical
    /// Trials 7, 1986).
    pub mean: Estimate,
    /// What the runs differ by beyond their standard deviations.
    pub between: f64,
    /// How many of their intervals of 95 % hold the mean.
    pub hold: usize,
}

impl Across {
    /// Of at least two runs.
    pub fn of(told: &[Estimate]) -> Option<Across> {
        let told: Vec<Estimate> = told.iter().copied().filter(|one| one.std > 0.0 && one.std.is_finite()).collect();
        if told.len() < 2 {
            return None;
        }
        let mean_with = |between: f64| {
            let weights: Vec<f64> = told.iter().map(|one| 1.0 / (one.std.powi(2) + between.powi(2))).collect();
            let total: f64 = weights.iter().sum();
            let sum: f64 = told.iter().zip(&weights).map(|(one, weight)| weight * one.value).sum();
            (Estimate { value: sum / total, std: total.recip().sqrt() }, weights)
        };
        let (fixed, weights) = mean_with(0.0);
        let total: f64 = weights.iter().sum();
        let scatter: f64 =
            told.iter().zip(&weights).map(|(one, weight)| weight * (one.value - fixed.value).powi(2)).sum();
        let squares: f64 = weights.iter().map(|weight| weight * weight).sum();
        let freedom = told.len() as f64 - 1.0;
        let between = ((scatter - freedom) / (total - squares / total)).max(0.0).sqrt();
        let (mean, _) = mean_with(between);
        let hold = told.iter().filter(|one| (one.value - mean.value).abs() <= 1.96 * one.std).count();
        Some(Across { runs: told.len(), mean, between, hold })
    }
}

/// "7.3 +- 0.4".
fn short(told: Option<Estimate>) -> String {
    told.map_or("-".to_owned(), |told| {
        let digits = told.decimals().unwrap_or(1).saturating_sub(1);
        format!("{:.digits$} +- {:.digits$}", told.value, told.std)
    })
}

impl fmt::Display for Run {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (axis, told, fit_pct) in &self.axes {
            let told = told.map(short).join(" | ");
            let name = if self.is_shown { self.name.clone() } else { format!("({})", self.name) };
            writeln!(out, "| {name} | {} | {told} | {fit_pct:.0} |", axis.name())?;
        }
        Ok(())
    }
}

/// Prints runs, what they have in common, and the authors' sets.
///
/// # Panics
/// As [`runs`].
pub fn print() {
    let runs = runs();
    println!("Runs in brackets do not show what their commands do; they are in no mean.\n");
    println!(
        "| run | axis | gain, 1e-5 | gravity, 1/s^2 | trim, rad/s^2 | viscous, 1/s | dry, rad/s^2 | late, ms | fit of \
         the rate, % |\n|---|---|---|---|---|---|---|---|---|"
    );
    runs.iter().for_each(|run| print!("{run}"));
    println!("\n| axis | constant | runs | mean | between runs | intervals that hold the mean | set 1 | set 2 |");
    println!("|---|---|---|---|---|---|---|---|");
    for axis in [Axis::Roll, Axis::Pitch] {
        let shown = || runs.iter().filter(|run| run.is_shown);
        let of_axis = || shown().flat_map(|run| &run.axes).filter(move |(own, ..)| *own == axis);
        for (place, constant) in Constant::ALL.into_iter().enumerate() {
            let told: Vec<Estimate> = of_axis().filter_map(|(_, told, _)| told[place]).collect();
            let Some(across) = Across::of(&told) else { continue };
            let [one, other] = constant.published(axis).map(|set| set.map_or("-".into(), |set| format!("{set:.3}")));
            println!(
                "| {} | {constant:?} | {} | {} | {:.2} | {} | {one} | {other} |",
                axis.name(),
                across.runs,
                short(Some(across.mean)),
                across.between,
                across.hold
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two runs that agree have the usual weighted mean; two that don't, their plain mean and their own spread.
    #[test]
    fn runs_that_differ_widen_the_mean() {
        let told = |values: [f64; 2], std: f64| values.map(|value| Estimate { value, std });
        let agree = Across::of(&told([1.0, 1.02], 0.1)).unwrap();
        assert_eq!((agree.between, agree.hold), (0.0, 2));
        assert!((agree.mean.std - 0.1 / 2f64.sqrt()).abs() < 1e-12);
        let differ = Across::of(&told([0.0, 2.0], 0.1)).unwrap();
        // the variance of two values a distance of 2 apart is 2
        assert!((differ.between.powi(2) + 0.01 - 2.0).abs() < 1e-9, "{}", differ.between);
        assert!((differ.mean.value - 1.0).abs() < 1e-12 && differ.hold == 0);
    }
}
