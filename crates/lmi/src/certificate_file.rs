//! Certificate files of results: the inequalities in expanded form, exactly, with the point that satisfies them or the
//! multipliers that refute them.
//!
//! `luenberger-verify` checks such a file without this crate. The expansion in `coefficients.rs` is trusted: it ensures
//! that the inequalities of the file are those of the [`Problem`]. The result itself is verified by the checker alone.

use luenberger_proof::certificate::{
    CertificateFile, Coefficient, Constraint, InequalityHolds, InequalityRefuted, MatrixInequality, Number, Rejection,
};
use luenberger_proof::{Exact, Matrix, Ring, Verdict};

use crate::coefficients::expand;
use crate::error::LmiError;
use crate::problem::Problem;
use crate::solution::{Infeasibility, Solution};
use crate::standard::{Anchor, Small, standard_form};

impl Problem {
    /// The certificate file of a result of this problem: the values, if they are verified, or the multipliers that
    /// refute it.
    ///
    /// The unknowns are numbered from 1 in the order of declaration: a symmetric matrix by its lower triangle, column
    /// by column, a rectangular one column by column. The objective is not included.
    ///
    /// ```
    /// use luenberger_lmi::{Problem, he};
    /// use luenberger_proof::certificate::verify;
    /// use nalgebra::dmatrix;
    ///
    /// let mut lmi = Problem::new();
    /// let p = lmi.symmetric("P", 2);
    /// lmi.constrain("P > 0", &p >> 0.0);
    /// lmi.constrain("decrease", he(&p * dmatrix![0.0, 1.0; -2.0, -3.0]) << 0.0);
    /// let file = lmi.certificate_file("a Lyapunov inequality", &lmi.solve()?)?.to_json();
    /// assert_eq!(verify(file.as_bytes())?.facts.len(), 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`LmiError::CertificateFile`] for an undecided result, or that of another problem; for an ill-posed problem, the
    /// error of [`solve`](Self::solve).
    pub fn certificate_file(&self, title: &str, solution: &Solution) -> Result<CertificateFile, LmiError> {
        let offsets = standard_form(self, Anchor::Middle, Small::Kept)?.offsets;
        let inequalities = self.multiplied_out(&offsets)?;
        let file = if let Verdict::Refuted { witness } = &solution.verdict {
            let multipliers = self.multipliers(witness);
            CertificateFile::prove(title, InequalityRefuted { inequalities, multipliers })
        } else {
            // Undecided values are refused by the proof itself, which says which inequality fails.
            let mut x = vec![0.0; inequalities.unknowns];
            for (variable, offset) in self.variables.iter().zip(&offsets) {
                let value = solution.value(variable);
                for i in 0..value.nrows() {
                    for j in 0..value.ncols() {
                        if let Some(entry) = variable.unknown_at(i, j).and_then(|k| x.get_mut(offset + k)) {
                            *entry = value[(i, j)];
                        }
                    }
                }
            }
            CertificateFile::prove(title, InequalityHolds { inequalities, x })
        };
        file.map_err(|rejection: Rejection| LmiError::CertificateFile(Box::new(rejection)))
    }

    /// The symmetric part of every constraint, exactly.
    fn multiplied_out(&self, offsets: &[usize]) -> Result<MatrixInequality, LmiError> {
        let unknowns = self.variables.iter().map(crate::Variable::unknowns).sum();
        let constraints = self.constraints.iter().map(|(name, inequality)| {
            let m = expand::<Exact>(&inequality.positive, offsets)
                .map_err(|fault| LmiError::Malformed { place: name.clone(), fault })?;
            let order = m.rows();
            let mut entries = Vec::new();
            for row in 0..order {
                for column in row..order {
                    let mut push = |unknown: usize, value: &Exact| {
                        // On the diagonal the entry is met twice, as its own mirror image.
                        let value = Number::from(value.shifted(-1));
                        entries.push(Coefficient { unknown, row, column, value });
                    };
                    for entry in [&m[(row, column)], &m[(column, row)]] {
                        if !entry.constant.is_zero() {
                            push(0, &entry.constant);
                        }
                        for (unknown, value) in &entry.terms {
                            push(unknown + 1, value);
                        }
                    }
                }
            }
            Ok(Constraint { name: name.clone(), order, entries: merged(entries) })
        });
        Ok(MatrixInequality { unknowns, strict: true, constraints: constraints.collect::<Result<_, LmiError>>()? })
    }

    /// The exact multiplier of every constraint, zeros where it takes no part, all scaled by one power of two to
    /// integers.
    fn multipliers(&self, witness: &Infeasibility) -> Vec<Matrix<Exact>> {
        let exponents = witness.multipliers.iter().flat_map(|m| m.exact.as_slice());
        let least = exponents.filter(|x| !x.is_zero()).map(Exact::exponent).min().unwrap_or(0);
        let of = |name: &str, order: usize| {
            let known = witness.multipliers.iter().find(|m| m.constraint == name);
            known.map_or_else(|| Matrix::zeros(order, order), |m| m.exact.map(|x| x.shifted(-least)))
        };
        self.constraints.iter().map(|(name, inequality)| of(name, inequality.positive.shape().0)).collect()
    }
}

/// Entries at the same place of the same matrix added up, in the order of unknown, row and column.
fn merged(mut entries: Vec<Coefficient>) -> Vec<Coefficient> {
    entries.sort_by_key(|entry| (entry.unknown, entry.row, entry.column));
    let mut merged: Vec<Coefficient> = Vec::with_capacity(entries.len());
    for entry in entries {
        match merged.last_mut() {
            Some(last) if (last.unknown, last.row, last.column) == (entry.unknown, entry.row, entry.column) => {
                let zero = Exact::zero();
                let sum = last.value.exact().unwrap_or(&zero).add(entry.value.exact().unwrap_or(&zero));
                last.value = Number::from(sum);
            }
            _ => merged.push(entry),
        }
    }
    merged.retain(|entry| entry.value.exact().is_none_or(|value| !value.is_zero()));
    merged
}
