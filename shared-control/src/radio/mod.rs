//! Radio control: from the receiver's channels to what the pilot wants.
//!
//! ```text
//!   RadioFrame (us per channel) -> calibration -> Sticks (-1..1) -> Pilot -> kill, mode, arming by sticks
//!                                              '------> stick_curves -> set-point
//! ```

pub mod calibration;
pub mod frame;
pub mod pilot;
pub mod stick_curves;

pub use calibration::{RadioFault, RadioSetup, Sticks};
pub use frame::{CHANNELS, RadioFrame};
pub use pilot::{Pilot, StickOrder};
pub use stick_curves::StickCurves;
