//! Sums and matrix products as if computed in twice the working precision and then rounded (Ogita, Rump and Oishi, SIAM
//! J. Sci. Comput. 26, 2005): what the residual of a nearly exact solution needs, in which the leading digits cancel.

use nalgebra::DMatrix;

/// `x + y` as a rounded sum and what the rounding left out, exactly (Knuth).
fn two_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    let part = sum - x;
    (sum, (x - (sum - part)) + (y - part))
}

/// `L R` as `high + low`, `low` about an eps of `high` or of the terms that cancelled in it.
pub fn product(l: &DMatrix<f64>, r: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let (rows, inner, cols) = (l.nrows(), l.ncols(), r.ncols());
    let (mut high, mut low) = (DMatrix::zeros(rows, cols), DMatrix::zeros(rows, cols));
    for j in 0..cols {
        for k in 0..inner {
            let factor = r[(k, j)];
            if factor == 0.0 {
                continue;
            }
            for i in 0..rows {
                let term = l[(i, k)] * factor;
                let left_out = l[(i, k)].mul_add(factor, -term);
                let (sum, rounded) = two_sum(high[(i, j)], term);
                high[(i, j)] = sum;
                low[(i, j)] += rounded + left_out;
            }
        }
    }
    (high, low)
}

/// The sum, rounded once unless its terms cancel to `eps` of themselves.
pub fn sum(terms: &[f64]) -> f64 {
    let (high, low) = terms.iter().fold((0.0, 0.0), |(high, low), &term| {
        let (sum, rounded) = two_sum(high, term);
        (sum, low + rounded)
    });
    high + low
}
