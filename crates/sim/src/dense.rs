//! Dense output: every accepted step as a polynomial.
//!
//! A step is kept by its values at eight Chebyshev points, and evaluated by the barycentric formula. Eight points carry
//! the seventh-order interpolant of DOP853 and the third-order one of Radau IIA without loss, whatever the integrator's
//! own representation, and they serve quantities computed *from* the solution (inputs, outputs, estimates) as well.

use crate::error::SimError;

/// Points kept per step.
pub const NODES: usize = 8;

/// The Chebyshev points `(1 - cos(i pi/7))/2`, which divide [0, 1].
pub const NODE: [f64; NODES] = [
    0.0,
    0.049515566048790434,
    0.18825509907063323,
    0.3887395330218428,
    0.6112604669781572,
    0.8117449009293668,
    0.9504844339512095,
    1.0,
];

/// Start and end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    start: f64,
    end: f64,
}

/// A vector-valued function of time, kept as one polynomial of degree 7 per step of the integrator.
///
/// It may jump between steps (a sample, a new value of the noise); its value at a jump is the one after it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dense {
    /// Where each component is.
    places: Vec<Kept>,
    /// Numbers of components that are constant within each step, and of those that vary.
    constant: usize,
    varying: usize,
    pieces: Vec<Piece>,
    /// One step after the other: the values that are constant, and those of the others at one node after the other.
    values: Vec<f64>,
}

/// How a component is kept, with its number among those that are kept alike.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kept {
    /// Once per step.
    Constant(usize),
    /// At every node.
    Varying(usize),
}

impl Dense {
    /// Of components that all vary within steps.
    #[doc(hidden)]
    pub fn new(width: usize) -> Self {
        Self::of(&vec![false; width])
    }

    /// Of components of which those with true are constant within each step.
    #[doc(hidden)]
    pub fn of(is_constant: &[bool]) -> Self {
        let (mut constant, mut varying) = (0, 0);
        let place = |is_constant: &bool| {
            let count = if *is_constant { &mut constant } else { &mut varying };
            *count += 1;
            if *is_constant { Kept::Constant(*count - 1) } else { Kept::Varying(*count - 1) }
        };
        let places = is_constant.iter().map(place).collect();
        Self { places, constant, varying, pieces: Vec::new(), values: Vec::new() }
    }

    /// Appends a step, given the values that are constant, and the others at the nodes.
    #[doc(hidden)]
    pub fn push(&mut self, start: f64, end: f64, constant: &[f64], values: &[f64]) {
        assert_eq!((constant.len(), values.len()), (self.constant, NODES * self.varying));
        self.pieces.push(Piece { start, end });
        self.values.extend_from_slice(constant);
        self.values.extend_from_slice(values);
    }

    /// The component that is entry `index` of the varying ones.
    #[doc(hidden)]
    pub fn varying(&self, index: usize) -> usize {
        self.places.iter().position(|place| *place == Kept::Varying(index)).unwrap_or(index)
    }

    /// The component that is entry `index` of the constant ones.
    #[doc(hidden)]
    pub fn constant(&self, index: usize) -> usize {
        self.places.iter().position(|place| *place == Kept::Constant(index)).unwrap_or(index)
    }

    /// The values of step `index` that are constant, and those at the nodes.
    fn of_step(&self, index: usize) -> (&[f64], &[f64]) {
        let length = self.constant + NODES * self.varying;
        self.values[index * length..][..length].split_at(self.constant)
    }

    /// Number of components.
    pub fn width(&self) -> usize {
        self.places.len()
    }

    /// Start and end of the span.
    pub fn span(&self) -> (f64, f64) {
        match (self.pieces.first(), self.pieces.last()) {
            (Some(first), Some(last)) => (first.start, last.end),
            _ => (0.0, 0.0),
        }
    }

    /// The steps, each by its start and end.
    pub fn steps(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.pieces.iter().map(|piece| (piece.start, piece.end))
    }

    /// Calls `visit` with the time and these components at every point that is kept.
    #[doc(hidden)]
    pub fn visit(&self, components: &[usize], mut visit: impl FnMut(f64, &[f64])) {
        let mut row = vec![0.0; components.len()];
        for (index, Piece { start, end }) in self.pieces.iter().enumerate() {
            let (constant, values) = self.of_step(index);
            for (i, node) in NODE.iter().enumerate() {
                for (entry, component) in row.iter_mut().zip(components) {
                    *entry = match self.places[*component] {
                        Kept::Constant(k) => constant[k],
                        Kept::Varying(k) => values[i * self.varying + k],
                    };
                }
                visit(start + node * (end - start), &row);
            }
        }
    }

