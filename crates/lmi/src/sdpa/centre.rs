//! Selection of a point that can be verified: the last suitable iterate, or a point moved towards a centre as little as
//! needed.

/// Calls `accept` with growing fractions of the way to the centre, from `10^least` by decades to 1, until it returns
/// true; then bisects three times on the logarithmic scale between the last failure and the success. Returns whether it
/// succeeded; at most 18 calls from 1e-14.
pub(super) fn draw(least: i32, mut accept: impl FnMut(f64) -> bool) -> bool {
    let Some(mut yes) = (least..=0).map(|k| 10f64.powi(k)).find(|&share| accept(share)) else { return false };
    let mut no = yes / 10.0;
    for _ in 0..3 {
        let middle = (no * yes).sqrt();
        if accept(middle) {
            yes = middle;
        } else {
            no = middle;
        }
    }
    true
}

/// Calls `accept` with the numbers below `count`, backwards in growing steps until it returns true, then twice between
/// the last failure and the success. Returns the last success; about 3 + log2(count) calls. Iterates with smaller index
/// are typically worse but easier to accept.
pub(super) fn last(count: usize, mut accept: impl FnMut(usize) -> bool) -> Option<usize> {
    let mut no = 0;
    let mut back = 1;
    while no < count {
        back = back.min(count);
        if accept(count - back) {
            let mut yes = back;
            for _ in 0..2 {
                if yes - no <= 1 {
                    break;
                }
                let middle = usize::midpoint(yes, no);
                if accept(count - middle) {
                    yes = middle;
                } else {
                    no = middle;
                }
            }
            return Some(count - yes);
        }
        no = back;
        back *= 2;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
