//! What a reader asked of a document: the keys that a file may have, as the code that reads them knows them.

use super::admissible::Admissible;

/// A key that was asked for.
#[derive(Clone, Debug)]
pub(crate) struct KeyRead {
    /// Header of its table, without the brackets; empty for the document.
    pub(crate) table: String,
    /// Where it stands in the document, tables of one header counted from 1: `body.mass_kg`, `effect.2.scale`.
    pub(crate) address: String,
    /// The key.
    pub(crate) key: &'static str,
    /// What it may hold.
    pub(crate) holds: Holds,
    /// True if it may be left out.
    pub(crate) is_optional: bool,
    /// What stands for it then, if anything does.
    pub(crate) default: Option<f64>,
    /// The number that was read; none for what is none, or was left out without a default.
    pub(crate) value: Option<f64>,
}

/// What a key may hold.
#[derive(Clone, Debug)]
pub(crate) enum Holds {
    /// A number.
    Number(Admissible),
    /// A list of numbers.
    Numbers(Admissible),
    /// A text.
    Text(&'static str),
    /// One of some names, and the one that was found.
    Choice {
        /// All of them.
        names: Vec<&'static str>,
        /// What stood there; empty where nothing did.
        found: String,
    },
}
