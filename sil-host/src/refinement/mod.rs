//! From bench measurements to a model's numbers: the thesis' appendix C as a computation.
//!
//! ```text
//! CSV --bench, reading, arrival--> Bench --steady, step--> readings, lags --component--> points of one curve
//!      points --form, choice--> the form that predicts best --constant--> constants with intervals
//!      constants + base model --file--> model file;   plausibility: what can't be
//! ```

mod arrival;
mod bench;
mod choice;
mod component;
mod constant;
mod file;
mod form;
mod plausibility;
mod reading;
mod refined;
mod steady;
mod step;

pub use bench::{Bench, BenchError};
pub use choice::{Candidate, Comparison};
pub use component::Component;
pub use constant::{Constant, Run};
pub use form::{Fitted, Form, Formula, FormulaFit, Points};
pub use plausibility::{Check, Found, Given, checks};
pub use reading::Reading;
pub use refined::{NotRefined, Order, Refined, refine};
pub use step::Step;
