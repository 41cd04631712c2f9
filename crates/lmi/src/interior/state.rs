//! The iterates and one step of the method.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par};

use super::program::{Blocks, Scaled};
use super::schur::{assemble, joined, refined, regularised};
use crate::conic::Ending;
use crate::sequential::{Cholesky, eigenvalues, product};

/// A ray is accepted if its equations hold to this tolerance, relative to its size.
const RAY: f64 = 1e-9;

/// Current iterate.
pub(super) struct State {
    pub(super) x: Vec<f64>,
    /// X, which is `F_0 + sum x_i F_i` up to the residual.
    pub(super) primal: Blocks,
    /// Y.
    pub(super) dual: Blocks,
    /// Whether X is `F_0 + sum x_i F_i`.
    pub(super) is_primal_feasible: bool,
    /// The residual of that, as a fraction of its initial value.
    pub(super) residual: f64,
}

pub(super) struct Progress {
    /// Of the point, and how far it is above the optimum at most, if the equations hold.
    pub(super) cost: f64,
    pub(super) excess: f64,
    pub(super) gap: f64,
    pub(super) residual: f64,
}

/// A search direction.
pub(super) struct Direction {
    pub(super) x: Vec<f64>,
    pub(super) primal: Blocks,
    pub(super) dual: Blocks,
}

/// Quantities computed once per iteration.
pub(super) struct Factors {
    pub(super) x: Vec<Cholesky>,
    pub(super) y: Vec<Cholesky>,
    pub(super) inverse: Vec<Mat<f64>>,
    pub(super) schur: Cholesky,
    /// The Schur complement, for refinement.
    pub(super) matrix: Mat<f64>,
    pub(super) residual: Blocks,
}

impl State {
    pub(super) fn start(scaled: &Scaled) -> Self {
        let size = 10.0 * (scaled.rows as f64).sqrt();
        let identity = |n: usize| Mat::from_fn(n, n, |i, j| if i == j { size } else { 0.0 });
        let dense: Vec<_> = scaled.dense.iter().map(|block| identity(block.order)).collect();
        let numbers = vec![size; scaled.numbers.len()];
        Self {
            x: vec![0.0; scaled.cost.len()],
            primal: Blocks { dense: dense.clone(), numbers: numbers.clone() },
            dual: Blocks { dense, numbers },
            is_primal_feasible: false,
            residual: 1.0,
        }
    }

    pub(super) fn complementarity(&self) -> f64 {
        let dense: f64 = self.primal.dense.iter().zip(&self.dual.dense).map(|(x, y)| inner(x, y)).sum();
        dense + self.primal.numbers.iter().zip(&self.dual.numbers).map(|(x, y)| x * y).sum::<f64>()
    }

    /// One iteration. `None` if a factorisation fails or the step is too short to continue.
    pub(super) fn step(&mut self, scaled: &Scaled) -> Option<Progress> {
        let factors = self.factors(scaled)?;
        let rows = scaled.rows as f64;
        let mu = self.complementarity() / rows;
        let predictor = self.direction(scaled, &factors, 0.0, None)?;
        let (ap, ad) = self.lengths(&factors, &predictor, 1.0)?;
        let after = self.moved_complementarity(&predictor, ap, ad) / rows;
        let ratio = (after / mu).clamp(0.0, 1.0);
        // The shorter the predictor's step, the more centring.
        let exponent = (3.0 * ap.min(ad).powi(2)).max(1.0);
        let sigma = ratio.powf(exponent).max(1e-6);
        let direction = self.direction(scaled, &factors, sigma * mu, Some(&predictor))?;
        let (ap, ad) = self.lengths(&factors, &direction, 0.9 + 0.08 * ap.min(ad))?;
        if ap < 1e-6 && ad < 1e-6 {
            return None;
        }
        self.advance(scaled, &direction, ap, ad);
        let progress = self.progress(scaled);
        Some(progress)
    }

    pub(super) fn factors(&self, scaled: &Scaled) -> Option<Factors> {
        let x: Vec<Cholesky> = self.primal.dense.iter().map(Cholesky::of).collect::<Option<_>>()?;
        let y: Vec<Cholesky> = self.dual.dense.iter().map(Cholesky::of).collect::<Option<_>>()?;
        let inverse: Vec<Mat<f64>> = x.iter().map(Cholesky::inverse).collect();
        let matrix = self.schur(scaled, &inverse);
        let mut pencil = scaled.pencil(&self.x, true);
        for (p, x) in pencil.dense.iter_mut().zip(&self.primal.dense) {
            *p -= x;
        }
        for (p, x) in pencil.numbers.iter_mut().zip(&self.primal.numbers) {
            *p -= x;
        }
        let schur = regularised(&matrix)?;
        Some(Factors { x, y, inverse, schur, matrix, residual: pencil })
    }

