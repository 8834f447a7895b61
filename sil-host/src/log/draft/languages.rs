//! Words of German, French, Spanish and Italian loggers, as English ones write them.

/// Whole words. What turns is a velocity in some of these languages.
const WORDS: [(&str, &str); 23] = [
    ("zeit", "time"),
    ("temps", "time"),
    ("tiempo", "time"),
    ("tempo", "time"),
    ("nick", "pitch"),
    ("gier", "yaw"),
    ("roulis", "roll"),
    ("tangage", "pitch"),
    ("lacet", "yaw"),
    ("alabeo", "roll"),
    ("cabeceo", "pitch"),
    ("guiñada", "yaw"),
    ("rollio", "roll"),
    ("beccheggio", "pitch"),
    ("imbardata", "yaw"),
    ("vitesse", "vel"),
    ("vit", "vel"),
    ("velocidad", "vel"),
    ("velocità", "vel"),
    ("soll", "ref"),
    ("consigne", "ref"),
    ("consigna", "ref"),
    ("schub", "thrust"),
];
/// What German writes behind the name of an axis without a blank between.
const BEHIND: [(&str, &str); 4] = [("winkel", "angle"), ("rate", "rate"), ("geschwindigkeit", "rate"), ("soll", "ref")];
/// Such an axis.
const AXES: [(&str, &str); 4] = [("roll", "roll"), ("nick", "pitch"), ("gier", "yaw"), ("dreh", "")];

/// A word in small letters, or the words that it says.
pub(super) fn in_english(word: String) -> Vec<String> {
    let whole = || WORDS.iter().find(|(own, _)| *own == word).map(|(_, english)| vec![(*english).to_owned()]);
    let joined = || {
        AXES.iter().find_map(|(own, axis)| {
            let behind = word.strip_prefix(own)?;
            let (_, english) = BEHIND.iter().find(|(own, _)| *own == behind)?;
            Some([*axis, english].into_iter().filter(|word| !word.is_empty()).map(str::to_owned).collect())
        })
    };
    whole().or_else(joined).unwrap_or_else(|| vec![word])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_others_become_english_and_english_ones_stay() {
        for (own, english) in [
            ("nickwinkel", vec!["pitch", "angle"]),
            ("gierrate", vec!["yaw", "rate"]),
            ("drehrate", vec!["rate"]),
            ("temps", vec!["time"]),
            ("guiñada", vec!["yaw"]),
            ("rollrate", vec!["roll", "rate"]),
            ("nickel", vec!["nickel"]),
            ("temperature", vec!["temperature"]),
        ] {
            assert_eq!(in_english(own.to_owned()), english, "{own}");
        }
    }
}
