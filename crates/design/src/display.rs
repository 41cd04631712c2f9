//! Designs as text: gains, poles, and each inequality with its verdict.

use core::fmt::{self, Display};

use luenberger_lmi::dynamic_matrix;
use luenberger_observers::{CubicObserver, LinearObserver, SampledObserver};
use luenberger_proof::certificate::Certificate;
use luenberger_proof::wording::{complex, significant};
use nalgebra::{Complex, DMatrix, Dyn};

use crate::mean_value::{ContractingCoordinates, MeanValueDesign};
use crate::number::{DIGITS, write_matrix};
use crate::numerical_kkl::HeldInputDesign;
use crate::robust::{GainCertificate, PolytopicDesign};
use crate::{
    CubicDesign, DeployedLinear, DiscreteDesign, FeedbackDesign, IntervalDesign, KklDesign, KklPebDesign, LinearDesign,
    LipschitzDesign, NormFilterDesign, NumericalKklDesign, OptimalCubicDesign, ReducedOrderDesign, SampledCubicDesign,
    SampledIntervalDesign, SuperTwistingDesign, UnknownInputDesign, VaryingPeriodDesign,
};

fn write_design(
    f: &mut fmt::Formatter<'_>,
    gains: &[(&str, &DMatrix<f64>)],
    numbers: &[(&str, &[f64])],
    poles: &[Complex<f64>],
    certificate: &Certificate,
) -> fmt::Result {
    for (name, gain) in gains {
        write_matrix(f, name, gain)?;
    }
    for (name, values) in numbers {
        let values: Vec<String> = values.iter().map(|value| significant(*value, DIGITS)).collect();
        writeln!(f, "{name} {}", values.join(", "))?;
    }
    if !poles.is_empty() {
        let poles: Vec<String> = poles.iter().map(|pole| complex([pole.re, pole.im], DIGITS)).collect();
        writeln!(f, "poles {}", poles.join(", "))?;
    }
    certificate.fmt(f)
}

/// A design by the names and values of its gains, other numbers in braces, and its poles where it has them.
macro_rules! displayed {
    ($($design:ty: |$d:ident| [$($name:literal = $gain:expr),+] $({$($what:literal = $value:expr),+})?
        $(, $poles:expr)?;)+) => {
        $(impl Display for $design {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let $d = self;
                let numbers: &[(&str, &[f64])] = &[$($(($what, $value)),+)?];
                write_design(f, &[$(($name, $gain)),+], numbers, displayed!(@poles $($poles)?), &$d.certificate)
            }
        })+
    };
    (@poles) => { &[] };
    (@poles $poles:expr) => { $poles };
}

displayed! {
    LinearDesign: |d| ["L" = d.l()], &d.poles;
    CubicDesign: |d| ["L" = d.l(), "N" = &d.observer.n, "theta" = &d.observer.theta];
    DiscreteDesign: |d| ["L" = d.l()] {"sampling period" = &[d.observer.period()]}, &d.poles;
    SampledCubicDesign: |d| ["L" = d.l(), "N" = d.observer.n(), "theta" = d.observer.theta()], &d.poles;
    FeedbackDesign: |d| ["K" = &d.k], &d.poles;
    PolytopicDesign: |d| ["L" = d.l()], &d.nominal.poles;
    GainCertificate: |d| ["L" = &d.l, "N" = &d.n];
    LipschitzDesign: |d| ["L" = d.l()];
    MeanValueDesign: |d| ["L" = d.l()];
    ContractingCoordinates: |d| ["K" = &d.k];
    DeployedLinear: |d| ["L" = &dynamic_matrix(&d.deployed.stored.l)];
    ReducedOrderDesign: |d| ["F" = &d.observer.f, "G" = &d.observer.g, "H" = &d.observer.h, "M" = &d.observer.m,
        "N" = &d.observer.n], &d.poles;
    NormFilterDesign: |d| ["L" = d.l()] {"norm" = &[d.norm], "proved to be below" = &[d.gamma]}, &d.poles;
    UnknownInputDesign<LinearObserver<f64, Dyn, Dyn, Dyn>>: |d| ["L" = d.l(), "H" = d.observer.h()];
    UnknownInputDesign<CubicObserver<f64, Dyn, Dyn, Dyn>>: |d| ["L" = d.l(), "N" = &d.observer.inner().n,
        "theta" = &d.observer.inner().theta, "H" = d.observer.h()];
    IntervalDesign: |d| ["L" = d.l(), "T" = &d.t] {"half-widths as t grows" = &d.widths};
    SampledIntervalDesign: |d| ["L" = d.l(), "T" = &d.t] {"half-widths as k grows" = &d.widths};
    VaryingPeriodDesign: |d| ["K" = &d.k, "N" = d.nominal.observer.n(), "theta" = d.nominal.observer.theta()]
        {"factor from correction to correction" = &[d.factor]};
    SuperTwistingDesign: |d| ["P" = &d.p] {"alpha, c" = &[d.alpha, d.c]};
}

/// The linear or the cubic observer, whichever is the optimum, and the costs of both.
impl Display for OptimalCubicDesign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let l = self.linear.l();
        let costs: [(&str, &[f64]); 2] =
            [("cost", &[self.cost.total]), ("cost of the linear optimum", &[self.linear_cost.total])];
        match self.cubic.as_ref().map(|cubic| &cubic.observer) {
            Some(cubic) => {
                let gains = [("L", l), ("N", &cubic.n), ("theta", &cubic.theta)];
                write_design(f, &gains, &costs, &self.linear.poles, &self.certificate)
            }
            None => write_design(f, &[("L", l)], &costs, &self.linear.poles, &self.certificate),
        }
    }
}

impl<K> Display for KklDesign<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.report.fmt(f)
    }
}

impl<O> Display for KklPebDesign<O> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.report.fmt(f)
    }
}

impl<const N: usize, const M: usize, const P: usize, const Z: usize> Display for NumericalKklDesign<N, M, P, Z> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.report.fmt(f)
    }
}

impl<const N: usize, const M: usize, const P: usize, const Z: usize, const ZM: usize> Display
    for HeldInputDesign<N, M, P, Z, ZM>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.report.fmt(f)
    }
}
