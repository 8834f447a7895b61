//! Software in the loop: a simulated quadrotor that flies the control core `shared-control`, and the judgement of
//! measured logs by that simulation.
//!
//! ```text
//!                        models/*.toml                                     measured log
//!                              |                                                |
//!                            model                                       log (reader, map)
//!                              |                                                |
//!          vehicle: parameters and equations of motion                          |
//!             |           ^ effects (catalogue) ^       |                       |
//!             v                                         v                       v
//!  plant (integrates) --> sensors --> cosim      prediction of the log: windows, start states, replay, noise
//!             ^                         |               |                       |
//!             '-- commands -- shared-control            v                       v
//!                  (the core)           |           comparison    diagnosis: findings, verdict, evidence
//!                                       v               |                       |
//!              metrics, margins, flight_log             '--> answer: text, page (report), JSON
//! ```
//!
//! # Where to begin
//! - A flight: [`flight::FlightSetup`], from a [`model::VehicleModel`], a [`controller_file::ControllerChoice`] and a
//!   [`scenario::Scenario`].
//! - A log: [`log::read`]; then [`comparison::compare`] or [`diagnosis::diagnose`]. From bytes to words, page and JSON:
//!   [`answer`].
//! - A log with known effects in it: [`synthesis::Synthesis`] and [`effects::Effect`].
//! - The binary `sil` (`main.rs`, `command/`) is a thin layer of arguments and printing over these; the library prints
//!   nothing.
//!
//! How to add an effect, a log format, a vehicle or a command: `docs/recipes.md`.
//!
//! # Frames and units
//! SI units throughout, and in every name (`rate_rad_s`). World: north-east-down. Body: forward-right-down, origin at
//! the centre of gravity. Euler angles Z-Y-X; nose up is positive pitch, right side down is positive roll. Arrays of
//! three are (roll, pitch, yaw) or (x, y, z), arrays of four are motors 1 to 4: front right, rear left, front left,
//! rear right. Motor commands are 0 to 1. Equations and numbers: `docs/rig.md`.
//!
//! # Words that have one meaning here
//! - **Plant**: the simulated vehicle with its state, in continuous time. It knows no controller.
//! - **Truth**: what the plant really does, before any sensor.
//! - **Rig**: what holds the vehicle: the gimbal of the thesis, nothing (free flight), or, for logs alone, separate
//!   axes.
//! - **Effect**: something that a vehicle does beyond its nominal model, with a name and parameters
//!   (`docs/effects.md`).
//! - **Nominal model**: the model as its file says, before a diagnosis; the **extended model** has the findings in it.
//! - **Window**: a stretch of a log, 0.5 s long, that is predicted from a start state of its own.
//! - **Start** (start state): the state at the first row of a window, estimated from the rows around it or fitted.
//! - **Held out**: windows that no fit and no choice uses, of which errors are reported; a quarter of them all. Half
//!   are **training** windows, a quarter decides which effects are in the model (windows of **choice**).
//! - **Base model**: what is ordinary about a vehicle (trims, lift, lag, delay, gyro bias), fitted along with findings.
//! - **Noise floor**: the error that an exact model would show on the same windows.
//! - **Hypothesis**: an effect of unknown size, tested on a log. A **finding** is a hypothesis that was accepted, with
//!   its size.
//! - **Residual**: measured minus predicted. The **remainder** is what the findings leave unexplained; its
//!   **signature** says what it depends on.
//! - **Plan**: the MPC's answer for one step. **Preview**: the shaped reference over the MPC's horizon.
//! - **Margins**: gain, phase and delay margins, measured on the running code.

pub mod answer;
pub mod axis;
pub mod bench_mpc;
pub mod closed_loop;
pub mod comparison;
pub mod console;
pub mod control_setup;
pub mod controller_file;
pub mod cosim;
pub mod diagnosis;
mod document;
pub mod effects;
pub mod flight;
pub mod flight_log;
pub mod ground_station;
pub mod hitl;
pub mod log;
pub mod margins;
pub mod metrics;
pub mod model;
pub mod montecarlo;
pub mod planner;
pub mod plant;
pub mod prediction;
pub mod refinement;
pub mod report;
pub mod scenario;
pub mod sensors;
pub mod serve;
pub mod statistics;
pub mod synthesis;
pub mod thesis;
pub mod vehicle;
