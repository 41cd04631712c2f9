//! The inequalities of the filters, solved. The head of `mod.rs` has them.

use luenberger_lmi::{Expression, Problem, Variable, block, he, identity, trace};
use nalgebra::DMatrix;

use super::{SystemNorm, Task, TimeDomain};
use crate::check;
use crate::error::DesignError;
use crate::gain_options::GainOptions;

const WHAT: &str = "the inequality of the filter in P and Y = P L";

impl Task<'_> {
    /// The least norm, and the gain found for it.
    pub(super) fn least(&self, options: &GainOptions) -> Result<(f64, DMatrix<f64>), DesignError> {
        let mut lmi = Problem::new();
        let square = lmi.scalar("gamma^2");
        self.pose(&mut lmi, &Expression::from(&square), options)?;
        lmi.minimise(&square);
        let solution = lmi.solve_with(&options.settings)?;
        let (l, _) = gain_of(&solution)?;
        Ok((solution.value(&square)[(0, 0)].max(0.0).sqrt(), l))
    }

    /// L and P with a norm below gamma.
    pub(super) fn gain_below(
        &self,
        gamma: f64,
        options: &GainOptions,
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), DesignError> {
        let mut lmi = Problem::new();
        self.pose(&mut lmi, &Expression::constant(DMatrix::from_element(1, 1, gamma * gamma)), options)?;
        gain_of(&lmi.solve_with(&options.settings)?)
    }

    /// P for a given gain, with an H-infinity norm below gamma.
    pub(super) fn storage(&self, l: &DMatrix<f64>, gamma: f64) -> Result<DMatrix<f64>, DesignError> {
        let (f, g) = self.flow(l);
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", f.nrows());
        lmi.constrain("P > 0", &p >> 0.0);
        let square = Expression::constant(DMatrix::from_element(1, 1, gamma * gamma));
        self.bounded_real(&mut lmi, &p, (&p * &f, &p * &g), &square);
        let solution = lmi.solve()?;
        if !solution.verdict.is_proved() {
            return Err(DesignError::not_proved(WHAT, Some(solution.verdict)));
        }
        Ok(solution.value(&p))
    }

    fn pose(&self, lmi: &mut Problem, square: &Expression, options: &GainOptions) -> Result<(), DesignError> {
        let (plant, of) = (self.plant, self.of);
        let (n, outputs) = (plant.a.nrows(), plant.c.nrows());
        let p = lmi.symmetric("P", n);
        let y = lmi.rectangular("Y", n, outputs);
        lmi.constrain("P > 0", &p >> 0.0);
        let limits = GainOptions { noise: None, ..options.clone() }.check(outputs)?;
        limits.constrain(lmi, &p, &y, n, outputs);
        let flow = &p * &plant.a - &y * &plant.c;
        let driven = &p * &of.e - &y * &of.d;
        match self.norm {
            SystemNorm::HInfinity => self.bounded_real(lmi, &p, (flow, driven), square),
            SystemNorm::H2 => {
                let (q, r) = (of.e.ncols(), of.h.nrows());
                match self.time {
                    TimeDomain::Continuous => lmi.constrain(
                        "variance",
                        block![[he(flow), driven.clone()], [driven.transpose(), -identity(q)]] << 0.0,
                    ),
                    TimeDomain::Discrete => lmi.constrain(
                        "variance",
                        block![
                            [&p, flow.clone(), driven.clone()],
                            [flow.transpose(), &p, zeros(n, q)],
                            [driven.transpose(), zeros(q, n), identity(q)],
                        ] >> 0.0,
                    ),
                }
                let z = lmi.symmetric("Z", r);
                lmi.constrain("H P^-1 H' < Z", block![[&z, of.h.clone()], [of.h.transpose(), &p]] >> 0.0);
                lmi.constrain("trace Z < gamma^2", (square.clone() - trace(&z)) >> 0.0);
            }
        }
        Ok(())
    }

    fn bounded_real(
        &self,
        lmi: &mut Problem,
        p: &Variable,
        (flow, driven): (Expression, Expression),
        square: &Expression,
    ) {
        let (n, q) = self.of.e.shape();
        let seen = self.of.h.transpose() * &self.of.h;
        let last = square.clone() * DMatrix::<f64>::identity(q, q);
        match self.time {
            TimeDomain::Continuous => lmi.constrain(
                "bounded real",
                block![[he(flow) + seen, driven.clone()], [driven.transpose(), -last]] << 0.0,
            ),
            TimeDomain::Discrete => lmi.constrain(
                "bounded real",
                block![
                    [p - seen, zeros(n, q), flow.transpose()],
                    [zeros(q, n), last, driven.transpose()],
                    [flow, driven, p],
                ] >> 0.0,
            ),
        }
    }
}

fn zeros(rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::zeros(rows, columns)
}

/// `L = P^-1 Y` and P, if the inequality is proved.
fn gain_of(solution: &luenberger_lmi::Solution) -> Result<(DMatrix<f64>, DMatrix<f64>), DesignError> {
    if !solution.verdict.is_proved() {
        return Err(DesignError::not_proved(WHAT, Some(solution.verdict.clone())));
    }
    let value = |name| solution.named(name).cloned().unwrap_or_else(|| DMatrix::zeros(0, 0));
    let p: DMatrix<f64> = value("P");
    Ok((check::solve_definite("P", &p, &value("Y"))?, p))
}
