//! The verdict on an observer whose gains were changed: the theorems of its certificate files, with the same P, for the
//! gains as they are now. Where that P does not prove a linear observer to converge, another one is tried, the solution
//! of the Lyapunov or Stein equation for these gains; what the file says of a rate is then not said.
//!
//! These theorems are about convergence without noise, for whatever first error. One that a page does not verify can
//! suppose bounds of the noise and of the first error ([`Hypotheses`]): a run beyond them leaves the theorem, with the
//! sliders where they were as well.

use luenberger_proof::Matrix;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{CertificateFile, Datum, DiscreteConvergence, LinearConvergence, Theorem};
use luenberger_proof::wording::{if_at_most, significant};
use nalgebra::{DMatrix, DVector};

use crate::experiment::{Experiment, Hypotheses, Sliders, StoredObserver};
use crate::join::start;

/// What is proved with the gains as they are now.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GainVerdict {
    /// Every inequality, with the smallest positive margin if one has a margin.
    Proved(Option<f64>),
    /// The same with another P than that of the certificate: convergence, without its rate.
    ProvedAnew(Option<f64>),
    /// This is not proved.
    Open(String),
    /// The certificate is one that a page does not verify: its verdict is in the report.
    Elsewhere,
}

/// Whether a page verifies certificates of this theorem.
pub fn verifies(theorem: &Theorem) -> bool {
    scale(&mut theorem.clone(), &Sliders::NEUTRAL)
}

/// The verdicts on the observers of an experiment for the gains as the sliders have them; `None` for an observer
/// without certificate.
pub fn verify(experiment: &Experiment, sliders: &Sliders) -> Vec<Option<GainVerdict>> {
    let sliders = experiment.fitted(sliders);
    experiment.observers.iter().map(|observer| certified(experiment, observer, &sliders)).collect()
}

fn certified(experiment: &Experiment, observer: &StoredObserver, sliders: &Sliders) -> Option<GainVerdict> {
    let Some(files) = &observer.certificates else {
        // The report's verdict is on the gains of the report.
        let is_other_cubic = sliders.cubic != 1.0 && observer.kind.is_cubic();
        let is_other_period = sliders.period != 1.0 && observer.kind.period().is_some();
        if sliders.gain != 1.0 || is_other_cubic || is_other_period {
            return Some(open(OF_DESIGN));
        }
        let left = observer.hypotheses.as_ref().and_then(|of| failed_hypothesis(of, experiment, observer, sliders));
        return Some(left.map_or(GainVerdict::Elsewhere, GainVerdict::Open));
    };
    let (mut least, mut is_other): (Option<f64>, bool) = (None, false);
    for file in files {
        let found = theorem(file, sliders);
        is_other |= matches!(found, GainVerdict::ProvedAnew(_));
        match found {
            GainVerdict::Proved(margin) | GainVerdict::ProvedAnew(margin) => {
                least = [least, margin].into_iter().flatten().reduce(f64::min);
            }
            other => return Some(other),
        }
    }
    let proved = if is_other { GainVerdict::ProvedAnew(least) } else { GainVerdict::Proved(least) };
    (!files.is_empty()).then_some(proved)
}

fn theorem(file: &str, sliders: &Sliders) -> GainVerdict {
    let Ok(file) = CertificateFile::read(file.as_bytes()) else {
        return open("the certificate file cannot be read");
    };
    let mut theorem = file.theorem().clone();
    if sliders.period != 1.0 && !in_continuous_time(&theorem) {
        return open("the certificate is for the sampling period of the design");
    }
    if (sliders.gain, sliders.cubic) != (1.0, 1.0) && !scale(&mut theorem, sliders) {
        return open(OF_DESIGN);
    }
    match decided(&theorem) {
        GainVerdict::Open(why) => match with_another_p(theorem).map(|theorem| decided(&theorem)) {
            Some(GainVerdict::Proved(margin)) => GainVerdict::ProvedAnew(margin),
            _ => GainVerdict::Open(why),
        },
        proved => proved,
    }
}

