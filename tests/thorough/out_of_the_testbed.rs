//! What docs/out-of-the-testbed.md says of the thesis' vehicle without its rings, and of the real one.

use campaigns::out_of_the_testbed::{Contender, Flown, Outcome, TakenFor, outcome};

fn delay_margins_ms(of: &Outcome) -> [f64; 2] {
    of.margins.unwrap_or_else(|| panic!("{of:?}")).map(|margins| margins.delay_ms.unwrap())
}

#[test]
fn made_again_roll_and_pitch_are_alike() {
    for flown in [Flown::RingsOff, Flown::RealF450] {
        for contender in [Contender::Cascade, Contender::Mpc] {
            let of = outcome(flown, contender, TakenFor::Itself);
            let [roll, pitch] = of.steps;
            assert!(!of.lost && (roll.rms_error_deg - pitch.rms_error_deg).abs() < 0.2, "{of:?}");
            let [roll_ms, pitch_ms] = delay_margins_ms(&of);
            assert!((roll_ms / pitch_ms - 1.0).abs() < 0.02 && pitch_ms > 20.0, "{of:?}");
            // a push of 0.1 N m, and a heading that is back where it was asked for
            assert!(of.pushed_deg[0].unwrap() < 5.0 && of.turn_deg.unwrap()[0] < 4.0, "{of:?}");
        }
    }
}

#[test]
fn without_its_rings_pitch_keeps_a_sixth_of_its_delay_margin() {
    for contender in [Contender::Cascade, Contender::Mpc] {
        let [roll_ms, pitch_ms] = delay_margins_ms(&outcome(Flown::RingsOff, contender, TakenFor::InTestbed));
        assert!(pitch_ms < roll_ms / 5.0, "{contender:?}: {roll_ms} {pitch_ms}");
    }
    // the thesis feared for its own: it is slow enough
    let thesis = outcome(Flown::RingsOff, Contender::ThesisMpc, TakenFor::InTestbed);
    assert!(!thesis.lost && delay_margins_ms(&thesis)[1] > 20.0, "{thesis:?}");
}

#[test]
fn no_controller_of_the_testbed_flies_the_real_one() {
    for contender in Contender::ALL {
        let of = outcome(Flown::RealF450, contender, TakenFor::InTestbed);
        assert!(of.margins.is_none(), "{of:?}");
    }
    // and the thesis' own has no estimate of what pushes
    let thesis = outcome(Flown::RealF450, Contender::ThesisMpc, TakenFor::Itself);
    assert!(thesis.pushed_deg[0].unwrap() > 10.0, "{thesis:?}");
}
