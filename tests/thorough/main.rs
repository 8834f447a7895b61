//! What takes seconds a test: parts of the campaigns, whole real logs, a page of flights, margins, spoiled logs. CI
//! runs them, `cargo test` does not: `cargo test -p integration-tests --test thorough [MODULE::]`. Tests of that kind
//! that stand elsewhere are ignored there; `cargo xtask ci --step "thorough tests"` runs both.

mod adaptation;
mod better_controller;
mod blind_diagnosis;
mod closed_loop_table;
mod controller_comparison;
mod gate_spoiled;
mod identification;
mod margins;
mod montecarlo;
mod motor_loss;
mod out_of_the_testbed;
mod real_baseline;
mod real_logs;
mod refinement;
mod thesis;
mod thesis_case;
