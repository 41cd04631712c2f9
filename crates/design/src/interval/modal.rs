//! Modal coordinates: real eigenvectors, with a block of two for a complex pair.

use luenberger_linalg::eigenvalues;
use luenberger_proof::statement::TimeDomain;
use nalgebra::{Complex, DMatrix, DVector};

use crate::error::DesignError;
use crate::lyapunov_choice::coordinates as units_of;

/// The least distance of two poles, relative to the norm of F, of which eigenvectors are computed.
pub(crate) const DISTINCT: f64 = 1e-7;

/// T and its blocks: T F T^-1 is block diagonal, with `[a b; -b a]` for the poles `a +- ib`. In the units given, or
/// where they hide the poles in balanced ones.
///
/// # Errors
/// [`DesignError::NoModalCoordinates`] for poles that are not distinct, [`DesignError::DependentModes`] for eigenvectors
/// that are nearly dependent.
pub(crate) fn coordinates(time: TimeDomain, f: &DMatrix<f64>) -> Result<(DMatrix<f64>, Vec<usize>), DesignError> {
    let mut found = in_units(f);
    for units in units_of(time, f) {
        if found.is_ok() {
            break;
        }
        // With x = D z, z being modal in T~ z: T = T~ D^-1.
        let balanced = in_units(&units.similar(f));
        found = balanced.map(|(t, blocks)| (units.outputs_back(&t), blocks));
    }
    found
}

/// [`coordinates`] in the units given.
pub(crate) fn in_units(f: &DMatrix<f64>) -> Result<(DMatrix<f64>, Vec<usize>), DesignError> {
    let n = f.nrows();
    let mut poles = eigenvalues(f)?;
    let separation = separation(&poles);
    if n > 1 && separation <= DISTINCT * f.norm() {
        return Err(DesignError::NoModalCoordinates { separation });
    }
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
        Some(t) if t.iter().all(|x| x.is_finite()) => Ok((t, blocks)),
        _ => Err(dependent(&vectors)),
    }
}

/// No modal coordinates, for the condition of T or of its inverse.
pub(super) fn dependent(t: &DMatrix<f64>) -> DesignError {
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
    // Next to the pole, so that the matrix is not singular.
    let near = pole + Complex::new(1e-13 * (1.0 + pole.norm()), 0.0);
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
