//! Raw bytes as numbers.

/// The bytes, four at a time, zeros after the end.
pub struct Words<'a>(pub &'a [u8]);

impl Words<'_> {
    pub fn next(&mut self) -> u32 {
        let Some((word, rest)) = self.0.split_first_chunk() else {
            self.0 = &[];
            return 0;
        };
        self.0 = rest;
        u32::from_le_bytes(*word)
    }

    pub fn number(&mut self) -> f32 {
        f32::from_bits(self.next())
    }

    pub fn three(&mut self) -> [f32; 3] {
        [self.number(), self.number(), self.number()]
    }
}
