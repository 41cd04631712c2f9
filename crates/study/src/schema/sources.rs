//! Where the kinds of observers come from: paper and equation.

use super::observers::KINDS;

/// Where the kinds come from: paper and equation.
const SOURCES: &[(&str, &str)] = &[
    ("luenberger", "Luenberger 1964"),
    ("kalman", "Kalman and Bucy 1961; in discrete time Kalman 1960"),
    ("cubic", "Share Pasand, Luenberger-type cubic observers, eq. (5)"),
    ("sampled-cubic", "the same paper's observer, eq. (5), with a step in closed form: docs/theory-cubic.md"),
    ("optimal-cubic", "open problem of Share Pasand, Luenberger-type cubic observers: docs/theory-cubic.md"),
    (
        "unknown-input",
        "open problem of Share Pasand, Luenberger-type cubic observers; Darouach, Zasadzinski and Xu 1994",
    ),
    (
        "sliding-mode",
        "Levant 2003; Davila, Fridman and Levant 2005; implicit step: Acary and Brogliato 2010, Mojallizadeh, Brogliato and Acary 2021",
    ),
    ("interval", "Gouze, Rapaport and Hadj-Sadok 2000; Mazenc and Bernard 2011; the least width after Briat 2013"),
    ("proportional-integral", "open problem of Share Pasand, Luenberger-type cubic observers; Wojciechowski 1978"),
    ("reduced-order", "Luenberger 1964, Gopinath 1971"),
    ("functional", "Luenberger 1966, Darouach 2000"),
    ("h-infinity", "Nagpal and Khargonekar 1991; as an inequality Boyd et al. 1994"),
    ("h2", "Kalman and Bucy 1961; as an inequality Scherer, Gahinet and Chilali 1997"),
    ("extended-state", "Han 2009; Gao 2003; as a disturbance observer Ohnishi, Shibata and Murakami 1996"),
    ("lpv", "Boyd et al., Linear Matrix Inequalities in System and Control Theory, 1994"),
    ("lipschitz", "Thau 1973, Rajamani 1998, Arcak and Kokotovic 2001"),
    ("mean-value", "Ben Messaoud and Hajji 2018, eq. (3)"),
    ("high-gain", "Yi, Ortega and Zhang 2018, Table I; Khalil and Praly 2014"),
    ("extended-kalman", "Gelb, Applied Optimal Estimation, 1974, section 6.1"),
    ("ukf", "Julier and Uhlmann 2004; Van der Merwe and Wan, ICASSP 2001"),
    ("mhe", "Rao, Rawlings and Mayne 2003; Bell, Burke and Pillonetto 2009"),
    ("kkl", "Yi, Ortega and Zhang 2018, eq. (6), Proposition 1"),
    ("pebo", "Yi, Ortega and Zhang 2018, eq. (8) to (12), Proposition 2"),
    ("kkl-peb", "Yi, Ortega and Zhang 2018, eq. (15), Propositions 3, 6 and 7"),
    ("immersion-invariance", "Yi, Ortega and Zhang 2018, eq. (18) and (19), Proposition 4"),
    ("kkl-numerical", "Kazantzis and Kravaris 1998, Andrieu and Praly 2006; computed by simulation"),
];

/// A kind of observer: its name in study files, what it is, and where it comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ObserverSource {
    /// Its name.
    pub kind: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Paper and equation; empty if unknown.
    pub source: &'static str,
}

/// The kinds of observers that a study can ask for, in the order of the schema.
///
/// ```
/// let kinds: Vec<&str> = luenberger_study::schema::observer_sources().map(|source| source.kind).collect();
/// assert!(kinds.contains(&"cubic") && kinds.contains(&"kkl-peb"));
/// ```
pub fn observer_sources() -> impl Iterator<Item = ObserverSource> {
    KINDS.iter().map(|variant| {
        let source = SOURCES.iter().find(|(kind, _)| *kind == variant.name).map_or("", |(_, source)| source);
        ObserverSource { kind: variant.name, about: variant.about, source }
    })
}
