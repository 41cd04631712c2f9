//! Result of a run: samples at the requested times, and every quantity in between by dense output.

use luenberger_plants::{Dimensions, wrap};
use nalgebra::DMatrix;

use crate::dense::Dense;
use crate::error::{SimError, check_positive};
use crate::events::{Difference, Trace};
use crate::sample_times::SampleTime;
use crate::score_grid::ScoreGrid;
use crate::sensor::Sampling;
use crate::updates::{Estimates, SampleEstimates, Updates};
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
    /// Which entries of a row are constant within each step.
    pub(crate) constant: Vec<bool>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ObserverLayout {
    /// Where the estimate begins; its state ends there.
    pub(crate) estimate: usize,
    /// Where in a row there is what it estimates: states of the plant, or functions of them behind the estimate.
    pub(crate) of: Vec<usize>,
    /// The full turns of these, 0 for what is no angle.
    pub(crate) turns: Vec<f64>,
    /// Its sampling period; none in continuous time.
    pub(crate) period: Option<f64>,
}

impl Layout {
    /// Where the outputs begin as the observers read them.
    pub(crate) fn measured(&self) -> usize {
        self.size.states + self.size.inputs + self.size.outputs
    }

    /// The name of an entry of a row.
    pub(crate) fn name(&self, entry: usize) -> String {
        let Dimensions { states: n, inputs: m, outputs: p } = self.size;
        for (observer, name) in self.observers.iter().zip(&self.names) {
            if let Some(&of) = entry.checked_sub(observer.estimate).and_then(|k| observer.of.get(k)) {
                return match of.checked_sub(observer.estimate + observer.of.len()) {
                    Some(function) => format!("zhat{} of {name:?}", function + 1),
                    None => format!("xhat{} of {name:?}", of + 1),
                };
            }
            if let Some(function) = observer.of.iter().position(|&of| of == entry && of >= observer.estimate) {
                return format!("z{} of {name:?}", function + 1);
            }
        }
        match entry {
            _ if entry < n => format!("x{}", entry + 1),
            _ if entry < n + m => format!("u{}", entry - n + 1),
            _ if entry < n + m + 2 * p => format!("y{}", (entry - n - m) % p + 1),
            _ if entry >= self.integrals => format!("integral {}", entry - self.integrals + 1),
            _ => {
                let of = self.observers.iter().zip(&self.names).find(|(observer, _)| entry < observer.estimate);
                of.map_or_else(|| "a state".to_owned(), |(_, name)| format!("a state of {name:?}"))
            }
        }
    }
}

/// Result of a run: samples at the requested times, and every quantity in between by dense output.
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
    /// Outputs as the observers read them, with noise and disturbances: the measurement of a periodic sensor is held
    /// until the next one is due; NaN where there is no measurement.
    pub measured: DMatrix<f64>,
    /// The observers, in the order they were added.
    pub observers: Vec<ObserverTrajectory>,
    /// The integrals, in the order they were added.
    pub integrals: Vec<IntegralTrajectory>,
    /// Steps the integrator attempted.
    pub steps: usize,
    dense: Dense,
    /// Everything at the end, after what happens there.
    last: Vec<f64>,
    layout: Layout,
    sampling: Sampling,
}

/// Trajectory of one observer: one row per requested time.
#[derive(Clone, Debug, PartialEq)]
pub struct ObserverTrajectory {
    /// Its name.
    pub name: String,
    /// Estimates.
    pub estimate: DMatrix<f64>,
    /// Errors, `x - xhat` in the states it estimates, or `K x - zhat`.
    pub error: DMatrix<f64>,
    /// Its own states.
    pub state: DMatrix<f64>,
    /// Which states of the plant it estimates, from 0; none if it estimates functions of the state.
    pub states: Vec<usize>,
    /// Its sampling period, over which the estimate is constant; none in continuous time.
    pub period: Option<f64>,
    /// Its samples, of an observer that is corrected at varying periods; otherwise none.
    pub samples: Vec<SampleTime>,
    /// Its estimates at its samples before and after their measurements, of a sampled filter.
    pub at_samples: Option<SampleEstimates>,
}

/// One integral.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegralTrajectory {
    /// Its name.
    pub name: String,
    /// Its values.
    pub value: Vec<f64>,
}

