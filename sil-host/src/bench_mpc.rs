//! Solver instances: the shipped single-precision MPC held against exact solutions in a file.
//!
//! A file holds one problem (axes, weights, bounds, control horizon) and a sequence of instances: parameters theta =
//! \[x (6), u_prev (3), r (3)\] and the exact minimiser z_ref. Only the problem's parameters are read, not its
//! matrices: what is held against the reference is the way from theta to the first input as it flies, condensing
//! included.

use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use shared_control::mpc::{HORIZON, MpcError, ProblemSettings, RegulationMpc, RegulationRequest, RegulationState};
use shared_control::signals::PlanStatus;

/// One file's figures, as `sil bench-mpc --json` writes them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseResult {
    /// The file.
    pub file: String,
    /// Letter of the control horizon.
    pub case: String,
    /// `i`: input bounds only; `ii`: roll and pitch bounded too.
    pub sub: String,
    /// Prediction step, s.
    pub ts_s: f64,
    /// Instances in the file.
    pub instances: usize,
    /// Instances that ended as solved.
    pub solved: usize,
    /// Largest |u0 - u0*| of any instance and axis, in u_max of the axis.
    pub error_max: f64,
    /// Median of the solver's iterations, summed over the axes.
    pub iterations_median: u16,
    /// Maximum of the same.
    pub iterations_max: u16,
}

/// What is wrong with an instance file.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The file can't be read or unpacked.
    #[error("{}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The file is no JSON of the expected form; the source names line and column.
    #[error("{}: {source}", file.display())]
    Format {
        /// The file.
        file: PathBuf,
        /// What was expected where.
        source: serde_json::Error,
    },
    /// The file describes a problem that the shipped MPC doesn't solve, or contradicts itself.
    #[error("{}: expected {expected}, found {found}", file.display())]
    Problem {
        /// The file.
        file: PathBuf,
        /// What the field must hold.
        expected: String,
        /// What it holds.
        found: String,
    },
    /// The MPC refuses the parameters.
    #[error("{}: {source}", file.display())]
    Settings {
        /// The file.
        file: PathBuf,
        /// Why.
        source: MpcError,
    },
}

/// The fields of an instance file that the benchmark needs.
#[derive(Debug, Deserialize)]
struct InstanceFile {
    case: String,
    sub: String,
    #[serde(rename = "N")]
    horizon: usize,
    #[serde(rename = "M")]
    control_horizon: usize,
    #[serde(rename = "Ts")]
    step_s: f64,
    mu: [f64; 3],
    rho: [f64; 3],
    umax: [f64; 3],
    ymax: f64,
    b: [f64; 3],
    #[serde(rename = "A_d")]
    state_matrix: [[f64; 6]; 6],
    #[serde(rename = "B_d")]
    input_matrix: [[f64; 3]; 6],
    theta: Vec<[f64; 12]>,
    z_ref: Vec<Vec<f64>>,
}

/// Solves every instance of `path` (`.json`, plain or gzipped) in sequence, warm-started.
pub fn solve_file(path: &Path) -> Result<CaseResult, BenchError> {
    let instances = read(path)?;
    instances.check(path)?;
    let mpc = RegulationMpc::<HORIZON>::prepare_shorter(instances.control_horizon, &instances.settings())
        .map_err(|source| BenchError::Settings { file: path.to_owned(), source })?;
    let mut state = RegulationState::new();
    let (mut solved, mut error_max) = (0, 0.0_f64);
    let mut iterations = Vec::with_capacity(instances.theta.len());
    for (theta, exact) in instances.theta.iter().zip(&instances.z_ref) {
        let plan = mpc.plan(&mut state, &request(theta));
        solved += usize::from(plan.status == PlanStatus::Solved);
        iterations.push(plan.iterations);
        for ((input, exact), input_max) in plan.input.iter().zip(exact).zip(instances.umax) {
            error_max = error_max.max((f64::from(*input) - exact).abs() / input_max);
        }
    }
    iterations.sort_unstable();
    Ok(CaseResult {
        file: path.display().to_string(),
        ts_s: instances.step_s,
        instances: iterations.len(),
        solved,
        error_max,
        iterations_median: iterations.get(iterations.len() / 2).copied().unwrap_or(0),
        iterations_max: iterations.last().copied().unwrap_or(0),
        case: instances.case,
        sub: instances.sub,
    })
}

fn read(path: &Path) -> Result<InstanceFile, BenchError> {
    let read_error = |source| BenchError::Read { file: path.to_owned(), source };
    let mut bytes = std::fs::read(path).map_err(read_error)?;
    if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut unpacked = Vec::new();
        flate2::read::MultiGzDecoder::new(bytes.as_slice()).read_to_end(&mut unpacked).map_err(read_error)?;
        bytes = unpacked;
    }
    serde_json::from_slice(&bytes).map_err(|source| BenchError::Format { file: path.to_owned(), source })
}

