//! The shipped MPC against the reference instances: exact solutions of the same problem, computed elsewhere in double
//! precision, with the dense matrices they were computed from.

use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::Value;
use shared_control::mpc::condense::Condensed;
use shared_control::mpc::model::PredictedAngles;
use shared_control::mpc::{HORIZON, RegulationMpc, RegulationState};
use sil_host::bench_mpc::solve_file;

/// Required of u0, in u_max.
const ERROR_MAX: f64 = 1e-4;

fn instance_files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("instances");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the instances' folder")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    files.sort();
    assert_eq!(files.len(), 12, "cases a to d, i and ii at 10 ms, i at 2.5 ms");
    files
}

fn read(file: &Path) -> Value {
    let packed = std::fs::File::open(file).expect("an instance file");
    let mut text = String::new();
    flate2::read::GzDecoder::new(packed).read_to_string(&mut text).expect("gzipped text");
    serde_json::from_str(&text).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn every_instance_is_solved_exactly() {
    println!("case      Ts    solved   max error   iterations: median  max");
    for file in instance_files() {
        let result = solve_file(&file).expect("a benchmark file");
        println!(
            "{:>2}-{:<2} {:7} s  {:3}/{:3}     {:.1e}               {:4} {:4}",
            result.case,
            result.sub,
            result.ts_s,
            result.solved,
            result.instances,
            result.error_max,
            result.iterations_median,
            result.iterations_max
        );
        assert_eq!((result.solved, result.instances), (200, 200), "{}", result.file);
        assert!(result.error_max <= ERROR_MAX, "{}: {:e}", result.file, result.error_max);
    }
}

/// H, F and the output rows as condensed here, in single precision, against the file's.
fn compare_condensed<const M: usize>(file: &Path, instances: &Value) {
    for axis in 0..3 {
        let parameter = |name: &str| number(&instances[name][axis]) as f32;
        let angles = PredictedAngles::<M>::new(HORIZON, M, number(&instances["Ts"]) as f32, parameter("b"));
        let condensed = Condensed::new(&angles, parameter("mu"), parameter("rho"));
        // Sums of 30 rounded products of one sign: 1e-6 of the largest entry of the same matrix.
        let near = |found: f32, expected: &Value, largest: f64, what: &str| {
            let expected = number(expected);
            let error = (f64::from(found) - expected).abs();
            assert!(error <= 1e-6 * largest, "{} axis {axis} {what}: {found} for {expected}", file.display());
        };
        let stiffest = f64::from(condensed.hessian.as_flattened().iter().fold(0.0, |a: f32, b| a.max(b.abs())));
        for row in 0..M {
            for column in 0..M {
                let expected = &instances["H"][3 * row + axis][3 * column + axis];
                near(condensed.hessian[row][column], expected, stiffest, "H");
            }
            // theta = [x (6), u_prev (3), r (3)].
            for (found, theta) in
                condensed.linear_map.0[row].into_iter().zip([2 * axis, 2 * axis + 1, 6 + axis, 9 + axis])
            {
                let expected = &instances["F"][3 * row + axis][theta];
                near(found, expected, number(expected).abs(), "F");
            }
        }
        // Case ii bounds roll and pitch, in turns: row 2 (k - 1) is y_k of roll.
        if instances["m_out"] == 60 && axis < 2 {
            for step in 0..HORIZON {
                let row = 2 * step + axis;
                near(angles.rate_weights[step], &instances["Phiy"][row][2 * axis + 1], 0.3, "Phiy");
                for block in 0..M {
                    let expected = &instances["A"][row][3 * block + axis];
                    near(angles.input_weights[step][block], expected, number(expected).abs(), "A");
                }
            }
        }
    }
}

#[test]
fn condensed_matrices_equal_the_files() {
    for file in instance_files() {
        let instances = read(&file);
        match instances["M"].as_u64() {
            Some(1) => compare_condensed::<1>(&file, &instances),
            Some(5) => compare_condensed::<5>(&file, &instances),
            Some(10) => compare_condensed::<10>(&file, &instances),
            Some(30) => compare_condensed::<30>(&file, &instances),
            other => panic!("{}: no such control horizon: {other:?}", file.display()),
        }
    }
}

/// The board has 192 kB of RAM, and the stack of one solve comes on top.
#[test]
fn memory_stays_small() {
    fn sizes<const M: usize>() -> (usize, usize) {
        let sizes = (size_of::<RegulationMpc<M>>(), size_of::<RegulationState<M>>());
        println!("M = {M:2}: prepared {:6} bytes, state {:5} bytes", sizes.0, sizes.1);
        sizes
    }
    assert!(sizes::<1>().0 < 3_000);
    assert!(sizes::<10>().0 < 10_000);
    let (prepared, state) = sizes::<30>();
    assert!(prepared < 34_000 && state < 7_000, "{prepared} {state}");
}
