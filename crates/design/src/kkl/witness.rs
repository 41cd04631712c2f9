//! Witnesses of a failed check: points, pairs of states, entries of B and xi.

use core::fmt;

use luenberger_plants::Dimensions;
use luenberger_proof::Interval;
use luenberger_proof::wording::{at_least, at_most, shortest, significant};

/// A point of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxPoint {
    /// x.
    pub state: Vec<f64>,
    /// u.
    pub input: Vec<f64>,
    /// t.
    pub time: f64,
}

impl BoxPoint {
    /// The lower corner: of a point, the point.
    pub(super) fn of(axes: &[Interval], size: Dimensions) -> Self {
        let lower: Vec<f64> = axes.iter().map(Interval::lo).collect();
        let (state, rest) = lower.split_at(size.states);
        let (input, time) = rest.split_at(size.inputs);
        Self { state: state.to_vec(), input: input.to_vec(), time: time.first().copied().unwrap_or(0.0) }
    }
}

impl fmt::Display for BoxPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "x = {:?}", self.state)?;
        if self.input.is_empty() { Ok(()) } else { write!(f, ", u = {:?}", self.input) }
    }
}

/// The residual of one row at one point.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualWitness {
    /// The row, from 0.
    pub row: usize,
    /// The magnitude of the residual is not below this: proved.
    pub at_least: f64,
    /// The largest of `|Dphi f| + |Lambda| |phi| + |B|` over the sampled points, for this row.
    pub scale: f64,
    /// Where.
    pub place: BoxPoint,
}

impl fmt::Display for ResidualWitness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { row, at_least: least, scale, place } = self;
        let (bound, share) = (at_least(*least, 4), significant(least / scale, 2));
        write!(f, "the residual of row {} is at least {bound}, about {share} of its terms, at {place}", row + 1)
    }
}

/// An entry of B that depends on an entry of xi which it may not read.
#[derive(Clone, Debug, PartialEq)]
pub struct CouplingWitness {
    /// The entry of B, from 0.
    pub row: usize,
    /// The entry of xi, from 0: not before it.
    pub entry: usize,
    /// Enclosure of the derivative of the entry of B by the entry of xi near the point: proved not to be 0.
    pub slope: Interval,
    /// x, u and t.
    pub place: BoxPoint,
    /// xi.
    pub xi: Vec<f64>,
}

impl fmt::Display for CouplingWitness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { row, entry, slope, place, xi } = self;
        let (row, entry, [lo, hi]) = (row + 1, entry + 1, [slope.lo(), slope.hi()].map(shortest));
        write!(f, "dB{row}/dxi{entry} is in [{lo}, {hi}] at {place}, xi = {xi:?}")
    }
}

/// The condition violated by an entry of xi on which B depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CouplingObjection {
    /// It is not before the entry of B that reads it, or was not shown not to be read.
    NotEarlier,
    /// It is only integrated: its error does not decay.
    Integrated,
    /// Lambda and B feed back to it: the entries form a loop.
    WayBack,
    /// No Lipschitz constant was shown.
    NotLipschitz,
}

/// The entry of B, the entry of xi, and the violated condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenCoupling {
    /// The entry of B, from 0.
    pub row: usize,
    /// The entry of xi, from 0.
    pub entry: usize,
    /// The violated condition.
    pub why: CouplingObjection,
}

impl fmt::Display for OpenCoupling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (row, entry) = (self.row + 1, self.entry + 1);
        match self.why {
            CouplingObjection::NotEarlier => write!(f, "B{row} was not shown to be independent of xi{entry}"),
            CouplingObjection::Integrated => write!(f, "B{row} may read xi{entry}, which is only integrated"),
            CouplingObjection::WayBack => write!(f, "B{row} may read xi{entry}, on which xi{row} may act back"),
            CouplingObjection::NotLipschitz => {
                write!(f, "B{row} may read xi{entry}, and was not shown to be Lipschitz in it")
            }
        }
    }
}

/// Two states that have one image, verified.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonImage {
    /// The first state.
    pub first: Vec<f64>,
    /// The other is a state between these bounds: numbers where it is known exactly.
    pub second: Vec<Interval>,
}

impl fmt::Display for CommonImage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bounds =
            |x: &Interval| if x.is_point() { format!("{:?}", x.lo()) } else { format!("[{:?}, {:?}]", x.lo(), x.hi()) };
        let second: Vec<String> = self.second.iter().map(bounds).collect();
        write!(f, "{:?} and a state in ({}) have one image", self.first, second.join(", "))
    }
}

/// Two states whose images under (phi, h) are close. This is no proof that any two are equal.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoStates {
    /// One.
    pub first: Vec<f64>,
    /// The other.
    pub second: Vec<f64>,
    /// `|x - x'|`.
    pub distance: f64,
    /// `|Phi(x) - Phi(x')|` is at most this: proved.
    pub gap: f64,
}

impl fmt::Display for TwoStates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first, second, distance, gap } = self;
        let (distance, gap) = (significant(*distance, 4), at_most(*gap, 2));
        write!(f, "{first:?} and {second:?}, {distance} apart, have images at most {gap} apart")
    }
}
