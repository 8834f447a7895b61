//! Do two answers to one vehicle agree? In their names, and in their sizes: z, the difference of a size over the root
//! of the summed squared standard deviations. Of honest intervals |z| has a median of 0.67 and exceeds 1.96 in 5 %.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use sil_host::diagnosis::Estimate;

use super::answer::Named;

/// A size in two logs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SizeTwice {
    /// Effect and axis or motor.
    pub name: String,
    /// Parameter.
    pub parameter: String,
    /// Its values.
    pub both: [Estimate; 2],
    /// Their difference in standard deviations.
    pub z: f64,
}

/// Difference in standard deviations; none without a standard deviation that says something.
pub fn z([a, b]: [Estimate; 2]) -> Option<f64> {
    let std = a.std.hypot(b.std);
    let z = (a.value - b.value) / std;
    (std > 0.0 && std.is_finite() && z.is_finite()).then_some(z)
}

/// Sizes of the effects that two answers have in common.
pub fn common_sizes(a: &[Named], b: &[Named]) -> Vec<SizeTwice> {
    let pairs = a.iter().filter_map(|one| Some((one, b.iter().find(|other| other.name == one.name)?)));
    pairs.flat_map(|(one, other)| sizes_twice(&one.name, &one.sizes, &other.sizes)).collect()
}

/// The parameters of one effect.
pub fn sizes_twice(name: &str, a: &BTreeMap<String, Estimate>, b: &BTreeMap<String, Estimate>) -> Vec<SizeTwice> {
    let size = |(parameter, one): (&String, &Estimate)| {
        let both = [*one, *b.get(parameter)?];
        Some(SizeTwice { name: name.to_owned(), parameter: parameter.clone(), both, z: z(both)? })
    };
    a.iter().filter_map(size).collect()
}

/// Number of names in both answers, and in either.
pub fn names_in_both_and_either(a: &[Named], b: &[Named]) -> [usize; 2] {
    let [a, b] = [a, b].map(|findings| findings.iter().map(|one| &one.name).collect::<BTreeSet<_>>());
    [a.intersection(&b).count(), a.union(&b).count()]
}

/// How often each name was found in some answers, all names that are in any of them.
pub fn found_in(answers: &[Vec<Named>]) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for answer in answers {
        let names: BTreeSet<&String> = answer.iter().map(|one| &one.name).collect();
        names.into_iter().for_each(|name| *counts.entry(name.clone()).or_insert(0) += 1);
    }
    counts
}

/// Figures of many |z|.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Scatter {
    /// Their number.
    pub count: usize,
    /// Median; none without any.
    pub median: Option<f64>,
    /// Number above 1.96.
    pub above_1_96: usize,
    /// Above 3.
    pub above_3: usize,
    /// The largest.
    pub max: Option<f64>,
}

impl Scatter {
    /// Of sizes that were found twice.
    pub fn of<'s>(sizes: impl IntoIterator<Item = &'s SizeTwice>) -> Scatter {
        let mut all: Vec<f64> = sizes.into_iter().map(|size| size.z.abs()).collect();
        all.sort_by(f64::total_cmp);
        let above = |least: f64| all.iter().filter(|z| **z > least).count();
        Scatter {
            count: all.len(),
            median: median(&all),
            above_1_96: above(1.96),
            above_3: above(3.0),
            max: all.last().copied(),
        }
    }
}

/// Of sorted values.
pub fn median(sorted: &[f64]) -> Option<f64> {
    let (low, high) = (sorted.get(sorted.len().checked_sub(1)? / 2)?, sorted.get(sorted.len() / 2)?);
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use sil_host::sensors::random::RandomStream;

    use super::*;

    fn named(name: &str, value: f64, std: f64) -> Named {
        let sizes = BTreeMap::from([("scale".to_owned(), Estimate { value, std })]);
        Named { name: name.to_owned(), sizes, gain_pct: None, one_of: Vec::new(), stability_pct: None, asked: None }
    }

    #[test]
    fn z_is_the_difference_in_standard_deviations() {
        let of = |a: (f64, f64), b: (f64, f64)| z([a, b].map(|(value, std)| Estimate { value, std }));
        assert_eq!(of((5.0, 3.0), (15.0, 4.0)), Some(-2.0));
        assert_eq!(of((1.0, 0.0), (2.0, 0.0)), None);
        assert_eq!(of((1.0, f64::INFINITY), (2.0, 1.0)), None);
        assert_eq!(of((f64::NAN, 1.0), (2.0, 1.0)), None);
    }

    #[test]
    fn honest_standard_deviations_give_the_figures_of_a_normal_variable() {
        let mut noise = RandomStream::new(5, "halves");
        let sizes: Vec<SizeTwice> = (0..4000)
            .flat_map(|_| {
                let answer = |noise: &mut RandomStream| [named("a", 1.0 + 0.2 * noise.normal(), 0.2)];
                common_sizes(&answer(&mut noise), &answer(&mut noise))
            })
            .collect();
        let scatter = Scatter::of(&sizes);
        assert_eq!(scatter.count, 4000);
        // four standard deviations of a median and of a share of 4000
        assert!((scatter.median.unwrap() - 0.6745).abs() < 0.05, "{scatter:?}");
        assert!((scatter.above_1_96 as f64 / 4000.0 - 0.05).abs() < 0.014, "{scatter:?}");
        assert_eq!(Scatter::of(&[]), Scatter::default());
    }

    #[test]
    fn names_are_compared_and_sizes_of_common_names_alone() {
        let (a, b) =
            ([named("lag", 1.0, 0.1), named("spring", 2.0, 0.1)], [named("lag", 2.0, 0.1), named("bias", 1.0, 1.0)]);
        assert_eq!(names_in_both_and_either(&a, &b), [1, 3]);
        let sizes = common_sizes(&a, &b);
        assert_eq!(sizes.len(), 1);
        assert!((sizes[0].z + 1.0 / 0.02f64.sqrt()).abs() < 1e-12);
        let counts = found_in(&[a.to_vec(), b.to_vec(), Vec::new()]);
        assert_eq!(counts, [("bias", 1), ("lag", 2), ("spring", 1)].map(|(name, n)| (name.to_owned(), n)).into());
    }

    #[test]
    fn a_median_lies_between_the_two_in_the_middle() {
        assert_eq!([median(&[]), median(&[3.0]), median(&[1.0, 2.0, 4.0, 9.0])], [None, Some(3.0), Some(3.0)]);
    }
}
