//! Suggestion of the nearest name.

use core::cmp::Reverse;

use strsim::damerau_levenshtein;

/// The known name nearest to `name`, if Damerau and Levenshtein's distance is at most a third of the letters, rounded
/// up, and not all of them. Case does not count, and `-` and a space are `_`; ties are broken by the longest
/// common prefix.
///
/// ```
/// use luenberger_expression::nearest;
/// assert_eq!(nearest("pols", ["poles", "gain"]), Some("poles"));
/// assert_eq!(nearest("Duration", ["duration", "samples"]), Some("duration"));
/// assert_eq!(nearest("temperature", ["poles", "gain"]), None);
/// // One letter is as near to another as to any.
/// assert_eq!(nearest("q", ["a", "b"]), None);
/// assert_eq!(nearest("A", ["a", "b"]), Some("a"));
/// ```
pub fn nearest<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    let folded = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
    let (name, length) = (folded(name), name.chars().count());
    known
        .into_iter()
        .map(|candidate| (damerau_levenshtein(&name, &folded(candidate)), candidate))
        .filter(|(distance, candidate)| {
            let letters = length.max(candidate.chars().count());
            *distance <= letters.div_ceil(3) && *distance < letters
        })
        .min_by_key(|(distance, candidate)| {
            let alike = name.chars().zip(candidate.chars()).take_while(|(a, b)| a == b).count();
            (*distance, Reverse(alike))
        })
        .map(|(_, candidate)| candidate)
}
