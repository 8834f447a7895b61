//! Which rig a log comes from.

use clap::ValueEnum;
use sil_host::log::Log;

/// The rigs that a log can come from.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum LogRig {
    /// The thesis' testbed
    Gimbal,
    /// Free flight
    Free,
    /// Any bench: each axis a rigid body of unit inertia with one input gain, fitted to the log
    Axis,
}

/// The rig that was said; else that of the model; else `axis` for a log in other people's columns, which is of other people's
/// vehicle, or without motors. `None` leaves it to the model.
pub fn of(log: &Log, said: Option<LogRig>, has_map: bool, has_model: bool) -> Option<LogRig> {
    if said.is_none() && !has_model && (has_map || log.driven_by_axis_commands()) { Some(LogRig::Axis) } else { said }
}