    /// B.
    pub(super) fn schur(&self, scaled: &Scaled, inverse: &[Mat<f64>]) -> Mat<f64> {
        let m = scaled.cost.len();
        let mut b: Mat<f64> = Mat::zeros(m, m);
        for ((block, v), y) in scaled.dense.iter().zip(inverse).zip(&self.dual.dense) {
            assemble(block, v.as_ref(), y.as_ref(), &mut b);
        }
        for ((number, x), y) in scaled.numbers.iter().zip(&self.primal.numbers).zip(&self.dual.numbers) {
            number.assemble(y / x, &mut b);
        }
        joined(b)
    }

    pub(super) fn direction(
        &self,
        scaled: &Scaled,
        factors: &Factors,
        mu: f64,
        predictor: Option<&Direction>,
    ) -> Option<Direction> {
        // mu V - V (R Y + dX_a dY_a), not yet symmetric.
        let dense: Vec<Mat<f64>> = (0..self.primal.dense.len())
            .map(|k| {
                let v = &factors.inverse[k];
                let mut known = if self.is_primal_feasible {
                    Mat::zeros(v.nrows(), v.ncols())
                } else {
                    product(factors.residual.dense[k].as_ref(), self.dual.dense[k].as_ref())
                };
                if let Some(p) = predictor {
                    known += product(p.primal.dense[k].as_ref(), p.dual.dense[k].as_ref());
                }
                let mut out = -product(v.as_ref(), known.as_ref());
                if mu > 0.0 {
                    out += faer::Scale(mu) * v;
                }
                out
            })
            .collect();
        let numbers: Vec<f64> = (0..self.primal.numbers.len())
            .map(|k| {
                let second = predictor.map_or(0.0, |p| p.primal.numbers[k] * p.dual.numbers[k]);
                (mu - factors.residual.numbers[k] * self.dual.numbers[k] - second) / self.primal.numbers[k]
            })
            .collect();
        let known = Blocks { dense, numbers };
        let right: Vec<f64> = scaled.adjoint(&known).iter().zip(&scaled.cost).map(|(a, c)| a - c).collect();
        let x = refined(&factors.schur, &factors.matrix, &right);
        if !x.iter().all(|x| x.is_finite()) {
            return None;
        }
        let mut dx = scaled.pencil(&x, false);
        let mut dy = Blocks {
            dense: Vec::with_capacity(self.dual.dense.len()),
            numbers: Vec::with_capacity(self.dual.numbers.len()),
        };
        for (k, known) in known.dense.into_iter().enumerate() {
            // - sym(V (sum dx_i F_i) Y), and the known part symmetric.
            let right = product(dx.dense[k].as_ref(), self.dual.dense[k].as_ref());
            let moved = product(factors.inverse[k].as_ref(), right.as_ref());
            let n = moved.nrows();
            let y = &self.dual.dense[k];
            dy.dense.push(Mat::from_fn(n, n, |i, j| {
                0.5 * (known[(i, j)] + known[(j, i)] - moved[(i, j)] - moved[(j, i)]) - y[(i, j)]
            }));
            if !self.is_primal_feasible {
                dx.dense[k] += &factors.residual.dense[k];
            }
        }
        for (k, known) in known.numbers.into_iter().enumerate() {
            dy.numbers
                .push(known - dx.numbers[k] * self.dual.numbers[k] / self.primal.numbers[k] - self.dual.numbers[k]);
            dx.numbers[k] += factors.residual.numbers[k];
        }
        Some(Direction { x, primal: dx, dual: dy })
    }

    /// The longest steps, at most 1, that keep this fraction of the distance to the boundary.
    pub(super) fn lengths(&self, factors: &Factors, d: &Direction, share: f64) -> Option<(f64, f64)> {
        let mut ends = [f64::INFINITY; 2];
        for (end, llts, changes, at, steps) in [
            (0, &factors.x, &d.primal.dense, &self.primal.numbers, &d.primal.numbers),
            (1, &factors.y, &d.dual.dense, &self.dual.numbers, &d.dual.numbers),
        ] {
            for (llt, change) in llts.iter().zip(changes) {
                let least = least_relative_eigenvalue(llt, change)?;
                if least < 0.0 {
                    ends[end] = ends[end].min(-1.0 / least);
                }
            }
            for (at, step) in at.iter().zip(steps) {
                if *step < 0.0 {
                    ends[end] = ends[end].min(-at / step);
                }
            }
        }
        Some(((share * ends[0]).min(1.0), (share * ends[1]).min(1.0)))
    }