impl ObserverTrajectory {
    /// The estimates at the times of the run, one row each: of a sampled filter at a sample those before or after its
    /// measurement, of other observers, and between samples, [`estimate`](Self::estimate).
    pub fn estimates(&self, times: &[f64], estimates: Estimates) -> DMatrix<f64> {
        let mut all = self.estimate.rows(0, times.len().min(self.estimate.nrows())).into_owned();
        let Some(at_samples) = &self.at_samples else { return all };
        for (k, t) in times.iter().enumerate().take(all.nrows()) {
            if let Some(sample) = at_samples.at(*t) {
                all.set_row(k, &at_samples.of(estimates).row(sample));
            }
        }
        all
    }
}

impl Trajectory {
    /// From the sampled rows of a run: `lengths` are those of the observers' own states, `integrals` their names.
    pub(crate) fn new(
        times: &[f64],
        lengths: &[usize],
        integrals: Vec<String>,
        layout: Layout,
        samples: &[f64],
        (dense, steps, sampling, due, updates): (Dense, usize, Sampling, Vec<Vec<SampleTime>>, Vec<Updates>),
    ) -> Self {
        let rows = times.len();
        let block = |offset: usize, columns: usize| {
            DMatrix::from_fn(rows, columns, |i, j| samples[i * layout.width + offset + j])
        };
        let Dimensions { states: n, inputs: m, outputs: p } = layout.size;
        let x = block(0, n);
        let places = layout.observers.iter().zip(lengths).zip(&layout.names).zip(due).zip(updates);
        let observers = places.map(|((((place, &length), name), due), updates)| {
            let estimate = block(place.estimate, place.of.len());
            let of = |i: usize, j: usize| samples[i * layout.width + place.of[j]];
            let error =
                DMatrix::from_fn(rows, place.of.len(), |i, j| wrap(of(i, j) - estimate[(i, j)], place.turns[j]));
            let state = block(place.estimate - length, length);
            let states = place.of.iter().copied().filter(|&of| of < n).collect();
            let period = place.period;
            let at_samples = updates.finish(place.of.len());
            ObserverTrajectory { name: name.clone(), estimate, error, state, states, period, samples: due, at_samples }
        });
        let observers = observers.collect();
        let value = |k: usize| block(layout.integrals + k, 1).as_slice().to_vec();
        let named = |(k, name)| IntegralTrajectory { name, value: value(k) };
        let integrals = integrals.into_iter().enumerate().map(named).collect();
        let (u, y, measured) = (block(n, m), block(n + m, p), block(n + m + p, p));
        // The last requested time ends the run.
        let last = samples[samples.len().saturating_sub(layout.width)..].to_vec();
        Self { t: times.to_vec(), x, u, y, measured, observers, integrals, steps, dense, last, layout, sampling }
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

    /// The state of the plant at any time of the run, by dense output.
    ///
    /// # Errors
    /// [`SimError::Outside`].
    pub fn state_at(&self, t: f64) -> Result<Vec<f64>, SimError> {
        let mut row = self.dense.at(t)?;
        row.truncate(self.layout.size.states);
        Ok(row)
    }

    /// The input at any time of the run, by dense output.
    ///
    /// # Errors
    /// [`SimError::Outside`].
    pub fn input_at(&self, t: f64) -> Result<Vec<f64>, SimError> {
        let (n, m) = (self.layout.size.states, self.layout.size.inputs);
        Ok(self.dense.at(t)?[n..n + m].to_vec())
    }

    /// The outputs as the observers read them at any time of the run, by dense output.
    ///
    /// # Errors
    /// [`SimError::Outside`].
    pub fn measured_at(&self, t: f64) -> Result<Vec<f64>, SimError> {
        let Dimensions { states: n, inputs: m, outputs: p } = self.layout.size;
        Ok(self.dense.at(t)?[n + m + p..n + m + 2 * p].to_vec())
    }

    /// Whether an output (from 0) is measured at t, and the measurement arrives: at the samples of a periodic
    /// sensor, otherwise at all times without a dropout.
    pub fn is_measured(&self, output: usize, t: f64) -> bool {
        self.sampling.is_measured(output, t)
    }

    /// The own state of the observer of that name at any time of the run, by dense output; of a filter estimate and
    /// covariance by columns.
    ///
    /// # Errors
    /// [`SimError::Outside`], [`SimError::UnknownName`].
    pub fn observer_state_at(&self, name: &str, t: f64) -> Result<Vec<f64>, SimError> {
        let unknown = || SimError::UnknownName { name: name.to_owned() };
        let index = self.observers.iter().position(|observer| observer.name == name).ok_or_else(unknown)?;
        let end = self.layout.observers[index].estimate;
        let length = self.observers[index].state.ncols();
        Ok(self.dense.at(t)?[end - length..end].to_vec())
    }

    /// Start and end of the run.
    pub fn span(&self) -> (f64, f64) {
        self.dense.span()
    }

    /// The steps of the integrator that were accepted, each by its start and end.
    pub fn step_spans(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.dense.steps()
    }

    /// Calls `visit` at every point that is kept of every step of the integrator, eight for each with both of its ends,
    /// with the time, x, u, and the estimate of an observer.
    ///
    /// # Errors
    /// [`SimError::UnknownName`].
    pub fn visit(&self, observer: &str, mut visit: impl FnMut(f64, &[f64], &[f64], &[f64])) -> Result<(), SimError> {
        let ObserverLayout { estimate, of, .. } = self.place(observer)?;
        let (n, m) = (self.layout.size.states, self.layout.size.inputs);
        let components: Vec<usize> = (0..n + m).chain(*estimate..estimate + of.len()).collect();
        self.dense.visit(&components, |t, row| visit(t, &row[..n], &row[n..n + m], &row[n + m..]));
        Ok(())
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
                layout.observers.iter().map(|o| row[o.estimate..o.estimate + o.of.len()].to_vec()).collect();
            let error = |(o, estimate): (&ObserverLayout, &Vec<f64>)| {
                let turned = o.of.iter().zip(estimate).zip(&o.turns);
                turned.map(|((&i, estimate), turn)| wrap(row[i] - estimate, *turn)).collect()
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

    /// Component `component` (from 0) of the error of an observer as a function of time. The estimate of a sampled
    /// observer is held between its samples: its scores are those of [`Errors`](crate::Errors).
    ///
    /// # Errors
    /// [`SimError::UnknownName`], [`SimError::Index`].
    pub fn error_trace(&self, observer: &str, component: usize) -> Result<Trace<'_>, SimError> {
        let ObserverLayout { estimate, of, turns, .. } = self.place(observer)?;
        let count = of.len();
        let Some(&state) = of.get(component) else {
            return Err(SimError::Index { what: "component of the error", index: component, count });
        };
        Ok(Trace::difference(
            &self.dense,
            Difference { of: state, from: estimate + component, turn: turns[component], scale: 1.0 },
        ))
    }

    /// `|e|`, the Euclidean norm of an observer's error, as a function of time. The estimate of a sampled observer is
    /// held between its samples.
    ///
    /// # Errors
    /// [`SimError::UnknownName`].
    pub fn error_norm(&self, observer: &str) -> Result<Trace<'_>, SimError> {
        self.scaled_norm(observer, &vec![1.0; self.place(observer)?.of.len()])
    }

    /// `sqrt(sum_i (e_i / scale_i)^2)` as a function of time.
    pub(crate) fn scaled_norm(&self, observer: &str, scale: &[f64]) -> Result<Trace<'_>, SimError> {
        let ObserverLayout { estimate, of, turns, .. } = self.place(observer)?;
        let pairs = of.iter().zip(*estimate..).zip(scale).zip(turns);
        let differences = pairs.map(|(((&of, from), &scale), &turn)| Difference { of, from, turn, scale }).collect();
        Ok(Trace::norm(&self.dense, differences))
    }

