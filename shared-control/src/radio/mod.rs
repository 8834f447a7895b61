//! Radio control: from the receiver's channels to what the pilot wants.
//!
//! ```text
//!   RadioFrame (us per channel) -> calibration -> Sticks (-1..1) -> Pilot -> set-point, kill, arming by sticks
//! ```

pub mod calibration;
pub mod frame;
pub mod pilot;

pub use calibration::{RadioFault, RadioSetup, Sticks};
pub use frame::{CHANNELS, RadioFrame};
pub use pilot::{Pilot, StickOrder};
