//! Single decisions of the search, and what it does with nonsense.

use super::super::{DoubleIntegrator, SoftAngle, Tracking};
use super::*;

const STAGES: usize = 4;

type Lq = BoundedLq<DoubleIntegrator, 2, STAGES>;

fn prepared() -> (Lq, SoftAngle<2>) {
    let lq = Lq::prepare(DoubleIntegrator, 50.0, STAGES, DoubleIntegrator.cost_of_held_input(3)).unwrap();
    (lq, SoftAngle::new(&DoubleIntegrator, 3, 50.0, 10.0))
}

const PROBLEM: Tracking<'static, 2> =
    Tracking { start: [0.0, 0.0], previous: 0.0, bounds: [-1.0, 1.0], reference: &[0.0; 6] };

/// Lets go of `change` while `aim` is pursued; the way on, and the tolerances and aim after it.
fn let_go(aim: Aim, change: Change, is_warm: bool, tolerances: [f32; 2]) -> (Option<usize>, [f32; 2], Aim) {
    let (_, soft) = prepared();
    let bounds = AngleBounds { tolerances, ..AngleBounds::new([-10.0, 10.0], &soft) };
    let (mut pattern, mut laws, mut angles) = (
        PatternOf::<Tracking<'_, 2>, 2, STAGES>::new(),
        LawsOf::<Tracking<'_, 2>, 2, STAGES>::blank(()),
        HeldAngles::NONE,
    );
    let (mut point, mut target, mut shifts) = (DualPoint::ZERO, DualPoint::ZERO, Shifts::new());
    let mut search = Search {
        problem: &PROBLEM,
        bounds,
        pattern: &mut pattern,
        laws: &mut laws,
        angles: &mut angles,
        shifts: &mut shifts,
        point: &mut point,
        target: &mut target,
        aim,
        may_leap: true,
        is_warm,
    };
    let next = match search.let_go(change) {
        Next::Go(changed) => Some(changed),
        Next::StartAnew => None,
        Next::Solved(_) => panic!("letting go solves nothing"),
    };
    (next, search.bounds.tolerances, search.aim)
}

/// A bound that is left where it was before it was taken in is so by rounding, or by what was held before.
#[test]
fn a_bound_taken_in_and_left_at_once_is_doubtful() {
    let (_, soft) = prepared();
    let fine = [2e-6, soft.tolerance];
    let loose = Change::Row(3, Row::Loose);
    let taken_in = Aim::TakeIn(Change::Row(3, Row::Upper), Direction::Rises);
    let coarser = fine.map(|tolerance| 4.0 * tolerance);
    assert_eq!(let_go(taken_in, loose, false, fine), (Some(0), coarser, Aim::Settle));
    assert_eq!(let_go(taken_in, loose, true, fine).0, None);
    // as coarse as rounding can be
    let coarse = [fine[0], 200.0 * soft.tolerance];
    assert_eq!(let_go(taken_in, loose, false, coarse), (Some(0), coarse, Aim::Settle));
    // given up, it was, or it comes to the weight: its multiplier went all the way
    let above = Change::Row(3, Row::AboveUpper);
    for is_warm in [false, true] {
        assert_eq!(let_go(taken_in, above, is_warm, fine), (Some(0), fine, Aim::Settle));
    }
    let falling = Aim::TakeIn(Change::Row(3, Row::Upper), Direction::Falls);
    assert_eq!(let_go(falling, above, false, fine), (Some(0), coarser, Aim::Settle));
    assert_eq!(let_go(falling, loose, true, fine), (Some(0), fine, Aim::Settle));
    // another one, on the way
    assert_eq!(let_go(taken_in, Change::Row(2, Row::Loose), true, fine), (Some(0), fine, taken_in));
    assert_eq!(let_go(taken_in, Change::Input(1, Held::Free), true, fine), (Some(2), fine, taken_in));
}

