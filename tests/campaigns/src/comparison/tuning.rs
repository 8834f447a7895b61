//! What is tuned of each controller, and the controller file that a point of the search stands for.
//!
//! A point is flown through the text of its file, so that the file that is kept flies what the search saw, to the bit.

use std::fmt::Write;

use sil_host::model::Rig;

use super::contender::{Contender, StandIn};
use super::draw::Draw;
use super::search::{self, Found};

/// One tuned field of the file's `[tuning]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub field: &'static str,
    /// How it is written.
    pub form: Form,
    /// Where the search begins; above zero.
    pub start: f64,
}

/// How a field is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// One number.
    Number,
    /// Roll, this times as much for pitch, and this for yaw, which the rig locks.
    Tilt {
        /// Pitch over roll.
        pitch: f64,
        /// Value of yaw.
        yaw: f64,
    },
}

/// A controller with what is to be tuned of it.
#[derive(Clone, Debug)]
pub struct Tunable<const N: usize> {
    /// What tables call it.
    pub name: &'static str,
    /// What flies in the place of the file's controller, if anything.
    pub stand_in: Option<StandIn>,
    /// Where it flies.
    pub rig: Rig,
    /// The file's lines that stay.
    pub fixed: String,
    /// What the search changes.
    pub parameters: [Parameter; N],
}

impl<const N: usize> Tunable<N> {
    /// Names and values of a point's parameters, those of roll.
    pub fn values(&self, point: &[f64; N]) -> impl Iterator<Item = (&'static str, f64)> {
        self.parameters.iter().zip(point).map(|(parameter, &log)| (parameter.field, rounded(libm::exp(log))))
    }

    /// The file of a point, whose coordinates are the logarithms of the parameters.
    pub fn file(&self, point: &[f64; N]) -> String {
        let mut text = self.fixed.clone();
        for (parameter, (_, value)) in self.parameters.iter().zip(self.values(point)) {
            // writing into a string does not fail
            let _ = match parameter.form {
                Form::Number => writeln!(text, "{} = {value:?}", parameter.field),
                Form::Tilt { pitch, yaw } => {
                    writeln!(text, "{} = [{value:?}, {:?}, {yaw:?}]", parameter.field, rounded(pitch * value))
                }
            };
        }
        text
    }

    /// The contender of a point.
    pub fn contender(&self, point: &[f64; N]) -> Contender {
        Contender { stand_in: self.stand_in, rig: self.rig, ..Contender::new(self.name, &self.file(point)) }
    }

    /// Where the search begins.
    pub fn start(&self) -> [f64; N] {
        self.parameters.map(|parameter| libm::log(parameter.start))
    }

    /// Tunes it on these draws.
    pub fn tune(&self, draws: &[Draw], evaluations: usize, seed: u64) -> Found<N> {
        let mut count = 0;
        search::minimise(self.start(), evaluations, seed, |point| {
            let contender = self.contender(point);
            // what can't be flown has no cost
            let cost = if contender.can_fly() { contender.cost(draws) } else { f64::NAN };
            count += 1;
            eprintln!("{} {count:4}: {cost:.4}", self.name);
            cost
        })
    }
}

/// Four significant digits: what is beyond them says nothing, and files stay short.
pub(super) fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_becomes_a_file_that_says_what_it_is() {
        let tunable = Tunable {
            name: "pid",
            stand_in: None,
            rig: Rig::Gimbal,
            fixed: "controller = \"pid\"\n[tuning]\n".into(),
            parameters: [
                Parameter { field: "angle_gain_1_s", form: Form::Tilt { pitch: 1.0, yaw: 3.0 }, start: 6.0 },
                Parameter { field: "rate_derivative_cutoff_hz", form: Form::Number, start: 40.0 },
            ],
        };
        let text = tunable.file(&[libm::log(7.123456), libm::log(50.0)]);
        assert!(text.ends_with("angle_gain_1_s = [7.123, 7.123, 3.0]\nrate_derivative_cutoff_hz = 50.0\n"), "{text}");
        let tuning = tunable.contender(&tunable.start()).choice.tuning;
        assert_eq!((tuning.angle_gain_1_s, tuning.rate_derivative_cutoff_hz), (Some([6.0, 6.0, 3.0]), Some(40.0)));
    }
}
