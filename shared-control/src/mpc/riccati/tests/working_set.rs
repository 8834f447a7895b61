//! What is held, which bound is violated most, and how far multipliers can go, worked out by hand.

use super::super::guess::{Held, Pattern};
use super::super::rows::{Row, Rows};
use super::super::working_set::{Change, Direction, DualPoint, Violation};
use super::super::{AngleBounds, DoubleIntegrator, SoftAngle};

const FREE: Held = Held::Free;
/// Greatest multiplier of an angle.
const WEIGHT: f32 = 8.0;

#[test]
fn a_change_is_of_its_own_input_or_angle() {
    let (input, row) = (Change::Input(3, FREE), Change::Row(3, Row::Upper));
    assert!(input.is_of(&Change::Input(3, Held::Low)) && row.is_of(&Change::Row(3, Row::Loose)));
    assert!(!input.is_of(&Change::Input(2, FREE)) && !row.is_of(&Change::Row(4, Row::Upper)));
    assert!(!input.is_of(&row) && !row.is_of(&input));
}

/// An input's law changes with it, and those before; no law depends on the angles held.
#[test]
fn a_change_counts_the_stages_whose_laws_it_changes() {
    let (mut pattern, mut rows) = (Pattern::<4, ()>::new(), Rows::LOOSE);
    assert_eq!(Change::Input(2, Held::Low).apply(&mut pattern, &mut rows), 3);
    assert_eq!((pattern.held, rows), ([FREE, FREE, Held::Low, FREE], Rows::LOOSE));
    assert_eq!(Change::Row(5, Row::Upper).apply(&mut pattern, &mut rows), 0);
    assert_eq!(rows.get(5), Row::Upper);
}

/// The worst violation of what is seen, with inputs in -1 ..= 2 and angles in -10 ..= 10, of which 0.25 and, times
/// the step's number, 0.5 count as none.
fn worst(rows: &Rows, inputs: &[f32], angles: &[(usize, f32)]) -> Option<Change> {
    let soft = SoftAngle::new(&DoubleIntegrator, 1, 1.0, 10.0);
    let bounds = AngleBounds { tolerances: [0.25, 0.5], ..AngleBounds::new([-10.0, 10.0], &soft) };
    let mut violation = Violation::none([-1.0, 2.0], &bounds, rows);
    for (index, input) in inputs.iter().enumerate() {
        violation.see_free_input(index, *input);
    }
    for (index, angle) in angles {
        violation.see_angle(*index, *angle);
    }
    violation.worst()
}

#[test]
fn the_input_furthest_beyond_its_bounds_is_the_worst() {
    let worst = |inputs: &[f32]| worst(&Rows::LOOSE, inputs, &[]);
    assert_eq!(worst(&[0.0, 2.25, -1.25]), None, "within the tolerance");
    assert_eq!(worst(&[0.0, 2.3]), Some(Change::Input(1, Held::High)));
    assert_eq!(worst(&[0.0, -1.3]), Some(Change::Input(1, Held::Low)));
    assert_eq!(worst(&[-1.5, -1.4, 2.45]), Some(Change::Input(0, Held::Low)));
    assert_eq!(worst(&[-1.5, 2.6, -1.4]), Some(Change::Input(1, Held::High)));
    assert_eq!(worst(&[2.5, 2.4, -1.6]), Some(Change::Input(2, Held::Low)));
    assert_eq!(worst(&[2.5, 2.5, -1.5]), Some(Change::Input(0, Held::High)), "of equal ones the first");
}

