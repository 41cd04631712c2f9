//! The inequalities of the filters, solved. The head of `mod.rs` has them.

use luenberger_lmi::{Expression, Infeasibility, Problem, Solution, Variable, block, he, identity, trace};
use luenberger_proof::Verdict;
use nalgebra::{DMatrix, DVector};

use super::units::Units;
use super::{SystemNorm, Task, TimeDomain};
use crate::check;
use crate::error::DesignError;
use crate::gain_options::GainOptions;
use crate::powers::shift;

const WHAT: &str = "the inequality of the filter in P and Y = P L";

impl Task<'_> {
    /// The least norm of the program, and the gain found for it.
    pub(super) fn least_value(&self, units: &Units, options: &GainOptions) -> Result<(f64, DMatrix<f64>), DesignError> {
        let mut lmi = Problem::new();
        let square = lmi.scalar("gamma^2");
        self.pose(&mut lmi, units, &Expression::from(&square), options)?;
        lmi.minimise(&square);
        let solution = lmi.solve_with(&options.settings)?;
        let (l, _) = gain_of(&solution, units)?.map_err(|verdict| DesignError::not_proved(WHAT, Some(verdict)))?;
        Ok((shift(solution.value(&square)[(0, 0)].max(0.0).sqrt(), -units.size), l))
    }

    /// L and, for the H-infinity norm, P with a norm below gamma; the verdict on the inequality where there is none.
    pub(super) fn gain_below(&self, gamma: f64, units: &Units, options: &GainOptions) -> Result<Found, DesignError> {
        let mut lmi = Problem::new();
        let gamma = shift(gamma, units.size);
        // Rounded up, so that what excludes it excludes gamma.
        let square = (gamma * gamma).next_up();
        self.pose(&mut lmi, units, &Expression::constant(DMatrix::from_element(1, 1, square)), options)?;
        gain_of(&lmi.solve_with(&options.settings)?, units)
    }

    /// P for a given gain, with an H-infinity norm below gamma.
    pub(super) fn storage(&self, l: &DMatrix<f64>, gamma: f64) -> Result<DMatrix<f64>, DesignError> {
        let (units, [f, g, h], gamma) = self.in_units_of(l, gamma);
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", f.nrows());
        lmi.constrain("P > 0", &p >> 0.0);
        let square = Expression::constant(DMatrix::from_element(1, 1, gamma * gamma));
        self.bounded_real(&mut lmi, &p, (&p * &f, &p * &g), (&h, &square));
        let solution = lmi.solve()?;
        match solution.verdict {
            Verdict::Proved { .. } => Ok(units.form_back(&solution.value(&p))),
            Verdict::Refuted { witness } => {
                Err(DesignError::RefutedAsRounded { what: WHAT, rounded: "A - L C, E - L D", witness })
            }
            undecided @ Verdict::Undecided { .. } => Err(DesignError::not_proved(WHAT, Some(undecided))),
        }
    }

    fn pose(
        &self,
        lmi: &mut Problem,
        units: &Units,
        square: &Expression,
        options: &GainOptions,
    ) -> Result<(), DesignError> {
        let (plant, of) = units.scaled(self);
        let (n, outputs) = (plant.a.nrows(), plant.c.nrows());
        let p = lmi.symmetric("P", n);
        let y = lmi.rectangular("Y", n, outputs);
        lmi.constrain("P > 0", &p >> 0.0);
        if let Some(bound) = options.max_gain {
            check::positive("the bound of the gain", bound)?;
            // (1) of `gain_options`, with the L of the units given.
            let s = lmi.scalar("s");
            let squares = |powers: &[i32]| {
                DMatrix::from_diagonal(&DVector::from_iterator(powers.len(), powers.iter().map(|k| shift(1.0, 2 * k))))
            };
            let tau = shift(1.0, 2 * units.half_time);
            lmi.constrain("P > s", (&p - s.identity(n) * squares(&units.state.0)) >> 0.0);
            let largest = s.identity(outputs) * (squares(&units.output) * (bound * bound * tau));
            lmi.constrain("|L| < max_gain", block![[largest, y.transpose()], [&y, tau * &p]] >> 0.0);
        }
        let flow = &p * &plant.a - &y * &plant.c;
        let driven = &p * &of.e - &y * &of.d;
        match self.norm {
            SystemNorm::HInfinity => self.bounded_real(lmi, &p, (flow, driven), (&of.h, square)),
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
        (h, square): (&DMatrix<f64>, &Expression),
    ) {
        let (n, q) = self.of.e.shape();
        let seen = h.transpose() * h;
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

/// A gain with its P, or the verdict on the inequality.
pub(super) type Found = Result<(DMatrix<f64>, DMatrix<f64>), Verdict<Infeasibility>>;

/// `L = P^-1 Y` and P in the units given, if the inequality is proved.
fn gain_of(solution: &Solution, units: &Units) -> Result<Found, DesignError> {
    if !solution.verdict.is_proved() {
        return Ok(Err(solution.verdict.clone()));
    }
    let value = |name| solution.named(name).cloned().unwrap_or_else(|| DMatrix::zeros(0, 0));
    let p: DMatrix<f64> = value("P");
    let l = check::solve_definite("P", &p, &value("Y"))?;
    Ok(Ok((units.gain_back(&l), units.form_back(&p))))
}
