//! Words that stand in an offered option for what only the user knows.

/// The sample time: with an invented one the inertia would be wrong, and nothing would show it.
pub(super) const SAMPLE_TIME: &str = "SAMPLE_TIME_IN_S";

/// No number and no column is called so: none of them is taken for what it stands for.
pub(super) const WORDS: [&str; 4] = [SAMPLE_TIME, "FACTOR", "AREA_M2", "COLUMN"];

/// The options as they are offered, with what is to be said of those words in them.
pub(super) fn offered(maps: &[String]) -> String {
    let has = |word: &&str| maps.iter().any(|map| map.contains(*word));
    let words: Vec<&str> = WORDS.into_iter().filter(has).collect();
    let maps = maps.join(" ");
    match words.is_empty() {
        true => maps,
        false => format!("{maps} (your own in place of {})", words.join(" and ")),
    }
}
