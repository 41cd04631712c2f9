//! The search for a point that can be verified: which is found, and in how many trials.

use luenberger_lmi::internals::{draw, last};

#[test]
fn the_last_acceptable_is_found_nearly() {
    for count in 0..20 {
        assert_eq!(last(count, |_| false), None);
        for most in 0..count {
            let (mut best, mut calls) = (0, 0);
            let found = last(count, |k| {
                calls += 1;
                if k <= most {
                    best = best.max(k);
                }
                k <= most
            });
            // Of steps of at most 8, two halvings leave 2.
            assert!(found == Some(best) && best + 2 >= most && calls <= 8, "{most} of {count}: {best} in {calls}");
        }
    }
}

#[test]
fn the_smallest_share_that_does_is_found_to_a_third_of_a_decade() {
    for least in [3e-13, 0.02, 1.0] {
        let mut last = f64::INFINITY;
        let mut calls = 0;
        draw(-14, |share| {
            calls += 1;
            if share >= least {
                last = last.min(share);
            }
            share >= least
        });
        assert!(last >= least && last <= least * 1.4 && calls <= 18, "{least}: {last} in {calls}");
    }
}
