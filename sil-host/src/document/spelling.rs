//! What somebody meant who wrote a name that is none of those known.

/// Names less alike than this (Jaro and Winkler's measure, 1 for equal ones) are no slip of the pen.
const ALIKE_MIN: f64 = 0.8;

/// "; did you mean `gain`?", or nothing where no known name is near.
pub(crate) fn did_you_mean<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let alike = known.into_iter().map(|name| (strsim::jaro_winkler(found, name), name));
    let nearest = alike.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(alike, _)| *alike >= ALIKE_MIN);
    nearest.map(|(_, name)| format!("; did you mean `{name}`?")).unwrap_or_default()
}

/// A message of the TOML reader, which lists the known names itself, with the nearest one behind its first line that
/// has "unknown field".
pub(crate) fn with_hint(message: &str) -> String {
    let hinted = |line: &str| {
        let names: Vec<&str> = line.split('`').skip(1).step_by(2).collect();
        match names.split_first().filter(|_| line.starts_with("unknown ")) {
            Some((found, known)) => format!("{line}{}", did_you_mean(found, known.iter().copied())),
            None => line.to_owned(),
        }
    };
    message.lines().map(hinted).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_of_the_pen_are_named_and_other_words_are_not() {
        let known = ["angle_gain_1_s", "rate_hz", "control_horizon"];
        assert_eq!(did_you_mean("angle_gains_1_s", known), "; did you mean `angle_gain_1_s`?");
        assert_eq!(did_you_mean("rate_Hz", known), "; did you mean `rate_hz`?");
        assert_eq!(did_you_mean("colour", known), "");
        assert_eq!(did_you_mean("anything", []), "");
    }

    #[test]
    fn the_readers_own_message_keeps_its_lines() {
        let message = "TOML parse error\n  |\nunknown field `ratehz`, expected `rate_hz` or `controller`\n";
        assert_eq!(
            with_hint(message),
            "TOML parse error\n  |\nunknown field `ratehz`, expected `rate_hz` or `controller`; did you mean `rate_hz`?"
        );
    }
}
