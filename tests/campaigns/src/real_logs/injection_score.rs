//! Is an effect that was put into a real log named and measured? The log as it was recorded is the baseline: what its
//! answer says is the vehicle's own, and only the difference counts. Where that answer does not name the effect, its
//! size is asked for beside what was found: a vehicle may have a little of it already. With a baseline
//! (`injection_baseline`) one answer says the difference by itself.

use serde::Serialize;
use sil_host::axis::Axis;
use sil_host::diagnosis::{Asked, Diagnosis, Estimate, Subject, diagnose, sizes};
use sil_host::log::Log;

use super::injection::Injection;
use super::scoreboard::{COMMAND_MIN, Entry, Named, command_std, sized_terms};

/// Within so many standard deviations lie 95 %.
const INTERVAL: f64 = 1.96;
/// A gyro scale, a bias of a gyro, a turn of the IMU, a scale of the commands: well above what a healthy vehicle has.
const GYRO_SCALE: f64 = 1.2;
const GYRO_BIAS_RAD_S: f64 = 0.1;
const TURN_RAD: f64 = 0.2;
const COMMAND_SCALE: f64 = 0.75;
/// Delays are whole rows, the fewest that are at least this, s.
const DELAY_S: f64 = 0.03;

/// How an effect was answered.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Injected {
    /// Whose vehicle, and the log's name.
    pub log: String,
    /// What was put in.
    pub injection: Injection,
    /// Why it was not tried.
    pub not_tried: Option<String>,
    /// Whether its name is in the answer, alone or as one of several, and a size of its own differs from the recorded
    /// log's.
    pub is_named: bool,
    /// Its size: what it should be more than in the recorded log, what it is, and their distance in standard
    /// deviations.
    pub size: Option<InjectedSize>,
    /// Other names that the recorded log does not have.
    pub other_new: Vec<String>,
    /// Names of the recorded log that are gone.
    pub gone: Vec<String>,
}

/// A size beyond that of the recorded log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InjectedSize {
    /// What was put in.
    pub truth: f64,
    /// What the two answers differ by; of a scale, their ratio.
    pub found: Estimate,
    /// Distance, in standard deviations.
    pub z: f64,
    /// Interval of 95 %.
    pub interval_95: [f64; 2],
}

impl InjectedSize {
    /// True if the interval of 95 % holds the truth.
    pub fn is_held(&self) -> bool {
        (self.interval_95[0]..=self.interval_95[1]).contains(&self.truth)
    }

    /// Half of the interval over what was put in, of a scale over what it changes.
    pub fn relative_half_width(&self, nothing: f64) -> f64 {
        0.5 * (self.interval_95[1] - self.interval_95[0]) / (self.truth - nothing).abs()
    }
}

/// What is put into a log: each kind once, on the first axis that has angle and rate, else on the first with a rate.
pub fn injections(log: &Log) -> Vec<Injection> {
    let axes = || (0..3).filter(|axis| log.axes[*axis] && log.rate_rad_s[*axis].is_some());
    let axis = axes().find(|axis| log.angle_rad[*axis].is_some()).or_else(|| axes().next());
    let step_s = log.median_step_s();
    let delay_s = (DELAY_S / step_s - 1e-6).ceil() * step_s;
    let mut all = Vec::new();
    if let Some(axis) = axis {
        all.push(Injection::GyroScale { axis, scale: GYRO_SCALE });
        all.push(Injection::GyroBias { axis, bias_rad_s: GYRO_BIAS_RAD_S });
    }
    all.push(Injection::TurnedImu { yaw_rad: TURN_RAD });
    all.push(Injection::AttitudeDelay { delay_s });
    all.push(Injection::CommandDelay { delay_s });
    all.push(Injection::CommandScale { scale: COMMAND_SCALE });
    all
}

