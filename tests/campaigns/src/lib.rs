//! Campaigns of many flights or many logs, whose tables are in `docs/`: a binary each, and a part of each that the
//! tests run.
//!
//! | binary | question | page |
//! |---|---|---|
//! | `active_limits` | does the MPC come to rest while motors are at their limits? | `docs/mpc-against-cascade.md` |
//! | `adaptation` | does the MPC learn the vehicle that it flies? | `docs/learning.md` |
//! | `attitude_error` | how wrong is the attitude in vibration and with a gyro that drifts? | `docs/attitude-error.md` |
//! | `blind_diagnosis` | does the diagnosis name and measure what is hidden in a log? | `docs/diagnosis.md` |
//! | `closed_loop_table` | both controllers under each effect | `docs/closed-loop.md` |
//! | `controller_blame` | does it name a changed number of the controller? | `docs/thesis-case.md` |
//! | `controller_comparison` | MPC against cascade on vehicles that neither expects | `docs/mpc-against-cascade.md` |
//! | `identification` | is a vehicle known from its log alone? | `docs/identification.md` |
//! | `limits_and_switching` | motors' limits, several linearisations | `docs/motor-limits.md`, `docs/switching-mpc.md` |
//! | `motor_loss` | a motor fails in free flight: noticed, named, flown on with three | `docs/motor-loss.md` |
//! | `out_of_the_testbed` | the testbed's controllers in free flight, and those made again | `docs/out-of-the-testbed.md` |
//! | `real_logs` | what other people's logs show, and how right the diagnosis is on them | `docs/real-logs.md` |
//! | `refinement` | do the intervals of bench measurements hold? | `docs/refine.md` |
//! | `thesis_case` | the thesis' case from the log to the better controller | `docs/thesis-case.md` |
//! | `worst_case` | the most passes that the MPC's solver can take | `docs/solver.md` |

pub mod active_limits;
pub mod adaptation;
pub mod attitude_error;
pub mod attitude_replay;
pub mod blind;
pub mod closed_loop_table;
pub mod comparison;
pub mod controller_blame;
pub mod identification;
pub mod limits_and_switching;
pub mod motor_loss;
pub mod notches;
pub mod out_of_the_testbed;
pub mod real_logs;
pub mod refinement;
pub mod rows_file;
pub mod thesis_case;
pub mod worst_case;
