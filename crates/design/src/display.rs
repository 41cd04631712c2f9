//! Designs as text: gains, poles, and each inequality with its verdict.

use core::fmt::{self, Display};

use luenberger_lmi::dynamic_matrix;
use luenberger_proof::certificate::Certificate;
use luenberger_proof::wording::{complex, significant};
use nalgebra::{Complex, DMatrix};

use crate::mean_value::{ContractingCoordinates, MeanValueDesign};
use crate::robust::{GainCertificate, PolytopicDesign};
use crate::{
    CubicDesign, DeployedLinear, DiscreteDesign, FeedbackDesign, KklDesign, KklPebDesign, LinearDesign,
    LipschitzDesign, NumericalKklDesign, SampledCubicDesign,
};

/// Significant digits: for people, nothing is claimed with them.
const DIGITS: usize = 6;

/// `L = [7; 10]`, as MATLAB writes it.
fn write_matrix(f: &mut fmt::Formatter<'_>, name: &str, m: &DMatrix<f64>) -> fmt::Result {
    let row = |row: usize| m.row(row).iter().map(|x| significant(*x, DIGITS)).collect::<Vec<_>>().join(", ");
    writeln!(f, "{name} = [{}]", (0..m.nrows()).map(row).collect::<Vec<_>>().join("; "))
}

fn write_design(
    f: &mut fmt::Formatter<'_>,
    gains: &[(&str, &DMatrix<f64>)],
    poles: &[Complex<f64>],
    certificate: &Certificate,
) -> fmt::Result {
    for (name, gain) in gains {
        write_matrix(f, name, gain)?;
    }
    if !poles.is_empty() {
        let poles: Vec<String> = poles.iter().map(|pole| complex([pole.re, pole.im], DIGITS)).collect();
        writeln!(f, "poles {}", poles.join(", "))?;
    }
    certificate.fmt(f)
}

/// A design by the names and values of its gains, and its poles where it has them.
macro_rules! displayed {
    ($($design:ty: |$d:ident| [$($name:literal = $gain:expr),+] $(, $poles:expr)?;)+) => {
        $(impl Display for $design {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let $d = self;
                write_design(f, &[$(($name, $gain)),+], displayed!(@poles $($poles)?), &$d.certificate)
            }
        })+
    };
    (@poles) => { &[] };
    (@poles $poles:expr) => { $poles };
}

displayed! {
    LinearDesign: |d| ["L" = &d.observer.l], &d.poles;
    CubicDesign: |d| ["L" = &d.observer.l, "N" = &d.observer.n, "theta" = &d.observer.theta];
    DiscreteDesign: |d| ["L" = d.observer.l()], &d.poles;
    SampledCubicDesign: |d| ["L" = d.observer.ld(), "N" = d.observer.n(), "theta" = d.observer.theta()], &d.poles;
    FeedbackDesign: |d| ["K" = &d.k], &d.poles;
    PolytopicDesign: |d| ["L" = &d.nominal.observer.l], &d.nominal.poles;
    GainCertificate: |d| ["L" = &d.l, "N" = &d.n];
    LipschitzDesign: |d| ["L" = &d.l];
    MeanValueDesign: |d| ["L" = &d.l];
    ContractingCoordinates: |d| ["K" = &d.k];
    DeployedLinear: |d| ["L" = &dynamic_matrix(&d.deployed.stored.l)];
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
