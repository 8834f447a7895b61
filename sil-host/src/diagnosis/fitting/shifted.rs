//! Models that differ from another one by steps of its numbers, for difference quotients along these.
//!
//! A number of a separate axis changes nothing that is predicted of the others, so that one model serves for a number
//! of each of the three (Curtis, Powell and Reid, On the estimation of sparse Jacobian matrices, J. Inst. Maths Applics
//! 13, 1974).

use rayon::prelude::*;

use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Nominal, Term, model_of};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::effects::Unknown;
use crate::prediction::windowed_log::Driven;

/// A model with some numbers moved.
pub(in crate::diagnosis) struct Shifted {
    pub(in crate::diagnosis) driven: Driven,
    pub(in crate::diagnosis) numbers: Vec<Moved>,
}

/// A number that is moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnosis) struct Moved {
    /// Its place among all that are.
    pub(in crate::diagnosis) place: usize,
    pub(in crate::diagnosis) step: f64,
    /// The separate axis that it acts on alone; none of one that may act on all.
    pub(in crate::diagnosis) axis: Option<Axis>,
}

/// Where a number is moved: its term, and its place among that one's.
type At = (usize, usize);

/// Models in which each parameter of the terms from `first` on is moved by its step.
pub(in crate::diagnosis) fn shifted_models(
    shooting: &Shooting<'_>,
    nominal: Nominal<'_>,
    terms: &[Term<'_>],
    first: usize,
) -> Vec<Shifted> {
    let is_separate = model_of(nominal, terms).has_separate_axes();
    let driven = |numbers: Vec<(At, Moved)>| {
        let mut moved = terms.to_vec();
        for ((term, number), Moved { step, .. }) in &numbers {
            moved[*term].values[*number] += step;
        }
        let numbers = numbers.into_iter().map(|(_, moved)| moved).collect();
        Shifted { driven: shooting.log.drive(model_of(nominal, &moved)), numbers }
    };
    // some have forces of their own to follow over the whole log
    together(terms, first, is_separate).into_par_iter().with_max_len(1).map(driven).collect()
}

/// The numbers of the terms from `first` on, those together of which each acts on a separate axis of its own.
fn together(terms: &[Term<'_>], first: usize, is_separate: bool) -> Vec<Vec<(At, Moved)>> {
    let mut all: Vec<Vec<(At, Moved)>> = Vec::new();
    let mut place = 0;
    for (index, term) in terms.iter().enumerate().skip(first) {
        let axis = term.effect.separate_axis(&term.values).filter(|_| is_separate);
        for (number, (unknown, value)) in term.effect.unknowns().iter().zip(&term.values).enumerate() {
            let moved = ((index, number), Moved { place, step: admissible_step(unknown, *value), axis });
            let is_beside = |(_, other): &(At, Moved)| axis.is_some() && other.axis.is_some() && other.axis != axis;
            match all.iter_mut().find(|others| others.iter().all(is_beside)) {
                Some(others) => others.push(moved),
                None => all.push(vec![moved]),
            }
            place += 1;
        }
    }
    all
}

/// The step of a number's difference quotient, which stays within its range.
pub(super) fn admissible_step(parameter: &Unknown, value: f64) -> f64 {
    if value + parameter.step <= parameter.max { parameter.step } else { -parameter.step }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::fitted::Fitted;
    use crate::log::Log;
    use crate::prediction::Subject;
    use crate::sensors::random::RandomStream;

    /// Six seconds of three axes with angles and rates, whose commands and motion have nothing to do with each other.
    fn log() -> Log {
        let mut random = RandomStream::new(6, "shifted");
        let mut column = |size: f64| Some((0..1200).map(|_| size * random.normal()).collect::<Vec<f64>>());
        Log {
            axes: [true; 3],
            time_s: (0..1200).map(|row| 0.005 * f64::from(row)).collect(),
            angle_rad: [0.2, 0.2, 0.2].map(&mut column),
            rate_rad_s: [1.0, 1.0, 1.0].map(&mut column),
            axis_command: [0.1, 0.1, 0.1].map(&mut column),
            ..Log::default()
        }
    }

    fn is_fitted(effect: &Fitted) -> bool {
        ["torque_bias", "motor_lag", "viscous_friction", "spring", "gyro_bias"].contains(&effect.name())
    }

    #[test]
    fn numbers_of_separate_axes_are_moved_at_once_and_have_the_slopes_that_each_has_alone() {
        let (log, subject) = (log(), Subject::Axes);
        let shooting = subject.shooting(&log, &subject.noise(&log)).unwrap();
        let effects: Vec<Fitted> = Axis::ALL.into_iter().map(Fitted::InputGain).collect();
        let effects: Vec<Fitted> =
            effects.into_iter().chain(Fitted::hypotheses(&subject.scope(&log)).into_iter().filter(is_fitted)).collect();
        let value = |unknown: &Unknown| (unknown.nominal + 20.0 * unknown.step).clamp(unknown.min, unknown.max);
        let term = |effect| Term { effect, values: Fitted::unknowns(effect).iter().map(value).collect() };
        let (terms, nominal): (Vec<Term<'_>>, _) = (effects.iter().map(term).collect(), || subject.model(&log));
        let starts = shooting.log.measured_starts(&nominal());
        let windows = shooting.log.in_use();
        let shifted = shifted_models(&shooting, &nominal, &terms, 0);
        let base = shooting.log.drive(model_of(&nominal, &terms));
        let linear = shooting.linearise(&base, &shifted, &windows, &starts, None);
        let numbers: Vec<(At, Moved)> = together(&terms, 0, false).into_iter().flatten().collect();
        // of roll and pitch a gain, a trim, a brake, a spring and its rest, of yaw the first three; a lag, and three
        // biases, each of which turns all of a body
        assert_eq!((shifted.len(), numbers.len()), (5 + 1 + 3, 5 + 5 + 3 + 1 + 3));
        for ((term, number), Moved { place, step, .. }) in numbers {
            let mut moved = terms.clone();
            moved[term].values[number] += step;
            let driven = shooting.log.drive(model_of(&nominal, &moved));
            let alone = [Shifted { driven, numbers: vec![Moved { place: 0, step, axis: None }] }];
            let slopes = shooting.slopes_of(&linear, &alone, &windows, &starts);
            let is_equal =
                slopes.iter().zip(&linear.windows).all(|(alone, window)| alone[0] == window.parameters[place]);
            assert!(is_equal, "{} {number}", terms[term].effect.name());
        }
    }
}
