//! The words of a column's name, and what its number counts from: names alone do not say whether `omega1` is the first
//! of three axes, the second of them, or one of four rotors; the names beside it do.

use std::collections::BTreeMap;

use shared_control::airframe::MOTORS;

use super::languages::in_english;

/// Words that loggers join with an axis' letter, as in `omegax`.
const BEFORE_LETTERS: [&str; 8] = ["omega", "gyro", "gyr", "rate", "angvel", "acc", "accel", "angrate"];
/// Words that they join with an angle's name, as in `rollrate`.
const BEHIND_ANGLES: [&str; 7] = ["rate", "rates", "speed", "ref", "sp", "cmd", "des"];

/// How loggers say where a motor stands, forward and to the right, as in [`MOTORS`].
const CORNERS: [([&str; 4], i8, i8); 4] = [
    (["fr", "rf", "front right", "right front"], 1, 1),
    (["fl", "lf", "front left", "left front"], 1, -1),
    (["rr", "rb", "rear right", "right rear"], -1, 1),
    (["rl", "lr", "rear left", "left rear"], -1, -1),
];
/// Another word for the rear.
const BACK: [(&str, &str); 3] = [("br", "rr"), ("bl", "rl"), ("back", "rear")];

/// The words of a name, in small letters: split at signs, digits and capitals, and where two of them are joined.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = ' ';
    for c in name.chars() {
        let is_start = c.is_ascii_uppercase() && before.is_ascii_lowercase()
            || c.is_ascii_digit() && before.is_ascii_alphabetic() && !before.is_ascii_uppercase()
            || c.is_ascii_alphabetic() && before.is_ascii_digit();
        if c == '°' {
            words.extend(["deg".to_owned(), String::new()]);
        } else if !c.is_alphanumeric() {
            words.push(String::new());
        } else {
            if is_start || words.is_empty() {
                words.push(String::new());
            }
            if let Some(word) = words.last_mut() {
                word.extend(c.to_lowercase());
            }
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    words.into_iter().flat_map(in_english).flat_map(parted).collect()
}

/// A word, or the two that it was joined of.
fn parted(word: String) -> Vec<String> {
    let letter = |first: &str| word.strip_prefix(first).is_some_and(|last| ["x", "y", "z"].contains(&last));
    let angle = |first: &str| word.strip_prefix(first).is_some_and(|last| BEHIND_ANGLES.contains(&last));
    let mut before = BEFORE_LETTERS.into_iter().filter(|first| letter(first));
    let first = before.next().or_else(|| ["roll", "pitch", "yaw"].into_iter().find(|first| angle(first)));
    match first {
        Some(first) => vec![first.to_owned(), word[first.len()..].to_owned()],
        None => vec![word],
    }
}

/// Which of our motors, from 0, stands at the place that a name says: `fl`, `rear_right`; none where it says none.
pub(super) fn motor_at(words: &[String]) -> Option<usize> {
    let usual = |word: &String| {
        let of_back = BACK.into_iter().find(|(back, _)| back == word);
        of_back.map_or_else(|| word.clone(), |(_, rear)| rear.to_owned())
    };
    let words: Vec<String> = words.iter().map(usual).collect();
    let is_said = |names: &[&str; 4]| {
        let pairs = words.windows(2).map(|pair| pair.join(" "));
        pairs.chain(words.iter().cloned()).any(|said| names.contains(&said.as_str()))
    };
    let (_, forward, right) = CORNERS.into_iter().find(|(names, ..)| is_said(names))?;
    MOTORS.iter().position(|motor| (motor.forward, motor.right) == (forward, right))
}

/// The names of a table that differ in their number only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Family {
    least: usize,
    count: usize,
}

impl Family {
    /// The number of the first of them, if it is one of so many.
    fn first_of(self, count: usize) -> Option<usize> {
        (self.count == count && self.least <= 1).then_some(self.least)
    }

    /// The number of the first of four or more motors.
    pub(super) fn first_motor(self) -> Option<usize> {
        (self.count >= 4 && self.least <= 1).then_some(self.least)
    }

    /// True of three names, or fewer, that may be the axes'.
    pub(super) fn may_be_axes(self) -> bool {
        self.count <= 3
    }

    /// True of three names that count from 0 or 1, as the axes do.
    pub(super) fn are_axes(self) -> bool {
        self.first_of(3).is_some()
    }

    /// The number of the first axis.
    pub(super) fn first_axis(self) -> usize {
        self.first_of(3).unwrap_or_default()
    }
}

/// All of a table's.
pub(super) struct Families(BTreeMap<String, Vec<usize>>);

impl Families {
    /// Of the table's names.
    pub(super) fn of<'n>(names: impl Iterator<Item = &'n str>) -> Families {
        let mut families: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (stem, number) in names.filter_map(numbered) {
            families.entry(stem).or_default().push(number);
        }
        Families(families)
    }

    /// That of a name; none where it has no number.
    pub(super) fn family(&self, name: &str) -> Option<Family> {
        let numbers = self.0.get(&numbered(name)?.0)?;
        Some(Family { least: numbers.iter().copied().min()?, count: numbers.len() })
    }
}

/// A name without its first number, and that number.
pub(super) fn numbered(name: &str) -> Option<(String, usize)> {
    let start = name.find(|c: char| c.is_ascii_digit())?;
    let digits =
        name[start..].find(|c: char| !c.is_ascii_digit()).map_or(&name[start..], |end| &name[start..start + end]);
    Some((format!("{}#{}", &name[..start], &name[start + digits.len()..]), digits.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_split_where_loggers_join_them() {
        for (name, expected) in [
            ("m1pwm", "m 1 pwm"),
            ("omegax", "omega x"),
            ("rollrate_dps", "roll rate dps"),
            ("gyroADC[2]", "gyro adc 2"),
            ("acc_z_m_s2", "acc z m s 2"),
            ("controller_rollRate", "controller roll rate"),
            ("max", "max"),
            ("accuracy", "accuracy"),
        ] {
            assert_eq!(words(name).join(" "), expected, "{name}");
        }
    }

    #[test]
    fn a_motors_place_is_told_in_letters_and_words() {
        for (name, motor) in [
            ("pwm_fr", Some(0)),
            ("rear_left_motor", Some(1)),
            ("motorBL", Some(1)),
            ("m front left", Some(2)),
            ("FL.rpm", Some(2)),
            ("backRight", Some(3)),
            ("esc_rr", Some(3)),
            ("pwm_1", None),
            ("front_motor", None),
            ("current_left", None),
        ] {
            assert_eq!(motor_at(&words(name)), motor, "{name}");
        }
    }

    #[test]
    fn numbers_count_from_the_least_of_the_names_that_differ_in_them_alone() {
        let families = Families::of(["omega1", "omega2", "omega3", "m0", "m1", "m2", "m3", "m4x", "t"].into_iter());
        let family = |name: &str| families.family(name);
        assert_eq!(family("omega2").map(Family::first_axis), Some(1));
        assert_eq!(family("m2").and_then(Family::first_motor), Some(0));
        assert_eq!((family("omega1").and_then(Family::first_motor), family("t")), (None, None));
        assert!(!family("m0").unwrap().may_be_axes());
    }
}
