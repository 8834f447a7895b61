//! From the bytes of a log to an answer that a person reads: the words, the terminal's text, the page and the JSON, one
//! implementation of each for whoever shows them. Nothing here needs a terminal, a file or a port.
//!
//! ```text
//! bytes, name -> log::Wanted -> log -> HeldAgainst (what was said, or what the log shows) -> Answered
//!                                                                                             |
//!                                                                          text, page, JSON, extended model
//! ```
//!
//! ```
//! use sil_host::answer::{Answered, HeldAgainst, Said, json};
//! use sil_host::diagnosis::Effort;
//! use sil_host::log::Wanted;
//!
//! let bytes = include_bytes!("../../demonstration/rig-log.csv");
//! let log = Wanted::default().read("rig-log.csv".as_ref(), &mut &bytes[..])?;
//! let against = HeldAgainst::of(&log, &Said::default(), &[], None, &|_| ())?;
//! let answered = Answered::of(log, against, Effort::Quick, &|progress| println!("{progress:?}"))?;
//! assert_eq!(answered.diagnosis.findings[0].effect, "cg_offset");
//! let (page, json) = (answered.page("dropped here").to_html(), json(&answered.diagnosis)?);
//! # assert!(page.contains("<svg") && json.starts_with('{'));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod answered;
pub mod baseline;
pub mod board_parameters;
pub mod comparison;
pub mod diagnosis;
pub mod flight;
mod held_against;
pub mod identified;
mod key_window;
pub mod montecarlo;
mod plain_words;
pub mod refinement;
mod said;
mod several;
pub mod text_table;
pub mod thesis;

pub use answered::Answered;
pub use held_against::{HeldAgainst, NotHeldAgainst};
pub use said::{RigsDisagree, Said, SaidModel, SaidRig, on_rig};
pub use several::{Row, SeveralJson, several_json, several_page, several_text};

/// How a line is made to stand out, where it is shown.
pub type Emphasis = fn(&str) -> String;

/// A value as the JSON that commands write.
///
/// # Errors
/// The value has no JSON.
pub fn json(value: &impl serde::Serialize) -> Result<String, serde_json::Error> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    Ok(text)
}
