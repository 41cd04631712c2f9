//! Drawing a proposal towards a centre, as little as it takes.

/// Calls `accept` with growing shares of the way to the centre, 1e-14 to 1, until it says yes; then with smaller ones while that is still so.
/// At most two dozen calls.
pub(super) fn draw(mut accept: impl FnMut(f64) -> bool) {
    let coarse = (0..=7).map(|k| 10f64.powi(2 * k - 14));
    for share in coarse {
        if accept(share) {
            // A decade less may do as well.
            let _ = share > 1e-14 && accept(share / 10.0);
            return;
        }
    }
}