#[test]
fn the_angle_furthest_beyond_its_bounds_is_the_worst() {
    let worst = |angles: &[(usize, f32)]| worst(&Rows::LOOSE, &[], angles);
    assert_eq!(worst(&[(0, 10.5), (1, -10.5)]), None, "within the tolerance");
    assert_eq!(worst(&[(0, 10.625)]), Some(Change::Row(0, Row::Upper)));
    assert_eq!(worst(&[(0, -10.625)]), Some(Change::Row(0, Row::Lower)));
    // rounding grows with the step
    assert_eq!(worst(&[(3, 11.875), (3, -11.875), (3, 12.0), (3, -12.0)]), None);
    assert_eq!(worst(&[(3, 12.125)]), Some(Change::Row(3, Row::Upper)));
    assert_eq!(worst(&[(3, -12.125)]), Some(Change::Row(3, Row::Lower)));
    assert_eq!(worst(&[(0, 12.0), (1, -13.0), (2, 12.5)]), Some(Change::Row(1, Row::Lower)));
    assert_eq!(worst(&[(0, 13.0), (1, -12.5), (2, 12.5)]), Some(Change::Row(0, Row::Upper)));
}

/// An input beyond its bounds counts thirty-two times as much as an angle.
#[test]
fn inputs_and_angles_are_compared() {
    let worst = |inputs: &[f32], angle: f32| worst(&Rows::LOOSE, inputs, &[(0, angle)]);
    for inputs in [[0.0, 2.5], [0.0, -1.5]] {
        assert!(matches!(worst(&inputs, 25.0), Some(Change::Input(1, _))));
        assert_eq!(worst(&inputs, 27.0), Some(Change::Row(0, Row::Upper)));
        assert_eq!(worst(&inputs, -27.0), Some(Change::Row(0, Row::Lower)));
    }
    let soft = SoftAngle::new(&DoubleIntegrator, 1, 1.0, 10.0);
    let bounds = AngleBounds { tolerances: [0.25, 0.5], ..AngleBounds::new([-10.0, 10.0], &soft) };
    // sixteen beyond is as much as half beyond
    for (input, expected) in [(2.45, false), (2.55, true), (-1.45, false), (-1.55, true)] {
        let mut violation = Violation::none([-1.0, 2.0], &bounds, &Rows::LOOSE);
        violation.see_angle(0, 26.0);
        violation.see_free_input(0, input);
        assert_eq!(matches!(violation.worst(), Some(Change::Input(..))), expected, "{input}");
    }
}

/// A bound that is given up belongs to an angle beyond it: it is wrong inside, by the distance. Held ones are kept
/// by the multipliers.
#[test]
fn an_angle_back_inside_a_bound_given_up_is_a_violation() {
    let mut rows = Rows::LOOSE;
    rows.set(0, Row::AboveUpper);
    rows.set(1, Row::BelowLower);
    rows.set(2, Row::Upper);
    rows.set(3, Row::Lower);
    let worst = |angles: &[(usize, f32)]| worst(&rows, &[], angles);
    assert_eq!(worst(&[(0, 15.0), (1, -15.0), (2, 40.0), (3, -40.0), (4, 0.0)]), None);
    assert_eq!(worst(&[(0, 9.0)]), Some(Change::Row(0, Row::Upper)));
    assert_eq!(worst(&[(1, -8.5)]), Some(Change::Row(1, Row::Lower)));
    assert_eq!(worst(&[(0, 9.5), (1, -9.0)]), None, "within the tolerance");
    // the first of equal ones, and no lesser one after it
    assert_eq!(worst(&[(4, 14.0), (5, 14.0), (0, 9.0)]), Some(Change::Row(4, Row::Upper)));
    assert_eq!(worst(&[(4, 14.0), (0, 5.0), (5, -14.0)]), Some(Change::Row(0, Row::Upper)));
}

/// Three inputs, of which the last is free, and angles of which 0 is held at the upper and 2 at the lower bound.
fn held() -> (Pattern<3, ()>, Rows) {
    let (mut pattern, mut rows) = (Pattern::new(), Rows::LOOSE);
    pattern.held = [Held::High, Held::Low, FREE];
    rows.set(0, Row::Upper);
    rows.set(2, Row::Lower);
    (pattern, rows)
}

/// The third angle's number is 2; what lies between means nothing.
fn point(inputs: [f32; 3], first: f32, third: f32) -> DualPoint<3> {
    let mut point = DualPoint { inputs, ..DualPoint::ZERO };
    (point.rows[0], point.rows[1], point.rows[2]) = (first, -5.0, third);
    point
}

