//! The diagnosis' own model of the vehicle: commands become forces (`actuation`), forces turn the `body` and move it through the `air`, the `sensor` reports it; `prediction`
//! runs all three over the rows of a window. It shares no equation with the simulated plant, so that a mistake in either shows.

pub(in crate::diagnosis) mod actuation;
pub(in crate::diagnosis) mod air;
pub(in crate::diagnosis) mod body;
pub(in crate::diagnosis) mod prediction;
pub(in crate::diagnosis) mod sensor;
