//! Designs of the observers of nonlinear plants.

use luenberger_design::enclosure::enclose;
use luenberger_design::lpv::Polytope;
use luenberger_design::number::decay;
use luenberger_design::{LipschitzDesign, LipschitzPlant, LpvDesign, MeanValueDesign, Region, Sector};
use luenberger_lmi::Settings;
use luenberger_observers::{ExtendedKalmanFilter, HighGainObserver, Integral, NoiseModel};
use luenberger_proof::wording::at_most;
use luenberger_proof::wording::significant;
use nalgebra::{DMatrix, DVector};

use super::explain::Misfit;
use super::runnable::{Chains, Runnable};
use super::{Designed, facts, matrix, number, verdict};
use crate::model::Model;
use crate::results::DesignReport;
use crate::study::{RateSpec, Study};

pub(super) fn lpv(model: &Model, region: &Region, rate: &RateSpec, settings: &Settings) -> Result<Designed, Misfit> {
    let design = match rate {
        RateSpec::Rate(rate) => LpvDesign::new_with(model.clone(), region, *rate, settings),
        // The rate is determined to one hundredth of the ceiling, which is enough for a design.
        RateSpec::Fastest(ceiling) => {
            LpvDesign::fastest_with(model.clone(), region, *ceiling, 0.01 * ceiling, settings)
        }
        RateSpec::Gain(gain, _) => LpvDesign::certify_with(model.clone(), region, gain, settings),
    }?;
    let evidence = design
        .stopped
        .as_ref()
        .map(|(rate, why)| format!("nothing was proved at the rate {}: {why}", significant(*rate, 5)));
    let report = DesignReport {
        statement: design.statement(),
        matrices: vec![matrix("L", design.observer.l()), matrix("P", &design.p)],
        poles: Vec::new(),
        numbers: vec![
            number("rate", design.rate),
            number("overshoot", design.overshoot),
            number("vertices", design.polytope.vertices.len() as f64),
        ],
        facts: facts(&design.certificate, &design.vertex_names()),
        verdict: verdict(&design.certificate),
        evidence,
    };
    let runnable = Runnable::NonlinearLuenberger(Box::new(design.observer.clone()));
    Ok(Designed { runnable, report, certificate: Some(design.certificate.clone()) })
}

/// A, C and the sectors of a plant.
type Split = (DMatrix<f64>, DMatrix<f64>, Vec<Sector>);

/// The entries of Df that vary over the box, each as its own sector: by the mean value theorem, applied to each
/// component, `f_i(x) - f_i(z) = sum_j a_ij (x_j - z_j)` with every `a_ij` between the bounds of that entry.
fn sectors(model: &Model, region: &Region) -> Result<Split, Misfit> {
    let n = model.size().states;
    let jacobians = enclose(model, region)?;
    let size = (0..n * n).map(|k| &jacobians.a[(k / n, k % n)]).map(|x| x.lo().abs().max(x.hi().abs()));
    let size = size.filter(|x| x.is_finite()).fold(0.0, f64::max);
    let mut a = DMatrix::zeros(n, n);
    let mut sectors = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let entry = &jacobians.a[(i, j)];
            // An entry that is constant up to the rounding of its enclosure is a coefficient.
            if entry.width() <= 8.0 * f64::EPSILON * size {
                a[(i, j)] = f64::midpoint(entry.lo(), entry.hi());
            } else {
                let (mut g, mut h) = (DMatrix::zeros(n, 1), DMatrix::zeros(1, n));
                (g[(i, 0)], h[(0, j)]) = (1.0, 1.0);
                sectors.push(Sector::slope(g, h, entry.lo(), entry.hi()));
            }
        }
    }
    let outputs = model.size().outputs;
    let mut c = DMatrix::zeros(outputs, n);
    for i in 0..outputs {
        for j in 0..n {
            let entry = &jacobians.c[(i, j)];
            if entry.width() > 8.0 * f64::EPSILON * entry.lo().abs().max(entry.hi().abs()) {
                return Err(Misfit::NonlinearOutput { output: i, state: j, low: entry.lo(), high: entry.hi() });
            }
            c[(i, j)] = f64::midpoint(entry.lo(), entry.hi());
        }
    }
    Ok((a, c, sectors))
}

