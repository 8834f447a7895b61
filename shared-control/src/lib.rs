//! Attitude control core of a quadrotor.
#![no_std]
#![forbid(unsafe_code)]

pub mod attitude;
pub mod elementary;
pub mod estimator;
pub mod filter;
pub mod frames;
pub mod imu;
pub mod lift_curve;
pub mod mixer;
pub mod output;
pub mod signals;
