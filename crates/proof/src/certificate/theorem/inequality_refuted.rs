//! Multipliers that show that no point satisfies linear matrix inequalities.
//!
//! **Theorem.** There are `Z_k >= 0`, not all zero, with `sum_k tr(F_ki Z_k) = 0` for every unknown i and `sum_k
//! tr(F_k0 Z_k) <= 0` (`< 0` for inequalities that are not strict), exactly. Then no x satisfies the inequalities.
//!
//! **Proof.** `sum_k tr(F_k(x) Z_k)` would be positive (not negative), and is that constant whatever x is.

use super::super::fields::Field;
use super::super::members::members;
use super::super::write::{Out, Written};
use super::super::{Fault, Witness};
use super::inequality::MatrixInequality;
use super::{Fact, FileError, Names, Statement};
use crate::definite::positive_semidefinite;
use crate::error::ProofError;
use crate::exact::Exact;
use crate::matrix::Matrix;
use crate::number::Number;
use crate::ring::Ring;
use crate::verdict::Verdict;
use crate::wording::quoted;

/// No point satisfies the inequalities; the head of the file has theorem and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct InequalityRefuted {
    /// The inequalities, with dyadic coefficients.
    pub inequalities: MatrixInequality,
    /// The multiplier of each constraint, dyadic; a matrix of zeros where it takes no part.
    pub multipliers: Vec<Matrix<Exact>>,
}

impl Statement for InequalityRefuted {
    const NAME: &'static str = "matrix-inequality-refuted";

    fn facts(&self, _: Names<'_>) -> Result<Vec<Fact>, ProofError> {
        let constraints = &self.inequalities.constraints;
        let mut facts = Vec::new();
        let mut terms = Vec::new();
        let mut all_zero = true;
        for (constraint, z) in constraints.iter().zip(&self.multipliers) {
            z.expect_shape("a multiplier", (constraint.order, constraint.order))?;
            facts.push(Fact::new(format!("Z >= 0 of {}", quoted(&constraint.name)), positive_semidefinite(z)?));
            all_zero &= z.as_slice().iter().all(Ring::is_zero);
            terms.extend(constraint.entries.iter().map(|entry| (entry, &z[(entry.row, entry.column)])));
        }
        // One trace at a time: each may be as long as the longest number.
        terms.sort_by_key(|(entry, _)| entry.unknown);
        let (mut constant, mut unsatisfied) = (Exact::zero(), None);
        for terms in terms.chunk_by(|x, y| x.0.unknown == y.0.unknown) {
            let mut trace = Exact::zero();
            for (entry, z) in terms {
                let Some(value) = entry.value.exact() else { continue };
                let product = value.mul(z);
                // An entry off the diagonal stands for its mirror image too.
                trace = trace.add(&if entry.row == entry.column { product } else { product.shifted(1) });
            }
            let unknown = terms.first().map_or(0, |(entry, _)| entry.unknown);
            if unknown == 0 {
                constant = trace;
            } else if !trace.is_zero() {
                unsatisfied = Some((unknown, trace));
                break;
            }
        }
        let holds = |witness: Option<Witness>, margin: f64| match witness {
            Some(witness) => Verdict::Refuted { witness },
            None => Verdict::Proved { margin },
        };
        let value = |x: &Exact| if x.signum() < 0 { x.round_down() } else { x.round_up() };
        let unsatisfied = unsatisfied.map(|(unknown, trace)| Witness::Equation { unknown, value: value(&trace) });
        facts.push(Fact::stated("sum_k tr(F_ki Z_k) = 0 for every unknown x_i", holds(unsatisfied, 0.0)));
        facts.push(Fact::stated("the Z_k are not all zero", holds(all_zero.then_some(Witness::Zero), 0.0)));
        let (relation, right_sign) =
            if self.inequalities.strict { ("<=", constant.signum() <= 0) } else { ("<", constant.signum() < 0) };
        let wrong = (!right_sign).then(|| Witness::Equation { unknown: 0, value: value(&constant) });
        let margin = constant.neg().round_down().clamp(0.0, f64::MAX);
        facts.push(Fact::stated(format!("sum_k tr(F_k0 Z_k) {relation} 0"), holds(wrong, margin)));
        Ok(facts)
    }

    fn words(&self) -> String {
        format!("No x satisfies the linear matrix inequalities {}.", self.inequalities.described())
    }
}

members! { InequalityRefuted { {
    inequalities: MatrixInequality = "inequalities".part();
    multipliers = "multipliers".by(|list| read_multipliers(list, &inequalities));
} } }

fn read_multipliers(list: &Field<'_>, inequalities: &MatrixInequality) -> Result<Vec<Matrix<Exact>>, FileError> {
    let items = list.items()?;
    if items.len() != inequalities.constraints.len() {
        return Err(list.error(Fault::Length { expected: inequalities.constraints.len(), found: items.len() }));
    }
    for (k, constraint) in inequalities.constraints.iter().enumerate() {
        if let Some(entry) = constraint.entries.iter().find(|entry| entry.value.exact().is_none()) {
            let mut error = list.not_exact(&entry.value, "dyadic number (scale the constraint)");
            error.path = format!("inequalities.constraints[{k}].entries");
            return Err(error);
        }
    }
    let mut multipliers = Vec::with_capacity(items.len());
    for (item, constraint) in items.iter().zip(&inequalities.constraints) {
        let z = item.symmetric_exact(constraint.order)?;
        let mut entries = Vec::with_capacity(z.as_slice().len());
        for number in z.as_slice() {
            let exact = number
                .exact()
                .ok_or_else(|| item.not_exact(number, "dyadic number (scale the multipliers to integers)"))?;
            entries.push(exact.clone());
        }
        let order = constraint.order;
        multipliers.push(Matrix::from_row_major(order, order, entries).map_err(|_| item.error(Fault::Empty))?);
    }
    Ok(multipliers)
}

impl Written for Exact {
    fn out(&self) -> Out {
        Number::from(self.clone()).out()
    }
}
