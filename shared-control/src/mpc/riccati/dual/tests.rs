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

type Inputs = PatternOf<Tracking<'static, 2>, 2, STAGES>;
type InputLaws = LawsOf<Tracking<'static, 2>, 2, STAGES>;

/// What a search works on, with all inputs held at the upper bound and the fourth angle at its own.
struct Held4 {
    lq: Lq,
    soft: SoftAngle<2>,
    pattern: Inputs,
    laws: InputLaws,
    angles: HeldAngles,
    shifts: Shifts<2, STAGES>,
    point: DualPoint<STAGES>,
    target: DualPoint<STAGES>,
}

impl Held4 {
    fn new() -> Self {
        let (lq, soft) = prepared();
        let (mut pattern, mut laws, mut angles) = (Inputs::new(), InputLaws::blank(()), HeldAngles::NONE);
        pattern.held = [Held::High; STAGES];
        lq.sweep(&PROBLEM, &pattern, &mut laws, STAGES);
        angles.rows.set(3, Row::Upper);
        let (point, target) = (DualPoint::ZERO, DualPoint::ZERO);
        Self { lq, soft, pattern, laws, angles, shifts: Shifts::new(), point, target }
    }

    /// The search under way, between -10 and 10.
    fn search(&mut self, aim: Aim, is_warm: bool) -> (&Lq, Search<'_, Tracking<'static, 2>, 2, STAGES>) {
        let Self { lq, soft, pattern, laws, angles, shifts, point, target } = self;
        let (bounds, may_leap) = (AngleBounds::new([-10.0, 10.0], soft), true);
        (lq, Search { problem: &PROBLEM, bounds, pattern, laws, angles, shifts, point, target, aim, may_leap, is_warm })
    }
}

/// The stages changed, or none for a start anew.
fn changed(next: Next) -> Option<usize> {
    match next {
        Next::Go(changed) => Some(changed),
        Next::StartAnew => None,
        Next::Solved(_) => panic!("nothing is solved yet"),
    }
}

/// Lets go of `change` while `aim` is pursued; the way on, and the tolerances and aim after it.
fn let_go(aim: Aim, change: Change, is_warm: bool, tolerances: [f32; 2]) -> (Option<usize>, [f32; 2], Aim) {
    let mut held = Held4::new();
    let (_, mut search) = held.search(aim, is_warm);
    search.bounds.tolerances = tolerances;
    let next = changed(search.let_go(change));
    (next, search.bounds.tolerances, search.aim)
}

/// With all inputs held no input gives way to the fourth angle: its multiplier is traded for theirs by their effects on
/// the angle, 3.5, 2.5, 1.5 and 0.5, up to the first that ends.
#[test]
fn a_dependent_bound_is_traded_for_inputs() {
    let row = Change::Row(3, Row::Upper);
    let near = |one: &[f32], other: &[f32]| one.iter().zip(other).all(|(one, other)| (one - other).abs() <= 1e-3);
    let mut held = Held4::new();
    held.point.inputs = [7.0, 2.5, 9.0, 1.0];
    let (lq, mut search) = held.search(Aim::TakeIn(row, Direction::Rises), false);
    assert_eq!(changed(lq.pass(&mut search)), Some(2));
    assert_eq!(held.pattern.held, [Held::High, Held::Free, Held::High, Held::High]);
    assert!(near(&held.point.inputs, &[3.5, 0.0, 7.5, 0.5]) && near(&held.point.rows[3..4], &[1.0]));
    // falling, it raises those of upper bounds and lowers that of the lower one
    let mut held = Held4::new();
    held.pattern.held[1] = Held::Low;
    held.lq.sweep(&PROBLEM, &held.pattern, &mut held.laws, STAGES);
    (held.point.inputs, held.point.rows[3]) = ([7.0, 5.0, 9.0, 1.0], 6.0);
    let (lq, mut search) = held.search(Aim::TakeIn(row, Direction::Falls), false);
    assert_eq!(changed(lq.pass(&mut search)), Some(2));
    assert_eq!(held.pattern.held, [Held::High, Held::Free, Held::High, Held::High]);
    assert!(near(&held.point.inputs, &[14.0, 0.0, 12.0, 2.0]) && near(&held.point.rows[3..4], &[4.0]));
}

