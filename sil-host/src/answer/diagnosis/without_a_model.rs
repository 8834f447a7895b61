//! What is said where an answer is no model of the vehicle: why not, and which flight would show one.

use crate::axis::Axis;
use crate::diagnosis::{Diagnosis, NotShownBecause, Verdict};

use crate::answer::plain_words::axis_of;

/// Rows a second that show what motors do.
const ROWS_WANTED_PER_S: f64 = 100.0;

/// Of a log that does not show what its commands do.
pub fn not_shown(answer: &Diagnosis) -> String {
    let because = match answer.not_shown_because {
        Some(NotShownBecause::FewCommands) => {
            "The log has few of them, and what the controller commanded in between nobody knows: how late and how \
             strongly the vehicle answers hardly shows."
        }
        Some(NotShownBecause::NoVehicle) => {
            "What fits best is no vehicle: it turns against its commands, or before its motors can turn it. Then the \
             controller's answer to the motion was taken for the motion's cause, or a column is not what it seems."
        }
        Some(NotShownBecause::Denied) => {
            "What follows from what the controller was told shows another gain than all motion together (both stand \
             below): something beside the commands moved the vehicle as much as they did."
        }
        Some(NotShownBecause::NoGain) => {
            "How strongly the vehicle answers them stays unknown: of no axis is that surely more than nothing."
        }
        Some(NotShownBecause::BesideCommands) | None => {
            "No linear response to them predicts the motion much better than its mean: they hardly change, or \
             something beside them moves the vehicle as much."
        }
    };
    format!("Not shown by this log: what the commands do. {because} {} would show it.", flight_wanted(answer))
}

/// Of a model that is none.
pub fn not_a_model(answer: &Diagnosis) -> String {
    format!(
        "Not a model of this vehicle yet: whatever is added, it predicts no better than the measurements' mean. {}",
        what_to_do(answer)
    )
}

/// What is not to be taken for a cause, above what was found.
pub fn warning(answer: &Diagnosis) -> Option<String> {
    let because = match answer.verdict {
        Verdict::NotAModel => "Whatever is added, the model predicts no better than the measurements' mean",
        Verdict::NotShown => "This log does not show what the commands do",
        _ => return None,
    };
    let then = match answer.findings.is_empty() {
        true => "no cause can be told",
        false => "what stands below is the best of what was tried, not a cause",
    };
    Some(format!("{because}: {then}."))
}

/// What to do then.
pub fn what_to_do(answer: &Diagnosis) -> String {
    let flight = flight_wanted(answer);
    format!(
        "If the vehicle lay, hung or was held in a part of the log, cut that away (--from, --to). {flight} would show \
         more."
    )
}

/// Of the axes that the log has, as often as it is wanted.
fn flight_wanted(answer: &Diagnosis) -> String {
    let turns = |axis: &&Axis| answer.statistics.iter().any(|of| axis_of(of.quantity) == Some(axis.name()));
    let leaning = [Axis::Roll, Axis::Pitch];
    let shown: Vec<&str> = leaning.iter().filter(turns).map(|axis| axis.name()).collect();
    let axes = match shown.as_slice() {
        [] if answer.statistics.is_empty() => "roll and pitch".to_owned(),
        [] => Axis::Yaw.name().to_owned(),
        shown => shown.join(" and "),
    };
    let rows = match answer.not_shown_because {
        Some(NotShownBecause::FewCommands) => format!(", its commands logged {ROWS_WANTED_PER_S:.0} times a second"),
        _ if answer.log.rate_hz < ROWS_WANTED_PER_S => {
            format!(", logged at {ROWS_WANTED_PER_S:.0} rows/s or more (here {:.0})", answer.log.rate_hz)
        }
        _ => String::new(),
    };
    format!("Steps of {axes} to 20 degrees for 15 s, in calm air{rows},")
}
