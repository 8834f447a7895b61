//! An instance file, and its problem as the source text that the image includes.

use std::fmt::Write;
use std::fs;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use flate2::read::MultiGzDecoder;
use serde_json::Value;

use super::counting::Solve;

/// What an image solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Problem {
    /// What flies: motors' lag, disturbance, a reference ahead.
    Flight,
    /// The thesis' and the file's own: double integrators, a constant reference.
    Regulation,
    /// Every option that can be chosen, with requests of the image's own.
    Options,
}

impl Problem {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Flight => "flight",
            Self::Regulation => "regulation",
            Self::Options => "options",
        }
    }
}

/// What the image and its judge need of the file.
pub(crate) struct Instances {
    pub(crate) case: String,
    pub(crate) sub: String,
    pub(crate) step_s: f64,
    horizon: u64,
    control_horizon: u64,
    input_gain: Vec<f64>,
    tracking_weight: Vec<f64>,
    increment_weight: Vec<f64>,
    input_max: Vec<f64>,
    angle_max_rad: f64,
    theta: Vec<Vec<f64>>,
    exact: Vec<Vec<f64>>,
}

impl Instances {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let in_file = || format!("{}", path.display());
        let mut bytes = fs::read(path).with_context(in_file)?;
        if bytes.starts_with(&[0x1f, 0x8b]) {
            let mut unpacked = Vec::new();
            MultiGzDecoder::new(&*bytes).read_to_end(&mut unpacked).with_context(in_file)?;
            bytes = unpacked;
        }
        let json = serde_json::from_slice(&bytes).with_context(in_file)?;
        Self::parse(&json).with_context(in_file)
    }

    /// None, of a problem that the image does not solve.
    pub(crate) fn none() -> Self {
        Self {
            case: "none".into(),
            sub: "i".into(),
            step_s: 0.01,
            horizon: 30,
            control_horizon: 1,
            input_gain: vec![1.0; 3],
            tracking_weight: vec![1.0; 3],
            increment_weight: vec![1.0; 3],
            input_max: vec![1.0; 3],
            angle_max_rad: 1.0,
            theta: Vec::new(),
            exact: Vec::new(),
        }
    }

    fn parse(json: &Value) -> Result<Self> {
        let text = |key: &str| json[key].as_str().map(str::to_owned).with_context(|| format!("no text \"{key}\""));
        let number = |key: &str| json[key].as_f64().with_context(|| format!("no number \"{key}\""));
        let count = |key: &str| json[key].as_u64().with_context(|| format!("no count \"{key}\""));
        let instances = Self {
            case: text("case")?,
            sub: text("sub")?,
            step_s: number("Ts")?,
            horizon: count("N")?,
            control_horizon: count("M")?,
            input_gain: row(&json["b"], 3).context("\"b\"")?,
            tracking_weight: row(&json["mu"], 3).context("\"mu\"")?,
            increment_weight: row(&json["rho"], 3).context("\"rho\"")?,
            input_max: row(&json["umax"], 3).context("\"umax\"")?,
            angle_max_rad: number("ymax")?,
            theta: rows(&json["theta"], 12).context("\"theta\"")?,
            exact: rows(&json["z_ref"], 3 * count("M")? as usize).context("\"z_ref\"")?,
        };
        ensure!(instances.theta.len() == instances.exact.len(), "as many rows of theta as of z_ref expected");
        Ok(instances)
    }

    /// `d-ii`.
    pub(crate) fn label(&self) -> String {
        format!("{}-{}", self.case, self.sub)
    }

    /// What is solved with the file's instances: for the problem that flies they serve as states and set-points, 10 ms
    /// apart.
    pub(crate) fn problems(&self) -> Vec<Problem> {
        match self.step_s == 0.01 {
            true => vec![Problem::Regulation, Problem::Flight],
            false => vec![Problem::Regulation],
        }
    }

    /// Of the control core: bounds on angles are left out where none is set, as on the board.
    pub(crate) fn features(&self) -> &'static [&'static str] {
        if self.sub == "ii" { &["bounded-angles"] } else { &[] }
    }

    /// `regulation-d-i-2500us`: what the image calls it.
    pub(crate) fn name(&self, problem: Problem) -> String {
        format!("{}-{}-{:.0}us", problem.name(), self.label(), 1e6 * self.step_s)
    }

    /// Constants for the image.
    pub(crate) fn rust_source(&self, problem: Problem) -> String {
        let bound = if self.sub == "ii" { format!("Some({:?})", self.angle_max_rad) } else { "None".into() };
        let mut source = format!(
            "pub(super) const CASE: &str = {:?};\n\
             pub(super) const PROBLEM: Problem = Problem::{problem:?};\n\
             pub(super) const CONTROL_HORIZON: usize = {};\n\
             pub(super) const SETTINGS: ProblemSettings = ProblemSettings {{\n    horizon: {},\n    \
             prediction_step_s: {:?},\n    \
             input_gain: {:?},\n    tracking_weight: {:?},\n    increment_weight: {:?},\n    input_max: {:?},\n    \
             output_max_rad: [{bound}, {bound}, None],\n}};\n\
             pub(super) static INSTANCES: [Theta; {}] = [\n",
            self.name(problem),
            self.control_horizon,
            self.horizon,
            self.step_s,
            self.input_gain,
            self.tracking_weight,
            self.increment_weight,
            self.input_max,
            self.theta.len(),
        );
        for theta in &self.theta {
            // writing to a string cannot fail
            let _ = writeln!(source, "    {theta:?},");
        }
        source + "];\n"
    }

    /// Largest |u0 - u0*| of any instance and axis, in u_max of the axis; none for a problem that is not the file's
    /// own.
    pub(crate) fn error_max(&self, problem: Problem, solves: &[Solve]) -> Result<Option<f64>> {
        if problem != Problem::Regulation {
            return Ok(None);
        }
        ensure!(solves.len() == self.exact.len(), "{} of {} instances came back", solves.len(), self.exact.len());
        let errors = solves.iter().zip(&self.exact).flat_map(|(solve, exact)| {
            let axes = solve.input.iter().zip(exact).zip(&self.input_max);
            axes.map(|((input, exact), input_max)| (input - exact).abs() / input_max)
        });
        Ok(Some(errors.fold(0.0, f64::max)))
    }
}

fn row(value: &Value, length: usize) -> Result<Vec<f64>> {
    let entries = value.as_array().context("no list")?;
    ensure!(entries.len() == length, "{length} numbers expected, {} found", entries.len());
    entries.iter().map(|entry| entry.as_f64().context("no number")).collect()
}

fn rows(value: &Value, length: usize) -> Result<Vec<Vec<f64>>> {
    value.as_array().context("no list")?.iter().map(|entries| row(entries, length)).collect()
}
