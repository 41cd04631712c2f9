//! The bound at one rate by a semidefinite program: for a cubic term, or several vertices. The head of `mod.rs` has the
//! inequalities.

use luenberger_linalg::symmetric_part;
use luenberger_lmi::{Expression, Problem, block, he, identity, trace};
use nalgebra::{DMatrix, DVector};

use super::reached::golden;
use super::{Candidate, ErrorSystem, WHAT};
use crate::check;
use crate::error::DesignError;
use crate::robust::orthogonal_rows;

impl ErrorSystem {
    /// The best of the rates near that of the linear observer, each by a semidefinite program in the units of `scale`.
    pub(super) fn by_programs(&self, rate: f64, scale: &[f64]) -> Result<Candidate, DesignError> {
        let mut best: Option<(f64, Candidate)> = None;
        let mut last = None;
        let mut cost = |rate: f64| match self.program(rate, scale) {
            Ok((cost, candidate)) => {
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, candidate));
                }
                cost
            }
            Err(error) => {
                last = Some(error);
                f64::INFINITY
            }
        };
        // Where N restricts P much, only slow rates have a solution.
        for shares in [&[0.25, 0.5, 0.75, 1.0, 1.3][..], &[0.12, 0.06, 0.03, 0.015, 0.007, 0.003]] {
            let costs: Vec<f64> = shares.iter().map(|share| cost(share * rate)).collect();
            let at = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
            if costs[at].is_finite() {
                golden(0.8 * shares[at] * rate, 1.2 * shares[at] * rate, 8, &mut cost);
                break;
            }
        }
        match (best, last) {
            (Some((_, candidate)), _) => Ok(candidate),
            (None, Some(error)) => self.of_design().ok_or(error),
            (None, None) => Err(DesignError::NoVertices),
        }
    }

    /// The P of the design, at half the rate at which its V decays; none where it does not decay at a vertex.
    fn of_design(&self) -> Option<Candidate> {
        let part = self.cubic.as_ref()?;
        let (p, n) = (&part.p, part.p.nrows());
        let root = p.clone().cholesky()?.l();
        let decrease = |f: DMatrix<f64>| {
            let half = p * f;
            -(&half + half.transpose())
        };
        let decreases: Vec<_> = self.flows().into_iter().map(|(f, g)| (decrease(f), p * g)).collect();
        let mut rate = f64::INFINITY;
        for (q, _) in &decreases {
            let half = root.solve_lower_triangular(q)?;
            let scaled = root.solve_lower_triangular(&half.transpose())?;
            rate = rate.min(0.25 * symmetric_part(&scaled).symmetric_eigenvalues().min());
        }
        if rate.is_nan() || rate <= 0.0 {
            return None;
        }
        let mut lambda = vec![0.0_f64; self.bounds.len()];
        for (q, corner) in &decreases {
            let left = symmetric_part(&(q - p * (2.0 * rate))).cholesky()?;
            for (lambda, column) in lambda.iter_mut().zip(corner.column_iter()) {
                let needed = column.dot(&left.solve(&column.into_owned()));
                *lambda = lambda.max(1.001 * self.bounds.len() as f64 * needed);
            }
        }
        // A disturbance that does not act on the error has a multiplier all the same.
        let largest = lambda.iter().fold(0.0_f64, |most, lambda| most.max(*lambda));
        let lambda = lambda.iter().zip(&self.bounds).map(|(x, w)| x.max(1e-9 * largest) / (w * w)).collect();
        let z = p.clone().cholesky()?.inverse();
        let limsup = (0..n).map(|k| z[(k, k)].sqrt()).collect();
        Some(Candidate { p: p.clone(), rate: rate * (1.0 - 1e-9), lambda, x: 1.0, limsup })
    }

    /// The least sum of squares of the bounds, in the units of `scale`, at a rate.
    fn program(&self, rate: f64, scale: &[f64]) -> Result<(f64, Candidate), DesignError> {
        let (n, m) = (scale.len(), self.bounds.len());
        let largest = scale.iter().fold(0.0_f64, |m, b| m.max(*b));
        let scale = DVector::from_iterator(n, scale.iter().map(|b| b.max(1e-6 * largest)));
        let (units, inverse) = (DMatrix::from_diagonal(&scale), DMatrix::from_diagonal(&scale.map(f64::recip)));
        let mut lmi = Problem::new();
        let lambda = lmi.diagonal("lambda", m);
        let z = lmi.symmetric("Z", n);
        let mut spent: Expression = trace(&lambda);
        let p: Expression = match &self.cubic {
            None => {
                let p = lmi.symmetric("P", n);
                Expression::from(&p)
            }
            Some(part) => {
                let x = lmi.scalar("x");
                lmi.constrain("x > 0", &x >> 0.0);
                let seen = &self.c * &units;
                let t = orthogonal_rows(&(&inverse * &part.n));
                let mut p = seen.transpose() * (&x * &part.x) * &seen;
                if t.nrows() > 0 {
                    let y = lmi.symmetric("Y", t.nrows());
                    p = p + t.transpose() * &y * &t;
                }
                spent = spent + part.cost * &x;
                p
            }
        };
        for (k, (f, g)) in self.flows().into_iter().enumerate() {
            let (f, g) = (without_rounding(&(&inverse * f * &units)), without_rounding(&(&inverse * g)));
            let corner = &p * &g;
            let block = block![[he(&p * &f) + (2.0 * rate) * &p, corner.clone()], [corner.transpose(), -&lambda]];
            lmi.constrain(&format!("decrease at vertex {}", k + 1), block << 0.0);
        }
        lmi.constrain("level", spent << (2.0 * rate));
        lmi.constrain("P^-1 < Z", block![[p.clone(), identity(n)], [identity(n), z.clone()]] >> 0.0);
        lmi.minimise(trace(&z));
        let solution = lmi.solve()?;
        if !solution.verdict.is_proved() {
            return Err(DesignError::not_proved(WHAT, Some(solution.verdict)));
        }
        let named = |name| solution.named(name).cloned().unwrap_or_else(|| DMatrix::zeros(0, 0));
        let (p, x) = match &self.cubic {
            None => (named("P"), 0.0),
            Some(part) => {
                let x = named("x")[(0, 0)];
                let seen = &self.c * &units;
                let mut p = seen.transpose() * &part.x * &seen * x;
                let t = orthogonal_rows(&(&inverse * &part.n));
                if t.nrows() > 0 {
                    p += t.transpose() * named("Y") * &t;
                }
                (p, x)
            }
        };
        let p = symmetric_part(&(&inverse * p * &inverse));
        let z = check::solve_definite("P", &p, &DMatrix::identity(n, n))?;
        let cost = (0..n).map(|k| z[(k, k)] / (scale[k] * scale[k])).sum();
        let lambda = named("lambda");
        let lambda = (0..m).map(|i| lambda[(i, i)] / (self.bounds[i] * self.bounds[i])).collect();
        let limsup = (0..n).map(|k| z[(k, k)].sqrt()).collect();
        Ok((cost, Candidate { p, rate, lambda, x, limsup }))
    }
}

/// Entries that are rounding, as those of a placed `A - LC` that is diagonal, are 0: the solver of the program would
/// scale by them. What it proposes is proved for the numbers themselves.
fn without_rounding(m: &DMatrix<f64>) -> DMatrix<f64> {
    let least = 8.0 * f64::EPSILON * m.norm();
    m.map(|x| if x.abs() <= least { 0.0 } else { x })
}
