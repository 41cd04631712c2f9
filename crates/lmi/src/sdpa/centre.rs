//! Drawing a proposal towards a centre, as little as it takes.

/// Calls `accept` with growing shares of the way to the centre, from 1e-14 by decades to 1, until it says yes; then halves the gap between the last no
/// and the yes three times on the logarithmic scale. Whether it ever said yes; at most 18 calls.
pub(super) fn draw(mut accept: impl FnMut(f64) -> bool) -> bool {
    let Some(mut yes) = (-14..=0).map(|k| 10f64.powi(k)).find(|&share| accept(share)) else { return false };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_share_that_does_is_found_to_a_third_of_a_decade() {
        for least in [3e-13, 0.02, 1.0] {
            let mut last = f64::INFINITY;
            let mut calls = 0;
            draw(|share| {
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
