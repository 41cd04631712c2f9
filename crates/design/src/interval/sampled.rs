//! The sampled interval observer: its entries, rounding included, and what is proved of the step that runs.

use luenberger_linalg::{RealMatrixView, spectral_radius};
use luenberger_lmi::{dynamic_matrix, proof_matrix};
use luenberger_observers::{SampledIntervalGains, SampledIntervalObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{Certificate, IntervalCoordinates, SampledIntervalEnclosure};
use luenberger_proof::statement::{BlockCoordinates, Format, SampledIntervals, TimeDomain, held_plant};
use luenberger_proof::{Interval, Matrix, Ring};
use nalgebra::{DMatrix, DVector, Dyn};

use super::{ErrorCoordinates, chosen, limit_of, positive_solution, times_up};
use crate::certificate::certified;
use crate::check;
use crate::error::DesignError;
use crate::error_bound::DisturbanceBounds;
use crate::modal;

certified!(SampledIntervalDesign);

/// A sampled interval observer with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct SampledIntervalDesign {
    /// The observer, with the numbers of its format.
    pub observer: SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn>,
    /// T, n x n.
    pub t: DMatrix<f64>,
    /// The numbers of entries of its blocks.
    pub blocks: Vec<usize>,
    /// Upper bounds of the norms of the columns of T, block by block: rho covers a box of half-widths w if it is at
    /// least this times w, and at least the constant of the step.
    pub state_norms: DMatrix<f64>,
    /// The factor by which rho approaches its limit at each step.
    pub factor: f64,
    /// The half-widths for k to infinity, n entries, valid while |xhat| and |u| are within the given bounds.
    pub widths: Vec<f64>,
    /// The certificate.
    pub certificate: Certificate,
}

/// Initial error, ranges of estimates and inputs, and format of a sampled interval observer.
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalRequirements {
    /// Bounds of the initial error `|x_i(0) - xhat_i(0)|`, n entries.
    pub initial_error: Vec<f64>,
    /// Bounds of |xhat_i| that are assumed for [`widths`](SampledIntervalDesign::widths), n entries.
    pub estimates: Vec<f64>,
    /// Bounds of |u_i| that are assumed for [`widths`](SampledIntervalDesign::widths), m entries.
    pub inputs: Vec<f64>,
    /// The format of the step, binary32 or binary64.
    pub format: Format,
}

/// A plant `x+ = A x + B u + E w`, `y = C x + v`, A and B between bounds.
struct Plant {
    a: Matrix<Interval>,
    b: Matrix<Interval>,
    c: DMatrix<f64>,
    e: Matrix<f64>,
    disturbances: Vec<f64>,
    noise: Vec<f64>,
}

/// E with the bounds of w, and those of the noise of each output.
struct Acting {
    e: Matrix<f64>,
    disturbances: Vec<f64>,
    noise: Vec<f64>,
}

impl Acting {
    fn of(all: &DisturbanceBounds, plant: &StateSpace) -> Result<Self, DesignError> {
        all.check_shapes((plant.a.nrows(), plant.c.nrows()))?;
        let acts = |m: &DMatrix<f64>, j: usize| m.column(j).iter().any(|entry| *entry != 0.0);
        let columns = |chosen: &dyn Fn(usize) -> bool| (0..all.bounds.len()).filter(|j| chosen(*j)).collect::<Vec<_>>();
        let of_states = columns(&|j| acts(&all.e, j) || !acts(&all.d, j));
        let of_outputs = columns(&|j| acts(&all.d, j));
        let bounds = |columns: &[usize]| columns.iter().map(|&j| all.bounds[j]).collect::<Vec<_>>();
        let disturbances = bounds(&of_states);
        check::not_negative("the bound of a disturbance", &disturbances)?;
        check::not_negative("the bound of the noise of an output", &bounds(&of_outputs))?;
        // |D| W rounded up; a factor of 1 is exact.
        let term = |i: usize, j: usize| match all.d[(i, j)].abs() {
            1.0 => Interval::of(all.bounds[j]),
            d => Interval::of(d).mul(&Interval::of(all.bounds[j])),
        };
        let sum = |i| of_outputs.iter().fold(Interval::of(0.0), |sum, &j| sum.add(&term(i, j))).hi();
        let noise = (0..all.d.nrows()).map(sum).collect();
        Ok(Self { e: proof_matrix(&all.e.select_columns(&of_states)), disturbances, noise })
    }
}