    pub(super) fn moved_complementarity(&self, d: &Direction, ap: f64, ad: f64) -> f64 {
        let dense: f64 = (0..self.primal.dense.len())
            .map(|k| {
                let (x, y, dx, dy) = (&self.primal.dense[k], &self.dual.dense[k], &d.primal.dense[k], &d.dual.dense[k]);
                inner(x, y) + ap * inner(dx, y) + ad * inner(x, dy) + ap * ad * inner(dx, dy)
            })
            .sum();
        let numbers: f64 = (0..self.primal.numbers.len())
            .map(|k| {
                (self.primal.numbers[k] + ap * d.primal.numbers[k]) * (self.dual.numbers[k] + ad * d.dual.numbers[k])
            })
            .sum();
        dense + numbers
    }

    pub(super) fn advance(&mut self, scaled: &Scaled, d: &Direction, ap: f64, ad: f64) {
        for (x, dx) in self.x.iter_mut().zip(&d.x) {
            *x += ap * dx;
        }
        for (y, dy) in self.dual.dense.iter_mut().zip(&d.dual.dense) {
            *y += faer::Scale(ad) * dy;
        }
        for (y, dy) in self.dual.numbers.iter_mut().zip(&d.dual.numbers) {
            *y += ad * dy;
        }
        self.residual *= 1.0 - ap;
        self.is_primal_feasible |= self.residual == 0.0;
        if self.is_primal_feasible {
            // Once the residual is gone it stays gone, to rounding.
            let pencil = scaled.pencil(&self.x, true);
            self.primal = pencil;
        } else {
            for (x, dx) in self.primal.dense.iter_mut().zip(&d.primal.dense) {
                *x += faer::Scale(ap) * dx;
            }
            for (x, dx) in self.primal.numbers.iter_mut().zip(&d.primal.numbers) {
                *x += ap * dx;
            }
        }
    }

    pub(super) fn progress(&self, scaled: &Scaled) -> Progress {
        let value: f64 = scaled.cost.iter().zip(&self.x).map(|(c, x)| c * x).sum();
        let dual = -scaled.constant_part(&self.dual);
        let infeasibility =
            scaled.adjoint(&self.dual).iter().zip(&scaled.cost).map(|(a, c)| (a - c).abs()).fold(0.0, f64::max);
        let excess = self.complementarity();
        Progress {
            cost: value,
            excess,
            gap: excess / (1.0 + value.abs() + dual.abs()),
            residual: f64::max(infeasibility / (1.0 + self.dual.size()), self.residual),
        }
    }

    /// Whether x or Y has become a ray that shows the other program infeasible, to working precision.
    pub(super) fn ray(&self, scaled: &Scaled) -> Option<Ending> {
        let value = -scaled.cost.iter().zip(&self.x).map(|(c, x)| c * x).sum::<f64>();
        // X - F_0 >= - |F_0|, and the constants have norm 1.
        if self.is_primal_feasible && value > 0.0 && 1.0 < RAY * value {
            return Some(Ending::Unbounded);
        }
        let dual = -scaled.constant_part(&self.dual);
        if dual > 0.0 {
            let infeasibility = scaled.adjoint(&self.dual).iter().map(|a| a * a).sum::<f64>().sqrt();
            if infeasibility < RAY * dual {
                return Some(Ending::NoPoint);
            }
        }
        None
    }
}

pub(super) fn inner(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.ncols()).map(|j| a.col(j).iter().zip(b.col(j).iter()).map(|(x, y)| x * y).sum::<f64>()).sum()
}
/// The smallest eigenvalue of `L^-1 D L^-T`.
pub(super) fn least_relative_eigenvalue(factor: &Cholesky, d: &Mat<f64>) -> Option<f64> {
    let mut left = d.clone();
    solve_lower_triangular_in_place(factor.l(), left.as_mut(), Par::Seq);
    let mut both = left.transpose().to_owned();
    solve_lower_triangular_in_place(factor.l(), both.as_mut(), Par::Seq);
    eigenvalues(&both)?.first().copied().filter(|x| x.is_finite())
}
