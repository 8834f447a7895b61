//! The card beside the picture: the answer in a few named lines.

use maud::{Markup, html};

/// How the answer is coloured; the words say the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Nothing is wrong, or what is wrong is known.
    Good,
    /// Part of it is known.
    Doubtful,
    /// It is not known, or the flight itself was bad.
    Bad,
}

impl Tone {
    fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Doubtful => "doubtful",
            Self::Bad => "bad",
        }
    }
}

/// Named lines: verdict, cause, size, certainty.
#[derive(Clone, Debug)]
pub struct Card {
    tone: Tone,
    lines: Vec<(String, String)>,
}

impl Card {
    /// A card without lines.
    pub fn new(tone: Tone) -> Self {
        Self { tone, lines: Vec::new() }
    }

    /// Adds a line; one without text is left out.
    pub fn line(mut self, name: impl Into<String>, text: impl Into<String>) -> Self {
        let text = text.into();
        if !text.is_empty() {
            self.lines.push((name.into(), text));
        }
        self
    }

    pub(super) fn render(&self) -> Markup {
        html! {
            dl class=(format!("card {}", self.tone.class())) {
                @for (name, text) in &self.lines {
                    div { dt { (name) } dd { (text) } }
                }
            }
        }
    }
}
