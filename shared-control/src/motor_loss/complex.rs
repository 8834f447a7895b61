//! Two axes at right angles as one number: what turns along with a spinning body is then a product.

/// re + i im; roll and pitch in this folder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Complex {
    /// Real part.
    pub re: f32,
    /// Imaginary part.
    pub im: f32,
}

impl Complex {
    /// 0.
    pub const ZERO: Complex = Complex { re: 0.0, im: 0.0 };

    /// Sum.
    pub fn plus(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }

    /// Product.
    pub fn times(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }

    /// Times a real number.
    pub fn scaled(self, factor: f32) -> Self {
        Self { re: factor * self.re, im: factor * self.im }
    }

    /// Mirror image.
    pub fn conjugate(self) -> Self {
        Self { re: self.re, im: -self.im }
    }
}
