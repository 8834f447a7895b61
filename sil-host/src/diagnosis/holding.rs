//! Commands that hold against a disturbance, and what they do all the same.
//!
//! A flight controller answers what turns its vehicle, and turns in its own air, gusts and wash last for tenths of a
//! second. Of such a disturbance each command is the mirror image: commands and motion seem to contradict each other,
//! and a fit that takes all disturbances for white believes in weak motors (of an acrobatic quadrotor's, in a fifth of
//! what they do). A disturbance that lasts belongs in the noise model then: what a row adds to the rows before it is
//! free of what commands have answered already, and the prediction-error method is consistent in a closed loop
//! (Forssell and Ljung, Closed-loop identification revisited, Automatica 35, 1999; what lasts is a process of Ornstein
//! and Uhlenbeck, `axis_filter`).
//!
//! All that is slow is worth less under it: gravity and friction of a bench hide in what lasts. So a bench's log is
//! held under it only where its gains are others by far.

use std::fmt;

use serde::Serialize;

use super::base::{self, Numbers, numbers_of};
use super::effectiveness;
use super::estimate::Estimate;
use super::fitted::Fitted;
use super::search::Search;
use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Fit, Nominal};
use crate::diagnosis::fitting::process_noise::Disturbance;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::log::Log;
use crate::log::sanity::exceeds;
use crate::prediction::{NotPredictable, Subject};

/// So many standard deviations from none a gain must be to count.
const SURE: f64 = 4.0;
/// And so many above the one that a base model of white noise has, by this factor at least: in a flight, and where
/// gravity and a bearing are to be told, too.
const APART_STDS: f64 = 2.0;
const APART: [f64; 2] = [1.1, 1.5];

/// Noise and model are found in turns at most so often, and until no gain changes by more than this share.
const ROUNDS: usize = 8;
const SETTLED: f64 = 0.03;

/// A disturbance that lasts about an axis, which its commands hold against.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Holding {
    /// Which axis.
    pub axis: &'static str,
    /// Standard deviation of its angular acceleration, rad/s^2.
    pub std_rad_s2: f64,
    /// After so long it is down to 1/e of what it was, s.
    pub memory_s: f64,
}

/// "disturbance (roll): 64.0 rad/s^2, remembered for 1 s".
impl fmt::Display for Holding {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "disturbance ({}): {:.1} rad/s^2, remembered for {} s", self.axis, self.std_rad_s2, self.memory_s)
    }
}

/// What commands hold against, and what follows for whoever reads the numbers, in words; none where they hold against
/// nothing.
pub(crate) fn held_against(holding: &[Holding]) -> Option<String> {
    let axes: Vec<&str> = holding.iter().map(|of| of.axis).collect();
    (!axes.is_empty()).then(|| {
        format!(
            "Something that no log shows (wind, the propellers' own wake) moves this vehicle about {}, and the \
             commands hold against it. The base model is fitted with that in mind. Replayed open loop the commands \
             answer what the replay does not have: a model that knows what they do then misses more than one that does \
             not, and how much it misses is no test of it.",
            axes.join(", ")
        )
    })
}

/// The gain of an axis if disturbances last.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LastingGain {
    /// Which axis.
    pub axis: &'static str,
    /// Angular acceleration per unit of command, rad/s^2.
    pub gain_rad_s2: f64,
    /// Its standard deviation.
    pub std_rad_s2: f64,
}

impl LastingGain {
    /// Is it another's within what is taken for settled?
    fn is_near(&self, other: &LastingGain) -> bool {
        (other.gain_rad_s2 - self.gain_rad_s2).abs() < SETTLED * other.gain_rad_s2.abs()
    }
}

/// "pitch: 304 +- 18 rad/s^2".
impl fmt::Display for LastingGain {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {:.0} +- {:.0} rad/s^2", self.axis, self.gain_rad_s2, self.std_rad_s2)
    }
}

/// A log in the noise of disturbances that last.
pub(super) struct Lasting<'l> {
    pub(super) shooting: Shooting<'l>,
    /// Of its base model there.
    pub(super) numbers: Numbers,
    pub(super) gains: Vec<LastingGain>,
    /// Does a gain surely differ by far from the one in white noise?
    pub(super) denies: bool,
}

