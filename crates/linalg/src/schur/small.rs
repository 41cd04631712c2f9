//! The double-shift iteration of Francis (`francis.rs`) for orders up to [`LARGEST`], on the stack: reduction, sweeps
//! and transformation with columns of constant length. A reflector is applied to whole columns: entries below the bulge
//! are zero and remain so.

use super::bulge::reflect_vector;
use super::chain::{reflect2, reflect3};
use super::francis::{Columns, Passage, Sweeps, iterate, next_reflector, reflect_rows2, reflect_rows3};
use super::hessenberg::Reduction;
use crate::kernel::Kernel;

/// For larger orders heap allocation costs little compared with the iteration.
pub(super) const LARGEST: usize = 8;

/// Overwrites the matrix `h` of order `n` with its real Schur form and `q` with the transformation. Returns the result
/// of [`iterate`].
pub(super) struct Small<'a> {
    pub(super) h: &'a mut [f64],
    pub(super) n: usize,
    pub(super) q: &'a mut [f64],
}

impl Kernel for Small<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> usize {
        match self.n {
            0..=1 => {
                self.q.fill(1.0);
                0
            }
            2..=4 => self.of::<4, FMA>(),
            _ => self.of::<LARGEST, FMA>(),
        }
    }
}

impl Small<'_> {
    #[inline(always)]
    fn of<const W: usize, const FMA: bool>(self) -> usize {
        let Self { h, n, q } = self;
        let mut fixed = Fixed { t: [[0.0; W]; W], q: [[0.0; W]; W], n };
        for (j, (to, from)) in fixed.t.iter_mut().zip(h.chunks_exact(n)).enumerate() {
            to[..n].copy_from_slice(from);
            fixed.q[j][j] = 1.0;
        }
        let mut work = [[0.0; W]; 3];
        let ((t, _), (u, _)) = fixed.parts();
        Reduction { h: t, n: W, order: n, q: u, fresh: true, work: work.as_flattened_mut() }.run::<FMA>();
        let stuck = iterate::<FMA>(&mut fixed, n, true);
        for (to, from) in h.chunks_exact_mut(n).zip(&fixed.t) {
            to.copy_from_slice(&from[..n]);
        }
        for (to, from) in q.chunks_exact_mut(n).zip(&fixed.q) {
            to.copy_from_slice(&from[..n]);
        }
        stuck
    }
}

/// Only the leading `n` rows and columns are used; the others are zero.
struct Fixed<const W: usize> {
    t: [[f64; W]; W],
    q: [[f64; W]; W],
    n: usize,
}

impl<const W: usize> Sweeps for Fixed<W> {
    #[inline(always)]
    fn parts(&mut self) -> (Columns<'_>, Columns<'_>) {
        ((self.t.as_flattened_mut(), W), (self.q.as_flattened_mut(), W))
    }

    #[inline(always)]
    fn sweep<const FMA: bool>(&mut self, passage: Passage, v: [f64; 3]) {
        let Self { t, q, n } = self;
        let Passage { first, from, last, .. } = passage;
        for k in from..last {
            let r = if k > from {
                next_reflector(&mut t[k - 1], k, k + 1 < last)
            } else {
                let (_, r) = reflect_vector(v);
                if from > first {
                    // As in `francis.rs`, to working precision.
                    t[k - 1][k] *= 1.0 - r.t[0];
                }
                r
            };
            if r.t[0] == 0.0 {
                continue;
            }
            let columns = t[k..*n].iter_mut().map(|column| &mut column[..]);
            if k + 1 < last {
                reflect_rows3::<FMA>(columns, k, &r);
                for m in [&mut *t, &mut *q] {
                    if let Some([x, y, z]) = m.get_mut(k..).and_then(|m| m.first_chunk_mut::<3>()) {
                        reflect3::<W, FMA>(&r, x, y, z);
                    }
                }
            } else {
                reflect_rows2::<FMA>(columns, k, &r);
                for m in [&mut *t, &mut *q] {
                    if let Some([x, y]) = m.get_mut(k..).and_then(|m| m.first_chunk_mut::<2>()) {
                        reflect2::<W, FMA>(&r, x, y);
                    }
                }
            }
        }
    }
}
