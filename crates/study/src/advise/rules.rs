//! The table of the kinds of observers: the prior information that each uses, its tuning rule, where the rule is from.
//!
//! A rule tests hypotheses that the design does not name by itself and gives the keys of an `[[observer]]`; the design
//! then decides. Several sets of keys are tried in their order. **A new kind is one row.**

use super::block::{Keys, Value};
use super::information::InformationKind;
use super::tuning::{self, Context};

/// A kind of observer with a tuning rule.
pub(super) struct Rule {
    /// The name of its row.
    pub(super) name: &'static str,
    /// The kind in study files.
    pub(super) kind: &'static str,
    /// The rule, as a sentence.
    pub(super) tuning: &'static str,
    /// Where the rule is from.
    pub(super) source: &'static str,
    /// What makes it good or bad, as an engineer would explain a result.
    pub(super) character: &'static str,
    /// What it uses of the information.
    pub(super) information: &'static [InformationKind],
    /// The keys to try, or the hypothesis that does not hold.
    pub(super) keys: fn(&Context<'_>) -> Result<Vec<Keys>, String>,
}

use InformationKind::{Bounds, Disturbance, FirstError, Noise, ProcessNoise, Region, Settling};

/// All of them, the quick designs first.
pub(super) const RULES: &[Rule] = &[
    Rule {
        name: "luenberger",
        kind: "luenberger",
        tuning: "modes of the plant that are slower than the decay rate, or than twice the slowest one, become the poles of a Bessel filter of that rate",
        source: "luenberger poles --pattern bessel",
        character: "its poles are placed without regard to the noise",
        information: &[Settling],
        keys: |context| Ok(vec![tuning::poles(context, 0)?]),
    },
    Rule {
        name: "luenberger-lmi",
        kind: "luenberger",
        tuning: "the least noise gain among the gains with the decay rate, or twice that of the plant, by a matrix inequality",
        source: "Boyd et al. 1994, sections 2.6 and 7.2",
        character: "its gain is the least noisy one that the matrix inequality finds for the decay rate",
        information: &[Settling, Noise],
        keys: tuning::least_noise,
    },
    Rule {
        name: "kalman",
        kind: "kalman",
        tuning: "stationary Kalman gain for the intensities of process and measurement noise",
        source: "Kalman and Bucy 1961",
        character: "its gain is that of the steady state: optimal once the first error is forgotten, not before",
        information: &[Noise, ProcessNoise],
        keys: tuning::kalman,
    },
    Rule {
        name: "h2",
        kind: "h2",
        tuning: "the least variance of the errors in units of the scale, for the intensities of process and measurement noise",
        source: "docs/disturbances.md",
        character: "without a bound on its gain it is the Kalman filter of the same intensities, with a proved variance",
        information: &[Noise, ProcessNoise],
        keys: tuning::norm,
    },
    Rule {
        name: "h-infinity",
        kind: "h-infinity",
        tuning: "the least norm from process and measurement noise, in units of their intensities, to the errors in units of the scale",
        source: "docs/disturbances.md",
        character: "it bounds the errors under the worst noise of the same energy, and is no optimum under white noise",
        information: &[Noise, ProcessNoise],
        keys: tuning::norm,
    },
    Rule {
        name: "reduced-order",
        kind: "reduced-order",
        tuning: "poles of a Bessel filter of order n - p at the rate of luenberger",
        source: "luenberger poles --pattern bessel",
        character: "the measured states are taken from the outputs, with all of their noise",
        information: &[Settling],
        keys: tuning::reduced_order,
    },
    Rule {
        name: "cubic",
        kind: "cubic",
        tuning: "the poles of luenberger, and the gamma at which an output error of one standard deviation adds an eighth to L",
        source: "docs/cubic-or-linear.md, rule 1",
        character: "the cubic term acts on large output errors only, such as after a push that nobody expects, and leaves the linear part to small ones",
        information: &[Settling, Noise],
        keys: |context| Ok(vec![tuning::cubic(context)?]),
    },
    Rule {
        name: "sampled-cubic",
        kind: "sampled-cubic",
        tuning: "the poles of luenberger, and the strength at which an output error of one standard deviation adds an eighth to L",
        source: "docs/cubic-or-linear.md, rule 1",
        character: "the cubic term acts on large output errors only, such as after a push that nobody expects, and leaves the linear part to small ones",
        information: &[Settling, Noise],
        keys: |context| Ok(vec![tuning::sampled_cubic(context)?]),
    },
    Rule {
        name: "optimal-cubic",
        kind: "optimal-cubic",
        tuning: "the least cost for the intensities of process and measurement noise and first errors of the given size, each error in units of its scale, over the duration of the simulation",
        source: "docs/theory-cubic.md",
        character: "its gains L and N have the least cost that a search finds, and it is linear where no cubic term pays; it pays for pushes that nobody expects, while for a first error of known covariance a Kalman filter that starts from it costs less",
        information: &[Noise, ProcessNoise, FirstError],
        keys: tuning::optimal_cubic,
    },
    Rule {
        name: "interval",
        kind: "interval",
        tuning: "the poles of luenberger; its bounds are for noise up to its amplitude, or to four standard deviations if it is Gaussian, and for x(0) anywhere in the region",
        source: "docs/disturbances.md",
        character: "its estimate is that of its gain alone, and the bounds that enclose the state come with it",
        information: &[Settling, Noise, Region, Bounds],
        keys: tuning::interval,
    },
    Rule {
        name: "proportional-integral",
        kind: "proportional-integral",
        tuning: "as luenberger, with the disturbance among the modes that become Bessel poles",
        source: "luenberger poles --pattern bessel",
        character: "it estimates the disturbance with the state, which costs noise where there is no disturbance",
        information: &[Settling, Disturbance],
        keys: tuning::proportional_integral,
    },
    Rule {
        name: "extended-state",
        kind: "extended-state",
        tuning: "the bandwidth with which a chain of the order of plant and disturbance settles in the settling time",
        source: "Gao 2003",
        character: "it estimates the disturbance with the state, which costs noise where there is no disturbance",
        information: &[Settling, Disturbance],
        keys: tuning::extended_state,
    },
    Rule {
        name: "unknown-input",
        kind: "unknown-input",
        tuning: "the decay rate, or half of it as often as needed, by a matrix inequality",
        source: "Darouach, Zasadzinski and Xu 1994",
        character: "the disturbance does not reach its error, and the noise of the outputs does unfiltered",
        information: &[Settling, Disturbance],
        keys: tuning::unknown_input,
    },
    Rule {
        name: "lpv",
        kind: "lpv",
        tuning: "the largest decay rate up to that of the settling time for all Jacobians over the region, and the least noise gain with it",
        source: "Boyd et al. 1994, section 7.2",
        character: "one constant gain serves all Jacobians of the region",
        information: &[Settling, Region, Noise],
        keys: |context| tuning::nonlinear(context).and_then(|()| tuning::over_region(context, "fastest")),
    },
    Rule {
        name: "lipschitz",
        kind: "lipschitz",
        tuning: "the decay rate, or half of it as often as needed, for all slopes over the region, and the least noise gain with it",
        source: "Arcak and Kokotovic 2001",
        character: "one constant gain serves all slopes within the sectors of the region",
        information: &[Settling, Region, Noise],
        keys: |context| tuning::nonlinear(context).and_then(|()| tuning::over_region(context, "decay_rate")),
    },
    Rule {
        name: "mean-value",
        kind: "mean-value",
        tuning: "the decay rate, or half of it as often as needed, for the mean Jacobians over the region; eta = 1",
        source: "docs/theory-mvt.md",
        character: "an internal model of the error corrects the estimate",
        information: &[Settling, Region, Noise],
        keys: |context| tuning::over_region(context, "decay_rate"),
    },
    Rule {
        name: "high-gain",
        kind: "high-gain",
        tuning: "the r with which chains of integrators, with all poles at -1/r, settle in the settling time",
        source: "Khalil and Praly 2014",
        character: "its gain grows as r^-i along the chain, without regard to the noise",
        information: &[Settling],
        keys: tuning::high_gain,
    },
    Rule {
        name: "sliding-mode",
        kind: "sliding-mode",
        tuning: "the larger of two bounds D: that of the disturbance and of what f differs by within the region, and the first error of the last state over the settling time",
        source: "docs/sliding-mode.md",
        character: "it rejects a bounded disturbance exactly in the limit of fast sampling, and does not average the noise",
        information: &[Settling, Region, FirstError, Bounds],
        keys: tuning::sliding_mode,
    },
    Rule {
        name: "extended-kalman",
        kind: "extended-kalman",
        tuning: "covariances of process noise, of a sample and of the first error",
        source: "Gelb 1974, section 6.1",
        character: "its gain is large while its covariance is, after the start, and small later: a constant gain is one for both",
        information: &[Noise, ProcessNoise, FirstError],
        keys: |context| Ok(vec![tuning::filter(context)?]),
    },
    Rule {
        name: "ukf",
        kind: "ukf",
        tuning: "the covariances of extended-kalman",
        source: "Van der Merwe and Wan 2001",
        character: "as extended-kalman, with the curvature of the plant between its sigma points in place of derivatives",
        information: &[Noise, ProcessNoise, FirstError],
        keys: |context| Ok(vec![tuning::filter(context)?]),
    },
    Rule {
        name: "mhe",
        kind: "mhe",
        tuning: "the covariances of extended-kalman, ten samples, and the region as bounds of the states",
        source: "Rao, Rawlings and Mayne 2003",
        character: "it solves a least-squares problem over the last samples and keeps its estimate within the region",
        information: &[Noise, ProcessNoise, FirstError, Region],
        keys: tuning::moving_horizon,
    },
    Rule {
        name: "kkl-numerical",
        kind: "kkl-numerical",
        tuning: "cutoff and table by the search of the design, over the region",
        source: "docs/numerical-kkl.md",
        character: "its filter has the cutoff for which the map is accurate over the region, whatever settling is asked for",
        information: &[Region],
        keys: |context| Ok(vec![vec![("domain", Value::pairs(context.information.region.states()))]]),
    },
];

// Each row says what it uses and where it is from, and has a name of its own.
const _: () = {
    let mut row = 0;
    while row < RULES.len() {
        assert!(!RULES[row].information.is_empty() && !RULES[row].source.is_empty());
        let mut other = 0;
        while other < row {
            assert!(!is_same(RULES[row].name.as_bytes(), RULES[other].name.as_bytes()));
            other += 1;
        }
        row += 1;
    }
};

const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut k = 0;
    while k < a.len() && k < b.len() && a[k] == b[k] {
        k += 1;
    }
    k == a.len() && k == b.len()
}

/// Kinds whose maps are derived by hand: they are tried if the study has one.
pub(super) const BY_HAND: &[&str] = &["kkl", "pebo", "kkl-peb", "immersion-invariance"];

/// The kinds without a rule, and why: they are ranked where the study has one.
pub(super) fn without_rule() -> impl Iterator<Item = (&'static str, &'static str)> {
    let kinds = crate::schema::observer_sources().map(|source| source.kind);
    kinds.filter(|kind| RULES.iter().all(|rule| rule.kind != *kind)).map(|kind| {
        let why = if BY_HAND.contains(&kind) {
            "its maps are derived by hand, and the study has 0 observers of this kind: see docs/kkl-studies.md"
        } else if kind == "functional" {
            "it estimates functions of the state, and the others are compared by the state"
        } else {
            "it has no tuning rule, and the study has 0 observers of this kind"
        };
        (kind, why)
    })
}
