//! What the real board does at its edges, finding by finding: each has a test, and `ELECTRICS.md` says what it found.
//!
//! A finding that the firmware does not live up to yet stands in [`EXPECTED_TO_FAIL`]; the test fails as soon as it
//! does.

mod findings;
mod table;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use findings::{EXPECTED_TO_FAIL, FINDINGS};

/// Each on boards of its own, two at a time.
#[test]
fn the_board_lives_up_to_every_finding_but_those_that_are_known() {
    let next = AtomicUsize::new(0);
    let found = Mutex::new(vec![None; FINDINGS.len()]);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(finding) = FINDINGS.get(place) else { return };
                    let evidence = (finding.look)();
                    found.lock().unwrap()[place] = Some(evidence);
                }
            });
        }
    });
    let found = found.into_inner().unwrap().into_iter().map(|evidence| evidence.expect("a look")).collect::<Vec<_>>();
    let mut wrong = Vec::new();
    for (finding, evidence) in FINDINGS.iter().zip(&found) {
        match (evidence, EXPECTED_TO_FAIL.contains(&finding.name)) {
            (Err(why), false) => wrong.push(format!("{}: {why}", finding.name)),
            (Ok(how), true) => wrong.push(format!("{}: no longer fails, strike it off the list: {how}", finding.name)),
            _ => {}
        }
    }
    let text = table::markdown(&found);
    println!("{text}");
    table::renew(&text);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    table::compare(&text);
}