fn decided(theorem: &Theorem) -> GainVerdict {
    let Ok(facts) = theorem.facts() else {
        return open("the theorem does not accept these gains");
    };
    let margins = facts.iter().filter_map(|fact| match &fact.verdict {
        Verdict::Proved { margin } if *margin > 0.0 => Some(*margin),
        _ => None,
    });
    match facts.iter().find(|fact| !fact.verdict.is_proved()) {
        None => GainVerdict::Proved(margins.reduce(f64::min)),
        Some(fact) => GainVerdict::Open(fact.inequality.clone()),
    }
}

/// The largest order for which another P is computed: its equation has the square of this number of unknowns.
const LARGEST_ORDER: usize = 10;

/// The theorem with the P of the gains as they are now, `F'P + PF + Q = 0` or `F'PF - P + Q = 0` for `F = A - LC`, and
/// without a rate. Q is the diagonal of the P before, so that it does not depend on the units of the states. None for
/// another theorem, and where the equation has no solution in floating point.
fn with_another_p(theorem: Theorem) -> Option<Theorem> {
    let numbers = |m: &Matrix<f64>| DMatrix::from_fn(m.rows(), m.cols(), |i, j| m[(i, j)]);
    let middle = |m: &Matrix<Datum>| {
        DMatrix::from_fn(m.rows(), m.cols(), |i, j| {
            let entry = m[(i, j)].interval();
            f64::midpoint(entry.lo(), entry.hi())
        })
    };
    Some(match theorem {
        Theorem::LinearConvergence(data) => {
            let f = middle(&data.plant.a) - numbers(&data.l) * middle(&data.plant.c);
            let p = another_p(&f, &numbers(&data.p), false)?;
            Theorem::LinearConvergence(LinearConvergence { p, rate: 0.0, ..data })
        }
        Theorem::DiscreteConvergence(data) => {
            let f = numbers(&data.plant.a) - numbers(&data.l) * numbers(&data.plant.c);
            let p = another_p(&f, &numbers(&data.p), true)?;
            Theorem::DiscreteConvergence(DiscreteConvergence { p, factor: None, ..data })
        }
        _ => return None,
    })
}

/// The solution of one of these equations, by its Kronecker form: the solvers of `luenberger-linalg` would be a large
/// part of the module of a page. Whatever P is, the theorem decides.
fn another_p(f: &DMatrix<f64>, before: &DMatrix<f64>, is_discrete: bool) -> Option<Matrix<f64>> {
    let n = f.nrows();
    if n > LARGEST_ORDER {
        return None;
    }
    let (of, one) = (f.transpose(), DMatrix::<f64>::identity(n, n));
    let equation = if is_discrete {
        of.kronecker(&of) - DMatrix::identity(n * n, n * n)
    } else {
        one.kronecker(&of) + of.kronecker(&one)
    };
    let q = DMatrix::from_diagonal(&before.diagonal());
    let solution = equation.lu().solve(&DVector::from_column_slice((-q).as_slice()))?;
    let p = DMatrix::from_column_slice(n, n, solution.as_slice());
    p.iter().all(|entry| entry.is_finite()).then(|| Matrix::from_fn(n, n, |i, j| f64::midpoint(p[(i, j)], p[(j, i)])))
}

/// Which hypothesis does not hold in the run of these sliders, if any.
fn failed_hypothesis(
    of: &Hypotheses,
    experiment: &Experiment,
    observer: &StoredObserver,
    sliders: &Sliders,
) -> Option<String> {
    let noise = of.noise.iter().enumerate();
    noise.into_iter().find_map(|(i, bound)| noise_excess(experiment, i, *bound, sliders.noise)).or_else(|| {
        let is_farther = is_beyond(of, experiment, &start(experiment, observer, sliders));
        is_farther.then(|| "the first error is larger than those that the certificate is for".to_owned())
    })
}