    /// How many numbers are kept: for each step one of every constant component, and eight of every other.
    #[doc(hidden)]
    pub fn stored(&self) -> usize {
        self.values.len()
    }

    /// Number of steps.
    pub fn step_count(&self) -> usize {
        self.pieces.len()
    }

    /// The value at `t`.
    ///
    /// # Errors
    /// [`SimError::Outside`] when `t` is not within the span.
    pub fn at(&self, t: f64) -> Result<Vec<f64>, SimError> {
        let mut value = vec![0.0; self.width()];
        self.on_step(self.step_at(t)?, t, 0, &mut value);
        Ok(value)
    }

    /// The step that `t` lies in, the later one at a seam.
    pub(crate) fn step_at(&self, t: f64) -> Result<usize, SimError> {
        let (start, end) = self.span();
        if self.pieces.is_empty() || !(start..=end).contains(&t) {
            return Err(SimError::Outside { time: t, start, end });
        }
        Ok(self.pieces.partition_point(|piece| piece.start <= t).saturating_sub(1))
    }

    /// The step at `t`, which is not before the start, with its span; the last one beyond the end.
    pub(crate) fn step_near(&self, t: f64) -> (usize, (f64, f64)) {
        let index = self.pieces.partition_point(|piece| piece.start <= t).saturating_sub(1);
        (index, (self.pieces[index].start, self.pieces[index].end))
    }

    /// Start and end of step `index`, which must exist.
    pub(crate) fn step(&self, index: usize) -> (f64, f64) {
        (self.pieces[index].start, self.pieces[index].end)
    }

    /// One component at the nodes of step `index`.
    #[doc(hidden)]
    pub fn nodes(&self, index: usize, component: usize) -> [f64; NODES] {
        let (constant, values) = self.of_step(index);
        match self.places[component] {
            Kept::Constant(k) => [constant[k]; NODES],
            Kept::Varying(k) => core::array::from_fn(|i| values[i * self.varying + k]),
        }
    }

    /// Components `offset..offset + value.len()` at `t` by the polynomial of step `index`, which must exist.
    pub(crate) fn on_step(&self, index: usize, t: f64, offset: usize, value: &mut [f64]) {
        let (constant, values) = self.of_step(index);
        let place = Place::of(self.step(index), t);
        for (entry, kept) in value.iter_mut().zip(&self.places[offset..]) {
            *entry = match *kept {
                Kept::Constant(k) => constant[k],
                Kept::Varying(k) => place.value_of(|i| values[i * self.varying + k]),
            };
        }
    }

    /// One component at `t` by the polynomial of step `index`.
    pub(crate) fn component(&self, index: usize, t: f64, component: usize) -> f64 {
        let mut value = [0.0];
        self.on_step(index, t, component, &mut value);
        value[0]
    }
}

/// Where a time lies on a step: on a node, or between nodes with its barycentric weights.
pub(crate) enum Place {
    Node(usize),
    Between { weights: [f64; NODES], total: f64 },
}

impl Place {
    pub(crate) fn of((start, end): (f64, f64), t: f64) -> Self {
        // Barycentric weights of Chebyshev points: alternating signs, halved at the ends.
        const WEIGHTS: [f64; NODES] = [0.5, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -0.5];
        let s = (t - start) / (end - start);
        let distances: [f64; NODES] = core::array::from_fn(|i| s - NODE[i]);
        if let Some(i) = distances.iter().position(|distance| *distance == 0.0) {
            return Self::Node(i);
        }
        let weights: [f64; NODES] = core::array::from_fn(|i| WEIGHTS[i] / distances[i]);
        Self::Between { weights, total: weights.iter().sum() }
    }

    /// The polynomial with these values at the nodes.
    pub(crate) fn value(&self, nodes: &[f64; NODES]) -> f64 {
        self.value_of(|i| nodes[i])
    }

    fn value_of(&self, node: impl Fn(usize) -> f64) -> f64 {
        match self {
            Self::Node(i) => node(*i),
            Self::Between { weights, total } => (0..NODES).map(|i| weights[i] * node(i)).sum::<f64>() / total,
        }
    }
}

/// What encloses the polynomial with these values at the nodes, on its step: by the Lebesgue constant of eight
/// Chebyshev points, which is below 3, about the middle of the values. `None` for values that are not finite.
pub fn enclosure(nodes: &[f64; NODES]) -> Option<(f64, f64)> {
    let (low, high) = nodes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let (middle, radius) = (low + (high - low) / 2.0, 1.5 * (high - low));
    (nodes.iter().all(|v| v.is_finite()) && radius.is_finite()).then_some((middle - radius, middle + radius))
}