/// A log in the noise of disturbances that last; none where none does, or of a vehicle's model.
///
/// # Errors
/// As [`Subject::windowed`].
pub(super) fn in_lasting_noise<'l>(
    log: &'l Log,
    subject: &Subject<'_>,
    search: &Search<'_>,
    ordinary: &[Fitted],
    base: &Fit<'_>,
) -> Result<Option<Lasting<'l>>, NotPredictable> {
    if subject.is_vehicle() {
        return Ok(None);
    }
    let gains_of = |fit: &Fit<'_>| gains_of(fit, subject, search.nominal);
    let mut shooting = base::in_noise_of(log, subject, search, base, Disturbance::Lasting)?;
    let (mut numbers, mut gains) = (begun_at(base, search.gains.len(), ordinary), gains_of(base));
    // what a base model of white noise leaves is what a wrong one leaves: noise and model are found in turns
    for round in 0..ROUNDS {
        if !shooting.is_disturbed() {
            return Ok(None);
        }
        let search = under(&shooting, search);
        let fit = match round {
            0 => base::fitted(&search, ordinary, Some(&numbers)).fit,
            _ => base::fitted_from(&search, ordinary, &numbers),
        };
        let next = base::in_noise_of(log, subject, &search, &fit, Disturbance::Lasting)?;
        let found = gains_of(&fit);
        let is_settled = gains.iter().zip(&found).all(|(before, now)| before.is_near(now));
        (numbers, gains) = (numbers_of(&fit), found);
        shooting = next;
        if is_settled {
            break;
        }
    }
    if !shooting.is_disturbed() {
        return Ok(None);
    }
    let (gains, numbers) = {
        let search = under(&shooting, search);
        let fit = base::fitted(&search, ordinary, Some(&numbers)).fit;
        let numbers = numbers_of(&fit);
        (gains_of(&search.with_parts_left_out(fit)), numbers)
    };
    let apart = APART[usize::from(!log.shows_free_flight())];
    let is_sure = |of: &LastingGain| of.gain_rad_s2.abs() > SURE * of.std_rad_s2;
    let both = |of: &LastingGain| [of.gain_rad_s2, of.std_rad_s2];
    let exceeds =
        |(own, of): (&LastingGain, &LastingGain)| is_sure(of) && exceeds(both(of), both(own), [apart, APART_STDS]);
    // how sure the others are takes many fits, and matters only where it could tell them apart
    let exact = |own: LastingGain| LastingGain { std_rad_s2: 0.0, ..own };
    let may_deny = gains_of(base).into_iter().map(exact).zip(&gains).any(|(own, of)| exceeds((&own, of)));
    let own = || gains_of(&search.with_parts_left_out(base.clone()));
    let denies = may_deny && own().iter().zip(&gains).any(exceeds);
    Ok(Some(Lasting { shooting, numbers, gains, denies }))
}

/// The search for a base model under a noise.
fn under<'e>(shooting: &'e Shooting<'e>, search: &Search<'e>) -> Search<'e> {
    Search::new(shooting, search.nominal, &[], search.gains.clone(), search.observer)
}

/// The numbers of a base model, with those that it was relieved of at their beginning.
fn begun_at(base: &Fit<'_>, gains: usize, ordinary: &[Fitted]) -> Numbers {
    let begun = |effect: &Fitted| {
        let own = base.terms.iter().find(|term| term.effect.is_the_same(effect));
        own.map_or_else(|| effect.beginning(&[0.0; 2]), |term| term.values.clone())
    };
    let own = base.terms[..gains].iter().map(|term| term.values.clone());
    own.chain(ordinary.iter().map(begun)).collect()
}

/// The input gains of a fit with their intervals, axis by axis.
fn gains_of(fit: &Fit<'_>, subject: &Subject<'_>, nominal: Nominal<'_>) -> Vec<LastingGain> {
    let gains = effectiveness::of(fit, nominal, subject);
    let of = |axis: Axis| {
        let Estimate { value, std } = gains[axis.index()]?;
        Some(LastingGain { axis: axis.name(), gain_rad_s2: value, std_rad_s2: std })
    };
    Axis::ALL.into_iter().filter_map(of).collect()
}

