//! The fields of `sil montecarlo --json` (docs/commands.md).

use serde::Serialize;

use super::StudyAnswer;
use crate::montecarlo::{Extreme, Kind, Sample};

/// All of it.
#[derive(Serialize)]
pub struct StudyJson {
    model: String,
    scenario: String,
    seed: u64,
    runs: u64,
    kept: usize,
    /// Runs flown by this command; the others were there.
    flown: u64,
    /// Time that they took, s.
    elapsed_s: f64,
    /// Threads that flew them.
    threads: usize,
    drawn: Vec<DrawnJson>,
    lost: Vec<LostJson>,
    figures: Vec<FigureJson>,
}

/// What it took to fly the rows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Work {
    /// Runs flown now.
    pub flown: u64,
    /// In this time, s.
    pub elapsed_s: f64,
    /// By so many threads.
    pub threads: usize,
}

#[derive(Serialize)]
struct DrawnJson {
    name: String,
    nominal: Option<f64>,
    mean: f64,
    min: f64,
    max: f64,
}

#[derive(Serialize)]
struct LostJson {
    controller: String,
    count: u64,
    interval: [f64; 2],
    commands: Vec<String>,
}

#[derive(Serialize)]
struct FigureJson {
    name: String,
    nominal: Option<f64>,
    count: u64,
    missing: u64,
    mean: Option<f64>,
    min: Option<f64>,
    p05: Option<f64>,
    p25: Option<f64>,
    p50: Option<f64>,
    p75: Option<f64>,
    p95: Option<f64>,
    p99: Option<f64>,
    max: Option<f64>,
    worst: Vec<WorstJson>,
    explained: Option<f64>,
    influences: Vec<InfluenceJson>,
}

#[derive(Serialize)]
struct WorstJson {
    run: u64,
    value: Option<f64>,
    command: String,
}

#[derive(Serialize)]
struct InfluenceJson {
    of: String,
    coefficient: f64,
    interval: [f64; 2],
}

impl StudyJson {
    /// Of an answer, and what it took to fly the rows.
    pub fn of(answer: &StudyAnswer, work: Work) -> Self {
        let drawn = answer.summary.of_kind(Kind::Drawn).map(|(column, sample)| DrawnJson {
            name: column.name.clone(),
            nominal: answer.nominal(column),
            mean: sample.mean,
            min: sample.min,
            max: sample.max,
        });
        let lost = answer.lost().map(|lost| LostJson {
            controller: lost.controller.to_owned(),
            count: lost.count,
            interval: lost.interval,
            commands: lost
                .runs
                .iter()
                .map(|run| answer.about.command(*run, &format!("{}.", lost.controller)))
                .collect(),
        });
        Self {
            model: answer.about.model.clone(),
            scenario: answer.about.scenario.clone(),
            seed: answer.about.seed,
            runs: answer.summary.rows(),
            kept: answer.summary.kept(),
            flown: work.flown,
            elapsed_s: work.elapsed_s,
            threads: work.threads,
            drawn: drawn.collect(),
            lost: lost.collect(),
            figures: answer.figures().map(|figure| FigureJson::of(answer, &figure)).collect(),
        }
    }
}

impl FigureJson {
    fn of(answer: &StudyAnswer, figure: &super::StudyFigure<'_>) -> Self {
        let Sample { count, missing, min, max, mean, .. } = *figure.sample;
        let of_any = |value: f64| (count > 0).then_some(value);
        let quantile = |share: f64| figure.sample.quantile(share);
        let worst = |worst: &Extreme| WorstJson {
            run: worst.run,
            value: worst.value,
            command: answer.about.command(worst.run, figure.name),
        };
        let influences = figure.sensitivity.map_or(&[][..], |sensitivity| &sensitivity.influences);
        Self {
            name: figure.name.to_owned(),
            nominal: figure.nominal,
            count,
            missing,
            mean: of_any(mean),
            min: of_any(min),
            p05: quantile(0.05),
            p25: quantile(0.25),
            p50: quantile(0.5),
            p75: quantile(0.75),
            p95: quantile(0.95),
            p99: quantile(0.99),
            max: of_any(max),
            worst: figure.sample.worst.iter().map(worst).collect(),
            explained: figure.sensitivity.map(|sensitivity| sensitivity.explained),
            influences: influences
                .iter()
                .map(|influence| InfluenceJson {
                    of: influence.of.clone(),
                    coefficient: influence.coefficient,
                    interval: [-1.0, 1.0].map(|side| influence.coefficient + side * influence.half_interval),
                })
                .collect(),
        }
    }
}
