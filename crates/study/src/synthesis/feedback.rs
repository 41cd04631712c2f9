//! The loop `u = r - K xhat` of a study around the observer that it feeds back: what is proved of it.
//!
//! With `x' = A x + B u`, `y = C x` and the observer with the gain L the state `z = (x, xhat)` obeys for r = 0
//! ```text
//! z' = ([A 0; 0 A] - [B 0; B L] [0 K; -C C]) z :
//! ```
//! the error equation of a linear observer of twice the order, with no product that would have to be rounded. Its
//! eigenvalues are those of `A - B K` and of `A - L C` (separation). In discrete time likewise.

use luenberger_design::{Certificate, CubicDesign, DiscreteDesign, FeedbackDesign, LinearDesign};
use luenberger_linalg::eigenvalues;
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{Reading, Represented};
use luenberger_proof::wording::significant;
use nalgebra::{Complex, DMatrix};

use super::{Designed, matrix, number};
use crate::results::eigenvalue;
use crate::results::{DesignReport, Statement};
use crate::signal::Input;
use crate::study::{ObserverSpec, Study};

/// The gain, if the study feeds back the estimate of this observer.
pub(crate) fn gain<'a>(study: &'a Study, observer: &str) -> Option<&'a DMatrix<f64>> {
    match &study.input {
        Input::Feedback { observer: fed, gain, .. } if fed == observer => Some(gain),
        _ => None,
    }
}

/// The design with what is proved of its loop, for a linear observer of this plant with the gain L.
pub(crate) fn linear(
    study: &Study,
    requested: &ObserverSpec,
    plant: &StateSpace,
    l: &DMatrix<f64>,
    designed: Designed,
) -> Designed {
    let Some(k) = gain(study, &requested.name) else { return designed };
    let proved = loop_of(plant, l, k).and_then(|(both, l)| match study.plant.dt {
        None => LinearDesign::with_gain(&both, &l).ok().map(|design| design.certificate.clone()),
        Some(dt) => DiscreteDesign::with_gain(&both, dt, &l).ok().map(|design| design.certificate.clone()),
    });
    described(study, plant, k, proved, designed)
}

/// The same for a cubic observer (Theorem 6).
pub(crate) fn cubic(
    study: &Study,
    observer: &str,
    plant: &StateSpace,
    design: &CubicDesign,
    designed: Designed,
) -> Designed {
    let Some(k) = gain(study, observer) else { return designed };
    let proved = FeedbackDesign::cubic(design, k).ok().map(|design| design.certificate.clone());
    described(study, plant, k, proved, designed)
}

/// The plant of twice the order, and its gain.
fn loop_of(plant: &StateSpace, l: &DMatrix<f64>, k: &DMatrix<f64>) -> Option<(StateSpace, DMatrix<f64>)> {
    let StateSpace { a, b, c, .. } = plant;
    let (n, m, p) = (a.nrows(), b.ncols(), c.nrows());
    let (mut both, mut gain, mut seen) =
        (DMatrix::zeros(2 * n, 2 * n), DMatrix::zeros(2 * n, m + p), DMatrix::zeros(m + p, 2 * n));
    for row in [0, n] {
        both.view_mut((row, row), (n, n)).copy_from(a);
        gain.view_mut((row, 0), (n, m)).copy_from(b);
    }
    gain.view_mut((n, m), (n, p)).copy_from(l);
    seen.view_mut((0, n), (m, n)).copy_from(k);
    seen.view_mut((m, 0), (p, n)).copy_from(&-c);
    seen.view_mut((m, n), (p, n)).copy_from(c);
    let input = gain.columns(0, m).into_owned();
    Some((StateSpace::new(both, input, seen).ok()?, gain))
}

fn described(
    study: &Study,
    plant: &StateSpace,
    k: &DMatrix<f64>,
    proved: Option<Certificate>,
    designed: Designed,
) -> Designed {
    let Designed { runnable, report, mut certificate, origin } = designed;
    let DesignReport { mut matrices, mut numbers, .. } = report.clone();
    matrices.push(matrix("K", k));
    let poles = eigenvalues(&(&plant.a - &plant.b * k)).unwrap_or_default();
    let is_discrete = study.plant.dt.is_some();
    let measure = |pole: &Complex<f64>| if is_discrete { pole.norm() } else { pole.re };
    let largest = poles.iter().map(measure).fold(f64::NEG_INFINITY, f64::max);
    let what =
        if is_discrete { "largest modulus of a pole of A - B K" } else { "largest real part of a pole of A - B K" };
    numbers.push(number(what, largest));
    let list: Vec<String> = poles.iter().map(|pole| eigenvalue([pole.re, pole.im])).collect();
    let held = match study.simulation.as_ref().and_then(|simulation| simulation.hold) {
        Some(_) if !is_discrete => "That is of u in continuous time, not held as in the simulation.",
        _ => "",
    };
    let said = match proved.filter(Certificate::is_proved) {
        Some(proved) => {
            let reading = Reading {
                plant: Represented::Loop { states: plant.a.nrows(), is_linear_part: false },
                ..study.plant.reading()
            };
            let sentences = proved.sentences(&reading);
            certificate = certificate.map(|own| own.and(proved));
            Statement::default().proved(sentences).remark(held)
        }
        None => Statement::of(format!(
            "The stability of the loop u = r - K xhat is not proved: the {what} is {}.",
            significant(largest, 4)
        )),
    };
    let poles = format!("The poles of A - B K are {}, besides those of the observer.", list.join(", "));
    let statement = report.statement.clone().and(&said).remark(poles);
    Designed { runnable, report: DesignReport { statement, matrices, numbers, ..report }, certificate, origin }
}
