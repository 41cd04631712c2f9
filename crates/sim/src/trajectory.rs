//! What a run leaves: samples at the requested times, and every quantity in between by dense output.

use luenberger_plants::Dimensions;
use nalgebra::DMatrix;

use crate::dense::Dense;
use crate::error::SimError;
use crate::events::Trace;
use crate::view::View;

/// Where things stand in a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    pub(crate) size: Dimensions,
    pub(crate) names: Vec<String>,
    pub(crate) observers: Vec<ObserverLayout>,
    /// Where the integrals begin.
    pub(crate) integrals: usize,
    /// The length of a row.
    pub(crate) width: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ObserverLayout {
    /// Where the estimate begins; its state ends there.
    pub(crate) estimate: usize,
    /// Which states of the plant it estimates.
    pub(crate) states: Vec<usize>,
}

/// What a run leaves: samples at the requested times, and everything in between by dense output.
///
/// Matrices have one row per requested time and one column per component.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// The requested times.
    pub t: Vec<f64>,
    /// States of the plant.
    pub x: DMatrix<f64>,
    /// Inputs.
    pub u: DMatrix<f64>,
    /// Outputs, without noise.
    pub y: DMatrix<f64>,
    /// The observers, in the order they were added.
    pub observers: Vec<ObserverTrajectory>,
    /// The integrals, in the order they were added.
    pub integrals: Vec<IntegralTrajectory>,
    /// Steps the integrator attempted.
    pub steps: usize,
    dense: Dense,
    layout: Layout,
}

/// What one observer did.
#[derive(Clone, Debug, PartialEq)]
pub struct ObserverTrajectory {
    /// Its name.
    pub name: String,
    /// Estimates.
    pub estimate: DMatrix<f64>,
    /// Errors, `x - xhat` in the states it estimates.
    pub error: DMatrix<f64>,
    /// Its own states.
    pub state: DMatrix<f64>,
    /// Which states of the plant it estimates, from 0.
    pub states: Vec<usize>,
}

/// One integral.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegralTrajectory {
    /// Its name.
    pub name: String,
    /// Its values.
    pub value: Vec<f64>,
}

impl Trajectory {
    /// From the sampled rows of a run: `lengths` are those of the observers' own states, `integrals` their names.
    pub(crate) fn new(
        times: &[f64],
        lengths: &[usize],
        integrals: Vec<String>,
        layout: Layout,
        samples: &[f64],
        dense: Dense,
        steps: usize,
    ) -> Self {
        let rows = times.len();
        let block = |offset: usize, columns: usize| {
            DMatrix::from_fn(rows, columns, |i, j| samples[i * layout.width + offset + j])
        };
        let Dimensions { states: n, inputs: m, outputs: p } = layout.size;
        let x = block(0, n);
        let observers = layout.observers.iter().zip(lengths).zip(&layout.names).map(|((place, &length), name)| {
            let estimate = block(place.estimate, place.states.len());
            let error = DMatrix::from_fn(rows, place.states.len(), |i, j| x[(i, place.states[j])] - estimate[(i, j)]);
            let state = block(place.estimate - length, length);
            ObserverTrajectory { name: name.clone(), estimate, error, state, states: place.states.clone() }
        });
        let observers = observers.collect();
        let value = |k: usize| block(layout.integrals + k, 1).as_slice().to_vec();
        let named = |(k, name)| IntegralTrajectory { name, value: value(k) };
        let integrals = integrals.into_iter().enumerate().map(named).collect();
        let (u, y) = (block(n, m), block(n + m, p));
        Self { t: times.to_vec(), x, u, y, observers, integrals, steps, dense, layout }
    }

    /// The observer of that name.
    ///
    /// # Errors
    /// [`SimError::UnknownName`].
    pub fn observer(&self, name: &str) -> Result<&ObserverTrajectory, SimError> {
        self.observers.iter().find(|o| o.name == name).ok_or_else(|| SimError::UnknownName { name: name.to_owned() })
    }

    /// The values of the integral of that name.
    ///
    /// # Errors
    /// [`SimError::UnknownName`].
    pub fn integral(&self, name: &str) -> Result<&[f64], SimError> {
        let found = self.integrals.iter().find(|integral| integral.name == name);
        found.map(|i| i.value.as_slice()).ok_or_else(|| SimError::UnknownName { name: name.to_owned() })
    }

    /// Start and end of the run.
    pub fn span(&self) -> (f64, f64) {
        self.dense.span()
    }

    /// The steps of the integrator that were accepted, each by its start and end.
    pub fn step_spans(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.dense.steps()
    }

    /// Any quantity as a function of time, from the dense output.
    ///
    /// ```
    /// # let plant = luenberger_plants::double_integrator();
    /// let trajectory = luenberger_sim::Scenario::new(plant).initial_state(&[0.0, 1.0]).until(2.0, 2).run()?;
    /// let product = trajectory.trace(|view| view.x[0] * view.x[1]);
    /// assert!((product.at(1.7)? - 1.7).abs() < 1e-12);
    /// # Ok::<(), luenberger_sim::SimError>(())
    /// ```
    pub fn trace<'t>(&'t self, quantity: impl Fn(&View<'_>) -> f64 + 't) -> Trace<'t> {
        let layout = &self.layout;
        let Dimensions { states: n, inputs: m, outputs: p } = layout.size;
        Trace::new(&self.dense, move |t, row| {
            let estimates: Vec<Vec<f64>> =
                layout.observers.iter().map(|o| row[o.estimate..o.estimate + o.states.len()].to_vec()).collect();
            let error = |(o, estimate): (&ObserverLayout, &Vec<f64>)| {
                o.states.iter().zip(estimate).map(|(&i, estimate)| row[i] - estimate).collect()
            };
            let errors: Vec<Vec<f64>> = layout.observers.iter().zip(&estimates).map(error).collect();
            quantity(&View {
                t,
                x: &row[..n],
                u: &row[n..n + m],
                y: &row[n + m..n + m + p],
                names: &layout.names,
                estimates: &estimates,
                errors: &errors,
            })
        })
    }

    /// Component `component` (from 0) of the error of an observer as a function of time.
    ///
    /// # Errors
    /// [`SimError::UnknownName`], [`SimError::Index`].
    pub fn error_trace(&self, observer: &str, component: usize) -> Result<Trace<'_>, SimError> {
        let unknown = || SimError::UnknownName { name: observer.to_owned() };
        let k = self.layout.names.iter().position(|name| name == observer).ok_or_else(unknown)?;
        let ObserverLayout { estimate, states } = &self.layout.observers[k];
        let count = states.len();
        let Some(&state) = states.get(component) else {
            return Err(SimError::Index { what: "component of the error", index: component, count });
        };
        let entry = estimate + component;
        Ok(Trace::new(&self.dense, move |_, row| row[state] - row[entry]))
    }

    /// The value of an integral as a function of time.
    ///
    /// # Errors
    /// [`SimError::UnknownName`].
    pub fn integral_trace(&self, name: &str) -> Result<Trace<'_>, SimError> {
        let position = self.integrals.iter().position(|integral| integral.name == name);
        let k = position.ok_or_else(|| SimError::UnknownName { name: name.to_owned() })?;
        let entry = self.layout.integrals + k;
        Ok(Trace::new(&self.dense, move |_, row| row[entry]))
    }
}
