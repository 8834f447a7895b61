//! What is soldered around the chip.

pub(crate) mod mpu6000;
