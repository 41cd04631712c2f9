//! Modal coordinates: real eigenvectors, with a block of two for a complex pair.

use luenberger_linalg::eigenvalues;
use nalgebra::{Complex, DMatrix, DVector};

use crate::error::DesignError;

/// The least distance of two poles, relative to the largest and to the norm of F, of which eigenvectors are computed:
/// an eigenvalue of multiplicity two is computed to half of the digits.
const DISTINCT: f64 = 1e-7;

/// T and its blocks, in the units given: T F T^-1 is block diagonal, with `[a b; -b a]` for the poles `a +- ib`.
///
/// # Errors
/// [`DesignError::NoModalCoordinates`] for poles that are not distinct, [`DesignError::DependentModes`] for
/// eigenvectors that are nearly dependent.
pub(crate) fn in_units(f: &DMatrix<f64>) -> Result<(DMatrix<f64>, Vec<usize>), DesignError> {
    let n = f.nrows();
    let mut poles = eigenvalues(f)?;
    let separation = separation(&poles);
    let fastest = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    if n > 1 && separation <= DISTINCT * fastest {
        return Err(DesignError::NoModalCoordinates { separation });
    }
    // Distinct poles, which a change of F by its rounding can make coincide.
    let is_defective = n > 1 && separation <= DISTINCT * f.norm();
    let not_found = || DesignError::DependentModes { condition: f64::INFINITY };
    poles.retain(|pole| pole.im >= 0.0);
    poles.sort_by(|x, y| y.re.total_cmp(&x.re).then(x.im.total_cmp(&y.im)));
    let mut columns: Vec<DVector<f64>> = Vec::with_capacity(n);
    let mut blocks = Vec::new();
    for pole in poles {
        let Some(vector) = eigenvector(f, pole) else { return Err(not_found()) };
        if pole.im == 0.0 {
            columns.push(vector.map(|x| x.re).normalize());
            blocks.push(1);
        } else {
            columns.push(vector.map(|x| x.re));
            columns.push(vector.map(|x| x.im));
            blocks.push(2);
        }
    }
    if columns.len() != n {
        return Err(not_found());
    }
    let vectors = DMatrix::from_columns(&columns);
    match vectors.clone().try_inverse() {
        Some(t) if !is_defective && t.iter().all(|x| x.is_finite()) => Ok((t, blocks)),
        _ => Err(dependent(&vectors)),
    }
}

/// No modal coordinates, for the condition of T or of its inverse.
pub(crate) fn dependent(t: &DMatrix<f64>) -> DesignError {
    let values = t.singular_values();
    DesignError::DependentModes { condition: values.max() / values.min() }
}

/// The least distance of two poles.
fn separation(poles: &[Complex<f64>]) -> f64 {
    let pairs = (0..poles.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.map(|(i, j)| (poles[i] - poles[j]).norm()).fold(f64::INFINITY, f64::min)
}

/// An eigenvector of length 1 by inverse iteration, real for a real pole.
fn eigenvector(f: &DMatrix<f64>, pole: Complex<f64>) -> Option<DVector<Complex<f64>>> {
    let n = f.nrows();
    // Next to the pole, so that the matrix is not singular, and squares of the solution are in range.
    let near = pole + Complex::new((1e-13 * f.norm()).max(1e-140), 0.0);
    let shifted = DMatrix::from_fn(n, n, |i, j| {
        Complex::new(f[(i, j)], 0.0) - if i == j { near } else { Complex::new(0.0, 0.0) }
    });
    let factored = shifted.lu();
    // No eigenvector is orthogonal to all of these for long: each step multiplies its share by 1e13.
    let mut vector = DVector::from_fn(n, |i, _| Complex::new(1.0 + 0.1 * i as f64, 0.0));
    for _ in 0..4 {
        vector = factored.solve(&vector)?;
        let size = vector.norm();
        if !(size.is_finite() && size > 0.0) {
            return None;
        }
        vector /= Complex::new(size, 0.0);
    }
    // The largest entry is real: one vector for each pole.
    let largest = vector.iter().copied().max_by(|x, y| x.norm().total_cmp(&y.norm()))?;
    let turned = largest.conj() / Complex::new(largest.norm(), 0.0);
    Some(vector * turned)
}