    fn place(&self, observer: &str) -> Result<&ObserverLayout, SimError> {
        let found = self.layout.names.iter().position(|name| name == observer);
        let k = found.ok_or_else(|| SimError::UnknownName { name: observer.to_owned() })?;
        Ok(&self.layout.observers[k])
    }

    /// The instants at which all observers of the run are scored: the samples, if any of them is sampled (see
    /// [`ScoreGrid`]).
    ///
    /// # Errors
    /// [`SimError::NoCommonGrid`].
    pub fn score_grid(&self) -> Result<ScoreGrid, SimError> {
        let (start, end) = self.span();
        let periods: Vec<Option<f64>> = self.observers.iter().map(|observer| observer.period).collect();
        ScoreGrid::common(&periods, end - start)
    }

    /// The multiples of `period` from the start on, and the errors of an observer there, one row each; those of a
    /// sampled observer at its last sample up to each, of a filter before or after the measurement of that sample.
    pub(crate) fn errors_at_samples(
        &self,
        observer: &str,
        period: f64,
        estimates: Estimates,
    ) -> Result<(Vec<f64>, DMatrix<f64>), SimError> {
        check_positive("the period of scoring", period)?;
        let ObserverLayout { estimate, of: places, turns, period: own } = self.place(observer)?;
        if let Some(own) = *own
            && period < own * (1.0 - 1e-9)
        {
            return Err(SimError::ScorePeriod { period, observer: observer.to_owned(), own });
        }
        let (start, end) = self.span();
        let last = |period: f64, t: f64| start + ((t - start) / period + 1e-9).floor() * period;
        let count = ((end - start) / period + 1e-9).floor() as usize;
        let times: Vec<f64> = (0..=count).map(|k| start + k as f64 * period).collect();
        let mut errors = DMatrix::zeros(times.len(), places.len());
        let at_samples = self.observer(observer)?.at_samples.as_ref();
        for (k, t) in times.iter().enumerate() {
            let t = own.map_or(*t, |own| last(own, *t));
            if let Some((at_samples, sample)) = at_samples.and_then(|all| Some((all, all.index(t)?))) {
                let x = if t >= end { self.last.clone() } else { self.dense.at(t)? };
                for (j, state) in places.iter().enumerate() {
                    errors[(k, j)] = wrap(x[*state] - at_samples.of(estimates)[(sample, j)], turns[j]);
                }
                continue;
            }
            if t >= end {
                for (j, state) in places.iter().enumerate() {
                    errors[(k, j)] = wrap(self.last[*state] - self.last[estimate + j], turns[j]);
                }
                continue;
            }
            let step = self.dense.step_at(t)?;
            for (j, state) in places.iter().enumerate() {
                let of = |component: usize| self.dense.component(step, t, component);
                errors[(k, j)] = wrap(of(*state) - of(estimate + j), turns[j]);
            }
        }
        Ok((times, errors))
    }

