//! One bulge on its way down an upper Hessenberg matrix: the implicit QR step of Francis, Computer Journal 4, 1961-62.
//!
//! A few steps at a time are made on the diagonal, and the chain of reflectors they leave is then applied to the rest of the window: see `chain.rs`.

use super::chain::{Chain, Reflector, chain_on_columns, chain_on_rows, fma};

/// Steps on the diagonal before the rest of the window follows.
pub(super) const STEPS: usize = 8;

/// The way of a bulge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    /// The first reflector acts on rows `from..from + 3`, the last on `to - 1..to + 2`.
    pub(super) from: usize,
    pub(super) to: usize,
    /// The last row of the active block; where `to` is `last`, the bulge leaves the block.
    pub(super) last: usize,
    /// The first row and the column after the last one that follow at once.
    pub(super) window: (usize, usize),
    /// The first column of the shifted product where the bulge enters the block at `from`, and whether there is an entry to the left of it.
    pub(super) entry: Option<([f64; 3], bool)>,
}

/// The reflector that maps `x` to `beta e1`, and `beta`.
#[inline(always)]
pub(super) fn reflect_vector(x: [f64; 3]) -> (f64, Reflector) {
    if x[1] == 0.0 && x[2] == 0.0 {
        return (x[0], Reflector::default());
    }
    let largest = x[0].abs().max(x[1].abs()).max(x[2].abs());
    // Outside this range the squares below would underflow or overflow.
    let scale = if (1e-140..1e140).contains(&largest) { 1.0 } else { largest };
    let x = if scale == 1.0 { x } else { x.map(|e| e / scale) };
    let norm = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
    let beta = if x[0] > 0.0 { -norm } else { norm };
    let pivot = x[0] - beta;
    let v = [x[1] / pivot, x[2] / pivot];
    let tau = -pivot / beta;
    (beta * scale, Reflector { v, t: [tau, tau * v[0], tau * v[1]] })
}

/// Chases a bulge. `chain` takes its `to - from` reflectors; `packed` has room for `WIDTH * (STEPS + 2)` numbers.
#[inline(always)]
pub(super) fn chase<const FMA: bool>(h: &mut [f64], n: usize, way: Way, chain: &mut [Reflector], packed: &mut [f64]) {
    let Way { from, to, last, window, entry } = way;
    let mut begin = from;
    while begin < to {
        let end = to.min(begin + STEPS);
        let cols = (end + 2).min(last + 1);
        for k in begin..end {
            let triple = k + 2 <= last;
            let (beta, r) = match entry {
                Some((v, linked)) if k == from => {
                    let (_, r) = reflect_vector(v);
                    if linked {
                        // The entry is not zero but small: the reflection changes it this way to working precision.
                        h[k * n - n + k] *= 1.0 - r.t[0];
                    }
                    (None, r)
                }
                _ => {
                    let column = &h[(k - 1) * n + k..];
                    let (beta, r) = reflect_vector([column[0], column[1], if triple { column[2] } else { 0.0 }]);
                    (Some(beta), r)
                }
            };
            if let Some(beta) = beta {
                let column = &mut h[(k - 1) * n + k..];
                (column[0], column[1]) = (beta, 0.0);
                if triple {
                    column[2] = 0.0;
                }
            }
            chain[k - from] = r;
            if r.t[0] == 0.0 {
                continue;
            }
            let rows = (k + 3).min(last) + 1;
            if triple {
                for column in h[k * n..cols * n].chunks_exact_mut(n) {
                    if let Some([x, y, z]) = column.get_mut(k..).and_then(|c| c.first_chunk_mut::<3>()) {
                        let s = fma::<FMA>(r.t[1], *y, fma::<FMA>(r.t[0], *x, r.t[2] * *z));
                        *x -= s;
                        *y = fma::<FMA>(-s, r.v[0], *y);
                        *z = fma::<FMA>(-s, r.v[1], *z);
                    }
                }
                let (x, rest) = h[k * n..(k + 3) * n].split_at_mut(n);
                let (y, z) = rest.split_at_mut(n);
                let (x, y, z) = (&mut x[begin..rows], &mut y[begin..rows], &mut z[begin..rows]);
                for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
                    let s = fma::<FMA>(r.t[1], *y, fma::<FMA>(r.t[0], *x, r.t[2] * *z));
                    *x -= s;
                    *y = fma::<FMA>(-s, r.v[0], *y);
                    *z = fma::<FMA>(-s, r.v[1], *z);
                }
            } else {
                for column in h[k * n..cols * n].chunks_exact_mut(n) {
                    if let Some([x, y]) = column.get_mut(k..).and_then(|c| c.first_chunk_mut::<2>()) {
                        let s = fma::<FMA>(r.t[1], *y, r.t[0] * *x);
                        *x -= s;
                        *y = fma::<FMA>(-s, r.v[0], *y);
                    }
                }
                let (x, y) = h[k * n..(k + 2) * n].split_at_mut(n);
                for (x, y) in x[begin..rows].iter_mut().zip(&mut y[begin..rows]) {
                    let s = fma::<FMA>(r.t[1], *y, r.t[0] * *x);
                    *x -= s;
                    *y = fma::<FMA>(-s, r.v[0], *y);
                }
            }
        }
        let part = Chain { at: begin, reflectors: &chain[begin - from..end - from], pair: end == last };
        chain_on_columns::<FMA>(h, n, window.0..begin, part);
        chain_on_rows::<FMA>(h, n, cols..window.1, part, packed);
        begin = end;
    }
}
