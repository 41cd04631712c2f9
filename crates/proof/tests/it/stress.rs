//! A sample of what `cargo xtask stress proof` tries by the million.

use crate::adversaries;

/// Every kind of case, some hundreds of times: not one verdict, margin or witness is wrong.
#[test]
fn no_verdict_is_wrong() {
    let kinds = adversaries::kinds().len() as u64;
    let mut sums = vec![adversaries::Tally::default(); adversaries::kinds().len()];
    for number in 0..kinds * 120 {
        let (kind, tally) = adversaries::examine(2019, number);
        assert!(tally.wrong.is_empty(), "{}", tally.wrong.join("\n"));
        sums[kind].add(tally);
    }
    for (name, sum) in adversaries::kinds().iter().zip(&sums) {
        assert_eq!(sum.cases, 120, "{name}");
        // A sample in which every case has the same answer would test little.
        assert!(sum.refuted > 0 && sum.proved > 0, "{name}: {sum:?}");
    }
}