    /// The full turns of what an observer estimates, 0 for what is no angle.
    pub(crate) fn turns_of(&self, observer: &str) -> Result<&[f64], SimError> {
        Ok(&self.place(observer)?.turns)
    }

    /// What an observer estimates, states of the plant or functions of them, at the time `t`.
    pub(crate) fn wanted_at(&self, observer: &str, t: f64) -> Result<Vec<f64>, SimError> {
        let row = self.dense.at(t)?;
        Ok(self.place(observer)?.of.iter().map(|place| row[*place]).collect())
    }

    /// The samples as comma-separated values: a head of names, then one line per requested time with `t`, states,
    /// inputs, outputs, the estimates of each observer and the integrals. Numbers are read back as they are.
    pub fn to_csv(&self) -> String {
        let numbered = |prefix: &str, count: usize| (1..=count).map(|i| format!("{prefix}{i}")).collect::<Vec<_>>();
        let mut names = vec!["t".to_owned()];
        let blocks = [("x", self.x.ncols()), ("u", self.u.ncols()), ("y", self.y.ncols())];
        names.extend(blocks.into_iter().flat_map(|(prefix, count)| numbered(prefix, count)));
        for observer in &self.observers {
            names.extend(observer.states.iter().map(|state| format!("{}.xhat{}", observer.name, state + 1)));
            let functions = observer.estimate.ncols() - observer.states.len();
            names.extend((1..=functions).map(|k| format!("{}.zhat{k}", observer.name)));
        }
        names.extend(self.integrals.iter().map(|integral| integral.name.clone()));
        let mut text = names.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(",") + "\n";
        for (k, t) in self.t.iter().enumerate() {
            let blocks = [&self.x, &self.u, &self.y].into_iter().chain(self.observers.iter().map(|o| &o.estimate));
            let values = blocks.flat_map(|block| block.row(k).iter().copied().collect::<Vec<_>>());
            let values = core::iter::once(*t).chain(values).chain(self.integrals.iter().map(|q| q.value[k]));
            text += &(values.map(|value| value.to_string()).collect::<Vec<_>>().join(",") + "\n");
        }
        text
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

/// A field of RFC 4180: in quotes where it has a comma, a quote or a line break.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.to_owned() }
}
