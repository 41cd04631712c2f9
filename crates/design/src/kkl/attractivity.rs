//! Attractivity of the manifold of an immersion-and-invariance observer: `d' = M d`, with M a mean of Jacobians that
//! are enclosed over a box. One P that proves every matrix of the enclosure Hurwitz proves that d decays exponentially.

use luenberger_proof::certificate::{Certificate, Certified};
use luenberger_proof::{Interval, Matrix};
use nalgebra::{Complex, DMatrix};

use super::error::KklError;
use super::stability::{HurwitzAnalysis, hurwitz};
use crate::enclosure::IntervalDual;
use crate::enclosure::paths::{Undefined, explore};

/// The enclosed Jacobian, and what is proved of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Attractivity {
    /// The Jacobian over the box.
    pub jacobian: Matrix<Interval>,
    /// Eigenvalues of its middle, the largest real part first.
    pub eigenvalues: Vec<Complex<f64>>,
    /// P; none where the middle is not Hurwitz.
    pub p: Option<DMatrix<f64>>,
    /// That every matrix of the enclosure is Hurwitz, with one P; no theorem where there is no P.
    pub certificate: Certificate,
}

impl Certified for Attractivity {
    fn certificate(&self) -> &Certificate {
        &self.certificate
    }
}

/// The matrix of `order` columns whose column j has the slopes of `column(j)`, proved Hurwitz or not. Entries without
/// bounds give the operation that has none.
///
/// `-(1 + u^2/2)` for u in [-1, 1]; the product u u is enclosed by [-1, 1]:
/// ```
/// use luenberger_design::IntervalDual;
/// use luenberger_design::kkl::attractivity;
/// use luenberger_proof::Interval;
/// let u = IntervalDual::new(Interval::of(-1.0).hull(&Interval::of(1.0)), Interval::of(0.0));
/// let d = IntervalDual::new(Interval::of(0.0), Interval::of(1.0));
/// let half = IntervalDual::new(Interval::of(0.5), Interval::of(0.0));
/// let found = attractivity(1, |_| vec![-d - half * u * u * d])?.map_err(|why| why.to_owned()).expect("bounds");
/// assert!(found.certificate.is_proved());
/// assert!(found.jacobian[(0, 0)].hi() < -0.49 && found.jacobian[(0, 0)].lo() > -1.51);
/// # Ok::<(), luenberger_design::KklError>(())
/// ```
/// # Errors
/// Those of the Lyapunov equation.
pub fn attractivity(
    order: usize,
    column: impl Fn(usize) -> Vec<IntervalDual>,
) -> Result<Result<Attractivity, &'static str>, KklError> {
    let mut columns: Vec<Vec<Interval>> = Vec::with_capacity(order);
    for j in 0..order {
        let ways = match explore(|| column(j)) {
            Ok(ways) => ways,
            Err(Undefined::Operation(operation)) => return Ok(Err(operation)),
            Err(Undefined::TooManyBranches) => return Ok(Err("a choice between too many branches")),
        };
        let slopes = ways.into_iter().map(|way| way.iter().map(IntervalDual::slope).collect::<Vec<_>>());
        let hull = slopes.reduce(|all, one| all.iter().zip(&one).map(|(all, one)| all.hull(one)).collect());
        match hull.filter(|hull| hull.len() == order && hull.iter().all(Interval::is_bounded)) {
            Some(hull) => columns.push(hull),
            None => return Ok(Err("a derivative")),
        }
    }
    let jacobian = Matrix::from_fn(order, order, |i, j| columns[j][i]);
    let HurwitzAnalysis { spectrum: eigenvalues, p, certificate } = hurwitz(&jacobian)?;
    Ok(Ok(Attractivity { jacobian, eigenvalues, p, certificate }))
}
