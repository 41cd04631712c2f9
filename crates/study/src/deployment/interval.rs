//! The interval observer on a target: its state is the estimate with the half-widths of its bounds, and rho.

use luenberger_design::SampledIntervalDesign;
use luenberger_export::step::ExpressionStep;
use luenberger_export::{ExportError, Scalar};
use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_plants::StateSpace;
use luenberger_proof::statement::Format;
use nalgebra::DMatrix;

use super::{Evidence, proved_line};
use crate::design::{Sampling, sampled_interval};
use crate::maps::operand;
use crate::operation;
use crate::study::{IntervalSpec, ObserverSpec, Study};

/// The designs for both formats: the entries that cover rounding depend on it.
#[derive(Debug, Clone)]
pub struct IntervalDeployment {
    binary32: Result<SampledIntervalDesign, String>,
    binary64: Result<SampledIntervalDesign, String>,
}

impl IntervalDeployment {
    /// The designs of a specification with the gain for samples; none for that of the least width.
    ///
    /// # Errors
    /// Why there is none in binary64.
    pub(super) fn new(
        study: &Study,
        observer: &ObserverSpec,
        spec: &IntervalSpec,
        (plant, gain): (&StateSpace, Option<DMatrix<f64>>),
        period: f64,
    ) -> Result<Self, String> {
        if plant.d.is_some() {
            return Err("the kind interval has no step for outputs with feedthrough D".to_owned());
        }
        let operation = operation::largest(study, observer);
        let of = |format| {
            let sampling = Sampling {
                plant,
                gain: gain.clone(),
                period,
                held: study.plant.dt.is_none(),
                operation: operation.clone(),
                format,
            };
            sampled_interval(&sampling, spec, observer.bounds.as_ref()).map_err(|error| error.to_string())
        };
        let binary64 = Ok(of(Format::Binary64)?);
        Ok(Self { binary32: of(Format::Binary32), binary64 })
    }

    fn of(&self, format: Format) -> Result<&SampledIntervalDesign, &str> {
        let found = if format == Format::Binary32 { &self.binary32 } else { &self.binary64 };
        found.as_ref().map_err(String::as_str)
    }

    /// The step of a format.
    pub(super) fn program(&self, scalar: Scalar) -> Result<ExpressionStep<f64>, ExportError> {
        let refused = |why: String| ExportError::NoStep { why, format: scalar.name() };
        let design = self.of(format(scalar)).map_err(|why| refused(why.to_owned()))?;
        step(design).map_err(refused)
    }

    /// The state of the step for a first estimate: the estimate, the half-widths and rho.
    pub(super) fn start(&self, scalar: Scalar, xhat: &[f64]) -> Vec<f64> {
        let Ok(design) = self.of(format(scalar)) else { return xhat.to_vec() };
        let gains = design.observer.gains();
        let state: Vec<f64> = xhat.iter().chain(gains.start.iter()).copied().collect();
        let widths = design.observer.half_widths(&state);
        xhat.iter().chain(widths.iter()).chain(gains.start.iter()).copied().collect()
    }

    /// The names of the states of the step beside the plant's.
    pub(super) fn names(&self, states: &[String]) -> Vec<String> {
        let blocks = self.binary64.as_ref().map_or(0, |design| design.blocks.len());
        let widths = states.iter().map(|state| format!("{state}_half_width"));
        widths.chain((1..=blocks).map(|k| format!("rho{k}"))).collect()
    }

    pub(super) fn evidence(&self, study: &Study, observer: &ObserverSpec, format: Format) -> Evidence {
        let design = match self.of(format) {
            Ok(design) => design,
            Err(why) => return Evidence { sentences: vec![format!("No stability certificate: {why}.")], file: None },
        };
        let layout = "State of the step: the estimate, then the half-widths r of its bounds, then rho. Start from xhat with r and rho of the first state, as written here.".to_owned();
        match design.certificate.file(&observer.name) {
            Ok(file) => Evidence {
                sentences: [
                    proved_line(", for the step as it runs", &design.certificate.sentences(&study.plant.reading())),
                    Some(layout),
                ]
                .into_iter()
                .flatten()
                .collect(),
                file: Some(file),
            },
            Err(error) => {
                Evidence { sentences: vec![format!("No stability certificate: {error}."), layout], file: None }
            }
        }
    }
}

fn format(scalar: Scalar) -> Format {
    match scalar {
        Scalar::Binary32 => Format::Binary32,
        Scalar::Binary64 => Format::Binary64,
    }
}

/// `m_i1 v_1 + m_i2 v_2 + ..` without the terms that are 0; `0` where all are.
fn row(m: &DMatrix<f64>, i: usize, vector: &[String]) -> String {
    let terms = vector.iter().enumerate().filter(|(j, _)| m[(i, *j)] != 0.0);
    let terms: Vec<String> = terms.map(|(j, v)| format!("{}*{v}", operand(m[(i, j)]))).collect();
    if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") }
}

/// The step as expressions in the order of `SampledIntervalObserver`, each sum from left to right.
fn step(design: &SampledIntervalDesign) -> Result<ExpressionStep<f64>, String> {
    let g = design.observer.gains();
    let (n, m, p, q) = (g.f.nrows(), g.g.ncols(), g.c.nrows(), g.blocks.nrows());
    let named = |letter: char, first: usize, count: usize| -> Vec<String> {
        (first..first + count).map(|k| format!("{letter}{}", k + 1)).collect()
    };
    let (xhat, rho) = (named('x', 0, n), named('x', 2 * n, q));
    let (u, y) = (named('u', 0, m), named('u', m, p));
    let magnitudes = |names: &[String]| names.iter().map(|name| format!("abs({name})")).collect::<Vec<_>>();
    let innovation: Vec<String> = (0..p).map(|i| format!("({} - ({}))", y[i], row(&g.c, i, &xhat))).collect();
    let estimate = |i: usize| {
        let moved = format!("({})", row(&g.f, i, &xhat));
        let moved = if m == 0 { moved } else { format!("({moved} + ({}))", row(&g.g, i, &u)) };
        format!("({moved} + ({}))", row(&g.l, i, &innovation))
    };
    let (sizes, fed) = (magnitudes(&xhat), magnitudes(&u));
    let bound = |k: usize| {
        let grown = format!("(({}) + {})", row(&g.blocks, k, &rho), operand(g.constant[k]));
        let grown = format!("({grown} + ({}))", row(&g.of_estimate, k, &sizes));
        if m == 0 { grown } else { format!("({grown} + ({}))", row(&g.of_input, k, &fed)) }
    };
    let (next, bounds): (Vec<String>, Vec<String>) = ((0..n).map(estimate).collect(), (0..q).map(bound).collect());
    let width = |i: usize| format!("({}) + {}*abs({})", row(&g.h, i, &bounds), operand(g.outward), next[i]);
    let widths: Vec<String> = (0..n).map(width).collect();
    let f: Vec<String> = next.iter().chain(&widths).chain(&bounds).cloned().collect();
    let h: Vec<String> = (0..p).map(|i| row(&g.c, i, &xhat)).collect();
    let words = |error: &dyn std::fmt::Display| error.to_string();
    let flow = ExpressionPlant::new(&f, &h, m + p, &Parameters::new()).map_err(|error| words(&error))?;
    ExpressionStep::new(flow, m, g.period).map_err(|error| words(&error))
}
