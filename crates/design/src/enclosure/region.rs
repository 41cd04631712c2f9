//! The box of the plant's state and its estimate, with the intervals of inputs and times.

use core::fmt;

use luenberger_plants::Dimensions;
use luenberger_proof::Interval;

use super::error::EnclosureError;
use super::place::Axis;

/// Default number of bisections for tightening, see [`Region::subdivisions`].
const SUBDIVISIONS: usize = 400;

/// A box of states, with bounds of inputs and time. Ends may be infinite.
///
/// ```
/// use luenberger_design::Region;
/// // x1 in [-3, -0.3], x2 anything, u in [-1, 1], at any time.
/// let region = Region::new(&[(-3.0, -0.3), (f64::NEG_INFINITY, f64::INFINITY)]).inputs(&[(-1.0, 1.0)]);
/// assert_eq!(region.states()[0], (-3.0, -0.3));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    states: Vec<(f64, f64)>,
    inputs: Option<Vec<(f64, f64)>>,
    time: (f64, f64),
    subdivisions: usize,
}

impl Region {
    /// The box of states with these lower and upper bounds; every input and every time.
    pub fn new(states: &[(f64, f64)]) -> Self {
        let time = (f64::NEG_INFINITY, f64::INFINITY);
        Self { states: states.to_vec(), inputs: None, time, subdivisions: SUBDIVISIONS }
    }

    /// All of the state space of n states: for plants whose Jacobian is bounded everywhere.
    pub fn everywhere(n: usize) -> Self {
        Self::new(&vec![(f64::NEG_INFINITY, f64::INFINITY); n])
    }

    /// The inputs lie between these bounds. Without this they are arbitrary, which costs nothing where the Jacobian
    /// does not depend on them.
    #[must_use]
    pub fn inputs(mut self, inputs: &[(f64, f64)]) -> Self {
        self.inputs = Some(inputs.to_vec());
        self
    }

    /// Times lie between these bounds. Without this they are arbitrary.
    #[must_use]
    pub fn time(mut self, from: f64, to: f64) -> Self {
        self.time = (from, to);
        self
    }

    /// Largest number of bisections for a tighter enclosure (default 400; 0 evaluates the box as a whole where that has
    /// a result). Fewer are made where samples show that bisection gains nothing.
    #[must_use]
    pub fn subdivisions(mut self, subdivisions: usize) -> Self {
        self.subdivisions = subdivisions;
        self
    }

    /// The bounds of the states.
    pub fn states(&self) -> &[(f64, f64)] {
        &self.states
    }

    /// The bounds of the inputs; none if they are arbitrary.
    pub fn input_bounds(&self) -> Option<&[(f64, f64)]> {
        self.inputs.as_deref()
    }

    /// The bounds of the time, infinite by default.
    pub fn time_bounds(&self) -> (f64, f64) {
        self.time
    }

    /// The bisections allowed.
    pub(crate) fn budget(&self) -> usize {
        self.subdivisions
    }

    /// One interval for each state, then each input, then time.
    pub(crate) fn axes(&self, size: Dimensions) -> Result<Vec<Interval>, EnclosureError> {
        let unbounded = vec![(f64::NEG_INFINITY, f64::INFINITY); size.inputs];
        let inputs = self.inputs.as_ref().unwrap_or(&unbounded);
        for (what, expected, found) in
            [("states", size.states, self.states.len()), ("inputs", size.inputs, inputs.len())]
        {
            if expected != found {
                return Err(EnclosureError::Dimension { what, expected, found });
            }
        }
        let bounds = self.states.iter().chain(inputs).chain([&self.time]);
        let axis = |k: usize| Axis::of(k, size);
        bounds
            .enumerate()
            .map(|(k, &(lo, hi))| Interval::new(lo, hi).ok_or(EnclosureError::Bounds { axis: axis(k), lo, hi }))
            .collect()
    }
}

impl fmt::Display for Region {
    /// The finite bounds; "everywhere" if there is none.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let states = self.states.iter().enumerate().map(|(k, bounds)| (Axis::State(k), bounds));
        let inputs = self.inputs.iter().flatten().enumerate().map(|(k, bounds)| (Axis::Input(k), bounds));
        let bounds: Vec<String> = states
            .chain(inputs)
            .chain([(Axis::Time, &self.time)])
            .filter(|(_, (lo, hi))| lo.is_finite() || hi.is_finite())
            .map(|(axis, (lo, hi))| format!("{axis} in [{lo}, {hi}]"))
            .collect();
        f.write_str(&if bounds.is_empty() { "everywhere".to_owned() } else { bounds.join(", ") })
    }
}
