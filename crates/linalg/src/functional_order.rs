//! Functional observers of least order: the rows of K with further ones, so that Darouach's conditions hold.
//!
//! An observer of `z = K x` of order q exists iff there is an R for which `[K; R]`, q rows, has one of its own order
//! (T. Fernando, H. Trinh and L. Jennings, IEEE TAC 55, 2010). The conditions are about `V = rows [C; K; R]` alone: the
//! first is `V A` within `V + rows (C A)`, and larger V are found in two ways.
//!
//! - *One function.* With the characteristic polynomial p of F there is an observer of order q iff `K p(A)` is a
//!   combination of the rows of `C, C A, .., C A^q`: this follows from `T A - F T = G C` and `p(F) = 0`, and the
//!   combination gives T, row by row (Luenberger, IEEE TAC 11, 1966). The first q for which it holds is the least one.
//!   For several functions, the rows that each needs are taken together.
//! - *By rates.* What is missing of the rates of `[K; R]` is added to R until nothing is missing; if an eigenvalue is
//!   fixed then, rows of C A are added.
//!
//! Where the observer exists for the whole state, V ends there: the order is n - rank(C) at most.

use nalgebra::{Complex, DMatrix, RowDVector};

use crate::argument::{RealMatrixView, owned, shaped};
use crate::functional_observer::{FunctionalObserver, Matrices, Singular, functional};
use crate::observability::{check, default_tolerance};
use crate::placement::place_observer;
use crate::units::{Units, shift};
use crate::{LinalgError, Result};

/// An observer of `z = K x`, of the least order that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastFunctionalObserver {
    /// The observer of all functions, M the identity.
    pub observer: FunctionalObserver,
    /// K with further rows below it, q x n.
    pub functions: DMatrix<f64>,
    /// Whether to working precision no observer of a lower order has the first poles given: decided for one function,
    /// unless an order would separate a pair; for several functions of the order `rank [C; K] - rank(C)` and the next.
    pub is_least: bool,
}

/// Observer of `z = K x` of least order, with the first ones of `poles` as the eigenvalues of F.
///
/// `a` is n x n, `b` n x m, `c` p x n, `k` r x n; `poles` are at least as many as the order, real or complex,
/// conjugates beside each other. Orders that would separate two of them are passed over. With n - rank(C) poles there
/// is an observer if the pair is observable.
///
/// # Errors
/// Those of [`functional_observer`](crate::functional_observer()) for the order r, if no larger one within the number
/// of poles exists.
///
/// # Cost
/// Singular value decompositions of up to `p (q + 1)` rows for each order q, and a placement of each order tried.
///
/// # Example
/// ```
/// use luenberger_linalg::least_functional_observer;
/// use nalgebra::dmatrix;
///
/// // A chain of three, y = x1, z = x2 + 2 x3: its rate x3 is missing, and x3 has the rate 0.
/// let a = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, 0.0];
/// let (b, c, k) = (dmatrix![0.0; 0.0; 1.0], dmatrix![1.0, 0.0, 0.0], dmatrix![0.0, 1.0, 2.0]);
/// let found = least_functional_observer(&a, &b, &c, &k, &[-3.0, -4.0])?;
/// println!("order {}, residual {:e}", found.observer.f.nrows(), found.observer.residual);
/// assert!(found.functions.nrows() == 2 && found.is_least && found.observer.residual < 1e-13);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: the head of the module.
pub fn least_functional_observer<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    k: impl Into<RealMatrixView<'a>>,
    poles: &[impl Into<Complex<f64>> + Copy],
) -> Result<LeastFunctionalObserver> {
    let poles: Vec<Complex<f64>> = poles.iter().map(|&pole| pole.into()).collect();
    least((&owned(a), &owned(b), &owned(c)), &owned(k), &poles)
}

