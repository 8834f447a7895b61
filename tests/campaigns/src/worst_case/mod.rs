//! The most passes that the MPC's solver can take, by following every way that they can go.
//!
//! ```text
//!  problems: the shipped settings -> program: a dense program with parameters, its laws for a guess
//!      -> passes: all parameters at once, split at every threshold (polytope) -> campaign: tables, and the solver itself at points of
//!         every part (solver)
//! ```
//! Tables and what they mean: docs/solver.md.

pub mod campaign;
pub mod passes;
pub mod polytope;
pub mod problems;
pub mod program;
pub mod solver;
