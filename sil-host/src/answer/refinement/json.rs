//! The fields of `sil refine --json` (docs/commands.md).

use serde::Serialize;

use super::cost::evaluation_ns;
use crate::refinement::{Check, Comparison, Constant, Fitted, Refined};

/// All of it.
#[derive(Serialize)]
pub struct RefinedJson {
    constants: Vec<ConstantJson>,
    forms: Vec<FormJson>,
    checks: Vec<Check>,
    notes: Vec<String>,
}

#[derive(Serialize)]
struct ConstantJson {
    component: &'static str,
    key: &'static str,
    form: &'static str,
    unit: &'static str,
    value: f64,
    interval: [f64; 2],
    readings: usize,
    outliers: usize,
    source: String,
    runs: Vec<RunJson>,
}

#[derive(Serialize)]
struct RunJson {
    source: String,
    value: f64,
    interval: [f64; 2],
}

#[derive(Serialize)]
struct FormJson {
    component: &'static str,
    form: &'static str,
    numbers: usize,
    held_out_error: f64,
    unseen_error: Option<f64>,
    evaluation_ns: f64,
    unit: &'static str,
    is_taken: bool,
    parameters: Vec<f64>,
}

impl RefinedJson {
    /// Of a refinement.
    pub fn of(refined: &Refined) -> Self {
        Self {
            constants: refined.constants.iter().map(constant).collect(),
            forms: refined.comparisons.iter().flat_map(forms).collect(),
            checks: refined.checks.clone(),
            notes: refined.notes.clone(),
        }
    }
}

fn constant(of: &Constant) -> ConstantJson {
    let run =
        |run: &crate::refinement::Run| RunJson { source: run.source.clone(), value: run.value, interval: run.interval };
    ConstantJson {
        component: of.component.name(),
        key: of.key,
        form: of.form,
        unit: of.unit,
        value: of.value,
        interval: of.interval,
        readings: of.readings,
        outliers: of.outliers,
        source: of.source.clone(),
        runs: of.runs.iter().map(run).collect(),
    }
}

fn forms(of: &Comparison) -> Vec<FormJson> {
    let form = |(index, candidate): (usize, &crate::refinement::Candidate)| FormJson {
        component: of.component.name(),
        form: candidate.fitted.form().name(),
        numbers: candidate.fitted.numbers(),
        held_out_error: candidate.held_out,
        unseen_error: candidate.unseen,
        evaluation_ns: evaluation_ns(&candidate.fitted, &of.points.x),
        unit: of.component.axes()[1].1,
        is_taken: index == of.chosen,
        parameters: match &candidate.fitted {
            Fitted::Formula(_, fit) => fit.parameters.clone(),
            Fitted::Table(table) => table.points().iter().flat_map(|(x, y)| [*x, *y]).collect(),
        },
    };
    of.candidates.iter().enumerate().map(form).collect()
}
