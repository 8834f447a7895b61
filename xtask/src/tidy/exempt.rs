//! Files that do not obey a rule yet. The lists can only shrink: who obeys must leave, and nobody joins by accident.

use std::collections::BTreeMap;

/// The files that a rule leaves alone, each with the reason, which may be empty.
pub(super) struct Exempt {
    /// Where the list is kept, for messages.
    list: &'static str,
    reasons: BTreeMap<&'static str, &'static str>,
}

impl Exempt {
    /// Reads a list: a path a line, a reason after a colon, comments after `#`.
    pub(super) fn parse(list: &'static str, text: &'static str) -> Self {
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
        let entry = |line: &'static str| line.split_once(": ").unwrap_or((line, ""));
        Self { list, reasons: lines.map(entry).collect() }
    }

    /// What a file's breaches of the rule come to: none where it is exempt, and one where it need not be any more.
    pub(super) fn judge<B>(&self, path: &str, breaches: Vec<B>, leave: impl Fn(String) -> B) -> Vec<B> {
        match (self.reasons.contains_key(path), breaches.is_empty()) {
            (false, _) => breaches,
            (true, false) => Vec::new(),
            (true, true) => vec![leave(format!("obeys the rule by now: take it out of {}", self.list))],
        }
    }

    /// Entries whose file is gone, with what to do about it.
    pub(super) fn stale<'a>(&'a self, exists: impl Fn(&str) -> bool + 'a) -> impl Iterator<Item = (&'a str, String)> {
        let gone = self.reasons.keys().filter(move |path| !exists(path));
        gone.map(|path| (*path, format!("is not there: take it out of {}", self.list)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIST: &str = "# why\n\na.rs: one table\nb.rs\n";

    #[test]
    fn an_exempt_file_may_break_the_rule_and_must_leave_the_list_when_it_does_not() {
        let exempt = Exempt::parse("list.txt", LIST);
        assert_eq!(exempt.judge("c.rs", vec!["long".to_owned()], |message| message), ["long"]);
        assert_eq!(exempt.judge("a.rs", vec!["long".to_owned()], |message| message), [""; 0]);
        assert_eq!(exempt.judge("c.rs", Vec::new(), |message| message), [""; 0]);
        let leave = exempt.judge("b.rs", Vec::new(), |message| message);
        assert_eq!(leave, ["obeys the rule by now: take it out of list.txt"]);
    }

    #[test]
    fn an_entry_without_a_file_is_stale() {
        let exempt = Exempt::parse("list.txt", LIST);
        let stale: Vec<_> = exempt.stale(|path| path == "a.rs").map(|(path, _)| path).collect();
        assert_eq!(stale, ["b.rs"]);
    }
}
