//! Verified refutation of injectivity: two states with the same image under Phi = (phi, h).
//!
//! Floating point finds pairs whose images are close; that is not a proof, since `2^-27 x` is injective. A common image
//! is proved in one of two ways:
//! - **By a symmetry.** Phi is collected at x and at sigma x, for sigma the change of some signs or the exchange of two
//!   coordinates, and the difference is the polynomial without terms. Both states are then binary64 numbers, and their
//!   images are equal exactly. This is how an overdetermined Phi is refuted.
//! - **By a box that holds a solution.** Let r of the rows of Phi be such that the others are affine combinations of
//!   them, exactly (rows of the collected form with exact coefficients, by elimination without division). If `r <= n`,
//!   r coordinates of z are solved for in `Phi(z) = Phi(x)` beside the others, which are fixed: with Y about the
//!   inverse of the Jacobian, Krawczyk's `K(Z) = z - Y (Phi(z) - Phi(x)) + (I - Y J(Z)) (Z - z)` in the interior of Z
//!   shows that Z holds a solution, and x is not in Z.
//!
//! Otherwise the question is undecided: for an overdetermined Phi without such a symmetry, such as `(sin x, cos x)`
//! over more than a period; for solutions at which the Jacobian is singular; for maps without a collected form that
//! have more rows than states.
//!
//! Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, SIAM 2009, section 8.2.

use std::collections::BTreeMap;

use luenberger_proof::{Exact, Interval, Ring};
use nalgebra::{DMatrix, DVector};

use super::candidate::Pieces;
use super::images::Images;
use super::witness::CommonImage;
use crate::enclosure::IntervalDual;
use crate::symbolic_polynomial::{Arena, Monomial, Polynomial, SymbolicPolynomial, collect, is_exact};

/// Rows that are reduced exactly; numbers double their length with each.
const EXACT_ROWS: usize = 8;

/// Up to so many coordinates all changes of sign are tried.
const SIGNS: usize = 6;

/// Newton steps from a pair that floating point found.
const STEPS: usize = 8;

/// How often the box around a solution is widened.
const WIDENINGS: usize = 6;

/// The collected form of Phi, and the rows of which the others are affine combinations.
pub(super) struct Form {
    arena: Arena,
    rows: Vec<usize>,
}

impl Form {
    /// Of the candidate; none where Phi has no polynomials, as where it may choose between branches.
    pub(super) fn of<C: Pieces<SymbolicPolynomial>>(candidate: &C) -> Option<Self> {
        let size = candidate.plant_dimensions();
        let (states, time) = (size.states, size.states + size.inputs);
        let (image, arena) = collect(|| {
            let x: Vec<SymbolicPolynomial> = (0..states).map(SymbolicPolynomial::variable).collect();
            image(candidate, SymbolicPolynomial::variable(time), &x)
        })
        .ok()?;
        let image = arena.polynomials(&image).ok()?;
        Some(Self { rows: independent(&image), arena })
    }
}

fn image<C: Pieces<SymbolicPolynomial>>(
    candidate: &C,
    t: SymbolicPolynomial,
    x: &[SymbolicPolynomial],
) -> Vec<SymbolicPolynomial> {
    let y = candidate.output(t, x);
    let mut image = candidate.image(t, x, &y);
    image.extend(y);
    image
}

/// Rows of which the others are affine combinations, wherever they are defined.
fn independent(rows: &[Polynomial]) -> Vec<usize> {
    let mut reduced: Vec<(Monomial, BTreeMap<Monomial, Exact>)> = Vec::new();
    let mut kept = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        if !is_exact(row) || reduced.len() >= EXACT_ROWS {
            kept.push(i);
            continue;
        }
        let terms = row.iter().filter(|(monomial, _)| !monomial.is_empty());
        let mut rest: BTreeMap<Monomial, Exact> =
            terms.filter_map(|(monomial, x)| Some((monomial.clone(), Exact::from_f64(x.lo())?))).collect();
        for (pivot, other) in &reduced {
            let (Some(factor), Some(leading)) = (rest.get(pivot).cloned(), other.get(pivot)) else { continue };
            let mut next: BTreeMap<Monomial, Exact> = rest.iter().map(|(m, x)| (m.clone(), x.mul(leading))).collect();
            for (monomial, x) in other {
                let entry = next.entry(monomial.clone()).or_insert_with(Exact::zero);
                *entry = entry.sub(&x.mul(&factor));
            }
            next.retain(|_, x| !x.is_zero());
            rest = next;
        }
        if let Some(pivot) = rest.keys().next().cloned() {
            kept.push(i);
            reduced.push((pivot, rest));
        }
    }
    kept
}