impl SampledIntervalDesign {
    /// For `x' = A x + B u + E w`, `y = C x + v` with u held over `period` and any w(t) and v within their bounds, with
    /// the gain `l` of the sampled plant. `disturbances` as in [`of_discrete`](Self::of_discrete).
    ///
    /// # Errors
    /// As [`of_discrete`](Self::of_discrete), and [`DesignError::Exponential`] where `exp(A period)` is too large to be
    /// enclosed.
    pub fn sampled<'a>(
        plant: &StateSpace,
        period: f64,
        l: impl Into<RealMatrixView<'a>>,
        disturbances: &DisturbanceBounds,
        coordinates: ErrorCoordinates,
        required: &IntervalRequirements,
    ) -> Result<Self, DesignError> {
        check::positive("the sampling period h", period)?;
        let Acting { e, disturbances, noise } = Acting::of(disturbances, plant)?;
        let (a, b) = (proof_matrix(&plant.a), proof_matrix(&plant.b));
        let Some(held) = held_plant((&a, &b), (&e, &disturbances), period)? else {
            return Err(DesignError::Exponential { period });
        };
        let plant =
            Plant { a: held.a, b: held.b, c: plant.c.clone(), e: held.e, disturbances: held.disturbances, noise };
        Self::of(&plant, &check::owned(l), coordinates, period, required)
    }

    /// For `x+ = A x + B u + E w`, `y = C x + v` with these matrices and the gain `l`.
    ///
    /// A disturbance that acts on states and outputs counts as two independent ones.
    ///
    /// ```
    /// use luenberger_design::{DisturbanceBounds, ErrorCoordinates, IntervalRequirements, SampledIntervalDesign};
    /// use luenberger_observers::SampledObserver;
    /// use luenberger_plants::StateSpace;
    /// use luenberger_proof::statement::Format;
    /// use nalgebra::{DVector, dmatrix};
    /// // Every 0.1 s a position with noise up to 0.01, an unknown change of velocity up to 0.002.
    /// let plant = StateSpace::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0])?;
    /// let (initial_error, estimates, inputs) = (vec![1.0; 2], vec![10.0; 2], vec![1.0]);
    /// let required = IntervalRequirements { initial_error, estimates, inputs, format: Format::Binary32 };
    /// let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![0.0; 1.0], &[0.002], &[0.01]);
    /// let (l, modal) = (dmatrix![0.9; 2.0], ErrorCoordinates::Modal);
    /// let design = SampledIntervalDesign::of_discrete(&plant, 0.1, &l, &acting, modal, &required)?;
    /// assert!(design.certificate.is_proved(), "{}", design.certificate);
    /// let mut state = design.observer.initial(0.0, &DVector::zeros(2), &DVector::zeros(1), &DVector::zeros(1));
    /// for _ in 0..100 {
    ///     design.observer.step(0.0, &mut state, &DVector::zeros(1), &DVector::from_element(1, 0.01));
    /// }
    /// let r = design.observer.half_widths(state.as_slice());
    /// // By hand, without rounding: 0.018/0.4 + 0.027/0.5 = 0.099. The certificate counts |xhat| = 10.
    /// assert!(r[0] > 0.099 && r[0] < 0.0992 && r[0] <= design.widths[0] && design.widths[0] < 0.11);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::NoModalCoordinates`], [`DesignError::WidthGrows`], [`DesignError::NotStored`] for entries of C
    /// that the format has not, errors of shapes.
    pub fn of_discrete<'a>(
        plant: &StateSpace,
        period: f64,
        l: impl Into<RealMatrixView<'a>>,
        disturbances: &DisturbanceBounds,
        coordinates: ErrorCoordinates,
        required: &IntervalRequirements,
    ) -> Result<Self, DesignError> {
        let Acting { e, disturbances, noise } = Acting::of(disturbances, plant)?;
        let points = |m: &DMatrix<f64>| proof_matrix(m).map(|x| Interval::of(*x));
        let plant = Plant { a: points(&plant.a), b: points(&plant.b), c: plant.c.clone(), e, disturbances, noise };
        Self::of(&plant, &check::owned(l), coordinates, period, required)
    }

    fn of(
        plant: &Plant,
        l: &DMatrix<f64>,
        coordinates: ErrorCoordinates,
        period: f64,
        required: &IntervalRequirements,
    ) -> Result<Self, DesignError> {
        let format = required.format;
        check::not_negative("a half-width of x(0)", &required.initial_error)?;
        let middle = |m: &Matrix<Interval>| rounded(&dynamic_matrix(&m.map(Interval::midpoint)), format);
        let (f, g) = (middle(&plant.a)?, middle(&plant.b)?);
        let l = rounded(l, format)?;
        if let Some(x) = plant.c.iter().find(|x| format.round(**x) != Some(**x)) {
            return Err(DesignError::NotStored { what: "an entry of C", value: *x, format });
        }
        let flow = &f - &l * &plant.c;
        let (t, blocks) = chosen(TimeDomain::Discrete, &flow, coordinates)?;
        let Some(known) = BlockCoordinates::new(&proof_matrix(&t), &blocks)? else {
            return Err(modal::dependent(&t));
        };
        let (proof_c, proof_f, proof_g, proof_l) =
            (proof_matrix(&plant.c), proof_matrix(&f), proof_matrix(&g), proof_matrix(&l));
        let step = SampledIntervals {
            a: &plant.a,
            b: &plant.b,
            c: &proof_c,
            e: &plant.e,
            f: &proof_f,
            g: &proof_g,
            l: &proof_l,
            disturbances: &plant.disturbances,
            noise: &plant.noise,
            format,
        };
        let least = step.bounds(&known)?;
        let eps = least.eps;
        let stored = |m: &Matrix<f64>| raised(&dynamic_matrix(m), eps, format);
        let (n, q, u, h) = (stored(&least.n)?, stored(&least.q)?, stored(&least.u)?, stored(&least.h)?);
        let mut constant = stored(&least.g)?;
        let small = 4.0 * least.count as f64 * smallest(format) / eps;
        // Products of H and g do not vanish.
        let needed = h.row_iter().fold(0.0_f64, |needed, row| needed.max(small / row.max()));
        constant.iter_mut().for_each(|g| *g = g.max(raised_number(needed, eps, format).unwrap_or(*g)));
        let radius = spectral_radius(&n)?;
        let grown = DMatrix::identity(n.nrows(), n.nrows()) - &n * (1.0 + 4.0 * eps);
        if radius * (1.0 + 4.0 * eps) >= 1.0 {
            let plant = coordinates == ErrorCoordinates::Plant;
            return Err(DesignError::WidthGrows { size: radius, limit: 1.0, plant });
        }
        let factor = 1.0 - 0.99 * (1.0 - radius * (1.0 + 4.0 * eps));
        let s = positive_solution(&(DMatrix::identity(n.nrows(), n.nrows()) * factor - &n * (1.0 + 2.0 * eps)))?;
        let forced =
            times_up(&q, &required.estimates).into_iter().zip(times_up(&u, &required.inputs)).zip(constant.iter());
        let tiny = 2.0 * least_number(format);
        let forced: Vec<f64> = forced.map(|((x, u), g)| (x + u + g) * (1.0 + 2.0 * eps) + tiny).collect();
        let limit = limit_of(&grown, &forced, &s)?;
        let outward = raised_number(eps, eps, format).unwrap_or(eps);
        let widths = times_up(&h, &limit).into_iter().zip(&required.estimates);
        let widths: Vec<f64> = widths.map(|(w, x)| (w + 2.0 * outward * x) * (1.0 + 2.0 * eps) + tiny).collect();
        let state_norms = dynamic_matrix(&known.state_norms());
        let start = times_up(&state_norms, &required.initial_error).into_iter().zip(constant.iter());
        let start: Option<Vec<f64>> = start.map(|(rho, g)| raised_number(rho.max(*g), eps, format)).collect();
        let start =
            start.ok_or(DesignError::NotStored { what: "a bound of the first error", value: f64::INFINITY, format })?;
        let (a, b) = SampledIntervalEnclosure::plant(&plant.a, &plant.b)?;
        let theorem = SampledIntervalEnclosure {
            a,
            b,
            c: proof_c,
            e: plant.e.clone(),
            f: proof_f,
            input: proof_g,
            l: proof_l,
            coordinates: IntervalCoordinates { t: proof_matrix(&t), blocks: blocks.clone() },
            format,
            n: proof_matrix(&n),
            g: constant.as_slice().to_vec(),
            q: proof_matrix(&q),
            u: proof_matrix(&u),
            h: proof_matrix(&h),
            outward,
            s,
            factor,
            disturbances: plant.disturbances.clone(),
            noise: plant.noise.clone(),
            estimates: required.estimates.clone(),
            inputs: required.inputs.clone(),
            limit,
            widths: widths.clone(),
        };
        let gains = SampledIntervalGains {
            f,
            g,
            c: plant.c.clone(),
            l,
            blocks: n,
            constant: DVector::from_column_slice(constant.as_slice()),
            of_estimate: q,
            of_input: u,
            h,
            outward,
            start: DVector::from_vec(start),
            period,
        };
        let observer = SampledIntervalObserver::new(gains)?;
        Ok(Self { observer, t, blocks, state_norms, factor, widths, certificate: Certificate::of([theorem])? })
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.l()
    }
}

