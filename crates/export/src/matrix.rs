//! Which matrix of an observer an exported one is. Its name is for the text alone.

use luenberger_observers::MatrixName;

/// A matrix of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ExportedMatrix {
    /// That of the observer.
    Of(MatrixName),
    /// The gain K of the feedback `u = r - K xhat`.
    Feedback,
    /// The gain of an observer in filter form, from the innovation to the estimate at the sample.
    Update,
    /// The ends of the bounds of a moving-horizon estimator, in a row.
    Bounds,
    /// The matrix of the filter of a numerical KKL observer.
    Filter,
    /// The mean of the coordinates of a left inverse.
    Mean,
    /// To the coordinates of a left inverse.
    Whiten,
    /// From the coordinates of a left inverse.
    Colour,
    /// The lower ends of the box of a left inverse.
    Lower,
    /// The upper ends of the box of a left inverse.
    Upper,
    /// The lower ends of a family of inputs.
    LeastInput,
    /// The upper ends of a family of inputs.
    MostInput,
    /// The input that is held at the start.
    FirstInput,
}

impl ExportedMatrix {
    /// The name in the emitted code.
    pub const fn name(self) -> &'static str {
        match self {
            // A program has the matrices over a period, or those of continuous time.
            Self::Of(MatrixName::Ad) => "A",
            Self::Of(MatrixName::Bd) => "B",
            Self::Of(MatrixName::Ld) => "L",
            Self::Of(MatrixName::K) => "GAIN",
            Self::Of(MatrixName::Theta) => "THETA",
            Self::Of(MatrixName::Coupling) => "G",
            Self::Of(MatrixName::P0) => "P0",
            Self::Of(MatrixName::RootW) => "ROOT_W",
            Self::Of(MatrixName::RootV) => "ROOT_V",
            Self::Of(MatrixName::RootP0) => "ROOT_P0",
            Self::Of(MatrixName::Turns) => "TURNS",
            Self::Of(MatrixName::StateTurns) => "STATE_TURNS",
            Self::Of(MatrixName::UnitVectors) => "UNIT_VECTORS",
            Self::Of(matrix) => matrix.text(),
            Self::Feedback => "K",
            Self::Update => "UPDATE",
            Self::Bounds => "BOUNDS",
            Self::Filter => "FILTER",
            Self::Mean => "MEAN",
            Self::Whiten => "WHITEN",
            Self::Colour => "COLOUR",
            Self::Lower => "LOWER",
            Self::Upper => "UPPER",
            Self::LeastInput => "LEAST_INPUT",
            Self::MostInput => "MOST_INPUT",
            Self::FirstInput => "FIRST_INPUT",
        }
    }
}

impl From<MatrixName> for ExportedMatrix {
    fn from(matrix: MatrixName) -> Self {
        Self::Of(matrix)
    }
}
