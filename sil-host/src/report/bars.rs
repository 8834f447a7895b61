//! A ranking: a bar a line, from 0 to 100 %, with its 95 % interval where there is one.

use super::axis::with_minus_sign;
use maud::{Markup, html};

/// Bars of percentages, in the order in which they are added.
#[derive(Clone, Debug)]
pub struct Bars {
    caption: String,
    bars: Vec<Bar>,
}

#[derive(Clone, Debug)]
struct Bar {
    name: String,
    percent: f64,
    interval: Option<[f64; 2]>,
    is_rest: bool,
}

impl Bars {
    /// A ranking without bars.
    pub fn new(caption: impl Into<String>) -> Self {
        Self { caption: caption.into(), bars: Vec::new() }
    }

    /// Adds a bar; what lies outside of 0 to 100 % is drawn to the nearer end, its number is not changed.
    pub fn bar(mut self, name: impl Into<String>, percent: f64, interval: Option<[f64; 2]>) -> Self {
        self.bars.push(Bar { name: name.into(), percent, interval, is_rest: false });
        self
    }

    /// Adds a bar of another colour for what no other bar stands for.
    pub fn rest(mut self, name: impl Into<String>, percent: f64) -> Self {
        self.bars.push(Bar { name: name.into(), percent, interval: None, is_rest: true });
        self
    }

    pub(super) fn render(&self) -> Markup {
        html! {
            figure.group {
                figcaption { strong { (self.caption) } }
                ul.bars { @for bar in &self.bars { (bar.render()) } }
            }
        }
    }
}

impl Bar {
    fn render(&self) -> Markup {
        let place = |percent: f64| if percent.is_finite() { percent.clamp(0.0, 100.0) } else { 0.0 };
        html! {
            li {
                span.name { (self.name) }
                span.track aria-hidden="true" {
                    span.fill.rest[self.is_rest] style=(format!("width:{:.1}%", place(self.percent))) {}
                    @if let Some([low, high]) = self.interval {
                        @let (from, to) = (place(low), place(high));
                        span.interval style=(format!("left:{from:.1}%;width:{:.1}%", (to - from).max(0.0))) {}
                    }
                }
                span.share { (self.text()) }
            }
        }
    }

    fn text(&self) -> String {
        let number = |value: f64| with_minus_sign(&format!("{value:.*}", decimals(value)));
        let share = format!("{} %", number(self.percent));
        match self.interval {
            // an interval that prints like its middle says nothing
            Some([low, high]) if number(low) != number(high) => {
                format!("{share} ({} to {})", number(low), number(high))
            }
            _ => share,
        }
    }
}

/// Whole percents, but where little of one is left at either end.
fn decimals(percent: f64) -> usize {
    if (1.0..99.0).contains(&percent) || percent == 0.0 { 0 } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_stay_on_their_track_and_keep_their_numbers() {
        let html = Bars::new("Gains").bar("a", 140.0, Some([90.0, 150.0])).bar("b", -3.0, None).render().into_string();
        assert!(html.contains("width:100.0%") && html.contains("left:90.0%;width:10.0%"), "{html}");
        assert!(html.contains("140.0 % (90 to 150.0)") && html.contains("−3.0 %"), "{html}");
        assert!(html.contains("width:0.0%"), "{html}");
    }

    #[test]
    fn digits_end_where_they_say_nothing() {
        let text = |percent, interval| Bar { name: String::new(), percent, interval, is_rest: false }.text();
        assert_eq!(text(62.34, Some([55.2, 70.9])), "62 % (55 to 71)");
        assert_eq!(text(99.97, Some([99.96, 99.98])), "100.0 %");
        assert_eq!(text(0.31, None), "0.3 %");
    }
}
