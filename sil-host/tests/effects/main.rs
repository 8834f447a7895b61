//! Every effect of the catalogue against its equation in docs/effects.md: what the simulated plant does, and what the
//! prediction of a log expects, are held against a vehicle that is written from the page (`reference`) and calls
//! neither.

mod catalogue;
mod checks;
mod reference;
mod shaken;
