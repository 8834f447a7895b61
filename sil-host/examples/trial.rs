//! Prints diagnoses of logs.
use sil_host::{diagnosis, log, model};
fn main() {
    let model = model::VehicleModel::nominal(model::Rig::Gimbal);
    for path in std::env::args().skip(1) {
        let log = log::read(path.as_ref(), None).unwrap();
        let begin = std::time::Instant::now();
        let answer = diagnosis::diagnose(&log, &diagnosis::Subject::Vehicle(&model)).unwrap();
        println!("== {path} {:?} {:?} {:.1} s", answer.verdict, answer.unexplained, begin.elapsed().as_secs_f64());
        for f in &answer.findings {
            println!("  {} gain {:.1} {:?} {:?}", f.effect, f.gain_pct, f.axis, f.statement);
        }
    }
}