/// What a log is held under.
pub(super) fn holding(shooting: &Shooting<'_>) -> Vec<Holding> {
    let axes = Axis::ALL.into_iter().filter_map(|axis| Some((axis, shooting.lasting_about(axis)?)));
    axes.map(|(axis, lasting)| Holding {
        axis: axis.name(),
        std_rad_s2: lasting.std_rad_s2,
        memory_s: lasting.memory_s,
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::{Diagnosis, Verdict, diagnose};
    use crate::sensors::random::RandomStream;
    use crate::statistics::wrapped;

    const GAIN: f64 = 300.0;
    const LAG_S: f64 = 0.02;
    const STEP_S: f64 = 0.005;

    /// 40 s of a rate under a controller with integrator, in a disturbance that is remembered for 0.3 s, and of its
    /// angle.
    fn flight_with_angle(disturbance_rad_s2: f64, seed: u64) -> (Log, Vec<f64>) {
        let mut random = RandomStream::new(seed, "holding");
        let [mut rate, mut angle, mut integral, mut disturbance, mut wanted, mut motor] = [0.0; 6];
        let (mut angles, mut of_angle) = (Vec::new(), RandomStream::new(seed, "angle"));
        let mut log = Log { axes: [true, false, false], comments: vec!["free flight".to_owned()], ..Log::default() };
        let [mut rates, mut commands] = [const { Vec::<f64>::new() }; 2];
        for row in 0..8_000 {
            log.time_s.push(f64::from(row) * STEP_S);
            if row % 100 == 0 {
                wanted = 0.7 * random.normal();
            }
            let seen = rate + 2e-3 * random.normal();
            let error = wanted - seen;
            integral += error * STEP_S;
            let command: f64 = ((14.0 * error + 60.0 * integral) / GAIN).clamp(-1.0, 1.0);
            rates.push(seen);
            angles.push(wrapped(angle + 5e-4 * of_angle.normal()));
            commands.push(command);
            for _ in 0..20 {
                let step_s = STEP_S / 20.0;
                let kept = libm::exp(-step_s / 0.3);
                disturbance = kept * disturbance + disturbance_rad_s2 * (1.0 - kept * kept).sqrt() * random.normal();
                motor += step_s / LAG_S * (command - motor);
                angle += step_s * rate;
                rate += step_s * (GAIN * motor + disturbance);
            }
        }
        log.rate_rad_s[0] = Some(rates);
        log.axis_command[0] = Some(commands);
        (log, angles)
    }

    fn flight(disturbance_rad_s2: f64, seed: u64) -> Log {
        flight_with_angle(disturbance_rad_s2, seed).0
    }

    fn number(answer: &Diagnosis, effect: &str) -> Estimate {
        let term = answer.base.iter().find(|term| term.effect == effect).unwrap();
        *term.parameters.values().next().unwrap()
    }

    #[test]
    fn what_commands_do_shows_though_they_hold_against_a_disturbance() {
        for seed in 0..3 {
            let answer = diagnose(&flight(40.0, seed), &Subject::Axes).unwrap();
            let (gain, lag_s) = (number(&answer, "input_gain"), answer.lateness_s.unwrap());
            println!("{gain:?} {lag_s:?} {:?} {:?}", answer.holding, answer.findings);
            assert!((gain.value - GAIN).abs() < 3.5 * gain.std && gain.std < 0.2 * GAIN, "seed {seed}: {gain:?}");
            assert!((lag_s.value - LAG_S).abs() < 3.5 * lag_s.std && lag_s.std < 0.01, "seed {seed}: {lag_s:?}");
            let [held] = answer.holding.as_slice() else { panic!("seed {seed}: {:?}", answer.holding) };
            // of a memory three times as long, changes as strong have 1.8 times the deviation: 73 rad/s^2
            assert!(held.axis == "roll" && (40.0..100.0).contains(&held.std_rad_s2), "seed {seed}: {held}");
            assert_eq!((answer.verdict, answer.findings.len()), (Verdict::UnknownEffect, 0), "{:?}", answer.findings);
        }
    }

    #[test]
    fn a_predicted_angle_that_turns_over_changes_nothing() {
        let (mut log, angles) = flight_with_angle(40.0, 0);
        log.angle_rad[0] = Some(angles);
        let answer = diagnose(&log, &Subject::Axes).unwrap();
        let gain = number(&answer, "input_gain");
        assert!((gain.value - GAIN).abs() < 3.5 * gain.std && gain.std < 0.2 * GAIN, "{gain:?}");
        assert_eq!(answer.holding.len(), 1);
    }

    #[test]
    fn where_little_disturbs_nothing_is_held_under_what_lasts() {
        let answer = diagnose(&flight(0.5, 1), &Subject::Axes).unwrap();
        let gain = number(&answer, "input_gain");
        assert!(answer.holding.is_empty() && (gain.value - GAIN).abs() < 3.5 * gain.std, "{gain:?}");
    }
}
