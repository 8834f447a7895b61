//! What the page can request, and how each request is answered: one file a request.

mod board;
mod catalogue;
mod diagnosed;
mod flown;
mod hidden;
mod models;
mod options;
mod recognised;

use serde::Deserialize;
use serde_json::{Value, json};
use sil_host::diagnosis::Observer;

/// A request, as the page writes it.
#[derive(Deserialize)]
#[serde(tag = "request", rename_all = "lowercase")]
enum Request {
    /// What there is to choose from: effects, tuning, models, maps.
    Catalogue,
    /// What a log is.
    Recognise(recognised::Recognise),
    /// What the simulation gets wrong in one log or several.
    Diagnose(diagnosed::Diagnose),
    /// A flight under each controller.
    Fly(flown::Fly),
    /// A log with one effect in it, and its picture.
    Hide(hidden::Hide),
    /// A vehicle on a serial port.
    Board(board::Board),
}

/// Answers a request: `{"ok": ...}`, or `{"error": "..."}` with the message that the terminal would show.
pub fn answer(request: &[u8], files: Vec<Vec<u8>>, observer: Observer<'_>) -> String {
    let answered = match serde_json::from_slice(request) {
        Ok(Request::Catalogue) => catalogue::answer(),
        Ok(Request::Recognise(recognise)) => recognise.answer(&files),
        Ok(Request::Diagnose(diagnose)) => diagnose.answer(&files, observer),
        Ok(Request::Fly(fly)) => fly.answer(),
        Ok(Request::Hide(hide)) => hide.answer(),
        Ok(Request::Board(board)) => board.answer(&files),
        Err(error) => Err(format!("the page's request: {error}")),
    };
    let answer = match answered {
        Ok(value) => json!({ "ok": value }),
        Err(error) => json!({ "error": error }),
    };
    answer.to_string()
}

/// What a request gives: a value for the page, or a message for a person.
type Answer = Result<Value, String>;

/// The message of anything.
fn message(error: impl std::fmt::Display) -> String {
    error.to_string()
}
