//! Attitude control core of a quadrotor.
#![no_std]
#![forbid(unsafe_code)]

pub mod airframe;
pub mod attitude;
pub mod battery;
pub mod config;
pub mod elementary;
pub mod estimator;
pub mod filter;
pub mod flight_core;
pub mod frames;
pub mod gravity_moment;
pub mod gyro_bias;
pub mod imu;
pub mod imu_health;
pub mod imu_select;
pub mod lagged_axis;
pub mod lift_curve;
pub mod link;
pub mod mixer;
pub mod mpc;
pub mod output;
pub mod params;
pub mod qp;
pub mod setup;
pub mod signals;
pub mod signs;
pub mod state_words;
pub mod supervisor;
pub mod test_sequence;
pub mod torque_observer;
pub mod trace;
pub mod vehicle;