#[test]
fn a_rate_moves_a_multiplier_up_or_down() {
    let rates = point([1.0, -1.0, 0.0], -2.0, 2.0);
    let rises = |change| (rates.goes(change, Direction::Rises), rates.goes(change, Direction::Falls));
    assert_eq!(rises(Change::Input(0, FREE)), (true, false));
    assert_eq!(rises(Change::Input(1, FREE)), (false, true));
    assert_eq!(rises(Change::Input(2, FREE)), (false, true), "what stays does not rise");
    assert_eq!(rises(Change::Row(0, Row::Loose)), (false, true));
    assert_eq!(rises(Change::Row(2, Row::Loose)), (true, false));
    assert_eq!(rises(Change::Input(3, FREE)), (false, false));
}

/// From 0 up, and from the weight down where the bound was given up.
#[test]
fn a_multiplier_begins_where_its_bound_was() {
    let (_, mut rows) = held();
    rows.set(1, Row::BelowLower);
    let mut point = point([1.0; 3], 2.0, 3.0);
    assert_eq!(point.begin(Change::Input(1, Held::Low), &rows, WEIGHT), Direction::Rises);
    assert_eq!(point.begin(Change::Row(1, Row::Lower), &rows, WEIGHT), Direction::Falls);
    point.rows[3] = 4.0;
    assert_eq!(point.begin(Change::Row(3, Row::Upper), &rows, WEIGHT), Direction::Rises);
    assert_eq!((point.inputs, &point.rows[..4]), ([1.0, 0.0, 1.0], &[2.0, WEIGHT, 3.0, 0.0][..]));
}

/// Straight to `towards`: the share of the way to the first multiplier that ends, and what its bound becomes.
fn blocking(from: &DualPoint<3>, towards: &DualPoint<3>) -> Option<(f32, Change)> {
    let (pattern, rows) = held();
    let blocking = from.first_blocking((&pattern, 2, &rows), WEIGHT, towards, 1.0, |now: f32, aim: f32| aim - now);
    blocking.map(|blocking| (blocking.step, blocking.change))
}

#[test]
fn the_first_multiplier_to_end_blocks() {
    let from = point([1.0, 2.0, 1.0], 2.0, 4.0);
    assert_eq!(blocking(&from, &point([-1.0, 2.0, 1.0], 2.0, 4.0)), Some((0.5, Change::Input(0, FREE))));
    assert_eq!(blocking(&from, &point([-1.0, -6.0, 1.0], 2.0, 4.0)), Some((0.25, Change::Input(1, FREE))));
    assert_eq!(blocking(&from, &point([-3.0, -6.0, 1.0], 2.0, 4.0)), Some((0.25, Change::Input(0, FREE))));
    assert_eq!(blocking(&from, &point([1.0, 2.0, 1.0], -2.0, 4.0)), Some((0.5, Change::Row(0, Row::Loose))));
    assert_eq!(blocking(&from, &point([1.0, 2.0, 1.0], 14.0, 4.0)), Some((0.5, Change::Row(0, Row::AboveUpper))));
    assert_eq!(blocking(&from, &point([1.0, 2.0, 1.0], 14.0, 20.0)), Some((0.25, Change::Row(2, Row::BelowLower))));
    assert_eq!(blocking(&from, &point([-3.0, 2.0, 1.0], 14.0, 12.0)), Some((0.25, Change::Input(0, FREE))));
    // free inputs and loose angles have no multipliers; an end that is only just reached is none
    assert_eq!(blocking(&from, &point([0.0, 0.0, -9.0], 0.0, 8.0)), None);
}

/// Inputs behind the last held stage are free, whatever is noted of them.
#[test]
fn only_held_stages_block() {
    let (pattern, rows) = held();
    let (from, towards) = (point([1.0, 1.0, 1.0], 1.0, 1.0), point([1.0, -1.0, 1.0], 1.0, 1.0));
    let blocks = |held_count: usize| {
        from.first_blocking((&pattern, held_count, &rows), WEIGHT, &towards, 1.0, |now: f32, aim: f32| aim - now)
    };
    assert!(blocks(1).is_none() && blocks(2).is_some());
}

