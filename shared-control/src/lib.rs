//! Attitude control core of a quadrotor.
#![no_std]
#![forbid(unsafe_code)]

pub mod airframe;
pub mod attitude;
pub mod config;
pub mod elementary;
pub mod filter;
pub mod flight_core;
pub mod frames;
pub mod gravity_moment;
pub mod lagged_axis;
pub mod lift_curve;
pub mod light_and_tone;
pub mod link;
pub mod mixer;
pub mod mpc;
pub mod output;
pub mod params;
pub mod qp;
pub mod record;
pub mod sensing;
pub mod setup;
pub mod signals;
pub mod supervisor;
pub mod test_sequence;
pub mod torque_observer;
pub mod vehicle;
