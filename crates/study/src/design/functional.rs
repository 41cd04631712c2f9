//! The functional observer: an estimate of z = K x alone.

use luenberger_design::DesignError;
use luenberger_linalg::{eigenvalues, functional_observer};
use luenberger_observers::FunctionalObserver;
use luenberger_plants::StateSpace;
use luenberger_proof::wording::{counted, significant};
use nalgebra::{Complex, DMatrix};

use super::explain::Misfit;
use super::{Designed, matrix, number, poles, uncertified};
use crate::results::{DesignReport, Statement};
use crate::runnable::Runnable;

pub(super) fn functional(plant: &StateSpace, k: &DMatrix<f64>, requested: &[Complex<f64>]) -> Result<Designed, Misfit> {
    let o = functional_observer(&plant.a, &plant.b, &plant.c, k, requested).map_err(DesignError::from)?;
    let found = eigenvalues(&o.f).map_err(DesignError::from)?;
    let slowest = -found.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
    let observer =
        FunctionalObserver::new(o.f.clone(), o.g.clone(), o.h.clone(), o.n.clone()).map_err(DesignError::from)?;
    let named = [("K", k), ("T", &o.t), ("F", &o.f), ("G", &o.g), ("H", &o.h), ("N", &o.n)];
    let report = DesignReport {
        statement: Statement::of(format!(
            "No stability certificate: T A = F T + G C holds up to rounding, with the relative residual {}. With equality the error of z = K x, {}, is e' = F e, for all x(0) and w(0): asymptotic rate exp(-{} t).",
            significant(o.residual, 2),
            counted(k.nrows(), "function"),
            significant(slowest, 5)
        )),
        matrices: named.into_iter().filter(|(_, m)| !m.is_empty()).map(|(name, m)| matrix(name, m)).collect(),
        poles: poles(&found),
        numbers: vec![
            number("decay rate", slowest),
            number("noise passed to the estimate, norm of N", o.n.clone().svd(false, false).singular_values.max()),
            number("relative residual of T A = F T + G C and K = T + N C", o.residual),
        ],
        ..uncertified("the equations hold up to rounding")
    };
    Ok(Designed::new(Runnable::Functional(Box::new(observer), k.clone()), report, None))
}
