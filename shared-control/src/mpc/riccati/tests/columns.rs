//! The system of the angles' multipliers against elimination in f64.

extern crate std;

use std::vec::Vec;

use super::super::columns::{self, Column, Columns};
use super::super::rows::{Row, Rows};
use super::Numbers;

type Sum = Column<2, 6>;

/// Sums of angles that the inputs up to the angle move by random effects, where each input's law gives way by its own
/// share: the offsets of a real problem are such, so that J is symmetric and positive definite.
fn random_columns(numbers: &mut Numbers, rows: &[usize]) -> Vec<Sum> {
    let shares: Vec<f32> = (0..6).map(|_| 1.5 + numbers.next()).collect();
    let column = |row: &usize| {
        let mut column = Sum::new(*row, [1.0, 0.0, 0.0]);
        column.excess = 3.0 * numbers.next();
        for (stage, share) in shares.iter().enumerate().take(*row + 1) {
            let (effect, offset) = column.at(stage).unwrap();
            *effect = numbers.next();
            *offset = -share * *effect;
        }
        column
    };
    rows.iter().map(column).collect()
}

/// How much a sum of angles falls per multiplier of another.
fn fall(one: &Sum, other: &Sum) -> f64 {
    one.effects.iter().zip(&other.offsets).map(|(effect, offset)| -f64::from(*effect) * f64::from(*offset)).sum()
}

/// How far the multipliers leave the sums from what they are to be.
fn remaining(columns: &[Sum]) -> f64 {
    let remaining = |one: &Sum| {
        let moved: f64 = columns.iter().map(|other| fall(one, other) * f64::from(other.multiplier)).sum();
        (f64::from(one.excess) - moved).abs()
    };
    columns.iter().map(remaining).fold(0.0, f64::max)
}

#[test]
fn the_multipliers_bring_every_sum_to_its_bound() {
    let mut numbers = Numbers(11);
    for _ in 0..500 {
        let mut columns = random_columns(&mut numbers, &[5, 2, 4, 3]);
        assert_eq!(columns::solve(&mut columns, 0), None);
        let size = columns.iter().map(|column| f64::from(column.multiplier.abs())).fold(1.0, f64::max);
        // sums of six products of at most 2.5, in single precision
        assert!(remaining(&columns) <= 1e-5 * size, "{}", remaining(&columns));
    }
}

/// A system that grows is factored from its new columns on; one whose columns changed, from the first that did.
#[test]
fn known_factors_stay() {
    let mut numbers = Numbers(12);
    for _ in 0..200 {
        let mut columns = random_columns(&mut numbers, &[5, 2, 4, 3]);
        let mut fresh = columns.clone();
        assert_eq!(columns::solve(&mut columns[..2], 0), None);
        assert_eq!(columns::solve(&mut columns, 2), None);
        assert_eq!(columns::solve(&mut fresh, 0), None);
        let bits = |columns: &[Sum]| columns.iter().map(|column| column.multiplier.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&columns), bits(&fresh));
    }
}

/// The third column is a sum of the first two: with the multipliers found, nothing moves, and the fourth has no part.
#[test]
fn what_depends_on_others_is_found_with_the_multipliers_that_move_nothing() {
    let mut numbers = Numbers(13);
    for _ in 0..200 {
        let mut columns = random_columns(&mut numbers, &[5, 2, 4, 3]);
        let (first, second) = (columns[0], columns[1]);
        let [one, other] = [1.0 + numbers.next(), -2.0 + numbers.next()];
        columns[2].row = 5;
        for stage in 0..6 {
            columns[2].effects[stage] = one * first.effects[stage] + other * second.effects[stage];
            columns[2].offsets[stage] = one * first.offsets[stage] + other * second.offsets[stage];
        }
        assert_eq!(columns::solve(&mut columns, 0), Some(5));
        for (column, expected) in columns.iter().zip([-one, -other, 1.0, 0.0]) {
            // the second may be nearly a multiple of the first
            assert!((column.multiplier - expected).abs() <= 1e-3, "{} {expected}", column.multiplier);
        }
    }
}

