//! The shipped MPC against the reference instances: exact solutions of the same problem, computed elsewhere in double
//! precision.

use std::path::{Path, PathBuf};

use shared_control::mpc::{RegulationMpc, RegulationState};
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
