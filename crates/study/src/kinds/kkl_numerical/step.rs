//! The numerical KKL observer with a step for each sample.

use luenberger_design::numerical_kkl::{HeldInputs, Settings, without_tables};
use luenberger_export::kkl::Kkl;
use luenberger_expression::ExpressionPlant;
use luenberger_observers::kkl::{LeftInverse, LinearKkl};
use luenberger_observers::numerical_kkl::SampledFilter;
use nalgebra::{Const, SVector};

use super::{Kkl as Designed, KklSpec};
use crate::results::NoObserver;
use crate::study::Study;

/// D and B with the step.
fn filter<I, const N: usize, const Z: usize>(
    map: &LinearKkl<f64, Const<Z>, Const<0>, Const<1>, Const<N>, I>,
    (period, substeps): (f64, usize),
) -> SampledFilter<f64, 1, Z>
where
    I: LeftInverse<f64, Const<Z>, Const<1>, Const<N>>,
{
    SampledFilter { d: *map.d(), b: *map.b(), period, substeps }
}

/// The same of an observer for held inputs.
fn filter_of_held<const N: usize, const M: usize, const Z: usize, const ZM: usize>(
    observer: &HeldInputs<N, M, 1, Z, ZM>,
    (period, substeps): (f64, usize),
) -> SampledFilter<f64, 1, Z> {
    SampledFilter { d: *observer.d(), b: *observer.b(), period, substeps }
}

/// The settings of the fit of a tree.
fn settings<const N: usize>(spec: &KklSpec) -> Settings<N> {
    Settings { leaves: spec.leaves, degree: spec.degree, samples: spec.samples, ..Settings::default() }
}

/// The step in the form of the study: with tables, or with trees alone.
pub(super) fn step(
    (study, spec): (&Study, &KklSpec),
    kkl: &Designed,
    plant: &ExpressionPlant,
    step: (f64, usize),
) -> Result<Kkl<f64>, NoObserver> {
    use Designed as Of;
    let mut first = vec![0.0; study.plant.inputs.len()];
    if let Some(program) = study.input.program() {
        program.at(0.0, &mut first);
    }
    // The sizes of a design are those of its plant.
    macro_rules! held {
        ($observer:expr, $n:literal, $m:literal, $z:literal, $zm:literal, $nm:literal, $zn:literal) => {{
            let (inverse, filter) = ($observer.inverse(), filter_of_held($observer, step));
            let first = SVector::<f64, $m>::from_column_slice(&first);
            if inverse.search().is_some() {
                Kkl::held::<_, $n, $m, $z, $zn>(plant, filter, inverse.clone(), first)?
            } else {
                let trees = without_tables::<$n, $m, $z, $zm, $nm>(inverse, &settings(spec))?;
                Kkl::held::<_, $n, $m, $z, $zn>(plant, filter, trees, first)?
            }
        }};
    }
    macro_rules! plain {
        ($observer:expr) => {
            Kkl::new(plant, filter($observer.map(), step), $observer.map().inverse().clone())?
        };
    }
    Ok(match kkl {
        Of::Two(observer) => plain!(observer),
        Of::TwoEmbedded(observer) => plain!(observer),
        Of::Three(observer) => plain!(observer),
        Of::ThreeEmbedded(observer) => plain!(observer),
        Of::Four(observer) => plain!(observer),
        Of::FourEmbedded(observer) => plain!(observer),
        Of::Five(observer) => plain!(observer),
        Of::FiveEmbedded(observer) => plain!(observer),
        Of::Six(observer) => plain!(observer),
        Of::SixEmbedded(observer) => plain!(observer),
        Of::TwoHeld(observer) => held!(observer, 2, 1, 3, 4, 3, 5),
        Of::TwoHeldTwo(observer) => held!(observer, 2, 2, 3, 5, 4, 5),
        Of::ThreeHeld(observer) => held!(observer, 3, 1, 4, 5, 4, 7),
        Of::ThreeHeldTwo(observer) => held!(observer, 3, 2, 4, 6, 5, 7),
    })
}
