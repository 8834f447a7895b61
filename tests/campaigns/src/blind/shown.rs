//! How much of a log hangs on its cause: of a vehicle of which everything is a little off, a centre of gravity may show
//! as nothing but the trim that it makes when level, and a disturbance that sets in as less than gusts do.

use sil_host::log::Log;

use super::behaviour::{Named, inertia_kg_m2};
use super::case::Case;

/// What trims are tried by, rad/s^2. Errors are linear in them, so that any size does.
const STEP_RAD_S2: f64 = 0.2;

/// Share by which the true vehicle's held-out error grows without the cause, if trims of roll and pitch, which any
/// vehicle has, make up for it as well as they can; none where there is no cause. A finding has to gain 2 %.
pub(super) fn shown(case: &Case, log: &Log) -> Option<f64> {
    let (cause, _) = case.hidden.first()?;
    let own = Named::of_short(&cause.short(cause.first_size));
    let all: Vec<String> = case.vehicle.effects.iter().map(|effect| effect.to_short()).collect();
    let without = all.iter().filter(|short| !Named::of_short(short).is_at(&own)).cloned().collect();
    let [with, without] = [all, without].map(|effects: Vec<String>| least_error(case, log, &effects));
    Some(without / with - 1.0)
}

/// Held-out error over the floor, roll's and pitch's trims at their best: the least of a parabola through six points.
fn least_error(case: &Case, log: &Log, effects: &[String]) -> f64 {
    let step_nm = inertia_kg_m2(&case.conditions.vehicle(&[])).map(|inertia_kg_m2| STEP_RAD_S2 * inertia_kg_m2);
    let error = |steps: [f64; 2]| {
        let mut shorts = effects.to_vec();
        for ((axis, steps), step_nm) in ["roll", "pitch"].into_iter().zip(steps).zip(step_nm) {
            if steps != 0.0 {
                shorts.push(format!("torque_bias:axis={axis},torque_nm={}", steps * step_nm));
            }
        }
        case.conditions.ratio_under(log, &case.conditions.vehicle(&shorts)).powi(2)
    };
    let here = error([0.0, 0.0]);
    let [[up, down], [right, left]] =
        [[[1.0, 0.0], [-1.0, 0.0]], [[0.0, 1.0], [0.0, -1.0]]].map(|pair| pair.map(&error));
    let both = error([1.0, 1.0]);
    let slope = [0.5 * (up - down), 0.5 * (right - left)];
    let [aa, bb] = [up + down - 2.0 * here, right + left - 2.0 * here];
    let ab = both - up - right + here;
    let determinant = aa * bb - ab * ab;
    let to = [(ab * slope[1] - bb * slope[0]) / determinant, (ab * slope[0] - aa * slope[1]) / determinant];
    error(to).min(here).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first of them is a centre of gravity off to the side: level it is a trim, and leaning by 30 degrees it has
    /// lost an eighth of its moment. No trim is a friction.
    #[test]
    fn what_trims_make_up_for_is_not_shown() {
        let [beside, brakes] = [0, 1].map(|seed| Case::reality(seed, 20.0));
        assert_eq!([&beside, &brakes].map(|case| case.hidden[0].0.name), ["cg_offset", "viscous_friction"]);
        let [beside, brakes] = [beside, brakes].map(|case| shown(&case, &case.log()).unwrap());
        assert!(beside.abs() < 0.05 && brakes > 0.3, "{beside} {brakes}");
    }
}
