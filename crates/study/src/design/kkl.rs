//! Numerical KKL observers of the plants of a study: run-time sizes are converted to const generics here.

use std::ops::ControlFlow::{Break, Continue};
use std::sync::atomic::{AtomicBool, Ordering};

use luenberger_design::enclosure::Axis;
use luenberger_design::numerical_kkl::{
    Choice, Domain, Embedded, Escape, Interpolated, NumericalKklDesign, NumericalKklError, Settings, Target, Wanted,
    choose,
};
use luenberger_observers::numerical_kkl::NumericalKklObserver;
use luenberger_plants::{Dimensions, Plant, Shape};
use luenberger_proof::wording::significant;
use nalgebra::{DVector, RealField, SVector, Vector1};

use super::explain::Misfit;
use super::runnable::Runnable;
use super::{Designed, number};
use crate::model::Model;
use crate::results::DesignReport;
use crate::study::KklSpec;

/// The observer, for two and for three states.
#[derive(Debug, Clone)]
pub enum Kkl {
    /// Two states, the accurate form.
    Two(Box<NumericalKklObserver<Interpolated<2, 3>, f64, 2, 0, 1, 3>>),
    /// Two states, the form for a microcontroller.
    TwoEmbedded(Box<NumericalKklObserver<Embedded<2, 3>, f64, 2, 0, 1, 3>>),
    /// Three states, the accurate form.
    Three(Box<NumericalKklObserver<Interpolated<3, 4>, f64, 3, 0, 1, 4>>),
    /// Three states, the form for a microcontroller.
    ThreeEmbedded(Box<NumericalKklObserver<Embedded<3, 4>, f64, 3, 0, 1, 4>>),
}

/// A model without inputs and with one output; the number of states is a const generic.
#[derive(Debug, Clone)]
struct Sized<const N: usize>(Model);

impl<const N: usize> luenberger_plants::ByDual for Sized<N> {}

impl<const N: usize> Shape for Sized<N> {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: N, inputs: 0, outputs: 1 }
    }
}

impl<T: RealField + Copy, const N: usize> Plant<T> for Sized<N> {
    type State = SVector<T, N>;
    type Input = SVector<T, 0>;
    type Output = Vector1<T>;

    fn derivative(&self, t: T, x: &SVector<T, N>, _u: &SVector<T, 0>) -> SVector<T, N> {
        let slope = self.0.derivative(t, &DVector::from_column_slice(x.as_slice()), &DVector::zeros(0));
        SVector::from_fn(|i, _| slope[i])
    }

    fn output(&self, t: T, x: &SVector<T, N>, _u: &Self::Input) -> Vector1<T> {
        Vector1::new(self.0.output(t, &DVector::from_column_slice(x.as_slice()), &DVector::zeros(0))[0])
    }
}

/// The design for a model whose sizes have been checked: 2 or 3 states, no input, one output. It stops once `cancel` is
/// true.
pub(super) fn design(model: &Model, wish: &KklSpec, cancel: &AtomicBool) -> Result<Designed, Misfit> {
    if model.size().states == 2 {
        let (design, report) = of_size::<2, 3>(model, wish, cancel)?;
        let kkl = if wish.embedded {
            Kkl::TwoEmbedded(Box::new(design.embedded))
        } else {
            Kkl::Two(Box::new(design.interpolated))
        };
        return Ok(Designed { runnable: Runnable::Kkl(Box::new(kkl)), report, certificate: None });
    }
    let (design, report) = of_size::<3, 4>(model, wish, cancel)?;
    let kkl = if wish.embedded {
        Kkl::ThreeEmbedded(Box::new(design.embedded))
    } else {
        Kkl::Three(Box::new(design.interpolated))
    };
    Ok(Designed { runnable: Runnable::Kkl(Box::new(kkl)), report, certificate: None })
}

type Design<const N: usize, const Z: usize> = NumericalKklDesign<N, 0, 1, Z>;

