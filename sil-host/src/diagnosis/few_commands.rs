//! Logs that have few of the commands that were given. What the vehicle does between two of them nobody can say, and a
//! search makes causes of it: of flights of others that logged their commands ten times a second one seemed to have a
//! motor that lifts half. Sensors are judged all the same, attitude and gyro against each other.

use std::collections::BTreeSet;

use super::Rejected;
use super::fitted::Fitted;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::effects::{Origin, Scope};
use crate::log::{Log, SLOW_HZ};

/// Why what acts by the commands is not looked for.
const NOT_ASKED: &str = "not asked: the log has few of the commands that were given";

/// Commands that a log has of each second, where the controller gave others between them: as its motion has it, and of
/// a flight controller, which commands some hundred times a second, whatever its motion has.
pub(super) fn commands_per_s(log: &Log, shooting: &Shooting<'_>) -> Option<f64> {
    let others = shooting.log.lost.is_some() || log.flight_controller.is_some();
    others.then(|| 1.0 / log.commands().median_step_s())
}

/// Are these so few that no log shows what they do?
pub(super) fn are_few(commands_per_s: Option<f64>) -> bool {
    commands_per_s.is_some_and(|per_s| per_s < SLOW_HZ)
}

/// Is a log one of those?
pub(super) fn has_few(log: &Log, shooting: &Shooting<'_>) -> bool {
    are_few(commands_per_s(log, shooting))
}

/// Can an effect be told without commands?
pub(super) fn is_asked(effect: &Fitted) -> bool {
    effect.origin() == Origin::Sensor
}

/// What is not looked for in such a log, each name once.
pub(super) fn not_asked(scope: &Scope) -> Vec<Rejected> {
    let names: BTreeSet<&'static str> =
        Fitted::hypotheses(scope).iter().filter(|effect| !is_asked(effect)).map(Fitted::name).collect();
    let unasked = |effect| Rejected { effect, axis: String::new(), reason: NOT_ASKED.to_owned() };
    names.into_iter().map(unasked).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_are_those_below_thirty_a_second_that_are_not_all() {
        assert!(are_few(Some(10.0)) && !are_few(Some(50.0)) && !are_few(None));
    }

    #[test]
    fn what_is_not_asked_of_is_said_and_sensors_are_asked() {
        let unasked = not_asked(&Scope::OF_AXES);
        let has = |name: &str| unasked.iter().filter(|one| one.effect == name).count();
        assert_eq!([has("torque_bias"), has("motor_lag"), has("gyro_bias")], [1, 1, 0]);
    }
}
