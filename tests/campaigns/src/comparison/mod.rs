//! MPC against the cascade, and a plain INDI beside them, on the gimbal, over vehicles that differ from what they
//! believe.
//!
//! ```text
//!  search over 50 draws -> controller files -> 200 other draws -> figures -> tables
//!                    `-> in weather        `-> torque step, noise, margins, eigenvalues
//! ```

pub mod alert_margins;
pub mod campaign;
pub mod contender;
pub mod contenders;
pub mod draw;
pub mod front;
pub mod hover;
pub mod indi;
pub mod linear_loop;
pub mod lqi;
pub mod search;
pub mod stability;
pub mod statistics;
pub mod table;
pub mod tuning;
pub mod weather;
