//! The first screen of a diagnosis: headline, two sentences, one picture, and a card with verdict, cause, size and
//! certainty.

use crate::diagnosis::{ChannelResiduals, Diagnosis, Finding, HorizonError, Verdict, held_against};
use crate::log::Log;
use crate::prediction::Channel;
use crate::report::{Card, Chart, Page, Tone};

use super::page::Beside;
use super::without_a_model;
use crate::answer::key_window::Predicted;
use crate::answer::plain_words::{
    axis_of, capitalised, cause, doubted, main_parameter, parameter, quantity, sentence, unit, with_unit,
};

/// An angle is shown rather than a rate if its error, in units of the noise, is at least this share of the rate's.
const ANGLE_PREFERRED: f64 = 0.5;
/// Share of the rows with a motor at its limit that a reader must know of.
const SATURATED_MIN: f64 = 0.02;

/// What came out, in a sentence.
pub fn headline(answer: &Diagnosis) -> String {
    let others = match answer.findings.len() {
        0 | 1 => String::new(),
        2 => ", and one effect more".to_owned(),
        count => format!(", and {} effects more", count - 1),
    };
    match (answer.verdict, answer.findings.first()) {
        (Verdict::NotAModel, _) => "No model was found of the vehicle that flew".to_owned(),
        (Verdict::NotShown, _) => "The log does not show what this vehicle's commands do".to_owned(),
        (_, Some(first)) => format!("{}{others}", doubted(first)),
        (Verdict::UnknownEffect, None) if !answer.holding.is_empty() => {
            "What the commands do is known, and something that no log shows moves the vehicle too".to_owned()
        }
        (Verdict::NoDiscrepancy, None) => "The simulation agrees with this log".to_owned(),
        (_, None) => {
            let axis = shown(answer).and_then(|(error, _)| axis_of(error.quantity));
            let place = axis.map(|axis| format!(" in {axis}")).unwrap_or_default();
            format!("The model misses something{place} that no known effect explains")
        }
    }
}

/// Lead, picture and card.
pub fn first_screen(page: Page, log: &Log, answer: &Diagnosis) -> Page {
    let page = lead(log, answer).into_iter().fold(page, Page::lead);
    let page = match picture(log, answer) {
        Some(picture) => page.picture(picture),
        None => page,
    };
    page.card(card(answer))
}

/// What it does to the prediction, and what was wrong with the flight.
pub fn lead(log: &Log, answer: &Diagnosis) -> Vec<String> {
    let saturated = saturated_share(log);
    let at_limit = (saturated >= SATURATED_MIN).then(|| {
        format!(
            "A motor was at the end of its range in {} of the rows: what no motor could do shows as an error too.",
            with_unit(100.0 * saturated, "%")
        )
    });
    let advice = match answer.verdict {
        Verdict::NotAModel => Some(without_a_model::what_to_do(answer)),
        Verdict::NotShown => Some(without_a_model::not_shown(answer)),
        _ => None,
    };
    // open loop says nothing of a model whose commands hold against a disturbance
    let improvement = improvement(answer).filter(|_| answer.holding.is_empty());
    improvement.into_iter().chain(held_against(&answer.holding)).chain(at_limit).chain(advice).collect()
}

/// How much better the model predicts, in the channel that is shown.
fn improvement(answer: &Diagnosis) -> Option<String> {
    let (error, _) = shown(answer)?;
    let unit = unit(error.unit);
    let sizes = [error.nominal, error.base, error.extended, error.noise_floor];
    let [nominal, base, extended, exact] = sizes.map(|size| with_unit(size, &unit));
    let start = format!(
        "Predicting {} s from the logged commands alone, the model misses the {} by {nominal}",
        answer.prediction_error.window_s,
        quantity(error.quantity)
    );
    let with = match (answer.findings.is_empty(), answer.base.is_empty()) {
        (true, true) => String::new(),
        (true, false) => format!("; with its ordinary numbers fitted by {base}"),
        (false, _) if !answer.verdict.has_a_model() => {
            format!("; with the best of what was tried by {extended}")
        }
        (false, true) => format!("; with this in it by {extended}"),
        (false, false) => format!("; with its ordinary numbers fitted by {base}, with this in it too by {extended}"),
    };
    Some(format!("{start}{with}. Noise alone makes {exact}."))
}