/// A sum moves with another by the stages that both see.
#[test]
fn coupling_counts_every_stage_that_both_see() {
    let mut numbers = Numbers(14);
    let columns = random_columns(&mut numbers, &[0, 3, 5]);
    for one in &columns {
        for other in &columns {
            assert!((f64::from(one.coupling(other)) + fall(one, other)).abs() <= 1e-6);
        }
    }
}

fn held(rows: &[usize]) -> Rows {
    let mut held = Rows::LOOSE;
    rows.iter().for_each(|row| held.set(*row, Row::Upper));
    held
}

/// Marks what is made anew.
fn choose(columns: &mut Columns<2, 6>, rows: &Rows) -> (Option<usize>, Vec<usize>) {
    columns.iter_mut().for_each(|column| column.value = 0.0);
    let unchanged = columns::choose(columns, rows, |column| column.value = 1.0);
    let made = columns.iter().filter(|column| column.value == 1.0).map(|column| column.row).collect();
    (unchanged, made)
}

/// An angle alone, the second of neighbours as a first difference, any more as second differences.
#[test]
fn neighbours_are_taken_as_differences() {
    let mut columns = Columns::new();
    assert_eq!(choose(&mut columns, &held(&[0, 1, 3, 4, 5, 6, 8])), (Some(0), std::vec![0, 1, 3, 4, 5, 6, 8]));
    let [alone, first, second] = [[1.0, 0.0, 0.0], [1.0, -1.0, 0.0], [1.0, -2.0, 1.0]];
    let weights: Vec<[f32; 3]> = columns.iter().map(|column| column.weights).collect();
    assert_eq!(weights, [alone, first, alone, first, second, second, alone]);
    let differences: Vec<bool> = columns.iter().map(Column::is_difference).collect();
    assert_eq!(differences, [false, true, false, true, true, true, false]);
}

#[test]
fn only_what_changed_is_made_anew() {
    let mut columns = Columns::new();
    choose(&mut columns, &held(&[1, 5, 9]));
    assert_eq!(choose(&mut columns, &held(&[1, 5, 9])), (Some(3), std::vec![]));
    assert_eq!(choose(&mut columns, &held(&[1, 5, 7, 9])), (Some(3), std::vec![7]));
    assert_eq!(choose(&mut columns, &held(&[1, 7, 9])), (Some(1), std::vec![]), "one less");
    // a new neighbour makes 9 a difference
    assert_eq!(choose(&mut columns, &held(&[1, 7, 8, 9])), (Some(1), std::vec![8, 9]));
    let rows: Vec<usize> = columns.iter().map(|column| column.row).collect();
    assert_eq!(rows, [1, 7, 8, 9]);
}

/// Of more angles than inputs one depends on the others; there is room for this one, and no more.
#[test]
fn there_is_room_for_one_more_than_inputs() {
    let mut columns = Columns::new();
    assert_eq!(choose(&mut columns, &held(&[0, 1, 2, 3, 4, 5, 6])).0, Some(0));
    assert_eq!(choose(&mut columns, &held(&[0, 1, 2, 3, 4, 5, 6, 7])).0, None);
}

/// The multipliers of angles add up to the same as those of their differences; of a lower bound the sign is the other.
#[test]
fn multipliers_of_differences_become_those_of_angles() {
    let mut rows = held(&[2, 3, 4, 5, 9]);
    rows.set(9, Row::Lower);
    let mut columns = Columns::<2, 6>::new();
    choose(&mut columns, &rows);
    for (column, multiplier) in columns.iter_mut().zip([1.0, 10.0, 100.0, 1000.0, 7.0]) {
        column.multiplier = multiplier;
    }
    let mut multipliers = [0.5; crate::mpc::HORIZON];
    columns::row_multipliers(&columns, &rows, &mut multipliers);
    // 1 a2 + 10 (a3 - a2) + 100 (a4 - 2 a3 + a2) + 1000 (a5 - 2 a4 + a3) + 7 a9
    let mut expected = [0.5; crate::mpc::HORIZON];
    (expected[2], expected[3], expected[4], expected[5], expected[9]) = (91.0, 810.0, -1900.0, 1000.0, -7.0);
    assert_eq!(multipliers, expected);
}