/// Two states of the box `axes` (states, inputs, time) that a symmetry of Phi maps to each other. The first is one of
/// `points`.
pub(super) fn by_symmetry<C: Pieces<SymbolicPolynomial>>(
    candidate: &C,
    (points, axes): (&[Vec<Interval>], &[Interval]),
) -> Option<CommonImage> {
    let size = candidate.plant_dimensions();
    let (n, time) = (size.states, size.states + size.inputs);
    let varying: Vec<usize> = (0..n).filter(|&k| !axes[k].is_point()).collect();
    let signs = (1..1usize << varying.len().min(SIGNS)).map(|which| {
        let negative =
            |k: usize| varying.iter().position(|v| *v == k).is_some_and(|bit| bit < SIGNS && which >> bit & 1 == 1);
        (0..n).map(|k| (k, negative(k))).collect::<Vec<_>>()
    });
    let exchanges =
        varying.iter().flat_map(|&i| varying.iter().map(move |&j| (i, j))).filter(|(i, j)| i < j).map(|(i, j)| {
            (0..n)
                .map(|k| {
                    (
                        if k == i {
                            j
                        } else if k == j {
                            i
                        } else {
                            k
                        },
                        false,
                    )
                })
                .collect::<Vec<_>>()
        });
    signs.chain(exchanges).find_map(|sigma| {
        let (difference, arena) = collect(|| {
            let t = SymbolicPolynomial::variable(time);
            let x: Vec<SymbolicPolynomial> = (0..n).map(SymbolicPolynomial::variable).collect();
            let other: Vec<SymbolicPolynomial> =
                sigma.iter().map(|&(k, negative)| if negative { -x[k] } else { x[k] }).collect();
            let (first, second) = (image(candidate, t, &x), image(candidate, t, &other));
            first.iter().zip(&second).map(|(first, second)| *first - *second).collect::<Vec<_>>()
        })
        .ok()?;
        if arena.polynomials(&difference).ok()?.iter().any(|row| !row.is_empty()) {
            return None;
        }
        points.iter().find_map(|point| {
            let second: Vec<Interval> =
                sigma.iter().map(|&(k, negative)| if negative { point[k].neg() } else { point[k] }).collect();
            let inside = second.iter().zip(axes).all(|(x, axis)| axis.contains(x.lo()));
            let differs = second.iter().zip(point).any(|(x, other)| x.lo() != other.lo());
            // Equal wherever all of it is defined.
            (inside && differs && arena.atoms_over(point).is_some())
                .then(|| CommonImage { first: point[..n].iter().map(Interval::lo).collect(), second })
        })
    })
}

