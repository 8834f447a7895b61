//! Motors of a healthy vehicle do not lift alike. Of one that lifts less than the others trims of roll and pitch take
//! up most, where they are fitted along; what is left, about yaw and from one axis' commands about another, is by how
//! much those that turn one way lift more than those that turn the other way. All four motors are in that. The size of
//! a weak one, which takes the three others for alike, has their ordinary scatter in it.

use std::collections::BTreeMap;

use super::base::is_trimmed;
use super::estimate::Estimate;
use crate::axis::Axis;
use crate::diagnosis::fitting::fit::Term;

/// Standard deviation of what a healthy motor with its propeller lifts beside the mean of all: normal flights of
/// CrazyPAD's airframes differ by as much as with one blade that is cut from 47 to 46 mm.
const LIFT_STD: f64 = 0.015;

/// Counts in the interval of a weak motor's size how the three others differ, where trims leave nothing else of it.
pub(super) fn count_others(terms: &[Term<'_>], parameters: &mut BTreeMap<&'static str, Estimate>, effect: &str) {
    let is_one_of_four = [Axis::Roll, Axis::Pitch].into_iter().all(|axis| is_trimmed(terms, Some(axis)));
    if effect == "weak_motor"
        && is_one_of_four
        && let Some(scale) = parameters.get_mut("scale")
    {
        scale.std = libm::hypot(scale.std, 3f64.sqrt() * LIFT_STD);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::fitted::Fitted;
    use crate::effects::Scope;

    #[test]
    fn beside_trims_the_other_motors_are_in_a_weak_ones_size() {
        let trims = Fitted::beside(&Scope::OF_AXES, |_| true);
        let trims = trims.iter().filter(|effect| effect.name() == "torque_bias");
        let trims: Vec<Term<'_>> = trims.map(|effect| Term { effect, values: vec![0.01] }).collect();
        let std_of = |terms: &[Term<'_>], effect: &str| {
            let mut parameters = BTreeMap::from([("scale", Estimate { value: 0.93, std: 0.01 })]);
            count_others(terms, &mut parameters, effect);
            parameters["scale"].std
        };
        let with_others = f64::sqrt(0.01 * 0.01 + 3.0 * 0.015 * 0.015);
        assert!((std_of(&trims, "weak_motor") - with_others).abs() < 1e-12);
        assert_eq!(std_of(&[], "weak_motor"), 0.01);
        assert_eq!(std_of(&trims, "thrust_scale"), 0.01);
    }
}