fn least(
    (a, b, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    k: &DMatrix<f64>,
    poles: &[Complex<f64>],
) -> Result<LeastFunctionalObserver> {
    check(a, c)?;
    let (n, r) = (a.nrows(), k.nrows());
    shaped("K", k, r, n)?;
    if r == 0 {
        return Err(LinalgError::Empty { what: "K" });
    }
    if let Some(index) = poles.iter().position(|pole| !(pole.re.is_finite() && pole.im.is_finite())) {
        return Err(LinalgError::PoleNotFinite { index, pole: poles[index] });
    }
    if poles.len() < r {
        return Err(LinalgError::PoleCount { order: r, found: poles.len() });
    }
    let search = Search::of(a, c, k, poles)?;
    let found = if r == 1 { of_one(&search, (a, b, c), k)? } else { of_several(&search, (a, b, c), k)? };
    found.map_err(|refusal| refusal.unwrap_or(LinalgError::PoleCount { order: r, found: poles.len() }))
}

/// An observer, or the first refusal.
type Found = std::result::Result<LeastFunctionalObserver, Option<LinalgError>>;

/// What says that there is no observer of this order.
fn is_refusal(error: &LinalgError) -> bool {
    matches!(error, LinalgError::NotFunctional { .. } | LinalgError::FixedObserverMode { .. })
}

/// By polynomials, one order after the other.
fn of_one(
    search: &Search,
    (a, b, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    k: &DMatrix<f64>,
) -> Result<Found> {
    let (mut refusal, mut is_least) = (None, search.own_order == 1);
    for order in 1..=search.given.len() {
        let Some(first) = first_ones(&search.given, order) else {
            is_least = false;
            continue;
        };
        let Some(rows) = search.of_order(&search.k.row(0).into_owned(), order)? else {
            if order == 1 {
                refusal = functional(a, b, c, k, first).err().filter(is_refusal);
            }
            continue;
        };
        if order == 1 {
            match functional(a, b, c, k, first) {
                Ok(observer) => {
                    return Ok(Ok(LeastFunctionalObserver { observer, functions: k.clone(), is_least }));
                }
                Err(error) if is_refusal(&error) => {}
                Err(error) => return Err(error),
            }
        }
        let (observer, functions) = search.observer(&rows, b)?;
        return Ok(Ok(LeastFunctionalObserver { observer, functions, is_least }));
    }
    Ok(Err(refusal))
}

/// By what is missing, for all functions together.
fn of_several(
    search: &Search,
    (a, b, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    k: &DMatrix<f64>,
) -> Result<Found> {
    let (r, least) = (k.nrows(), search.own_order);
    let mut refusal = None;
    for further in search.candidates()? {
        let order = r + further.nrows();
        let Some(first) = first_ones(&search.given, order) else { continue };
        let functions = stacked(&[k, &search.in_given_units(&further)]);
        match functional(a, b, c, &functions, first) {
            Ok(observer) => {
                let is_least = order <= least || (order == r + 1 && least == r && refusal.is_some());
                return Ok(Ok(LeastFunctionalObserver { observer, functions, is_least }));
            }
            Err(error) if is_refusal(&error) => {
                refusal.get_or_insert(error);
            }
            Err(error) => return Err(error),
        }
    }
    Ok(Err(refusal))
}

/// The first `count` poles, if they are closed under conjugation.
fn first_ones(poles: &[Complex<f64>], count: usize) -> Option<&[Complex<f64>]> {
    let first = poles.get(..count)?;
    let times = |wanted: Complex<f64>| first.iter().filter(|pole| **pole == wanted).count();
    first.iter().all(|pole| times(*pole) == times(pole.conj())).then_some(first)
}

/// These rows below each other.
fn stacked(parts: &[&DMatrix<f64>]) -> DMatrix<f64> {
    let columns = parts.iter().map(|part| part.ncols()).max().unwrap_or(0);
    let mut all = DMatrix::zeros(parts.iter().map(|part| part.nrows()).sum(), columns);
    let mut at = 0;
    for part in parts.iter().filter(|part| part.nrows() > 0) {
        all.rows_mut(at, part.nrows()).copy_from(part);
        at += part.nrows();
    }
    all
}

/// An orthonormal basis of the row space.
fn basis(rows: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    if rows.nrows() == 0 {
        return Ok(rows.clone());
    }
    let split = Singular::of(rows)?;
    Ok(split.v.columns(0, split.rank).transpose())
}

/// An orthonormal basis of what `rows` add to the row space of `of`, a row being rounding below `floor`.
fn outside(of: &DMatrix<f64>, rows: &DMatrix<f64>, floor: f64) -> Result<DMatrix<f64>> {
    let known = basis(of)?;
    let part = rows - rows * known.transpose() * &known;
    // Once more, since a small part has lost its digits.
    let part = &part - &part * known.transpose() * &known;
    let kept: Vec<_> = part.row_iter().filter(|row| row.norm() > floor).map(|row| row / row.norm()).collect();
    if kept.is_empty() { Ok(DMatrix::zeros(0, rows.ncols())) } else { basis(&DMatrix::from_rows(&kept)) }
}

/// The pair and K in units in which they are balanced.
struct Search {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    k: DMatrix<f64>,
    units: Units,
    /// The unit of the first function.
    asked: i32,
    poles: Vec<Complex<f64>>,
    /// The same in the units given.
    given: Vec<Complex<f64>>,
    /// `rank [C; K] - rank(C)`, below which there is no observer.
    own_order: usize,
}

impl Search {
    fn of(a: &DMatrix<f64>, c: &DMatrix<f64>, k: &DMatrix<f64>, poles: &[Complex<f64>]) -> Result<Self> {
        let p = c.nrows();
        let both = stacked(&[c, k]);
        let mut units = Units::of(a, &both);
        let both = units.outputs(&both);
        let asked = units.output.split_off(p)[0];
        let (c, k) = (both.rows(0, p).into_owned(), both.rows(p, k.nrows()).into_owned());
        let own_order = Singular::of(&both)?.rank - Singular::of(&c)?.rank;
        let given = poles.to_vec();
        let poles = poles.iter().map(|s| Complex::new(shift(s.re, -units.time), shift(s.im, -units.time))).collect();
        Ok(Self { a: units.dynamics(a), c, k, units, asked, poles, given, own_order })
    }

    fn floor(&self, size: f64) -> f64 {
        default_tolerance(self.a.nrows(), self.a.nrows() + self.c.nrows()) * size
    }

    /// Rows in the units given, without a unit of their own.
    fn in_given_units(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, j| shift(rows[(i, j)], -self.units.state[j]))
    }

    /// Further rows R, the fewest first; none at first.
    fn candidates(&self) -> Result<Vec<DMatrix<f64>>> {
        let mut all = vec![DMatrix::zeros(0, self.a.nrows())];
        self.by_rates(&mut all)?;
        self.by_polynomials(&mut all)?;
        all.sort_by_key(DMatrix::nrows);
        Ok(all)
    }

    /// What is missing of the rates, and where nothing is, of the rates of the outputs.
    fn by_rates(&self, all: &mut Vec<DMatrix<f64>>) -> Result<()> {
        let (ca, n) = (&self.c * &self.a, self.a.nrows());
        let floor = self.floor(self.a.norm());
        let mut further = DMatrix::zeros(0, n);
        while further.nrows() < n {
            let functions = stacked(&[&self.k, &further]);
            let known = stacked(&[&self.c, &functions]);
            let mut missing = outside(&stacked(&[&known, &ca]), &(&functions * &self.a), floor)?;
            if missing.nrows() == 0 {
                let more = outside(&known, &ca, floor)?;
                missing = more.rows(0, more.nrows().min(1)).into_owned();
            }
            if missing.nrows() == 0 {
                break;
            }
            further = stacked(&[&further, &missing]);
            all.push(further.clone());
        }
        Ok(())
    }

    /// The rows that each function needs by itself, with the first poles, taken together.
    fn by_polynomials(&self, all: &mut Vec<DMatrix<f64>>) -> Result<()> {
        let mut needed = DMatrix::zeros(0, self.a.nrows());
        for row in self.k.row_iter() {
            let row = row.into_owned();
            let Some(rows) = (1..=self.poles.len()).find_map(|order| self.of_order(&row, order).transpose()) else {
                return Ok(());
            };
            needed = stacked(&[&needed, &rows?.t]);
        }
        all.push(outside(&stacked(&[&self.c, &self.k]), &needed, self.floor(1.0))?);
        Ok(())
    }

    /// The rows `t_1, .., t_q` of T for one function and the first q poles, if there are any.
    ///
    /// `(k - N C) p(A) = g_1 C A^(q-1) + .. + g_q C`, `t_1 = k - N C` and `t_(i+1) = t_i A + p_(q-i) t_1 - g_i C`.
    fn of_order(&self, row: &RowDVector<f64>, order: usize) -> Result<Option<Rows>> {
        let Some(poles) = first_ones(&self.poles, order) else { return Ok(None) };
        let p = polynomial(poles);
        let mut powers = vec![self.c.clone()];
        for _ in 0..order {
            let last = &powers[powers.len() - 1];
            powers.push(last * &self.a);
        }
        // x p(A) = x A^q + p_(q-1) x A^(q-1) + ..
        let at = |powers: &[DMatrix<f64>]| {
            powers
                .iter()
                .zip(&p)
                .fold(DMatrix::zeros(powers[0].nrows(), self.a.nrows()), |sum, (power, p)| sum + power * *p)
        };
        let mut of_row = vec![DMatrix::from_rows(std::slice::from_ref(row))];
        for _ in 0..order {
            let last = &of_row[of_row.len() - 1];
            of_row.push(last * &self.a);
        }
        let (wanted, outputs) = (at(&of_row), self.c.nrows());
        let size = of_row.iter().zip(&p).map(|(power, p)| power.norm() * p.abs()).sum::<f64>();
        let mut blocks = vec![at(&powers)];
        blocks.extend(powers[..order].iter().rev().cloned());
        let known = stacked(&blocks.iter().collect::<Vec<_>>());
        let split = Singular::of(&known)?;
        let left = &wanted - (&wanted * split.v.columns(0, split.rank)) * split.v.columns(0, split.rank).transpose();
        if left.norm() > self.floor(size) {
            return Ok(None);
        }
        // wanted = x known.
        let x = DMatrix::from_fn(1, known.nrows(), |_, j| {
            let of = |s: usize| wanted.row(0).dot(&split.v.column(s).transpose()) / split.sigma[s] * split.u[(j, s)];
            (0..split.rank).map(of).sum()
        });
        let injected = |i: usize| x.columns(i * outputs, outputs) * &self.c;
        let first = &of_row[0] - injected(0);
        let mut rows = vec![first.clone()];
        for i in 1..order {
            let last = &rows[i - 1];
            rows.push(last * &self.a + &first * p[order - i] - injected(i));
        }
        let g = DMatrix::from_fn(order, outputs, |i, k| x[(0, (i + 1) * outputs + k)]);
        Ok(Some(Rows { t: stacked(&rows.iter().collect::<Vec<_>>()), n: x.columns(0, outputs).into_owned(), g, p }))
    }

    /// The observer with these rows, F being the companion matrix of p, and its functions `T + N C`.
    fn observer(&self, rows: &Rows, b: &DMatrix<f64>) -> Result<(FunctionalObserver, DMatrix<f64>)> {
        let (Rows { t, g, .. }, order) = (rows, rows.t.nrows());
        let chain = DMatrix::from_fn(order, order, |i, j| if j == i + 1 { 1.0 } else { 0.0 });
        let first = DMatrix::from_fn(1, order, |_, j| if j == 0 { 1.0 } else { 0.0 });
        let f = DMatrix::from_fn(order, order, |i, j| if j == 0 { -rows.p[order - 1 - i] } else { chain[(i, j)] });
        let n = DMatrix::from_fn(order, self.c.nrows(), |i, k| if i == 0 { rows.n[(0, k)] } else { 0.0 });
        let mut functions = t.clone();
        functions.row_mut(0).copy_from(&self.k.row(0));
        let placement = place_observer(&chain, &first, &self.poles[..order])?.in_time(self.units.time);
        let m = DMatrix::identity(order, order);
        let inner = Matrices { t: t.clone(), f, g: g.clone(), m, n };
        let found = inner.in_given_units(
            (&self.a, &self.c),
            &functions,
            (&self.units, &vec![self.asked; order]),
            (b, placement),
        )?;
        let scaled = |i: usize, j: usize| shift(functions[(i, j)], self.asked - self.units.state[j]);
        Ok((found, DMatrix::from_fn(order, t.ncols(), scaled)))
    }
}

/// The rows of T of an observer of one function, N, the rows of G, and p.
struct Rows {
    t: DMatrix<f64>,
    n: DMatrix<f64>,
    g: DMatrix<f64>,
    p: Vec<f64>,
}

/// The coefficients of the polynomial with these zeros, that of `s^k` at k.
fn polynomial(zeros: &[Complex<f64>]) -> Vec<f64> {
    let mut coefficients = vec![Complex::new(1.0, 0.0)];
    for zero in zeros {
        let mut next = vec![Complex::new(0.0, 0.0); coefficients.len() + 1];
        for (k, coefficient) in coefficients.iter().enumerate() {
            next[k + 1] += coefficient;
            next[k] -= coefficient * zero;
        }
        coefficients = next;
    }
    coefficients.into_iter().map(|coefficient| coefficient.re).collect()
}
