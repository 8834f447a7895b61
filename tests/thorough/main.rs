//! What takes many seconds a test: parts of the campaigns, whole real logs, a page of flights. CI runs them beside the
//! campaigns' tenth, `cargo test` does not: `cargo test -p integration-tests --test thorough [MODULE::]`.

mod better_controller;
mod closed_loop_table;
mod controller_comparison;
mod identification;
mod montecarlo;
mod out_of_the_testbed;
mod real_baseline;
mod real_logs;
mod refinement;
mod thesis;
mod thesis_case;
