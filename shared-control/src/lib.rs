//! Attitude control core of a quadrotor: raw IMU counts and a set-point in, timer counts for four ESCs out.
//!
//! The same code runs on the flight controller, in the simulator, in the replay of a log and on the emulated board, and
//! gives the same bits everywhere: it has no clock, no memory of its own and no randomness. [`config::Config`] is made
//! once and read, [`flight_core::State`] is what one step leaves to the next, [`signals::StepInput`] holds everything
//! else that can change a result. Begin with [`signals`], the nouns, and [`flight_core::FlightCore`], the block diagram
//! as code.
//!
//! # Block diagram of one step
//!
//! ```text
//!  fast    StepInput.imu, imu_second --sensing--> AttitudeEstimate (attitude, rate, gyro bias)
//!                                                       |
//!          StepInput.arming, battery_v --supervisor--> Arming: may the motors turn?
//!                                                       |
//!          attitude::rate: rate error to torque, or the Plan that arrived --> Wrench (lift, torque)
//!                                                       |
//!          mixer --> MotorCommands --output--> compare_counts, which the caller writes to its timer
//!
//!  follow  StepInput.setpoint --attitude::shaping--> reference --attitude::angle--> rate target of the next step
//!          torque_observer: where the vehicle will be when the next plan acts --> PlanRequest (in MPC mode)
//!
//!  plan    PlanRequest --mpc--> Plan, for the input of the next step
//! ```
//! What takes a varying time comes after the outputs, so that they don't jitter; the price is one sample of delay. What
//! the motors could not deliver goes back to the rate loop's integrator and to the observer one step later. Around the
//! step stand [`link`] (the vehicle's side of MAVLink), [`params`] and [`setup`] (from the owner's choices to a
//! configuration), [`light_and_tone`], and [`record`] (a step as plain words, for comparing targets to the bit).
//!
//! # Frames and units
//!
//! SI units throughout; names end in them (`rate_rad_s`, `torque_nm`). World is north-east-down, body is
//! forward-right-down with its origin at the centre of gravity; a rotation names both (`q_world_from_body`). Euler
//! angles are Z-Y-X; nose up is positive pitch, right side down is positive roll. Arrays of three are (x, y, z) or
//! (roll, pitch, yaw), arrays of four are motors 1 to 4 of [`airframe::MOTORS`]. A motor's command is 0 to 1, times are
//! in microseconds since start. Numbers are `f32`; elementary functions are those of [`elementary`], so that they agree
//! between targets.
//!
//! # Words that have one meaning here
//!
//! - **Set-point**: what is wanted of the vehicle, as it came in; it may jump. **Reference**: the shaped set-point,
//!   which the vehicle can follow. **Target**: what one loop of the cascade demands of the next.
//! - **Wrench**: the lift and the torque that the controllers demand of the mixer.
//! - **Plan**: the MPC's answer to the request of one step: the first torque of its solution, and how the solution
//!   ended. Only a plan that was solved and arrived in time flies; else the cascade does, which is the **fallback**.
//! - **Preview**: the reference over the MPC's horizon, as shaping will make it if the set-point stays.
//! - **Disturbance**: the torque that the motors' known torque and gravity's known moment do not explain.
//! - **Effect**: what a real vehicle does beyond the nominal model. The core knows three (the motors' delay and lag,
//!   and gravity's moment); the simulator can apply many more, and its diagnosis names them.
//! - **Reserve**: the share of the motors' span that the MPC keeps for torque, whatever the throttle.
//! - **At rest**: motors off and the gyro quiet; then the gyro's mean is its bias.
//! - **Unmet**: demanded less delivered, where the motors stood at an end of their range.
//! - **Window**, **start state**, **held out**, **finding**: parts of the judgement of logs, which the simulator's
//!   library explains; nothing in the core depends on them.
//!
//! # One flight of a few steps
//!
//! ```
//! use shared_control::config::{Config, Controller, Tuning, mpc_settings};
//! use shared_control::flight_core::{FlightCore, State, TorqueSource};
//! use shared_control::mpc::{HORIZON, Mpc, MpcState};
//! use shared_control::signals::{ArmingRequest, RawImuSample, Setpoint, StepInput};
//! use shared_control::vehicle::VehicleParameters;
//!
//! let vehicle = VehicleParameters::F450_FREE;
//! let tuning = Tuning::for_vehicle(&vehicle);
//! let config = Config::new(&vehicle, &tuning, 400.0, 1000.0, Controller::Cascade)?;
//! // the MPC is prepared in any case; the cascade never calls it
//! let mpc = Mpc::<HORIZON>::prepare(&mpc_settings(&vehicle, &tuning, 400.0)).expect("the nominal problem");
//! let (mut state, mut plan_state) = (State::default(), MpcState::default());
//!
//! let mut fly = |step: u64, arming: ArmingRequest, setpoint: Setpoint| {
//!     let time_us = 2500 * step;
//!     // level and at rest: the MPU6000 feels 1 g, 4096 counts, and is mounted upside down
//!     let sample = RawImuSample { time_us, gyro_counts: [0; 3], accel_counts: [0, 0, -4096] };
//!     let imu = [sample].into_iter().collect();
//!     let input = StepInput { time_us, imu, arming, setpoint, ..StepInput::default() };
//!     FlightCore::step(&config, &mpc, &mut state, &mut plan_state, &input).0
//! };
//!
//! // one second on the ground calibrates the gyro, then arming is granted
//! for step in 0..=401 {
//!     fly(step, ArmingRequest::None, Setpoint::default());
//! }
//! fly(402, ArmingRequest::Arm, Setpoint::default());
//!
//! // throttle up, right side down: the first step leaves the rate target that the second one flies
//! let to_the_right = Setpoint { roll_rad: 0.2, throttle: 0.5, ..Setpoint::default() };
//! fly(403, ArmingRequest::None, to_the_right);
//! let output = fly(404, ArmingRequest::None, to_the_right);
//!
//! assert_eq!(output.source, TorqueSource::Cascade);
//! let [front_right, rear_left, front_left, rear_right] = output.mix.commands.0;
//! assert!(front_left > front_right && rear_left > rear_right, "more lift on the left rolls to the right");
//! # Ok::<(), shared_control::config::ConfigError>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

pub mod airframe;
pub mod attitude;
pub mod config;
pub mod elementary;
pub mod exchange;
pub mod filter;
pub mod flight_core;
pub mod frames;
pub mod gravity_moment;
pub mod io_chip;
pub mod lagged_axis;
pub mod learning;
pub mod lift_curve;
pub mod light_and_tone;
pub mod link;
pub mod log_card;
pub mod mixer;
pub mod motor_loss;
pub mod mpc;
pub mod onboard_log;
pub mod output;
pub mod params;
pub mod qp;
pub mod radio;
pub mod record;
pub mod self_test;
pub mod sensing;
pub mod setup;
pub mod signals;
pub mod supervisor;
pub mod test_sequence;
pub mod torque_observer;
pub mod usb;
pub mod vehicle;
