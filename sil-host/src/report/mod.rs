//! The report: one HTML file that needs nothing else, for a screen of any width, light or dark, and for paper.
//!
//! A [`Page`] begins with its answer: a headline, one picture, a [`Card`]. Then come [`Section`]s, open or folded, with
//! text, [`Chart`]s, [`Bars`] and [`Table`]s in reading order. Everything is built in memory, and the same calls give
//! the same bytes: no clock, no random identifiers.
//!
//! ```
//! use sil_host::report::{Better, Chart, Page, Section, Table};
//!
//! let time_s = [0.0, 0.5, 1.0, 1.5];
//! let page = Page::new("Step response")
//!     .lead("A step of 15 degrees in roll, flown by the PID cascade.")
//!     .section(
//!         Section::new("Roll")
//!             .chart(
//!                 Chart::time_series("Roll angle", "deg")
//!                     .step_series("reference", &time_s, &[0.0, 15.0, 15.0, 15.0])
//!                     .series("PID", &time_s, &[0.0, 0.0, 13.2, 15.1]),
//!             )
//!             .table(
//!                 Table::new("Tracking error, degrees", &["axis", "PID", "MPC"])
//!                     .comparison("roll", &[1.31, 1.12], 2, Better::Lower),
//!             ),
//!     )
//!     .provenance("Command", "sil fly --seed 1");
//! assert!(page.to_html().starts_with("<!DOCTYPE html>"));
//! ```
//!
//! The charts are written as SVG here, through `maud` like the rest of the page, and not by a chart crate: plotters'
//! SVG backend rounds every point to whole pixels, carries colours as fixed attributes (no light and dark), knows no
//! dash pattern and sizes its text for one width, so that a phone shows it at a third of the size.

mod axis;
mod bars;
mod card;
mod chart;
mod figure;
mod page;
mod palette;
mod table;
mod trace;

pub use bars::Bars;
pub use card::{Card, Tone};
pub use chart::Chart;
pub use page::{Page, Section};
pub use table::{Better, Cell, Table};
