//! The simulator and the diagnosis of logs for the page that runs in a browser: requests in JSON with the bytes of
//! files, answers in JSON. Nothing here computes: it all is `sil-host`'s.
//!
//! ```text
//! page/web/*.js --(worker)--> boundary: bytes -> requests -> sil_host -> answer in JSON -> page/web/*.js
//!                                  '-- progress, and the message of a panic, on the way --^
//! ```
//! `cargo xtask page` compiles this for `wasm32-unknown-unknown` and puts it, with the sources in `page/web/`, into one
//! file. [`requests::answer`] is the same natively, which the tests call.

mod boundary;
#[cfg(target_family = "wasm")]
mod memory;
pub mod requests;