/// Along a ray, without end: the same rule with the rates themselves.
#[test]
fn along_a_ray_the_first_end_blocks() {
    let (pattern, rows) = held();
    let rates = point([-0.5, 1.0, 0.0], -0.125, 0.5);
    let ray = |_: f32, direction: f32| direction;
    let from = point([1.0, 0.0, 0.0], 2.0, 4.0);
    let blocking = from.first_blocking((&pattern, 2, &rows), WEIGHT, &rates, f32::INFINITY, ray);
    let blocking = blocking.map(|blocking| (blocking.step, blocking.change));
    assert_eq!(blocking, Some((2.0, Change::Input(0, FREE))));
}

#[test]
fn a_walk_moves_what_is_held_and_stays_above_zero() {
    let (_, rows) = held();
    let mut walker = point([1.0, 2.0, 3.0], 2.0, 4.0);
    walker.walk(&rows, &point([3.0, -8.0, 3.0], 6.0, 0.0), 0.5, |now: f32, aim: f32| aim - now);
    assert_eq!(walker.inputs, [2.0, 0.0, 3.0]);
    assert_eq!(walker.rows[..3], [4.0, -5.0, 2.0]);
    walker.walk(&rows, &point([1.0, 0.0, 0.0], -9.0, -1.0), 0.5, |_: f32, direction: f32| direction);
    assert_eq!(walker.inputs, [2.5, 0.0, 3.0]);
    assert_eq!(walker.rows[..3], [0.0, -5.0, 1.5]);
}

/// A quarter of the way from 2 to -8 is below 0, from 2 to -6 it is just 0.
#[test]
fn what_ends_within_a_quarter_of_the_way_is_let_go() {
    let let_go = |towards: [f32; 3], held_count: usize| {
        let (mut pattern, _) = held();
        let from = point([2.0, 2.0, 2.0], 0.0, 0.0);
        (from.let_go_near(&mut pattern, held_count, &point(towards, 0.0, 0.0)), pattern.held)
    };
    assert_eq!(let_go([-8.0, 8.0, -8.0], 3), (1, [FREE, Held::Low, FREE]));
    assert_eq!(let_go([-6.0, -8.0, -8.0], 3), (2, [Held::High, FREE, FREE]));
    assert_eq!(let_go([-8.0, -8.0, -8.0], 1), (1, [FREE, Held::Low, FREE]));
    assert_eq!(let_go([-5.0, -6.0, -8.0], 3), (0, [Held::High, Held::Low, FREE]));
}

#[test]
fn what_has_a_multiplier_out_of_range_is_dropped() {
    let drop_wrong = |point: DualPoint<3>, held_count: usize| {
        let (mut pattern, mut rows) = held();
        let changed = point.drop_wrong(&mut pattern, held_count, &mut rows, WEIGHT);
        (changed, pattern.held, [rows.get(0), rows.get(1), rows.get(2)])
    };
    let (all, angles) = ([Held::High, Held::Low, FREE], [Row::Upper, Row::Loose, Row::Lower]);
    assert_eq!(drop_wrong(point([0.0, 0.0, -1.0], 0.0, WEIGHT), 3), (None, all, angles));
    assert_eq!(drop_wrong(point([-1.0, 1.0, -1.0], 0.0, WEIGHT), 3), (Some(1), [FREE, Held::Low, FREE], angles));
    assert_eq!(drop_wrong(point([-1.0, -1.0, 1.0], 0.0, 0.0), 3), (Some(2), [FREE; 3], angles));
    assert_eq!(drop_wrong(point([-1.0, -1.0, 1.0], 0.0, 0.0), 1), (Some(1), [FREE, Held::Low, FREE], angles));
    let below = [Row::Loose, Row::Loose, Row::Lower];
    assert_eq!(drop_wrong(point([1.0; 3], -1.0, 1.0), 3), (Some(0), all, below));
    let beyond = [Row::AboveUpper, Row::Loose, Row::BelowLower];
    assert_eq!(drop_wrong(point([1.0; 3], 9.0, 9.0), 3), (Some(0), all, beyond));
}
