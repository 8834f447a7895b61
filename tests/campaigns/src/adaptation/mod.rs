//! Does the MPC learn the vehicle that it flies? The figures of docs/learning.md.

pub mod flight;