impl Injection {
    /// Why a log can't show it; none where it can (docs/log-format.md, "What each test of the diagnosis needs").
    pub fn hidden_in(&self, log: &Log, subject: &Subject<'_>) -> Option<&'static str> {
        let has_motors = matches!(subject, Subject::Vehicle(_));
        let both = |axis: usize| log.angle_rad[axis].is_some() && log.rate_rad_s[axis].is_some();
        match *self {
            Injection::GyroScale { axis, .. } | Injection::GyroBias { axis, .. } if !both(axis) => {
                Some("a gyro's error needs the angle of its axis")
            }
            Injection::AttitudeDelay { .. } if !(0..3).any(both) => Some("needs angle and rate of one axis"),
            Injection::TurnedImu { .. } if !has_motors => Some("separate axes can't be turned into each other"),
            Injection::TurnedImu { .. } if log.rate_rad_s[0].is_none() || log.rate_rad_s[1].is_none() => {
                Some("needs p and q")
            }
            Injection::CommandDelay { .. } if (0..3).all(|axis| command_std(log, axis) < COMMAND_MIN) => {
                Some("the commands stand still")
            }
            _ => None,
        }
    }

    /// The size of nothing put in: a difference of 0, a ratio of 1.
    pub fn nothing(&self) -> f64 {
        match self {
            Injection::GyroScale { .. } | Injection::CommandScale { .. } => 1.0,
            _ => 0.0,
        }
    }

    /// What was put in, of a scale of the commands what the vehicle answers by.
    pub fn truth(&self) -> f64 {
        match *self {
            Injection::GyroScale { scale, .. } => scale,
            Injection::GyroBias { bias_rad_s, .. } => bias_rad_s,
            Injection::TurnedImu { yaw_rad } => yaw_rad,
            Injection::AttitudeDelay { delay_s } | Injection::CommandDelay { delay_s } => delay_s,
            Injection::CommandScale { scale } => 1.0 / scale,
        }
    }

    /// The name and the parameter that an answer gives it; of a scale of the commands any of the axes' gains, or the
    /// lift.
    fn answers(&self) -> Vec<(String, &'static str)> {
        let of_axis = |effect: &str, axis: usize| format!("{effect} {}", Axis::ALL[axis].name());
        match *self {
            Injection::GyroScale { axis, .. } => vec![(of_axis("gyro_scale", axis), "scale")],
            Injection::GyroBias { axis, .. } => vec![(of_axis("gyro_bias", axis), "bias_rad_s")],
            Injection::TurnedImu { .. } => vec![("imu_misalignment".to_owned(), "yaw_rad")],
            Injection::AttitudeDelay { .. } => vec![("attitude_delay".to_owned(), "delay_s")],
            Injection::CommandDelay { .. } => vec![("actuation_delay".to_owned(), "delay_s")],
            Injection::CommandScale { .. } => {
                let gains = (0..3).map(|axis| (of_axis("input_gain", axis), "gain_rad_s2"));
                gains.chain([("thrust_scale".to_owned(), "scale")]).collect()
            }
        }
    }

    /// What to ask for its size by; none of a scale of the commands, which is no single effect.
    fn asked(&self) -> Option<Asked> {
        match *self {
            Injection::GyroScale { axis, .. } => Some(("gyro_scale", Some(Axis::ALL[axis]))),
            Injection::GyroBias { axis, .. } => Some(("gyro_bias", Some(Axis::ALL[axis]))),
            Injection::TurnedImu { .. } => Some(("imu_misalignment", None)),
            Injection::AttitudeDelay { .. } => Some(("attitude_delay", None)),
            Injection::CommandDelay { .. } => Some(("actuation_delay", None)),
            Injection::CommandScale { .. } => None,
        }
    }

    /// How far an answer to the injected log is from one to the recorded log, and from the truth.
    fn size(&self, recorded: Option<Estimate>, injected: Estimate) -> Option<InjectedSize> {
        let difference = || {
            let recorded = recorded.unwrap_or(Estimate { value: 0.0, std: 0.0 });
            Estimate { value: injected.value - recorded.value, std: injected.std.hypot(recorded.std) }
        };
        let ratio = || {
            let recorded = recorded.unwrap_or(Estimate { value: 1.0, std: 0.0 });
            let value = injected.value / recorded.value;
            let relative = (injected.std / injected.value).hypot(recorded.std / recorded.value);
            Estimate { value, std: (value * relative).abs() }
        };
        let (truth, found) = (self.truth(), if self.nothing() == 1.0 { ratio() } else { difference() });
        let z = (found.value - truth) / found.std;
        let interval_95 = [found.value - INTERVAL * found.std, found.value + INTERVAL * found.std];
        z.is_finite().then_some(InjectedSize { truth, found, z, interval_95 })
    }
}

/// Puts each kind of effect into a log and diagnoses it beside the log as it was recorded.
pub fn score(entry: &Entry) -> Vec<Injected> {
    let (log, subject) = (entry.log(), entry.subject());
    let answer = |log: &Log| -> Result<Vec<Named>, String> {
        let answer: Diagnosis = diagnose(log, &subject).map_err(|e| e.to_string())?;
        Ok(sized_terms(&answer))
    };
    let recorded = answer(&log);
    let with_own_size = |injection: &Injection| -> Result<Vec<Named>, String> {
        let mut recorded = recorded.clone()?;
        recorded.extend(own_size(&log, &subject, &recorded, injection));
        Ok(recorded)
    };
    let one = |injection: Injection| {
        let hidden = injection.hidden_in(&log, &subject).map(str::to_owned);
        let answers = hidden.map_or(Ok(()), Err).and_then(|()| {
            let injected = injection.into_log(&log).map_err(|e| e.to_string())?;
            Ok((with_own_size(&injection)?, answer(&injected)?))
        });
        match answers {
            Ok((recorded, injected)) => judged(entry.label(), injection, &recorded, &injected),
            Err(reason) => Injected { not_tried: Some(reason), ..judged(entry.label(), injection, &[], &[]) },
        }
    };
    injections(&log).into_iter().map(one).collect()
}

/// What the recorded log has of the effect by itself, fitted beside its findings; none where an answer names it, or
/// where it can't be asked for.
fn own_size(log: &Log, subject: &Subject<'_>, recorded: &[Named], injection: &Injection) -> Option<Named> {
    let wanted = injection.asked()?;
    let name = injection.answers().into_iter().next()?.0;
    if recorded.iter().any(|one| one.name == name) {
        return None;
    }
    let asked: Vec<Asked> = recorded.iter().filter_map(|one| one.asked).chain([wanted]).collect();
    let size = sizes(log, subject, &asked).ok()?.pop()??;
    let sizes = size.into_iter().map(|(name, estimate)| (name.to_owned(), estimate)).collect();
    Some(Named { name, sizes, gain_pct: None, one_of: Vec::new(), stability_pct: None, asked: Some(wanted) })
}

/// Judges the answer to an injected log by that to the recorded one.
fn judged(log: String, injection: Injection, recorded: &[Named], injected: &[Named]) -> Injected {
    let answers = injection.answers();
    let is_answer = |name: &str| answers.iter().any(|(answer, _)| answer == name);
    let estimate = |of: &[Named], name: &str, parameter: &str| {
        of.iter().find(|one| one.name == name).and_then(|one| one.sizes.get(parameter).copied())
    };
    let size = answers.iter().find_map(|(name, parameter)| {
        injection.size(estimate(recorded, name, parameter), estimate(injected, name, parameter)?)
    });
    let nothing = injection.nothing();
    let missing = |of: &[Named], from: &[Named]| -> Vec<String> {
        let is_missing = |one: &&Named| !is_answer(&one.name) && from.iter().all(|other| other.name != one.name);
        of.iter().filter(is_missing).map(|one| one.name.clone()).collect()
    };
    let differs = |size: InjectedSize| (size.found.value - nothing).abs() > INTERVAL * size.found.std;
    let is_new = |one: &&Named| recorded.iter().all(|other| other.name != one.name);
    let effect = |name: &str| name.split(' ').next().map(str::to_owned);
    let is_one_of =
        |one: &Named| one.one_of.iter().any(|of| answers.iter().any(|(answer, _)| effect(answer) == effect(of)));
    Injected {
        log,
        injection,
        not_tried: None,
        is_named: size.map_or_else(|| injected.iter().filter(is_new).any(is_one_of), differs),
        size,
        other_new: missing(injected, recorded),
        gone: missing(recorded, injected),
    }
}

/// A line for each effect and the shares of all: named, within the interval, without other new names.
pub fn table(outcomes: &[Injected]) -> String {
    let mut lines = vec![
        "| log | put in | named | size: truth, found | z | other new names | gone |\n|---|---|---|---|---|---|---|"
            .to_owned(),
    ];
    lines.extend(outcomes.iter().map(line));
    let tried: Vec<&Injected> = outcomes.iter().filter(|one| one.not_tried.is_none()).collect();
    let count = |of: &dyn Fn(&Injected) -> bool| tried.iter().filter(|one| of(one)).count();
    let mut widths: Vec<f64> = tried
        .iter()
        .filter(|one| one.is_named)
        .filter_map(|one| Some(one.size?.relative_half_width(one.injection.nothing())))
        .collect();
    widths.sort_by(f64::total_cmp);
    let width_pct = widths.get(widths.len() / 2).map_or("-".to_owned(), |width| format!("{:.0}", 100.0 * width));
    lines.push(format!(
        "\nnamed {} of {} (goal 90 %); interval holds the truth in {} of {} with a size (goal 90 %), half width of \
         those named {width_pct} % of the effect in the median (goal 15 %); other new names in {}; not tried {}\n",
        count(&|one| one.is_named),
        tried.len(),
        count(&|one| one.size.is_some_and(|size| size.is_held())),
        count(&|one| one.size.is_some()),
        count(&|one| !one.other_new.is_empty()),
        outcomes.len() - tried.len()
    ));
    lines.join("\n")
}

/// A row of the table.
pub fn line(one: &Injected) -> String {
    let what = one.injection;
    if let Some(reason) = &one.not_tried {
        return format!("| {} | {what} | not tried: {reason} | | | | |", one.log);
    }
    let (size, z) = one.size.map_or(("-".to_owned(), "-".to_owned()), |InjectedSize { truth, found, z, .. }| {
        (format!("{truth:.4}, {:.4} +- {:.4}", found.value, found.std), format!("{z:+.1}"))
    });
    let named = if one.is_named { "yes" } else { "NO" };
    format!(
        "| {} | {what} | {named} | {size} | {z} | {} | {} |",
        one.log,
        one.other_new.join(", "),
        one.gone.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn named(name: &str, parameter: &str, value: f64, std: f64) -> Named {
        let sizes = BTreeMap::from([(parameter.to_owned(), Estimate { value, std })]);
        Named { name: name.to_owned(), sizes, gain_pct: None, one_of: Vec::new(), stability_pct: None, asked: None }
    }

    #[test]
    fn what_the_recorded_log_has_already_is_taken_off() {
        let delay = Injection::CommandDelay { delay_s: 0.03 };
        let recorded =
            [named("actuation_delay", "delay_s", 0.02, 0.003), named("spring pitch", "stiffness_1_s2", 9.0, 1.0)];
        let injected =
            [named("actuation_delay", "delay_s", 0.051, 0.004), named("torque_bias roll", "torque_nm", 1.0, 0.1)];
        let outcome = judged(String::new(), delay, &recorded, &injected);
        let size = outcome.size.unwrap();
        assert!(outcome.is_named && size.is_held());
        assert!((size.found.value - 0.031).abs() < 1e-12 && (size.found.std - 0.005).abs() < 1e-12);
        assert!((size.z - 0.2).abs() < 1e-9);
        assert_eq!(
            (outcome.other_new, outcome.gone),
            (vec!["torque_bias roll".to_owned()], vec!["spring pitch".to_owned()])
        );
    }

    #[test]
    fn scales_are_compared_by_their_ratio_and_commands_by_its_reciprocal() {
        let scale = Injection::GyroScale { axis: 1, scale: 1.2 };
        let of = |value: f64| named("gyro_scale pitch", "scale", value, 0.011);
        let outcome = judged(String::new(), scale, &[of(1.1)], &[of(1.32)]);
        let size = outcome.size.unwrap();
        assert!((size.found.value - 1.2).abs() < 1e-12 && size.is_held() && outcome.is_named);
        let gain = |value: f64| named("input_gain roll", "gain_rad_s2", value, 0.5);
        let outcome = judged(String::new(), Injection::CommandScale { scale: 0.8 }, &[gain(100.0)], &[gain(125.0)]);
        assert!((outcome.size.unwrap().truth - 1.25).abs() < 1e-12 && outcome.size.unwrap().z.abs() < 1e-9);
    }

    #[test]
    fn an_unchanged_answer_names_nothing() {
        let recorded = [named("actuation_delay", "delay_s", 0.02, 0.003)];
        let outcome = judged(String::new(), Injection::CommandDelay { delay_s: 0.03 }, &recorded, &recorded);
        assert!(!outcome.is_named && !outcome.size.unwrap().is_held());
        let one_of =
            Named { one_of: vec!["gyro_bias roll".to_owned()], ..named("torque_bias roll", "torque_nm", 1.0, 0.1) };
        let bias = Injection::GyroBias { axis: 0, bias_rad_s: 0.1 };
        assert!(judged(String::new(), bias, &recorded, std::slice::from_ref(&one_of)).is_named);
        assert!(!judged(String::new(), bias, std::slice::from_ref(&one_of), std::slice::from_ref(&one_of)).is_named);
        let outcome = judged(String::new(), bias, &recorded, &recorded);
        assert!(!outcome.is_named && outcome.size.is_none() && outcome.other_new.is_empty());
    }

    #[test]
    fn each_kind_is_put_in_once_with_delays_of_whole_rows() {
        let column = || Some(vec![0.0; 200]);
        let log = Log {
            axes: [true, true, false],
            time_s: (0..200).map(|row| 0.02 * f64::from(row)).collect(),
            angle_rad: [None, column(), None],
            rate_rad_s: [column(), column(), None],
            ..Log::default()
        };
        let all = injections(&log);
        assert_eq!(all.len(), 6);
        assert_eq!(all[0], Injection::GyroScale { axis: 1, scale: GYRO_SCALE });
        let Injection::AttitudeDelay { delay_s } = all[3] else { panic!("{all:?}") };
        assert!((delay_s - 0.04).abs() < 1e-9);
        assert!(all[0].hidden_in(&log, &Subject::Axes).is_none() && all[2].hidden_in(&log, &Subject::Axes).is_some());
        assert!(all[4].hidden_in(&log, &Subject::Axes).is_some(), "no command moves");
        assert!(Injection::GyroScale { axis: 0, scale: 1.1 }.hidden_in(&log, &Subject::Axes).is_some());
    }
}
