//! The scoreboard as text: a block for each log, a table of the vehicles, and the goals.

use std::collections::BTreeSet;
use std::fmt::{self, Write};

use super::agreement::{Scatter, SizeTwice};
use super::channels::ChannelScore;
use super::score::{FindingScore, Halves, LogScore};
use super::summary::Summary;

/// Sizes of more deviations than this are shown one by one.
const TELLING_Z: f64 = 1.96;

/// A log's block.
pub fn of_log(score: &LogScore) -> String {
    let mut text = String::new();
    // writing to a string can't fail
    let _ = write_log(&mut text, score);
    text
}

fn write_log(out: &mut String, score: &LogScore) -> fmt::Result {
    let cpu = score.user_cpu_s.map_or_else(String::new, |cpu_s| format!(", processor {cpu_s:.1} s"));
    writeln!(
        out,
        "== {}/{}: {} | {:.1} s at {:.0} Hz | answer in {:.1} s, with its cuts in {:.1} s{cpu}",
        score.vehicle, score.name, score.verdict, score.usable_s, score.rate_hz, score.wall_s, score.checked_s
    )?;
    if !score.base.is_empty() {
        let terms: Vec<String> =
            score.base.iter().map(|term| format!("{} {}", term.name, sizes(&term.sizes))).collect();
        writeln!(out, "   base: {}", terms.join("; "))?;
    }
    score.channels.iter().try_for_each(|channel| writeln!(out, "   {}", channel_line(channel)))?;
    for of in &score.findings {
        writeln!(out, "   {}", finding_line(score, of))?;
    }
    if let Some(cuts) = &score.cuts {
        let own: BTreeSet<&str> = score.findings.iter().map(|of| of.finding.name.as_str()).collect();
        let others = cuts.found.iter().filter(|(name, _)| !own.contains(name.as_str()));
        let others: Vec<String> = others.map(|(name, count)| format!("{name} {count}")).collect();
        writeln!(
            out,
            "   {} of {} cuts answered; other names in them: {}",
            cuts.answered,
            cuts.tried,
            listed(&others)
        )?;
    }
    if score.hides_remainder {
        writeln!(out, "   no remainder printed though an error is more than 5 times an exact model's")?;
    }
    score.halves.as_ref().map_or(Ok(()), |halves| write_halves(out, halves))
}

fn channel_line(channel: &ChannelScore) -> String {
    let ChannelScore { quantity, unit, before, after, floor, change_pct, .. } = channel;
    let optional =
        |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |value| format!("{value:.digits$}"));
    let interval =
        channel.change_interval.map_or("-".to_owned(), |[low, high]| format!("{low:+.2} to {high:+.2} {unit}"));
    let worse = match (channel.is_worse(), channel.is_worse_by_2_pct()) {
        (Some(true), _) => "  WORSE",
        (_, true) => "  worse, not beyond chance",
        _ => "",
    };
    format!(
        "{quantity:5} {before:9.3} -> {after:9.3} {unit:5} floor {:>8}  {change_pct:+6.1} % ({interval})  fit {:>4} -> \
         {:>4} %  {}{worse}",
        optional(*floor, 3),
        optional(channel.fit_before_pct, 0),
        optional(channel.fit_after_pct, 0),
        if channel.is_excited { "excited" } else { "not excited" },
    )
}

fn finding_line(score: &LogScore, of: &FindingScore) -> String {
    let gain = of.finding.gain_pct.map_or("-".to_owned(), |gain| format!("{gain:.1}"));
    let tried = score.cuts.as_ref().map(|cuts| cuts.answered);
    let cuts = of.in_cuts.zip(tried).map_or_else(String::new, |(found, tried)| format!(", in {found} of {tried} cuts"));
    let one_of =
        if of.finding.is_certain() { String::new() } else { format!(", one of {}", of.finding.one_of.join(" | ")) };
    let objections: Vec<String> = of.objections.iter().map(|objection| format!("  CAN'T BE: {objection}")).collect();
    format!("- {}: {}, gain {gain} %{cuts}{one_of}{}", of.finding.name, sizes(&of.finding.sizes), objections.join(""))
}

fn sizes(sizes: &std::collections::BTreeMap<String, sil_host::diagnosis::Estimate>) -> String {
    let size = |(name, estimate): (&String, &sil_host::diagnosis::Estimate)| {
        let digits = estimate.decimals().unwrap_or(4);
        format!("{name} {:.digits$} +- {:.digits$}", estimate.value, estimate.std)
    };
    sizes.iter().map(size).collect::<Vec<_>>().join(", ")
}

