//! Attitude control core of a quadrotor.
#![no_std]
#![forbid(unsafe_code)]

pub mod mpc;
pub mod qp;
pub mod signals;
