//! Which points nothing beats in every column at once.

/// Whether `a` is nowhere worse than `b` and somewhere better; less is better.
pub fn dominates<const N: usize>(a: &[f64; N], b: &[f64; N]) -> bool {
    let mut pairs = a.iter().zip(b);
    pairs.clone().all(|(a, b)| a <= b) && pairs.any(|(a, b)| a < b)
}

/// Indices of the points that no other dominates, in their order; of equal ones the first.
pub fn front<const N: usize>(points: &[[f64; N]]) -> Vec<usize> {
    let is_beaten = |index: usize| {
        let point = &points[index];
        points.iter().any(|other| dominates(other, point)) || points[..index].contains(point)
    };
    (0..points.len()).filter(|&index| !is_beaten(index)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sil_host::sensors::random::RandomStream;

    #[test]
    fn to_dominate_is_to_be_nowhere_worse_and_somewhere_better() {
        assert!(dominates(&[1.0, 2.0], &[1.0, 3.0]));
        assert!(!dominates(&[1.0, 2.0], &[1.0, 2.0]), "equal");
        assert!(!dominates(&[1.0, 3.0], &[2.0, 2.0]) && !dominates(&[2.0, 2.0], &[1.0, 3.0]), "each better somewhere");
    }

    #[test]
    fn a_staircase_is_its_own_front_and_what_lies_behind_is_not() {
        let points = [[1.0, 3.0], [2.0, 2.0], [3.0, 1.0], [2.0, 2.0], [3.0, 2.0], [1.0, 4.0]];
        assert_eq!(front(&points), [0, 1, 2]);
        assert_eq!(front::<2>(&[]), [0; 0]);
    }

    /// Every point is on the front, or a point of the front dominates or equals it; and none of the front another.
    #[test]
    fn a_front_covers_all_points_and_none_of_its_own() {
        let mut stream = RandomStream::new(1, "front");
        // tenths, so that some columns are equal
        let points: Vec<[f64; 3]> = (0..200).map(|_| [0; 3].map(|_: i32| (10.0 * stream.uniform()).floor())).collect();
        let front = front(&points);
        for point in &points {
            assert!(front.iter().any(|&index| points[index] == *point || dominates(&points[index], point)));
        }
        for &a in &front {
            assert!(front.iter().all(|&b| !dominates(&points[a], &points[b])));
        }
    }
}
