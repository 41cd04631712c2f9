//! The numerical KKL observers of two to six states.

use std::sync::Arc;

use luenberger_design::numerical_kkl::{Embedded, HeldInputs, Interpolated, Train};
use luenberger_observers::numerical_kkl::NumericalKklObserver;
use luenberger_sim::AnyObserver;

use super::continuous;

/// The observer, for two to six states.
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
    /// Four states, the accurate form.
    Four(Box<NumericalKklObserver<Interpolated<4, 5>, f64, 4, 0, 1, 5>>),
    /// Four states, the tree of polynomials.
    FourEmbedded(Box<NumericalKklObserver<Embedded<4, 5>, f64, 4, 0, 1, 5>>),
    /// Five states, the accurate form, with a table of low rank.
    Five(Box<NumericalKklObserver<Interpolated<5, 6, Train<5, 6>>, f64, 5, 0, 1, 6>>),
    /// Five states, the tree of polynomials.
    FiveEmbedded(Box<NumericalKklObserver<Embedded<5, 6>, f64, 5, 0, 1, 6>>),
    /// Six states, the accurate form, with a table of low rank.
    Six(Box<NumericalKklObserver<Interpolated<6, 7, Train<6, 7>>, f64, 6, 0, 1, 7>>),
    /// Six states, the tree of polynomials.
    SixEmbedded(Box<NumericalKklObserver<Embedded<6, 7>, f64, 6, 0, 1, 7>>),
    /// Two states and one held input, in both forms.
    TwoHeld(Box<HeldInputs<2, 1, 1, 3, 4>>),
    /// Two states and two held inputs.
    TwoHeldTwo(Box<HeldInputs<2, 2, 1, 3, 5>>),
    /// Three states and one held input.
    ThreeHeld(Box<HeldInputs<3, 1, 1, 4, 5>>),
    /// Three states and two held inputs.
    ThreeHeldTwo(Box<HeldInputs<3, 2, 1, 4, 6>>),
}

impl Kkl {
    /// As one that is simulated, whatever its size.
    pub(super) fn any(&self) -> Arc<dyn AnyObserver + '_> {
        match self {
            Self::Two(observer) => continuous(observer.as_ref()),
            Self::TwoEmbedded(observer) => continuous(observer.as_ref()),
            Self::Three(observer) => continuous(observer.as_ref()),
            Self::ThreeEmbedded(observer) => continuous(observer.as_ref()),
            Self::Four(observer) => continuous(observer.as_ref()),
            Self::FourEmbedded(observer) => continuous(observer.as_ref()),
            Self::Five(observer) => continuous(observer.as_ref()),
            Self::FiveEmbedded(observer) => continuous(observer.as_ref()),
            Self::Six(observer) => continuous(observer.as_ref()),
            Self::SixEmbedded(observer) => continuous(observer.as_ref()),
            Self::TwoHeld(observer) => continuous(observer.as_ref()),
            Self::TwoHeldTwo(observer) => continuous(observer.as_ref()),
            Self::ThreeHeld(observer) => continuous(observer.as_ref()),
            Self::ThreeHeldTwo(observer) => continuous(observer.as_ref()),
        }
    }
}
