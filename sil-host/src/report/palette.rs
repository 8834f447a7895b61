//! Which line style or shade stands for which name: the same one in every figure of the page.

use std::collections::BTreeMap;

/// What a legend entry stands for; the styles of each kind are classes of the page's style sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Mark {
    /// A curve between samples.
    Line,
    /// A curve whose values hold, such as a reference: they are all grey.
    Held,
    /// A span of time.
    Shade,
}

impl Mark {
    /// Prefix and number of the classes in the style sheet.
    fn classes(self) -> (&'static str, usize) {
        match self {
            Self::Line => ("line", 6),
            Self::Held => ("held", 1),
            Self::Shade => ("shade", 3),
        }
    }
}

/// A name in a figure, and what it names.
pub(super) type Key<'a> = (Mark, &'a str);

/// The styles given so far.
#[derive(Default)]
pub(super) struct Palette {
    style_of_name: BTreeMap<(Mark, String), usize>,
}

impl Palette {
    /// The class of each key of one figure (the keys differ). Known names keep their style, new ones take one that no
    /// other name has, or, when all are given, one that is free in this figure; only a figure with more names than
    /// styles repeats one.
    pub(super) fn classes(&mut self, keys: &[Key<'_>]) -> Vec<String> {
        let mut styles: Vec<Option<usize>> = Vec::new();
        for &(mark, name) in keys {
            let known = self.style_of_name.get(&(mark, name.to_owned())).copied();
            styles.push(known.filter(|&style| !is_taken(&keys[..styles.len()], &styles, mark, style)));
        }
        for (index, &(mark, name)) in keys.iter().enumerate() {
            if styles[index].is_none() {
                let count = mark.classes().1;
                let is_free_here = |&style: &usize| !is_taken(keys, &styles, mark, style);
                let is_free =
                    |style: &usize| !self.style_of_name.iter().any(|((of, _), given)| *of == mark && given == style);
                let style = (0..count).find(is_free).or_else(|| (0..count).find(is_free_here)).unwrap_or(index % count);
                self.style_of_name.entry((mark, name.to_owned())).or_insert(style);
                styles[index] = Some(style);
            }
        }
        keys.iter()
            .zip(styles)
            .map(|(&(mark, _), style)| format!("{}{}", mark.classes().0, style.unwrap_or(0)))
            .collect()
    }
}

fn is_taken(keys: &[Key<'_>], styles: &[Option<usize>], mark: Mark, style: usize) -> bool {
    keys.iter().zip(styles).any(|(&(of, _), &given)| of == mark && given == Some(style))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(palette: &mut Palette, names: &[&str]) -> Vec<String> {
        palette.classes(&names.iter().map(|&name| (Mark::Line, name)).collect::<Vec<_>>())
    }

    #[test]
    fn a_name_keeps_its_style() {
        let mut palette = Palette::default();
        assert_eq!(lines(&mut palette, &["PID", "MPC"]), ["line0", "line1"]);
        assert_eq!(lines(&mut palette, &["measured", "MPC"]), ["line2", "line1"]);
        assert_eq!(palette.classes(&[(Mark::Held, "PID"), (Mark::Line, "PID")]), ["held0", "line0"]);
    }

    #[test]
    fn a_figure_repeats_no_style_while_there_are_enough() {
        let mut palette = Palette::default();
        lines(&mut palette, &["a", "b", "c", "d", "e"]);
        // "v" and "w" share a style, in different figures ...
        lines(&mut palette, &["v", "b", "c", "d", "e"]);
        assert_eq!(lines(&mut palette, &["w", "c"]), ["line0", "line2"]);
        // ... and differ where they meet.
        let mut classes = lines(&mut palette, &["a", "w", "c", "d", "e", "v"]);
        classes.sort();
        assert_eq!(classes, ["line0", "line1", "line2", "line3", "line4", "line5"]);
    }

    #[test]
    fn more_names_than_styles_repeat_some() {
        let classes = lines(&mut Palette::default(), &["a", "b", "c", "d", "e", "f", "g", "h"]);
        assert_eq!(classes[..6], ["line0", "line1", "line2", "line3", "line4", "line5"]);
        assert!(classes[6..].iter().all(|class| class.starts_with("line")));
    }
}
