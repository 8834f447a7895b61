//! The blind campaign: `cargo run --release -p integration-tests --bin blind_diagnosis -- [FIRST [COUNT]]`.

use integration_tests::blind::{Case, Outcome, Score};
use sil_host::diagnosis::{Subject, diagnose};
use sil_host::model::{Rig, VehicleModel};

fn main() {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>().expect("a number"));
    let (first, count) = (arguments.next().unwrap_or(0), arguments.next().unwrap_or(200));
    let model = VehicleModel::nominal(Rig::Gimbal);
    let mut score = Score::default();
    for seed in first..first + count {
        let case = Case::new(seed);
        let begin = std::time::Instant::now();
        let answer = diagnose(&case.log(), &Subject::Vehicle(&model)).expect("a whole log");
        let outcome = Outcome::new(&case, &answer);
        println!(
            "{seed:4} {} {:<24} -> {:<24} {:?} ratio {:.2} {} Hz size error {:?} covered {:?} more {} {:?} {:.1} s",
            if outcome.right { "right" } else { "WRONG" },
            outcome.hidden,
            outcome.found,
            answer.findings.first().map(|finding| &finding.confounded_with),
            case.ratio,
            case.rate_hz,
            outcome.size_error,
            outcome.covered,
            outcome.false_findings,
            outcome.verdict,
            begin.elapsed().as_secs_f64()
        );
        score.add(outcome);
    }
    println!("\n{}", score.table());
}
