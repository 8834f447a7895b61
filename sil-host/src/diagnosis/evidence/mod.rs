//! What is shown beside the names: how far a prediction holds (`horizons`), the figures that people know
//! (`statistics`) beside what any model could reach (`commanded`), where errors arise (`conditions`, `residuals`), how
//! sure the gain is (`bootstrap`), what the log excites (`excitation`), what not to rely on (`warnings`), and the
//! flight that would show more (`experiment`, out of `manoeuvres`).

pub(in crate::diagnosis) mod bootstrap;
mod commanded;
pub(in crate::diagnosis) mod conditions;
pub(in crate::diagnosis) mod excitation;
pub(in crate::diagnosis) mod experiment;
pub(in crate::diagnosis) mod horizons;
mod manoeuvres;
pub(in crate::diagnosis) mod residuals;
pub(in crate::diagnosis) mod statistics;
pub(in crate::diagnosis) mod warnings;

#[cfg(test)]
mod tests;
