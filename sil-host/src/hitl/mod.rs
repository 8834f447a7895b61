//! Hardware in the loop: the plant and the sensors on the other end of a board's link, in lock-step.
//!
//! ```text
//!   plant -> sensors -> HIL_SENSOR ------.
//!     ^                                  v
//!     '------ HIL_ACTUATOR_CONTROLS <- board (its own core)
//! ```
//! One step of the simulation: the board makes a step of its own when the message arrives, and the plant moves on when
//! the answer is there.
//!
//! The vehicle is held at rest until the board has armed and started its test sequence, both requested over the same
//! link; the sequence's first step is the flight's time zero. `shared_control::link::hil` is the board's side.

mod error;
mod flight;
mod port;
mod session;
mod timing;

pub use error::HitlError;
pub use flight::{HitlFigures, HitlFlight, HitlSetup, fly};
pub use port::{BoardPort, FromBoard, Patience};
pub use timing::Timing;