fn write_halves(out: &mut String, halves: &Halves) -> fmt::Result {
    let names = halves.names.each_ref().map(|names| match names {
        Ok(names) => listed(names),
        Err(reason) => format!("({reason})"),
    });
    writeln!(
        out,
        "   halves: {} of {} names in both: {} || {}",
        halves.names_in_both, halves.names_in_either, names[0], names[1]
    )?;
    writeln!(out, "   |z| found by both: {}", scatter(&halves.found))?;
    let not_prescribed = match &halves.not_prescribed[..] {
        [] => String::new(),
        names => format!("; not prescribed: {}", names.join(", ")),
    };
    writeln!(out, "   |z| same names prescribed: {}{not_prescribed}", scatter(&halves.prescribed))
}

fn scatter(sizes: &[SizeTwice]) -> String {
    let Scatter { count, median, above_1_96, above_3, max } = Scatter::of(sizes);
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    let telling: Vec<String> = sizes
        .iter()
        .filter(|size| size.z.abs() > TELLING_Z)
        .map(|size| {
            let [a, b] = size.both;
            format!(
                "; {} {} {:.4} +- {:.4} || {:.4} +- {:.4}",
                size.name, size.parameter, a.value, a.std, b.value, b.std
            )
        })
        .collect();
    format!(
        "median {}, {above_1_96} of {count} above 1.96, {above_3} above 3, largest {}{}",
        number(median),
        number(max),
        telling.join("")
    )
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// The vehicles' table and the goals.
pub fn of_summary(scores: &[LogScore]) -> String {
    let mut text = String::new();
    let _ = write_summary(&mut text, scores);
    text
}

fn write_summary(out: &mut String, scores: &[LogScore]) -> fmt::Result {
    writeln!(
        out,
        "| vehicle | logs | worse by 2 %, beyond chance, of | excited without fit, of | implausible, gain < 2 %, of \
         | names in both halves, either | abs(z) found: median, > 1.96, > 3, of, largest \
         | abs(z) prescribed: the same | stable in the cuts, of | time: median, longest, s |"
    )?;
    writeln!(out, "|{}", "---|".repeat(10))?;
    let vehicles: BTreeSet<&str> = scores.iter().map(|score| score.vehicle.as_str()).collect();
    let all: Vec<&LogScore> = scores.iter().collect();
    for vehicle in vehicles {
        let own: Vec<&LogScore> = scores.iter().filter(|score| score.vehicle == vehicle).collect();
        writeln!(out, "{}", summary_row(vehicle, &Summary::of(&own)))?;
    }
    let summary = Summary::of(&all);
    writeln!(out, "{}\n", summary_row("all", &summary))?;
    let verdicts: Vec<String> = summary.verdicts.iter().map(|(verdict, count)| format!("{verdict} {count}")).collect();
    writeln!(out, "verdicts: {}", listed(&verdicts))?;
    summary.refused.iter().try_for_each(|refused| writeln!(out, "no answer: {refused}"))?;
    writeln!(out, "\n| goal | measured | |\n|---|---|---|")?;
    for (goal, measured, is_met) in summary.goals() {
        let met = match is_met {
            Some(true) => "met",
            Some(false) => "NOT MET",
            None => "-",
        };
        writeln!(out, "| {goal} | {measured} | {met} |")?;
    }
    Ok(())
}

fn summary_row(name: &str, of: &Summary) -> String {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    let z =
        |z: &Scatter| format!("{}, {}, {}, {}, {}", number(z.median), z.above_1_96, z.above_3, z.count, number(z.max));
    format!(
        "| {name} | {} | {}, {}, {} | {}, {} | {}, {}, {} | {}, {} | {} | {} | {}, {} | {}, {:.1} |",
        of.logs,
        of.worse_by_2_pct,
        of.worse,
        of.channels,
        of.excited_without_fit,
        of.excited,
        of.implausible,
        of.below_2_pct,
        of.findings,
        of.names_in_both,
        of.names_in_either,
        z(&of.z_found),
        z(&of.z_prescribed),
        of.certain_and_stable,
        of.certain,
        number(of.median_s),
        of.slowest_s
    )
}