/// The channel whose error says most, in units of what an exact model would leave, and its series.
pub(crate) fn shown(answer: &Diagnosis) -> Option<(&HorizonError, &ChannelResiduals)> {
    let horizon = answer.horizons.iter().find(|horizon| horizon.horizon_s == answer.prediction_error.window_s)?;
    let series = |error: &HorizonError| answer.residuals.iter().find(|of| of.name == error.quantity);
    let states: Vec<_> = horizon.errors.iter().filter_map(|error| Some((error, series(error)?))).collect();
    let ratio = |error: &HorizonError| error.nominal / error.noise_floor;
    let most = states.iter().max_by(|a, b| ratio(a.0).total_cmp(&ratio(b.0)))?;
    let is_angle = |error: &HorizonError| ["roll", "pitch", "yaw"].contains(&error.quantity);
    let mut angle =
        states.iter().filter(|(error, _)| is_angle(error) && axis_of(error.quantity) == axis_of(most.0.quantity));
    Some(*angle.find(|(error, _)| ratio(error) >= ANGLE_PREFERRED * ratio(most.0)).unwrap_or(most))
}

/// Measured and predicted, where it shows best.
pub(crate) fn picture(log: &Log, answer: &Diagnosis) -> Option<Chart> {
    let (error, series) = shown(answer)?;
    let channel = Channel::ALL.into_iter().find(|channel| channel.name() == series.name)?;
    let column = log.column(channel.quantity()).unwrap_or(&[]);
    let all = column.iter().map(|value| channel.in_unit(*value)).collect();
    let mut errors = vec![("nominal model", &series.nominal[..])];
    errors.extend(Beside::of(answer).map(|beside| match beside {
        Beside::Findings => (beside.name(), &series.extended[..]),
        Beside::Base => (beside.name(), &series.base[..]),
    }));
    let predicted = Predicted {
        title: capitalised(quantity(error.quantity)),
        unit: unit(error.unit),
        time_s: &series.time_s,
        measured: &series.measured,
        all: (&log.time_s, all),
        errors,
    };
    predicted.picture()
}

/// Verdict, cause, size and certainty.
pub(crate) fn card(answer: &Diagnosis) -> Card {
    let (tone, verdict) = match answer.verdict {
        Verdict::NoDiscrepancy => (Tone::Good, "No discrepancy: nothing but noise remains"),
        Verdict::Explained => (Tone::Good, "Explained: nothing but noise remains"),
        Verdict::PartlyExplained => (Tone::Doubtful, "Partly explained: something else is wrong too"),
        Verdict::UnknownEffect if !answer.holding.is_empty() => {
            (Tone::Doubtful, "Commands known; what else moves the vehicle is in no log")
        }
        Verdict::UnknownEffect => (Tone::Bad, "Not explained by any known effect"),
        Verdict::NotAModel => (Tone::Bad, "Not a model: no better than the mean of the measurements"),
        Verdict::NotShown => (Tone::Doubtful, "Not shown: what the commands do"),
    };
    let card = Card::new(tone).line("Verdict", verdict);
    let card = match answer.findings.first() {
        Some(first) if !answer.verdict.has_a_model() => card.line("Best of what was tried", sentence(first)),
        Some(first) => {
            let size = main_parameter(first)
                .map(|(name, size)| format!("{} ({})", size.exact(), parameter(first.effect, name)))
                .unwrap_or_default();
            card.line("Cause", cause(first)).line("Size", size).line("Certainty", certainty(first))
        }
        None => card.line("What remains", capitalised(&answer.unexplained.signature)),
    };
    let others: Vec<String> = answer.findings.iter().skip(1).map(doubted).collect();
    card.line("Also", others.join("; "))
}

fn certainty(finding: &Finding) -> String {
    let cuts = finding.stability_pct.map(|pct| format!("{pct:.0} % of other cuts of this log show it"));
    let others = finding.one_of.iter().skip(1).map(|other| other.replace('_', " "));
    let confounded = finding.confounded_with.iter().map(|other| other.replace('_', " "));
    let mut others: Vec<String> = others.collect();
    others.extend(confounded.filter(|other| !others.contains(other)).collect::<Vec<_>>());
    let or = (!others.is_empty()).then(|| format!("it may as well be {}", others.join(" or ")));
    let gain = format!("without it {} of the improvement is lost", with_unit(finding.gain_pct, "%"));
    let said: Vec<String> = std::iter::once(gain).chain(cuts).chain(or).collect();
    capitalised(&said.join("; "))
}

/// Share of a log's rows in which any motor's command is at an end of its range.
pub fn saturated_share(log: &Log) -> f64 {
    let columns: Vec<&Vec<f64>> = log.motor_command.iter().flatten().collect();
    let at_limit = |row: usize| columns.iter().any(|column| column[row] <= 0.0 || column[row] >= 1.0);
    (0..log.rows()).filter(|row| at_limit(*row)).count() as f64 / log.rows().max(1) as f64
}
