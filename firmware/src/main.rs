//! The Pixhawk 1 image.
fn main() {}