pub(super) fn lipschitz(
    study: &Study,
    split: Option<&(DMatrix<f64>, Vec<Sector>)>,
    region: &Region,
    rate: f64,
    gain: Option<&DMatrix<f64>>,
    settings: &Settings,
) -> Result<Designed, Misfit> {
    let model = &study.plant.model;
    let (read_a, c, read) = sectors(model, region)?;
    let (a, sectors, whose) = match split {
        Some((a, sectors)) => (a.clone(), sectors.clone(), "The sectors are the study's own, and not checked."),
        None => (read_a, read, "The sectors enclose the Jacobian over the box."),
    };
    let count = sectors.len();
    let plant = LipschitzPlant::new(a, c, sectors)?;
    let design = LipschitzDesign::new_with(&plant, gain, rate, settings)?;
    let who = match count {
        1 => "the nonlinearity does within its sector".to_owned(),
        count => format!("the {count} nonlinearities do within their sectors"),
    };
    let box_ = match region.to_string().as_str() {
        "everywhere" => "From every x(0) and xhat(0)".to_owned(),
        bounds => format!("As long as x(t) and xhat(t) stay in the box ({bounds})"),
    };
    let report = DesignReport {
        statement: format!("{box_}, the error decays at least like {}, whatever {who}. {whose}", decay(rate)),
        matrices: vec![matrix("L", &design.l), matrix("P", &design.p)],
        poles: Vec::new(),
        numbers: vec![number("rate", design.rate), number("sectors", count as f64)],
        facts: facts(&design.certificate, &[]),
        verdict: verdict(&design.certificate),
        evidence: None,
    };
    let observer = design.observer(model.clone())?;
    Ok(Designed {
        runnable: Runnable::NonlinearLuenberger(Box::new(observer)),
        report,
        certificate: Some(design.certificate.clone()),
    })
}

pub(super) fn mean_value(
    model: &Model,
    region: &Region,
    rate: f64,
    eta: f64,
    internal_error: &[f64],
    settings: &Settings,
) -> Result<Designed, Misfit> {
    let polytope = Polytope::new(enclose(model, region)?)?;
    let vertices: Vec<DMatrix<f64>> = polytope.vertices.iter().map(|vertex| vertex.a.clone()).collect();
    let design = MeanValueDesign::new_with(&vertices, model.size().outputs, rate, settings)?;
    let names: Vec<String> = polytope.vertices.iter().map(ToString::to_string).collect();
    let observer = design.observer(model.clone(), eta, Integral, DVector::from_column_slice(internal_error))?;
    let hypothesis = match region.to_string().as_str() {
        "everywhere" => ", from every x(0) and z(0)".to_owned(),
        bounds => format!(" as long as x(t) and z(t) stay in the box ({bounds})"),
    };
    let hypothesis = match &polytope.enclosure.branches {
        Some(branches) => format!("{hypothesis}, provided that {branches}"),
        None => hypothesis,
    };
    let report = DesignReport {
        statement: format!(
            "With z = xhat + e, |x(t) - z(t)| <= {} |x(0) - z(0)| {}{hypothesis}.",
            at_most(design.overshoot, 5),
            decay(rate)
        ),
        matrices: vec![matrix("L", &design.l), matrix("P", &design.p)],
        poles: Vec::new(),
        numbers: vec![
            number("rate", design.rate),
            number("overshoot", design.overshoot),
            number("eta", eta),
            number("vertices", vertices.len() as f64),
        ],
        facts: facts(&design.certificate, &names),
        verdict: verdict(&design.certificate),
        evidence: None,
    };
    let runnable = Runnable::MeanValue(Box::new(observer));
    Ok(Designed { runnable, report, certificate: Some(design.certificate.clone()) })
}

pub(super) fn high_gain(chains: Chains, alpha: &[f64], r: f64) -> Result<Designed, Misfit> {
    let column = |entries: &DVector<f64>| DMatrix::from_column_slice(entries.len(), 1, entries.as_slice());
    let factors = (!chains.are_pure()).then(|| column(chains.factors()));
    let observer = HighGainObserver::new(chains, DVector::from_column_slice(alpha), r)?;
    let mut matrices = vec![matrix("alpha_i / r^i", &column(observer.gain()))];
    let mut gains = "the gains alpha_i / r^i".to_owned();
    if let Some(factors) = factors {
        gains.push_str(" times factors (the inverse products of the chain's coefficients at the first estimate)");
        matrices.push(matrix("factors", &factors));
    }
    let report = DesignReport {
        statement: format!(
            "A copy of the plant with {gains}, r = {r}. If the right-hand side is Lipschitz and r is small enough, the error decays like exp(-c t / r)."
        ),
        matrices,
        poles: Vec::new(),
        numbers: vec![number("r", r)],
        facts: Vec::new(),
        verdict: "none".to_owned(),
        evidence: Some(
            "the theorem holds for every r below some bound, which is not computed; the simulation tests this r"
                .to_owned(),
        ),
    };
    Ok(Designed { runnable: Runnable::HighGain(Box::new(observer)), report, certificate: None })
}

pub(super) fn extended_kalman(
    model: &Model,
    (w, v, p0): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    period: f64,
    substeps: usize,
) -> Result<Designed, Misfit> {
    let noises = NoiseModel { w: w.clone(), v: v.clone(), p0: p0.clone() };
    let filter = ExtendedKalmanFilter::new(model.clone(), noises, period, substeps)?;
    let report = DesignReport {
        statement: format!("One measurement every {period}; its gain follows its own covariance along the estimate."),
        matrices: vec![matrix("W", w), matrix("V", v), matrix("P(0)", p0)],
        poles: Vec::new(),
        numbers: vec![number("period", period)],
        facts: Vec::new(),
        verdict: "none".to_owned(),
        evidence: Some("it converges from small errors, and nothing is promised from large ones".to_owned()),
    };
    Ok(Designed { runnable: Runnable::ExtendedKalman(Box::new(filter)), report, certificate: None })
}
