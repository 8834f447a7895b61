//! Tables of TOML as model files have them: read key by key, every mistake named by line and column, and written back.

mod admissible;
mod error;
mod key_read;
mod section;
mod spelling;
mod table;

pub(crate) use admissible::{Admissible, admissible};
pub use error::{ModelError, Position, Problem};
pub(crate) use key_read::{Holds, KeyRead};
pub(crate) use section::{Replaced, Section, Source};
pub(crate) use spelling::{did_you_mean, with_hint};
pub(crate) use table::Table;
