//! Which matrix of an observer a number belongs to.

/// A matrix of an observer: what its list of numbers has there.
///
/// ```
/// use luenberger_observers::{LinearObserver, MatrixName};
/// use nalgebra::{DMatrix, Dyn, dmatrix};
/// let plant = luenberger_plants::double_integrator().to_dynamic();
/// let observer = LinearObserver::of(plant, dmatrix![7.0; 10.0])?;
/// // The same with half the gain.
/// let half = |name, m: &DMatrix<f64>| if name == MatrixName::L { m * 0.5 } else { m.clone() };
/// let slower: LinearObserver<f64, Dyn, Dyn, Dyn> = observer.map(half)?;
/// assert_eq!(slower.l, dmatrix![3.5; 5.0]);
/// assert_eq!(MatrixName::Theta.text(), "theta");
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MatrixName {
    /// A of the plant.
    A,
    /// A over a period.
    Ad,
    /// B of the plant.
    B,
    /// B over a period.
    Bd,
    /// C of the plant.
    C,
    /// The feedthrough D.
    D,
    /// The gain L.
    L,
    /// The gain L over a period.
    Ld,
    /// N of a cubic part, or the blocks of an interval observer.
    N,
    /// The weights of a cubic part.
    Theta,
    /// A gain from innovations to the estimate at the sample.
    K,
    /// -C N of a semi-implicit cubic part.
    Coupling,
    /// F of `z' = F z + ..`.
    F,
    /// G, of the outputs or inputs in the same.
    G,
    /// H, of the outputs in the estimate.
    H,
    /// The intensity of the process noise.
    W,
    /// The covariance of a measurement.
    V,
    /// The covariance of the first error.
    P0,
    /// A factor of W.
    RootW,
    /// A factor of V.
    RootV,
    /// A factor of the covariance of the first error.
    RootP0,
    /// What the estimate adds to the bounds of an interval observer.
    Q,
    /// What the input adds to the bounds of an interval observer.
    U,
    /// What is added to the bounds of an interval observer in any case.
    Constant,
    /// The first bounds of an interval observer.
    Rho,
    /// The full turns of the outputs that are angles.
    Turns,
    /// The full turns of the states that are angles.
    StateTurns,
    /// The numbers of the unit vectors that states form.
    UnitVectors,
}

impl MatrixName {
    /// As errors and texts call it.
    pub const fn text(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::Ad => "Ad",
            Self::B => "B",
            Self::Bd => "Bd",
            Self::C => "C",
            Self::D => "D",
            Self::L => "L",
            Self::Ld => "Ld",
            Self::N => "N",
            Self::Theta => "theta",
            Self::K => "K",
            Self::Coupling => "-C N",
            Self::F => "F",
            Self::G => "G",
            Self::H => "H",
            Self::W => "W",
            Self::V => "V",
            Self::P0 => "P(0)",
            Self::RootW => "W^(1/2)",
            Self::RootV => "V^(1/2)",
            Self::RootP0 => "P(0)^(1/2)",
            Self::Q => "Q",
            Self::U => "U",
            Self::Constant => "g",
            Self::Rho => "rho",
            Self::Turns => "turns",
            Self::StateTurns => "turns of the states",
            Self::UnitVectors => "unit vectors",
        }
    }

    /// Whether its columns belong to the inputs.
    pub const fn is_of_inputs(self) -> bool {
        matches!(self, Self::B | Self::Bd | Self::D)
    }
}