/// Why the noise of an output, from 0, is not within a bound.
fn noise_excess(experiment: &Experiment, output: usize, bound: f64, factor: f64) -> Option<String> {
    let all = experiment.noise.iter().filter_map(|noise| Some((noise.gaussian, *noise.amplitude.get(output)?)));
    let sensors = experiment.sensors.iter().filter(|sensor| sensor.output == output);
    let sources = all.chain(sensors.map(|sensor| (sensor.gaussian, sensor.amplitude)));
    let name = format!("the noise of output {}", output + 1);
    sources.map(|(gaussian, amplitude)| (gaussian, factor * amplitude)).find_map(|(gaussian, amplitude)| {
        if gaussian && amplitude > 0.0 {
            return Some(format!("{name} is Gaussian, and the certificate is for a bounded one"));
        }
        let (found, allowed) = (significant(amplitude, 4), if_at_most(bound, 4));
        (amplitude > bound).then(|| format!("{name} is up to {found}, and the certificate is for {allowed}"))
    })
}

/// Whether a block of `z = T(x - xhat)` at the start is longer than its bound, by more than the rounding of its length:
/// `4 n u` times the sum of the absolute values of its terms.
fn is_beyond(of: &Hypotheses, experiment: &Experiment, start: &[f64]) -> bool {
    let error: Vec<f64> = experiment.x0.iter().zip(start).map(|(x, xhat)| x - xhat).collect();
    let mut rows = of.t.iter();
    of.blocks.iter().zip(&of.start).any(|(&length, bound)| {
        let (mut square, mut terms) = (0.0, 0.0);
        for row in rows.by_ref().take(length) {
            let products = || row.iter().zip(&error).map(|(t, e)| t * e);
            square += products().sum::<f64>().powi(2);
            terms += products().map(f64::abs).sum::<f64>();
        }
        square.sqrt() > bound + 4.0 * error.len() as f64 * f64::EPSILON * terms
    })
}

/// Why nothing is proved for other gains, where the page has no theorem for them.
const OF_DESIGN: &str = "the certificate is for the gains of the design";

fn open(what: &str) -> GainVerdict {
    GainVerdict::Open(what.to_owned())
}

/// Whether the sampling period does not occur in the theorem.
fn in_continuous_time(theorem: &Theorem) -> bool {
    !matches!(theorem, Theorem::SampledCubicConvergence(_) | Theorem::SemiImplicitCubicConvergence(_))
}

/// The theorem for the gains of the sliders; `false` for one whose gains are none of its data, or that binds them to
/// other data.
fn scale(theorem: &mut Theorem, sliders: &Sliders) -> bool {
    let times = |m: &mut Matrix<f64>, factor: f64| *m = m.map(|entry| factor * entry);
    match theorem {
        Theorem::LinearConvergence(data) => times(&mut data.l, sliders.gain),
        Theorem::DiscreteConvergence(data) => times(&mut data.l, sliders.gain),
        Theorem::DiscreteJacobianPolytope(data) => times(&mut data.l, sliders.gain),
        Theorem::JacobianPolytope(data) => times(&mut data.l, sliders.gain),
        Theorem::PlantPolytope(data) => times(&mut data.l, sliders.gain),
        Theorem::SectorConvergence(data) => times(&mut data.l, sliders.gain),
        Theorem::StructuredCubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.s, sliders.cubic);
        }
        Theorem::CubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.n, sliders.cubic);
            times(&mut data.s, sliders.cubic);
        }
        Theorem::SampledCubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.n, sliders.cubic);
            data.w *= sliders.cubic;
        }
        Theorem::SemiImplicitCubicConvergence(data) => {
            times(&mut data.l, sliders.gain);
            times(&mut data.n, sliders.cubic);
            times(&mut data.s, sliders.cubic);
        }
        _ => return false,
    }
    true
}
