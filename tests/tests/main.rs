//! Tests of the crates together: `cargo test -p integration-tests [MODULE::]`. What takes many seconds is in
//! `tests/thorough`.

mod blind_diagnosis;
mod bounded_angles;
mod change_in_flight;
mod closed_loop;
mod configuration_page;
mod controller_blame;
mod firmware_vehicle;
mod flight_controllers;
mod flight_safety;
mod gate_map;
mod gate_real;
mod hitl;
mod learning;
mod limits_and_switching;
mod log_errors;
mod qp_reference;
mod real_logs;
mod refinement;
mod test_sequence;
mod worst_case;