/// What no input can keep is given up, and all inputs up to it are for it.
#[test]
fn what_no_input_can_keep_is_given_up() {
    let (lq, soft) = prepared();
    let given_up = |start: [f32; 2]| {
        let problem = Tracking { start, ..PROBLEM };
        let bounds = AngleBounds::new([-10.0, 10.0], &soft);
        let (mut pattern, mut laws) =
            (PatternOf::<Tracking<'_, 2>, 2, STAGES>::new(), LawsOf::<Tracking<'_, 2>, 2, STAGES>::blank(()));
        let mut angles = HeldAngles::NONE;
        lq.give_up(&problem, &bounds, (&mut pattern, &mut laws), &mut angles);
        let rows: [Row; 7] = core::array::from_fn(|index| angles.rows.get(index));
        (rows, pattern.held, laws.held_count)
    };
    let (loose, above, below) = (Row::Loose, Row::AboveUpper, Row::BelowLower);
    let (free, low, high) = (Held::Free, Held::Low, Held::High);
    assert_eq!(given_up([0.0, 1.0]), ([loose; 7], [free; 4], 0));
    // braking all the way: 10.5, 10, 8.5; and 11.5, 12, 11.5, 10, 7.5
    assert_eq!(given_up([10.0, 1.0]), ([above, loose, loose, loose, loose, loose, loose], [low, free, free, free], 1));
    assert_eq!(given_up([10.0, 2.0]), ([above, above, above, loose, loose, loose, loose], [low, low, low, free], 3));
    assert_eq!(
        given_up([-10.0, -2.0]),
        ([below, below, below, loose, loose, loose, loose], [high, high, high, free], 3)
    );
    // braking until it is just at the bound
    assert_eq!(given_up([-10.0, -1.0]).0, [below, loose, loose, loose, loose, loose, loose]);
    // to the horizon's end, and no further
    assert_eq!(given_up([10.0, 9.0]), ([above, above, above, above, above, above, loose], [low; 4], 4));
    // 4.4, 7.8, 10.2, 11.6, 12, 11.4
    assert_eq!(given_up([0.0, 4.9]), ([loose, loose, above, above, above, above, loose], [low; 4], 4));
}

fn solve(problem: &Tracking<'_, 2>, bounds: [f32; 2]) -> (Outcome, Pattern, HeldAngles) {
    let (lq, soft) = prepared();
    let bounds = AngleBounds { lower: bounds[0], upper: bounds[1], ..AngleBounds::new([0.0; 2], &soft) };
    let (mut pattern, mut laws) = (Pattern::new(), LawsOf::<Tracking<'_, 2>, 2, STAGES>::blank(()));
    pattern.held[0] = Held::High;
    let mut angles = HeldAngles::NONE;
    angles.rows.set(1, Row::Upper);
    lq.begin(problem, &mut pattern, &mut laws);
    let outcome = lq.solve_bounded(problem, &bounds, (&mut pattern, &mut laws), &mut angles);
    (outcome, pattern, angles)
}

type Pattern = PatternOf<Tracking<'static, 2>, 2, STAGES>;

/// No bounds and no data that are no numbers are solved with; nothing of the guess stays.
#[test]
fn nonsense_has_a_status() {
    let sound = solve(&PROBLEM, [-10.0, 10.0]).0;
    assert_eq!((sound.status, sound.input), (Status::Solved, 0.0));
    assert!(sound.iterations > 1, "what was held is let go first");
    let (nan, infinite) = (f32::NAN, f32::INFINITY);
    let bad_bounds = [[nan, 10.0], [-10.0, nan], [-10.0, infinite], [-infinite, 10.0], [-infinite, infinite]];
    let cases = bad_bounds.map(|bounds| (PROBLEM, bounds));
    for (problem, bounds) in cases.into_iter().chain([(Tracking { previous: nan, ..PROBLEM }, [-10.0, 10.0])]) {
        let (outcome, pattern, angles) = solve(&problem, bounds);
        assert_eq!(outcome, Outcome { input: 0.0, status: Status::NumericalError, iterations: 0 });
        assert!(pattern == Pattern::new() && !angles.is_any());
    }
}

/// Numbers whose products are none.
#[test]
fn an_overflow_has_a_status() {
    let huge = Tracking { reference: &[5e37; 6], start: [-5e37, 0.0], ..PROBLEM };
    let (outcome, pattern, angles) = solve(&huge, [-1e38, 1e38]);
    assert_eq!((outcome.status, outcome.input), (Status::NumericalError, 0.0));
    assert!(outcome.iterations < PASS_LIMIT && pattern == Pattern::new() && !angles.is_any());
}
