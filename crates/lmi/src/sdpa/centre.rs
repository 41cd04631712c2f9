//! Selection of a point that can be verified: the last suitable iterate, or a point moved towards a centre as little as
//! needed.

/// Calls `accept` with growing fractions of the way to the centre, from `10^least` by decades to 1, until it returns
/// true; then bisects three times on the logarithmic scale between the last failure and the success. Returns whether it
/// succeeded; at most 18 calls from 1e-14.
pub fn draw(least: i32, mut accept: impl FnMut(f64) -> bool) -> bool {
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
pub fn last(count: usize, mut accept: impl FnMut(usize) -> bool) -> Option<usize> {
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
