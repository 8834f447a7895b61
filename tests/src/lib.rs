//! Fixtures of the integration tests, and the campaigns that their short forms run a part of.

pub mod blind;
pub mod comparison;
pub mod controller_blame;
pub mod real_logs;
pub mod steps;
pub mod thesis_case;
pub mod worst_case;
