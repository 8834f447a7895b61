//! The FMU's side of the wire to the IO chip, the second processor: bytes in and bytes out, time by slots of 5 ms.
//!
//! ```text
//!   every 5 ms  IoSession::begin_slot -> request -> wire -> reply -> IoSession::take -> another request, or none
//!                                                                         '--> IoReport: receiver, safety button
//! ```
//! The chip carries any of three stock firmwares, whose registers differ (`firmware`). It is asked which (page 0), then
//! disarmed and made safe, since it outlives a reset of the FMU with what it was told; then it is only read. A firmware
//! that is not known is written nothing and asked for nothing. MAIN carries nothing but the
//! disarmed pulse.
//!
//! Sources: PX4 `protocol.h` (protocol 4 at 00c514bc, 5 at 1bbd1168), ArduPilot `ioprotocol.h` (0065471b).

pub mod firmware;
pub mod packet;
pub mod session;

pub use firmware::Safety;
pub use session::{IoReport, IoSession, IoState};

/// Length of a slot, µs.
pub const SLOT_US: u32 = 5000;