/// theta = \[roll, roll rate, pitch, pitch rate, yaw, yaw rate, u_prev (3), r (3)\].
fn request(theta: &[f64; 12]) -> RegulationRequest {
    let pick = |indices: [usize; 3]| indices.map(|index| theta[index] as f32);
    RegulationRequest {
        angle_rad: pick([0, 2, 4]),
        rate_rad_s: pick([1, 3, 5]),
        input_prev: pick([6, 7, 8]),
        reference_rad: pick([9, 10, 11]),
    }
}

impl InstanceFile {
    fn settings(&self) -> ProblemSettings {
        let single = |values: [f64; 3]| values.map(|value| value as f32);
        let angle_max_rad = (self.sub == "ii").then_some(self.ymax as f32);
        ProblemSettings {
            horizon: self.horizon,
            prediction_step_s: self.step_s as f32,
            input_gain: single(self.b),
            tracking_weight: single(self.mu),
            increment_weight: single(self.rho),
            input_max: single(self.umax),
            output_max_rad: [angle_max_rad, angle_max_rad, None],
        }
    }

    /// Refuses what the shipped MPC would silently solve as another problem.
    fn check(&self, path: &Path) -> Result<(), BenchError> {
        let refuse =
            |expected: String, found: String| Err(BenchError::Problem { file: path.to_owned(), expected, found });
        if self.horizon > HORIZON {
            return refuse(format!("N of at most {HORIZON} prediction steps"), self.horizon.to_string());
        }
        if self.sub != "i" && self.sub != "ii" {
            return refuse("sub \"i\" or \"ii\"".into(), format!("{:?}", self.sub));
        }
        for row in 0..6 {
            for column in 0..6 {
                let (expected, found) = (self.double_integrator_state(row, column), self.state_matrix[row][column]);
                if !agree(expected, found) {
                    return refuse(
                        format!("the double integrator's A_d[{row}][{column}] = {expected}"),
                        found.to_string(),
                    );
                }
            }
            for axis in 0..3 {
                let (expected, found) = (self.double_integrator_input(row, axis), self.input_matrix[row][axis]);
                if !agree(expected, found) {
                    return refuse(
                        format!("the double integrator's B_d[{row}][{axis}] = {expected}"),
                        found.to_string(),
                    );
                }
            }
        }
        if self.theta.is_empty() || self.z_ref.len() != self.theta.len() {
            return refuse(
                format!("as many rows of z_ref as of theta ({}), and at least one", self.theta.len()),
                self.z_ref.len().to_string(),
            );
        }
        let inputs = 3 * self.control_horizon;
        match self.z_ref.iter().position(|row| row.len() != inputs) {
            Some(row) => refuse(format!("3 M = {inputs} numbers in z_ref[{row}]"), self.z_ref[row].len().to_string()),
            None => Ok(()),
        }
    }

    /// A_d: per axis \[\[1, Ts\], \[0, 1\]\].
    fn double_integrator_state(&self, row: usize, column: usize) -> f64 {
        match (row / 2 == column / 2, row % 2, column % 2) {
            (true, 0, 1) => self.step_s,
            (true, from, to) if from == to => 1.0,
            _ => 0.0,
        }
    }

    /// B_d: per axis b \[Ts^2/2, Ts\].
    fn double_integrator_input(&self, row: usize, axis: usize) -> f64 {
        match (row / 2 == axis, row % 2) {
            (true, 0) => 0.5 * self.step_s * self.step_s * self.b[axis],
            (true, _) => self.step_s * self.b[axis],
            _ => 0.0,
        }
    }
}