fn of_size<const N: usize, const Z: usize>(
    model: &Model,
    wish: &KklSpec,
    cancel: &AtomicBool,
) -> Result<(Design<N, Z>, DesignReport), NumericalKklError> {
    let ends = |f: fn(&(f64, f64)) -> f64| std::array::from_fn(|i| wish.domain.get(i).map_or(f64::NAN, f));
    let (lower, upper) = (ends(|end| end.0), ends(|end| end.1));
    let mut settings = Settings {
        leaves: wish.leaves,
        degree: wish.degree,
        samples: wish.samples,
        // A grid of 17 points on three axes is too large for the comparison of all pairs.
        injectivity_points: if N > 2 { 9 } else { 17 },
        ..Settings::default()
    };
    let plant = Sized::<N>(model.clone());
    let mut on = |_| if cancel.load(Ordering::Relaxed) { Break(()) } else { Continue(()) };
    let wanted = Wanted {
        cutoff: wish.cutoff,
        points: wish.points,
        escape: wish.escape.map(|margin| Escape::Slowed { margin }),
        ..Wanted::default()
    };
    let choice = choose::<_, N, 0, Z>(&plant, (lower, upper), SVector::zeros(), &wanted, &settings, &mut on)?;
    settings.points = [choice.points; N];
    let domain = Domain::new(lower, upper, choice.escape)?;
    let target = Target::<1, Z>::bessel(choice.cutoff)?;
    let design = NumericalKklDesign::new(&plant, &target, &domain, SVector::zeros(), &settings, &mut on)?;
    let measured = &design.report;
    let form = if wish.embedded { &measured.embedded } else { &measured.interpolated };
    let mut numbers = vec![
        number("cutoff", choice.cutoff),
        number("grid points per axis", choice.points as f64),
        number("memory", measured.horizon),
        number("largest error of the table", measured.spline.1),
        number("largest residual of dT/dx f = D T + B y", measured.residual.1),
    ];
    for i in 0..N {
        numbers.push(number(&format!("largest error of the left inverse, {}", Axis::State(i)), form.max[i]));
    }
    let report = DesignReport {
        statement: "z' = D z + B y is stable; while x(t) stays in the region, the estimation error tends to that of the left inverse.".to_owned(),
        matrices: Vec::new(),
        poles: target.dynamics().complex_eigenvalues().iter().map(|pole| [pole.re, pole.im]).collect(),
        numbers,
        facts: Vec::new(),
        verdict: "measured".to_owned(),
        noise_deviation: Vec::new(),
        evidence: Some(format!(
            "errors measured at {} points that were not used in the fit{}",
            form.samples,
            explained(&choice, &wanted)
        )),
    };
    Ok((design, report))
}

/// What was chosen, why, and what the other candidates gave; nothing where the keys left nothing to choose.
fn explained(choice: &Choice, wanted: &Wanted) -> String {
    if choice.candidates.is_empty() && (wanted.escape.is_some() || choice.escape == Escape::Free) {
        return String::new();
    }
    let mut chosen = Vec::new();
    if wanted.cutoff.is_none() {
        chosen.push(format!("cutoff = {}", significant(choice.cutoff, 4)));
    }
    if wanted.points.is_none() {
        chosen.push(format!("points = {}", choice.points));
    }
    if wanted.escape.is_none() {
        chosen.push(match choice.escape {
            Escape::Slowed { margin } => {
                format!("escape = {} (a trajectory is unbounded backward in time)", significant(margin, 4))
            }
            Escape::Free => "no escape".to_owned(),
        });
    }
    if choice.candidates.is_empty() {
        return format!(". Chosen: {}", chosen.join(", "));
    }
    let why = if choice.is_reached {
        format!("the slowest filter with a root mean square error of at most {:e} half-widths", wanted.error)
    } else {
        format!("the smallest error: none of the designs reaches {:e} half-widths", wanted.error)
    };
    let tried = choice.candidates.iter().map(|candidate| {
        let result = match &candidate.outcome {
            Ok(error) => format!("error {}", significant(*error, 2)),
            Err(NumericalKklError::Unresolved { .. }) => "refused (the table does not resolve T)".to_owned(),
            Err(NumericalKklError::NotInjective { .. }) => "refused (two states with one image)".to_owned(),
            Err(error) => format!("refused ({error})"),
        };
        format!("cutoff {} on {} points: {result}", significant(candidate.cutoff, 4), candidate.points)
    });
    let tried = tried.collect::<Vec<_>>().join("; ");
    format!(". Chosen: {}, {why}. Coarse designs: {tried}", chosen.join(", "))
}
