//! A [`State`](crate::flight_core::State) as plain words, so that two targets, which lay it out differently, can be
//! compared to the bit.
//!
//! Each part of the state writes its own words, in the order of its fields, and takes itself apart without `..`: a new
//! field that is not written does not compile. Every state has the same number of words, whatever is in its options.

use nalgebra::{UnitQuaternion, Vector3};

/// Words of a state.
pub const STATE_WORDS: usize = 617;

/// Takes words until all have come.
#[derive(Clone, Debug)]
pub struct StateWords {
    pub(crate) words: [u32; STATE_WORDS],
    /// How many were written, those for which there was no room included.
    pub(crate) written: usize,
}

impl StateWords {
    pub(crate) const EMPTY: Self = Self { words: [0; STATE_WORDS], written: 0 };

    pub(crate) fn word(&mut self, word: u32) {
        if let Some(place) = self.words.get_mut(self.written) {
            *place = word;
        }
        self.written += 1;
    }

    pub(crate) fn number(&mut self, number: f32) {
        self.word(number.to_bits());
    }

    pub(crate) fn numbers(&mut self, numbers: &[f32]) {
        for number in numbers {
            self.number(*number);
        }
    }

    /// Many in a row.
    #[inline(never)] // at each of the places it costs flash
    pub(crate) fn row(&mut self, numbers: &[f32]) {
        self.numbers(numbers);
    }

    pub(crate) fn vector(&mut self, vector: &Vector3<f32>) {
        self.numbers(&[vector.x, vector.y, vector.z]);
    }

    pub(crate) fn rotation(&mut self, q: &UnitQuaternion<f32>) {
        self.numbers(&[q.w, q.i, q.j, q.k]);
    }

    /// Low word first.
    pub(crate) fn time_us(&mut self, time_us: u64) {
        self.word(time_us as u32);
        self.word((time_us >> 32) as u32);
    }

    /// 1 and the value, or zeros.
    pub(crate) fn optional_time_us(&mut self, time_us: Option<u64>) {
        self.word(u32::from(time_us.is_some()));
        self.time_us(time_us.unwrap_or_default());
    }
}
