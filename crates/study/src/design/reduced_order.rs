//! Designs of reduced-order observers. They run as KKL observers with linear maps: `phi = T x`, `Lambda = F`,
//! `B = G y + H u`, `phi^L = M xi + N y`.

use luenberger_design::ReducedOrderDesign;
use luenberger_observers::{KklObserver, LinearInverse, LinearKkl};
use luenberger_plants::StateSpace;
use nalgebra::{Complex, DMatrix};

use super::explain::Misfit;
use super::{Designed, asymptotic_rate, certified, matrix, number, poles, proved_of};
use crate::results::DesignReport;
use crate::runnable::Runnable;
use crate::study::Study;

pub(super) fn reduced_order(study: &Study, plant: &StateSpace, requested: &[Complex<f64>]) -> Result<Designed, Misfit> {
    let design = ReducedOrderDesign::with_poles(plant, requested)?;
    let o = &design.observer;
    let inverse = LinearInverse::new(o.m.clone(), o.n.clone(), o.t.clone())?;
    let maps = LinearKkl::new(o.f.clone(), o.g.clone(), o.h.clone(), inverse)?;
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
    let runnable = Runnable::ReducedOrder(Box::new(KklObserver::new(maps)));
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

fn norm(m: &DMatrix<f64>) -> f64 {
    m.clone().svd(false, false).singular_values.max()
}