/// A state of the box near z with the image of x.
pub(super) fn by_box<C: Pieces<IntervalDual>>(
    images: &Images<'_, C>,
    form: Option<&Form>,
    (x, z): (&DVector<f64>, &DVector<f64>),
    (time, axes): (f64, &[Interval]),
) -> Option<CommonImage> {
    let all: Vec<usize> = (0..images.rows()).collect();
    let rows = form.map_or(&all, |form| &form.rows);
    let varying: Vec<usize> = (0..x.len()).filter(|&k| !axes[k].is_point()).collect();
    if rows.len() > varying.len() {
        return None;
    }
    let points = |x: &DVector<f64>| x.iter().map(|x| Interval::from_f64(*x)).collect::<Option<Vec<_>>>();
    // Where the rows left out are combinations of these: where everything is defined.
    let defined = |state: &[Interval]| {
        form.is_none_or(|form| {
            let variables: Vec<Interval> =
                state.iter().copied().chain(axes[x.len()..axes.len() - 1].iter().copied()).collect();
            form.arena.atoms_over(&[variables, vec![Interval::of(time)]].concat()).is_some()
        })
    };
    let first = points(x)?;
    let target = images.over(time, &first, None)?;
    let gap = |z: &[Interval]| -> Option<Vec<Interval>> {
        let image = images.over(time, z, None)?;
        Some(rows.iter().map(|&i| image[i].value().sub(&target[i].value())).collect())
    };
    let jacobian = |z: &[Interval], columns: &[usize]| -> Option<Vec<Vec<Interval>>> {
        columns
            .iter()
            .map(|&k| {
                Some(images.over(time, z, Some(k))?).map(|image| rows.iter().map(|&i| image[i].slope()).collect())
            })
            .collect()
    };
    let middle = Interval::midpoint;
    let middles =
        |columns: &[Vec<Interval>]| DMatrix::from_fn(rows.len(), columns.len(), |i, j| middle(&columns[j][i]));
    let mut z = z.clone();
    let half = |k: usize| 0.5 * axes[k].width();
    let scaled = {
        let mut whole = middles(&jacobian(&points(&z)?, &varying)?);
        for (mut column, &k) in whole.column_iter_mut().zip(&varying) {
            column *= half(k);
        }
        whole
    };
    let columns: Vec<usize> = independent_columns(scaled)?.into_iter().map(|k| varying[k]).collect();
    // Where it is solved for nothing, z itself is the other state.
    let mut inverse = DMatrix::zeros(0, 0);
    for _ in 0..if columns.is_empty() { 0 } else { STEPS } {
        let state = points(&z)?;
        inverse = middles(&jacobian(&state, &columns)?).try_inverse()?;
        let step = &inverse * DVector::from_vec(gap(&state)?.iter().map(middle).collect());
        let mut next = z.clone();
        for (&k, step) in columns.iter().zip(&step) {
            next[k] -= step;
        }
        let moved = columns.iter().any(|&k| (next[k] - z[k]).abs() > 4.0 * f64::EPSILON * half(k));
        z = next;
        if !moved {
            break;
        }
    }
    let centre = points(&z)?;
    let missed = gap(&centre)?;
    // Y F(z), whose size is that of the box to begin with.
    let times = |matrix: &DMatrix<f64>, i: usize, v: &[Interval]| {
        v.iter().enumerate().fold(Interval::zero(), |sum, (k, v)| sum.add(&Interval::of(matrix[(i, k)]).mul(v)))
    };
    let newton: Vec<Interval> = (0..columns.len()).map(|i| times(&inverse, i, &missed)).collect();
    let mut radius: Vec<f64> = columns
        .iter()
        .zip(&newton)
        .map(|(&k, step)| 2.0 * step.magnitude() + 8.0 * f64::EPSILON * half(k).max(z[k].abs()))
        .collect();
    for _ in 0..WIDENINGS {
        let mut state = centre.clone();
        for (&k, radius) in columns.iter().zip(&radius) {
            state[k] = Interval::around(z[k], *radius)?;
        }
        let inside = state.iter().zip(axes).all(|(x, axis)| axis.lo() <= x.lo() && x.hi() <= axis.hi());
        let differs = state.iter().zip(x).any(|(state, x)| !state.contains(*x));
        if !(inside && differs && defined(&first) && defined(&state)) {
            return None;
        }
        let slopes = jacobian(&state, &columns)?;
        let contracts = (0..columns.len()).all(|i| {
            let shift = columns.iter().enumerate().fold(newton[i].neg(), |sum, (j, &k)| {
                let product = times(&inverse, i, &slopes[j]);
                let unit = if i == j { Interval::ONE } else { Interval::zero() };
                sum.add(&unit.sub(&product).mul(&state[k].sub(&centre[k])))
            });
            let (k, image) = (columns[i], centre[columns[i]].add(&shift));
            state[k].lo() < image.lo() && image.hi() < state[k].hi()
        });
        // Without unknowns the rows are constant: nothing is left to show.
        if contracts {
            return Some(CommonImage { first: x.iter().copied().collect(), second: state });
        }
        for radius in &mut radius {
            *radius *= 4.0;
        }
    }
    None
}

/// As many columns as there are rows, by pivoted orthogonalization; none where they do not span.
fn independent_columns(mut matrix: DMatrix<f64>) -> Option<Vec<usize>> {
    let mut chosen = Vec::with_capacity(matrix.nrows());
    for _ in 0..matrix.nrows() {
        let norm = |k: &usize| matrix.column(*k).norm();
        let best = (0..matrix.ncols()).max_by(|i, j| norm(i).total_cmp(&norm(j)))?;
        let length = norm(&best);
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let direction = matrix.column(best) / length;
        let shares = direction.transpose() * &matrix;
        matrix -= &direction * shares;
        matrix.column_mut(best).fill(0.0);
        chosen.push(best);
    }
    Some(chosen)
}
