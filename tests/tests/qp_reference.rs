use sil_host::bench_mpc::solve_file;
use std::path::PathBuf;

#[test]
fn every_instance() {
    let dir = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("instances");
    let mut files: Vec<_> = std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    for f in files {
        let r = solve_file(&f).unwrap();
        println!(
            "{:2} {:2} {:6} {:3}/{:3} err {:.2e} it {} {}",
            r.case, r.sub, r.ts_s, r.solved, r.instances, r.error_max, r.iterations_median, r.iterations_max
        );
    }
}
