//! What can be wrong with a model file: always with file, line and column, and with what was expected there.

use std::fmt;

/// A model that could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The file could not be opened or is not UTF-8 text.
    #[error("{file}: cannot read the model: {source}")]
    Unreadable {
        /// Path as it was given.
        file: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The text was read, and something in it is wrong.
    #[error("{file}:{position}: {problem}")]
    Invalid {
        /// Name of the file or of the source of the text.
        file: String,
        /// Where in it.
        position: Position,
        /// What is wrong, and what was expected.
        problem: Problem,
    },
}

/// A position in a text; both numbers start at 1, columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

impl Position {
    /// The position of byte `offset` of `text`; its end if the offset lies beyond.
    pub(crate) fn of_offset(text: &str, offset: usize) -> Self {
        let before = text.char_indices().take_while(|(index, _)| *index < offset).map(|(_, character)| character);
        let mut position = Self { line: 1, column: 1 };
        for character in before {
            if character == '\n' {
                position.line += 1;
                position.column = 1;
            } else {
                position.column += 1;
            }
        }
        position
    }
}

impl fmt::Display for Position {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{}", self.line, self.column)
    }
}

/// What is wrong at a position.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// Not TOML.
    #[error("not valid TOML: {0}")]
    Syntax(String),
    /// A key that must be there is not.
    #[error("{section} lacks `{key}`: expected {expected}")]
    MissingKey {
        /// The table it belongs to.
        section: String,
        /// The missing key.
        key: String,
        /// What its value should be.
        expected: String,
    },
    /// A key that means nothing here: most often a slip of the pen.
    #[error("unknown key `{key}` in {section}: expected {expected}")]
    UnknownKey {
        /// The table it stands in.
        section: String,
        /// The key.
        key: String,
        /// The keys that this table has.
        expected: String,
    },
    /// Text where a number should be, or the like.
    #[error("`{key}` is of type {found}: expected {expected}")]
    WrongType {
        /// The key.
        key: String,
        /// The type that stands there.
        found: &'static str,
        /// What was expected.
        expected: String,
    },
    /// A number that is not finite or cannot be meant.
    #[error("`{key}` is {value}: expected {expected}")]
    OutOfRange {
        /// The key.
        key: String,
        /// The number that stands there.
        value: f64,
        /// The range, with unit.
        expected: String,
    },
    /// A name that is none of those known.
    #[error("`{key}` is \"{found}\": expected {expected}")]
    UnknownName {
        /// The key.
        key: String,
        /// The name that stands there.
        found: String,
        /// The names that are known.
        expected: String,
    },
    /// Each number for itself is possible, together they are not.
    #[error("{0}")]
    Impossible(String),
}
