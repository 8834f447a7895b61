//! A contradiction in a log, with its evidence and the way out of it.

use std::fmt;

use super::quantity::Quantity;

/// Something in a log that can't be as it is labelled.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contradiction {
    /// What was seen, with its figures.
    pub seen: String,
    /// What it most likely is.
    pub likely: String,
    /// Lines of a map that would mend it; empty where none would.
    pub map_lines: Vec<MapLine>,
    /// Lines that would mend it as well.
    pub or_instead: Vec<MapLine>,
    /// The turn of the frame about yaw that would mend it, deg, beside what a map has already.
    pub frame_turn_deg: Option<f64>,
    /// What a map had better leave out.
    pub leave_out: Vec<Quantity>,
}

impl fmt::Display for Contradiction {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}; {}", self.seen, self.likely)?;
        if !self.map_lines.is_empty() {
            write!(out, "; in a --map:")?;
        }
        self.map_lines.iter().try_for_each(|line| write!(out, "\n    {line}"))?;
        if !self.or_instead.is_empty() {
            write!(out, "\n  or instead:")?;
        }
        self.or_instead.iter().try_for_each(|line| write!(out, "\n    {line}"))?;
        match self.frame_turn_deg {
            Some(turn_deg) => write!(out, "; --frame-turn {turn_deg}, or in a --map: frame_turn_deg = {turn_deg}"),
            None => Ok(()),
        }
    }
}

/// A line of a map: what a quantity is to be made of.
#[derive(Clone, Debug, PartialEq)]
pub struct MapLine {
    /// The quantity's name and unit.
    pub key: String,
    /// What the column is taken for now.
    pub from: Quantity,
    /// -1 where its sign is to be turned.
    pub sign: f64,
    /// What a map says of the column, without scale and sign: `column = "x"`.
    pub source: String,
    /// True where a map has a line for it already, which may have a sign.
    pub is_mapped: bool,
}

impl fmt::Display for MapLine {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_turned = self.sign < 0.0;
        let sign = if is_turned { ", sign = -1" } else { "" };
        write!(out, "{} = {{ {}{sign} }}", self.key, self.source)?;
        if is_turned && self.is_mapped { write!(out, "   # or 1, where it is -1 now") } else { Ok(()) }
    }
}
