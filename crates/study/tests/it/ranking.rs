//! The criteria of `advise`, the order that they give, and the numbers of its tuning rules.

use luenberger_study::advise::{Criteria, Criterion};
use luenberger_study::internals::{Ranked, chain_settling, compositions, preferred, rank, tied};

struct One(f64, f64, bool);

impl Ranked for One {
    fn value(&self, criterion: Criterion) -> f64 {
        if criterion == Criterion::Cost { self.1 } else { self.0 }
    }
    fn is_complete(&self) -> bool {
        self.2
    }
}

#[test]
fn scores_are_geometric_means_of_ratios() {
    let all = [One(1.0, 400.0, true), One(2.0, 100.0, true), One(0.1, 1.0, false), One(9.0, f64::INFINITY, true)];
    let (scores, order) = rank(&all, &Criteria::default(), Criterion::Error);
    assert_eq!(order, [0, 1, 3, 2], "a run that ended early comes last");
    assert!((scores[1] - 2.0).abs() < 1e-12);
    let criteria: Criteria = "error=1,cost=3".parse().unwrap();
    let (scores, order) = rank(&all, &criteria, Criterion::Error);
    // (1/1)(400/100)^3 and (2/1)(1)^3, to the power 1/4.
    assert!((scores[0] - 64f64.powf(0.25)).abs() < 1e-12 && (scores[1] - 2f64.powf(0.25)).abs() < 1e-12);
    assert_eq!((order[0], scores[3]), (1, f64::INFINITY));
}

/// Observers of one cost: the one of the smaller error first, whatever order they come in.
#[test]
fn a_tie_is_broken_by_the_error() {
    let cost: Criteria = "cost".parse().unwrap();
    let all = [One(3.0, 50.0, true), One(1.0, 50.0, true), One(2.0, 50.0, true), One(9.0, 40.0, true)];
    let (scores, order) = rank(&all, &cost, Criterion::Error);
    assert_eq!((scores, order), (vec![1.25, 1.25, 1.25, 1.0], vec![3, 1, 2, 0]));
}

/// An observer of an error, whether it has a proof, its cost, and whether its runs finished.
struct Of(f64, bool, f64, bool);

impl Ranked for Of {
    fn value(&self, criterion: Criterion) -> f64 {
        match criterion {
            Criterion::Proved => f64::from(u8::from(!self.1)),
            Criterion::Cost => self.2,
            _ => self.0,
        }
    }
    fn is_complete(&self) -> bool {
        self.3
    }
}

/// Of scores within 5 % the one with a proof is recommended, then the cheapest; a score further away never is.
#[test]
fn within_five_percent_proof_and_then_cost_decide() {
    let chosen = |all: &[Of]| {
        let (scores, order) = rank(all, &Criteria::default(), Criterion::Error);
        let ordered: Vec<(&Of, f64)> = order.iter().map(|&i| (&all[i], scores[i])).collect();
        let tied = tied(&ordered);
        (tied.len(), preferred(&tied).map(|one| (one.0, one.2)))
    };
    let cheap = [Of(1.0, false, 900.0, true), Of(1.02, false, 300.0, true), Of(1.06, true, 10.0, true)];
    assert_eq!(chosen(&cheap), (2, Some((1.02, 300.0))));
    let proved = [Of(1.0, false, 100.0, true), Of(1.01, false, 50.0, true), Of(1.04, true, 900.0, true)];
    assert_eq!(chosen(&proved), (3, Some((1.04, 900.0))));
    let both = [Of(1.0, true, 100.0, true), Of(1.01, true, 50.0, true), Of(1.04, false, 1.0, true)];
    assert_eq!(chosen(&both), (3, Some((1.01, 50.0))));
    let alike = [Of(1.01, true, 50.0, true), Of(1.0, true, 50.0, true)];
    assert_eq!(chosen(&alike), (2, Some((1.0, 50.0))));
    // A run that ended early is not recommended; without a cost it comes after those that have one.
    let ended = [Of(1.0, true, 1.0, false), Of(2.0, false, f64::INFINITY, true), Of(2.0, false, 7.0, true)];
    assert_eq!(chosen(&ended), (2, Some((2.0, 7.0))));
    assert_eq!(chosen(&[]), (0, None));
    assert_eq!(chosen(&[Of(1.0, true, 1.0, false)]), (0, None));
}

#[test]
fn criteria_are_read_and_written() {
    for text in ["error", "error=2,cost=1", "proved", "peak=0.5,noise=1,settling=3"] {
        assert_eq!(text.parse::<Criteria>().unwrap().to_string(), text);
    }
    for wrong in ["", "speed", "error=0", "error=-1", "error=x", "error,error", "error=inf"] {
        assert!(wrong.parse::<Criteria>().is_err(), "{wrong}");
    }
}

/// scipy 1.17: `gamma.isf(0.05, n)` and `gamma.isf(0.02, 2)`.
#[test]
fn chains_settle_when_the_gamma_distribution_says() {
    let times = [2.995_732, 4.743_865, 6.295_794, 7.753_657];
    for (n, time) in times.into_iter().enumerate() {
        assert!((chain_settling(n + 1, 0.05) - time).abs() < 1e-5, "{n}");
    }
    assert!((chain_settling(2, 0.02) - 5.833_92).abs() < 1e-4);
}

#[test]
fn chains_are_all_ways_to_add_up() {
    assert_eq!(compositions(4, 2), [vec![2, 2], vec![1, 3], vec![3, 1]]);
    assert_eq!(compositions(3, 1), [vec![3]]);
    assert_eq!(compositions(3, 3), [vec![1, 1, 1]]);
}
