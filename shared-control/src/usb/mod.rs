//! The vehicle as a USB device: a serial port of the communications class. Requests in, answers out, no registers.
//!
//! - [`descriptors`]: what the device says of itself, in one place;
//! - [`control`]: what it does with the requests to its endpoint 0.
//!
//! USB 2.0 chapter 9, CDC 1.2 and its subclass for PSTN devices 1.2 (<https://www.usb.org/documents>). Written here,
//! since the stack that exists (`usb-device` 0.3.2, `usbd-serial` 0.2.2, `synopsys-usb-otg` 0.5.0) masks every
//! interrupt while it looks at its peripheral, waits there for bits without an end, and can panic.

pub mod control;
pub mod descriptors;

pub use control::{Control, Reply, Request};

#[cfg(test)]
mod tests;