/// The numbers of the format nearest to these.
fn rounded(m: &DMatrix<f64>, format: Format) -> Result<DMatrix<f64>, DesignError> {
    match m.iter().find(|x| format.round(**x).is_none()) {
        Some(x) => Err(DesignError::NotStored { what: "an entry of A, B or L", value: *x, format }),
        None => Ok(m.map(|x| format.round(x).unwrap_or(x))),
    }
}

/// A number of the format that is at least `x/(1 - eps)`.
fn raised_number(x: f64, eps: f64, format: Format) -> Option<f64> {
    let wanted = (x * (1.0 + 4.0 * eps)).next_up();
    if x == 0.0 {
        return Some(0.0);
    }
    let near = format.round(wanted)?;
    if near >= wanted {
        return Some(near);
    }
    match format {
        Format::Binary32 => {
            let next = f64::from((near as f32).next_up());
            next.is_finite().then_some(next)
        }
        _ => Some(near.next_up()),
    }
}

fn raised(m: &DMatrix<f64>, eps: f64, format: Format) -> Result<DMatrix<f64>, DesignError> {
    let mut raised = m.clone();
    for x in &mut raised {
        *x = raised_number(*x, eps, format).ok_or(DesignError::NotStored {
            what: "a coefficient of the half-widths",
            value: *x,
            format,
        })?;
    }
    Ok(raised)
}

fn smallest(format: Format) -> f64 {
    if format == Format::Binary32 { 2f64.powi(-149) } else { f64::from_bits(1) }
}

fn least_number(format: Format) -> f64 {
    if format == Format::Binary32 { 2f64.powi(-110) } else { 2f64.powi(-1000) }
}