/// At the begin there are no multipliers to trade: what depends on the rest is let go.
#[test]
fn a_dependent_bound_of_the_begin_is_let_go() {
    let mut held = Held4::new();
    let (lq, mut search) = held.search(Aim::Begin, false);
    assert_eq!(changed(lq.pass(&mut search)), Some(0));
    assert_eq!((held.angles.rows.get(3), held.pattern.held), (Row::Loose, [Held::High; STAGES]));
}

/// Once a search, when one input's multiplier ends, all those that end within a quarter of the remaining way are let go
/// too; after it, and if it is the one taken in that ends, only the first.
#[test]
fn many_inputs_are_let_go_once() {
    const FREE: Held = Held::Free;
    let step = |aim: Aim, may_leap: bool| {
        let mut held = Held4::new();
        (held.point.inputs, held.target.inputs) = ([1.0; STAGES], [-4.0, -1.0, -8.0, 1.0]);
        let (_, mut search) = held.search(aim, false);
        search.may_leap = may_leap;
        let next = search.step().and_then(changed);
        (next, search.may_leap, held.pattern.held)
    };
    let only_third = [Held::High, Held::High, FREE, Held::High];
    let other = Aim::TakeIn(Change::Input(3, Held::High), Direction::Rises);
    let third = Aim::TakeIn(Change::Input(2, Held::High), Direction::Rises);
    assert_eq!(step(other, true), (Some(3), false, [FREE, Held::High, FREE, Held::High]));
    assert_eq!(step(Aim::Settle, true), (Some(3), false, [FREE, Held::High, FREE, Held::High]));
    assert_eq!(step(other, false), (Some(3), false, only_third));
    assert_eq!(step(third, true), (Some(3), true, only_third));
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

fn solve(problem: &Tracking<'_, 2>, bounds: [f32; 2]) -> (Outcome, Inputs, HeldAngles) {
    let (lq, soft) = prepared();
    let bounds = AngleBounds { lower: bounds[0], upper: bounds[1], ..AngleBounds::new([0.0; 2], &soft) };
    let (mut pattern, mut laws) = (Inputs::new(), LawsOf::<Tracking<'_, 2>, 2, STAGES>::blank(()));
    pattern.held[0] = Held::High;
    let mut angles = HeldAngles::NONE;
    angles.rows.set(1, Row::Upper);
    lq.begin(problem, &mut pattern, &mut laws);
    let outcome = lq.solve_bounded(problem, &bounds, (&mut pattern, &mut laws), &mut angles);
    (outcome, pattern, angles)
}

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
        assert!(pattern == Inputs::new() && !angles.is_any());
    }
}

/// More angles held than inputs can keep are no start: one pass, and then those of a start anew.
#[test]
fn a_start_that_makes_no_sense_costs_a_pass() {
    let (lq, soft) = prepared();
    let problem = Tracking { start: [0.0, 4.0], reference: &[12.0; 6], ..PROBLEM };
    let bounds = AngleBounds::new([-10.0, 10.0], &soft);
    let solve = |held_rows: usize| {
        let mut angles = HeldAngles::NONE;
        (0..held_rows).for_each(|index| angles.rows.set(index, Row::Upper));
        lq.solve_within(&problem, &bounds, (&mut Inputs::new(), &mut InputLaws::blank(())), &mut angles)
    };
    let anew = solve(0);
    assert!(anew.status == Status::Solved && anew.iterations > 2, "{anew:?}");
    assert_eq!(solve(6), Outcome { iterations: 1 + anew.iterations, ..anew });
}

/// Numbers whose products are none.
#[test]
fn an_overflow_has_a_status() {
    let (lq, soft) = prepared();
    let huge = Tracking { reference: &[5e37; 6], ..PROBLEM };
    let (bounds, mut pattern, mut angles) = (AngleBounds::new([-10.0, 10.0], &soft), Inputs::new(), HeldAngles::NONE);
    angles.rows.set(1, Row::AboveUpper);
    let outcome = lq.solve_within(&huge, &bounds, (&mut pattern, &mut InputLaws::blank(())), &mut angles);
    assert_eq!((outcome.status, outcome.input), (Status::NumericalError, 0.0));
    assert!((1..PASS_LIMIT).contains(&outcome.iterations) && pattern == Inputs::new() && !angles.is_any());
}
