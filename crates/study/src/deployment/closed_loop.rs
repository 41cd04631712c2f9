//! The feedback `u = r - K xhat` of a study on a target: its gain, and what is proved of the loop.
//!
//! The loop of the plant `x+ = A x + B u`, `y = C x + D u` with the stored observer
//! `xhat+ = As xhat + Bs u + Ls (y - Cs xhat - D u)` and `u = -Ks xhat` has for `z = (x, xhat)` the matrix
//!
//! ```text
//! [A  0 ] - [B  0 ] [ 0  Ks]
//! [0  As]   [Bs Ls] [-C  Cs]
//! ```
//!
//! without a product that would have to be rounded: its certificate is that of a linear observer of twice the order,
//! and the rounding of the stored numbers is in it.

use luenberger_design::{Certificate, DiscreteDesign};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{Reading, Represented};
use luenberger_proof::statement::Format;
use nalgebra::DMatrix;

use super::{Evidence, Matrices, SampledDesign, stored};
use crate::study::{ObserverSpec, Study};

pub use super::feedback::gain;

/// What is proved of the loop with the numbers as stored in `format`, in exact arithmetic.
pub fn evidence(
    study: &Study,
    observer: &ObserverSpec,
    design: &SampledDesign,
    k: &DMatrix<f64>,
    format: Format,
) -> Evidence {
    let not_proved = "Not proved: bounds of the state of the plant under references, noise and rounding, and the loop with an actuator at its limit.";
    let none = || {
        let sentences = vec!["Feedback: no stability certificate of the loop.".to_owned(), not_proved.to_owned()];
        Evidence { sentences, file: None }
    };
    let Some((m, found)) = design.matrices().and_then(|m| certificate(&m, k, format).map(|found| (m, found))) else {
        return none();
    };
    let whole = match design {
        SampledDesign::Cubic(cubic) => cubic.certificate.sentence_of_sampled_loop(&found),
        _ => None,
    };
    let of_loop = Represented::Loop { states: m.a.nrows(), is_linear_part: m.is_cubic };
    let sentence =
        whole.or_else(|| found.sentences(&Reading { plant: of_loop, ..study.plant.reading() }).into_iter().next());
    let title = format!("{}: feedback", observer.name);
    let (Some(sentence), Ok(file)) = (sentence, found.file(&title)) else { return none() };
    let sentences = vec![
        format!(
            "Proved (certificate-feedback.json, with z = (x, xhat) as its error), for the input held over the period and all numbers as stored in {format}, in exact arithmetic: {sentence}"
        ),
        "Rounding in u = r - K xhat does not enter the estimation error: the observer steps with the u that the plant gets.".to_owned(),
        not_proved.to_owned(),
    ];
    Evidence { sentences, file: Some(file) }
}

/// The certificate of the loop; none if the loop is not stable, and for a D that the format rounds.
fn certificate(m: &Matrices<'_>, k: &DMatrix<f64>, format: Format) -> Option<Certificate> {
    let stored = |matrix: &DMatrix<f64>| stored(matrix, format);
    if m.d.is_some_and(|d| stored(d).as_ref() != Some(d)) {
        return None;
    }
    let [a, b, c, l, ks] = [m.a, m.b, m.c, m.l, k].map(stored);
    let (a, b, c, l, ks) = (a?, b?, c?, l?, ks?);
    let (n, inputs, outputs) = (a.nrows(), b.ncols(), c.nrows());
    let mut loop_a = DMatrix::zeros(2 * n, 2 * n);
    loop_a.view_mut((0, 0), (n, n)).copy_from(m.a);
    loop_a.view_mut((n, n), (n, n)).copy_from(&a);
    let mut loop_l = DMatrix::zeros(2 * n, inputs + outputs);
    loop_l.view_mut((0, 0), (n, inputs)).copy_from(m.b);
    loop_l.view_mut((n, 0), (n, inputs)).copy_from(&b);
    loop_l.view_mut((n, inputs), (n, outputs)).copy_from(&l);
    let mut loop_c = DMatrix::zeros(inputs + outputs, 2 * n);
    loop_c.view_mut((0, n), (inputs, n)).copy_from(&ks);
    loop_c.view_mut((inputs, 0), (outputs, n)).copy_from(&-m.c);
    loop_c.view_mut((inputs, n), (outputs, n)).copy_from(&c);
    let loop_b = loop_l.columns(0, inputs).into_owned();
    let plant = StateSpace::new(loop_a, loop_b, loop_c).ok()?;
    let design = DiscreteDesign::with_gain(&plant, m.period, &loop_l).ok()?;
    Some(design.certificate.clone())
}