/// Equal but for double-precision rounding of whoever wrote the file.
fn agree(expected: f64, found: f64) -> bool {
    (expected - found).abs() <= 1e-9 * (expected.abs() + found.abs())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use serde_json::{Value, json};

    use super::*;

    /// Two instances with M = 2: at rest, and a roll far beyond its reference, where full input is right.
    fn sound() -> Value {
        let (step_s, b) = (0.01, [20.0, 6.0, 34.0]);
        let mut state_matrix = [[0.0; 6]; 6];
        let mut input_matrix = [[0.0; 3]; 6];
        for axis in 0..3 {
            let angle = 2 * axis;
            (state_matrix[angle][angle], state_matrix[angle][angle + 1]) = (1.0, step_s);
            state_matrix[angle + 1][angle + 1] = 1.0;
            (input_matrix[angle][axis], input_matrix[angle + 1][axis]) =
                (step_s * step_s / 2.0 * b[axis], step_s * b[axis]);
        }
        let mut beyond = vec![0.0; 12];
        beyond[0] = 30.0;
        let full = [-2.0, 0.0, 0.0, -2.0, 0.0, 0.0];
        json!({
            "case": "x", "sub": "i", "N": 30, "M": 2, "Ts": step_s,
            "mu": [100.0, 100.0, 100.0], "rho": [30.0, 30.0, 3000.0],
            "umax": [2.0, 2.0, 0.1], "ymax": 0.7, "b": b, "A_d": state_matrix, "B_d": input_matrix,
            "theta": [vec![0.0; 12], beyond], "z_ref": [vec![0.0; 6], full],
        })
    }

    fn solve(content: &[u8]) -> Result<CaseResult, BenchError> {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(content).unwrap();
        solve_file(file.path())
    }

    fn complaint(field: &str, value: Value) -> String {
        let mut instances = sound();
        instances[field] = value;
        solve(instances.to_string().as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn plain_and_gzipped_files_give_the_same_figures() {
        let text = sound().to_string();
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(text.as_bytes()).unwrap();
        let (plain, gzipped) = (solve(text.as_bytes()).unwrap(), solve(&packed.finish().unwrap()).unwrap());
        assert_eq!(CaseResult { file: String::new(), ..plain.clone() }, CaseResult { file: String::new(), ..gzipped });
        assert_eq!((plain.instances, plain.solved, plain.error_max), (2, 2, 0.0));
        assert_eq!((plain.case.as_str(), plain.sub.as_str(), plain.ts_s), ("x", "i", 0.01));
        // At rest one look per axis is enough; both inputs of roll at their bounds take one more.
        assert_eq!(plain.iterations_max, 4);
    }

    #[test]
    fn a_wrong_reference_shows_as_error() {
        let mut instances = sound();
        instances["z_ref"][0][2] = json!(0.05);
        let result = solve(instances.to_string().as_bytes()).unwrap();
        assert!((result.error_max - 0.5).abs() < 1e-6, "{}", result.error_max);
    }

    #[test]
    fn the_control_horizon_may_be_any_from_1_to_30() {
        for control_horizon in 1..=30 {
            let mut instances = sound();
            instances["M"] = json!(control_horizon);
            instances["z_ref"] = json!([vec![0.0; 3 * control_horizon], vec![0.0; 3 * control_horizon]]);
            assert_eq!(solve(instances.to_string().as_bytes()).unwrap().solved, 2, "M = {control_horizon}");
        }
        for control_horizon in [0, 31] {
            let mut instances = sound();
            instances["M"] = json!(control_horizon);
            instances["z_ref"] = json!([vec![0.0; 3 * control_horizon], vec![0.0; 3 * control_horizon]]);
            let error = solve(instances.to_string().as_bytes()).unwrap_err().to_string();
            assert!(error.contains(&format!("must be 1 to 30 steps, not {control_horizon}")), "{error}");
        }
    }

    #[test]
    fn other_problems_are_refused_by_name() {
        let mut damped = sound()["A_d"].clone();
        damped[3][3] = json!(0.99);
        let mut crossed = sound()["B_d"].clone();
        crossed[1][2] = json!(0.1);
        for (field, value, expected) in [
            ("N", json!(31), "expected N of at most 30 prediction steps, found 31"),
            ("sub", json!("iii"), "expected sub \"i\" or \"ii\", found \"iii\""),
            ("A_d", damped, "the double integrator's A_d[3][3] = 1, found 0.99"),
            ("B_d", crossed, "the double integrator's B_d[1][2] = 0, found 0.1"),
            ("b", json!([20.0, 6.0, 35.0]), "the double integrator's B_d[4][2]"),
            ("z_ref", json!([vec![0.0; 6]]), "as many rows of z_ref as of theta (2), and at least one, found 1"),
            ("theta", json!([]), "at least one"),
            ("z_ref", json!([vec![0.0; 6], vec![0.0; 5]]), "3 M = 6 numbers in z_ref[1], found 5"),
            ("mu", json!([100.0, -1.0, 100.0]), "tracking_weight (axis 1) must be finite and positive, not -1"),
            ("mu", json!([100.0, 2e-38, 100.0]), "axis 1: the matrices of the quadratic program must be finite"),
        ] {
            let error = complaint(field, value);
            assert!(error.contains(expected), "{field}: {error}");
        }
    }

    #[test]
    fn files_of_another_form_are_refused_with_their_place() {
        let error = |content: &[u8]| solve(content).unwrap_err().to_string();
        assert!(error(b"").contains("line 1 column 0"), "{}", error(b""));
        assert!(error(b"{\n\"case\": 3}").contains("expected a string at line 2 column 9"));
        assert!(error(b"{}").contains("missing field `case`"));
        assert!(error(&[0x1f, 0x8b, 8, 0]).contains("unexpected end of file"), "{}", error(&[0x1f, 0x8b, 8, 0]));
        assert!(
            complaint("theta", json!([vec![0.0; 11]])).contains("invalid length 11, expected an array of length 12")
        );
        assert!(complaint("umax", json!([2.0, "two", 0.1])).contains("expected f64"));
        let missing = solve_file(Path::new("no/such/file.json")).unwrap_err().to_string();
        assert!(missing.starts_with("no/such/file.json: "), "{missing}");
    }
}
