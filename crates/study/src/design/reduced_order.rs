//! Designs of reduced-order observers. They run as KKL observers with linear maps: `phi = T x`, `Lambda = F`,
//! `B = G y + H u`, `phi^L = M xi + N y`.

use luenberger_design::ReducedOrderDesign;
use luenberger_expression::{Expression, ParameterError, Scope};
use luenberger_observers::KklObserver;
use luenberger_plants::StateSpace;
use nalgebra::{Complex, DMatrix};

use super::explain::Misfit;
use super::{Designed, asymptotic_rate, certified, matrix, number, poles, proved_of};
use crate::maps::{KklMaps, MapNames};
use crate::model::PlantModel;
use crate::results::DesignReport;
use crate::runnable::Runnable;
use crate::study::Study;

pub(super) fn reduced_order(study: &Study, plant: &StateSpace, requested: &[Complex<f64>]) -> Result<Designed, Misfit> {
    let design = ReducedOrderDesign::with_poles(plant, requested)?;
    let o = &design.observer;
    let maps = maps(&study.plant, &design).ok_or(Misfit::UnnamedMaps)?;
    let slowest = -design.poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
    let named = [("T", &o.t), ("F", &o.f), ("G", &o.g), ("H", &o.h), ("M", &o.m), ("N", &o.n), ("P", &design.p)];
    let matrices = named.into_iter().filter(|(_, m)| !m.is_empty()).map(|(name, m)| matrix(name, m)).collect();
    let report = DesignReport {
        statement: proved_of(&design.certificate, &study.plant.reading())
            .remark("The outputs of the estimate are the measured ones, noise included.")
            .remark(asymptotic_rate(slowest)),
        matrices,
        poles: poles(&design.poles),
        numbers: vec![number("decay rate", slowest), number("noise passed to the estimate, norm of N", norm(&o.n))],
        ..certified(&design.certificate, &[])
    };
    let runnable = Runnable::KklMaps(Box::new(KklObserver::new(maps)));
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

fn norm(m: &DMatrix<f64>) -> f64 {
    m.clone().svd(false, false).singular_values.max()
}

/// The observer as maps under the names of the plant; none for names that no expression can have.
fn maps(plant: &PlantModel, design: &ReducedOrderDesign) -> Option<KklMaps> {
    let o = &design.observer;
    let order = o.f.nrows();
    let names = MapNames::new(plant, order);
    let numbered = |name: &str, count: usize| (1..=count).map(|k| format!("{name}{k}")).collect::<Vec<_>>();
    let xi = numbered("xi", order);
    let parse = |rows: Vec<String>, scope: Result<Scope, ParameterError>| {
        let scope = scope.ok()?;
        rows.iter().map(|row| Expression::parse(row, &scope).ok()).collect::<Option<Vec<_>>>()
    };
    let rows = |parts: &[(&DMatrix<f64>, &[String])]| -> Vec<String> {
        (0..parts[0].0.nrows())
            .map(|i| {
                let term = |m: &DMatrix<f64>, names: &[String]| {
                    let entries = (0..m.ncols()).filter(|j| m[(i, *j)] != 0.0);
                    entries.map(|j| format!("({:?})*{}", m[(i, j)], names[j])).collect::<Vec<_>>()
                };
                let terms: Vec<String> = parts.iter().flat_map(|(m, names)| term(m, names)).collect();
                if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") }
            })
            .collect()
    };
    let lambda = (0..order * order).map(|k| format!("{:?}", o.f[(k / order, k % order)])).collect();
    Some(KklMaps {
        plant: plant.model.size(),
        phi: parse(rows(&[(&o.t, &plant.states)]), names.image())?,
        lambda: parse(lambda, names.dynamics())?,
        injection: parse(rows(&[(&o.g, &plant.outputs), (&o.h, &plant.inputs)]), names.injection())?,
        left_inverse: parse(rows(&[(&o.m, &xi), (&o.n, &plant.outputs)]), names.left_inverse())?,
    })
}
