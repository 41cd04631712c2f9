//! Plants given by expressions: `f = ["x2", "-k*sin(x1) + u1/J"]`, `h = ["x1"]`.
//!
//! An [`ExpressionPlant`] is a plant over every scalar, like one written in Rust: its Jacobians are exact, observers
//! run on it, and the designs of `luenberger-design` that enclose Jacobians over a box accept it. Sizes are known at
//! run time; [`Fixed`] has them in its type, for the designs that require it.
//!
//! For expressions that are syntactically affine the matrices are available, so that linear designs apply:
//! [`ExpressionPlant::affine`].

use core::fmt;
use std::sync::{Arc, OnceLock};

use luenberger_plants::{Differentiable, Dimensions, Plant, PlantError, Shape, StateSpace};
use nalgebra::{Const, DMatrix, DVector, Dyn, RealField, SMatrix, SVector, convert};

use crate::function::is_number;
use crate::graph::recording::{Recording, is_recorded, with_tables};
use crate::graph::{Graph, Id, Routine};
use crate::{Expression, ExpressionError, NameError, ParameterError, Parameters, Scope, Undefined};

/// A row of a plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    /// `x_k'`, from 0.
    Derivative(usize),
    /// `y_k`, from 0.
    Output(usize),
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Derivative(k) => write!(f, "f{}", k + 1),
            Self::Output(k) => write!(f, "h{}", k + 1),
        }
    }
}

/// Error of a plant of expressions.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExpressionPlantError {
    /// No states or no outputs.
    #[error("a plant needs at least one state and one output: f has {states} rows, h has {outputs}")]
    Empty {
        /// Number of rows of f.
        states: usize,
        /// Number of rows of h.
        outputs: usize,
    },
    /// More rows than are taken.
    #[error("f has {states} rows and h {outputs}, with {inputs} inputs: at most {} of each are taken", LARGEST)]
    TooLarge {
        /// Number of rows of f.
        states: usize,
        /// Number of inputs.
        inputs: usize,
        /// Number of rows of h.
        outputs: usize,
    },
    /// A parameter that cannot be one.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A name of a state or an input that cannot be one.
    #[error(transparent)]
    Name(#[from] NameError),
    /// A text that is no expression.
    #[error("{row}: {error}")]
    Expression {
        /// The row.
        row: Row,
        /// The error of the expression.
        error: ExpressionError,
    },
    /// A point with another number of coordinates than the plant.
    #[error("{what} has {found} entries where the plant has {expected}")]
    Length {
        /// Which point.
        what: &'static str,
        /// Required number of entries.
        expected: usize,
        /// Actual number of entries.
        found: usize,
    },
    /// A coordinate of a point that is NaN or infinite.
    #[error("entry {} of {what} is {value}, not a finite number", index + 1)]
    NotFinite {
        /// Which point.
        what: &'static str,
        /// Which entry, from 0.
        index: usize,
        /// The entry.
        value: f64,
    },
    /// A row without a finite value or derivative at a point.
    #[error("{row} = {text}: {undefined}, at x = {x:?}{}", at_input(u))]
    Undefined {
        /// The row.
        row: Row,
        /// Its text.
        text: String,
        /// The part that is not finite.
        undefined: Box<Undefined>,
        /// The state.
        x: Vec<f64>,
        /// The input.
        u: Vec<f64>,
    },
    /// A row that is not affine, although the matrices of a plant were requested.
    #[error("{row} = {text} is not affine in states and inputs: `{part}` is not")]
    NotAffine {
        /// The row.
        row: Row,
        /// Its text.
        text: String,
        /// The first part of it that is not affine.
        part: String,
    },
    /// Matrices that do not make a plant.
    #[error(transparent)]
    Matrices(#[from] PlantError),
    /// A plant with other sizes than a type.
    #[error(
        "the plant has {} states, {} inputs and {} outputs; the type says {}, {} and {}",
        found.states, found.inputs, found.outputs, expected.states, expected.inputs, expected.outputs
    )]
    Sizes {
        /// The sizes of the type.
        expected: Dimensions,
        /// The sizes of the plant.
        found: Dimensions,
    },
}

/// At most so many states, inputs and outputs.
const LARGEST: usize = 1000;

fn at_input(u: &[f64]) -> String {
    if u.is_empty() { String::new() } else { format!(", u = {u:?}") }
}

/// An affine plant `x' = A x + B u + f0`, `y = C x + D u + h0`.
#[derive(Clone, Debug, PartialEq)]
pub struct AffinePlant {
    /// A, n x n; B, n x m; C, p x n; D, p x m, where an output uses an input.
    pub linear: StateSpace,
    /// f(0, 0), n entries.
    pub f0: DVector<f64>,
    /// h(0, 0), p entries.
    pub h0: DVector<f64>,
}

impl AffinePlant {
    /// Whether `f0 = 0` and `h0 = 0`, so that it is a linear plant and not only the linear part of one.
    pub fn is_linear(&self) -> bool {
        self.f0.iter().chain(self.h0.iter()).all(|entry| *entry == 0.0)
    }
}

#[derive(Debug)]
struct Rows {
    f: Vec<Expression>,
    h: Vec<Expression>,
    inputs: usize,
    /// Made when they are first asked for.
    values: OnceLock<Values>,
    jacobians: OnceLock<Jacobians>,
    affine: OnceLock<bool>,
    linear_between_samples: OnceLock<bool>,
}

impl PartialEq for Rows {
    fn eq(&self, other: &Self) -> bool {
        (&self.f, &self.h, self.inputs) == (&other.f, &other.h, other.inputs)
    }
}

#[derive(Debug)]
struct Values {
    f: Routine,
    h: Routine,
}

#[derive(Debug)]
struct Jacobians {
    df: Routine,
    dh: Routine,
    /// f and Df, h and Dh, the Jacobians by columns.
    motion: Routine,
    measurement: Routine,
}

/// The right-hand sides of a plant as straight-line code, with entries of Jacobians row by row.
#[derive(Clone, Debug)]
pub struct Routines {
    /// f, n results.
    pub f: Routine,
    /// h, p results.
    pub h: Routine,
    /// f and Df = df/dx, n + n^2 results.
    pub motion: Routine,
    /// h and Dh = dh/dx, p + p n results.
    pub measurement: Routine,
}

/// A plant `x' = f(t, x, u)`, `y = h(t, x, u)` whose rows are expressions. A copy shares them.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionPlant(Arc<Rows>);

impl ExpressionPlant {
    /// The plant with these rows of f and h, so many inputs, and these parameters.
    ///
    /// The rows of f and h may use `x1..xn`, `u1..um`, `t` and the parameters, with n the number of rows of f.
    ///
    /// # Errors
    /// [`ExpressionPlantError::Empty`], [`TooLarge`](ExpressionPlantError::TooLarge),
    /// [`Parameter`](ExpressionPlantError::Parameter), and [`Expression`](ExpressionPlantError::Expression) for the
    /// first row that is none.
    pub fn new<S: AsRef<str>>(
        f: &[S],
        h: &[S],
        inputs: usize,
        parameters: &Parameters,
    ) -> Result<Self, ExpressionPlantError> {
        Self::of(f, h, inputs, (&[], &[]), parameters)
    }

    /// The same with names supplied by the user for the states and inputs, which the rows may use beside `x1, ..` and
    /// `u1, ..`: see [`Scope::named`].
    ///
    /// ```
    /// use luenberger_plants::Plant;
    /// use luenberger_expression::{ExpressionPlant, Parameters};
    /// use nalgebra::dvector;
    /// let (states, inputs) = (["angle", "speed"].map(str::to_owned), ["torque".to_owned()]);
    /// let rows = ["speed", "torque - 9.81*sin(angle)"];
    /// let pendulum = ExpressionPlant::named(&rows, &["angle"], &states, &inputs, &Parameters::new())?;
    /// assert_eq!(pendulum.derivative(0.0, &dvector![0.0, 2.0], &dvector![1.0]), dvector![2.0, 1.0]);
    /// # Ok::<(), luenberger_expression::ExpressionPlantError>(())
    /// ```
    /// # Errors
    /// As [`new`](Self::new); [`ExpressionPlantError::Length`] unless there is a name for each state,
    /// [`ExpressionPlantError::Name`].
    pub fn named<S: AsRef<str>>(
        f: &[S],
        h: &[S],
        states: &[String],
        inputs: &[String],
        parameters: &Parameters,
    ) -> Result<Self, ExpressionPlantError> {
        if states.len() != f.len() {
            let what = "the list of the states' names";
            return Err(ExpressionPlantError::Length { what, expected: f.len(), found: states.len() });
        }
        Self::of(f, h, inputs.len(), (states, inputs), parameters)
    }

    fn of<S: AsRef<str>>(
        f: &[S],
        h: &[S],
        inputs: usize,
        (state_names, input_names): (&[String], &[String]),
        parameters: &Parameters,
    ) -> Result<Self, ExpressionPlantError> {
        let states = f.len();
        let scope = Scope::plant(states, inputs).named(state_names, input_names)?.with(parameters)?;
        Self::within(f, h, &scope)
    }

    /// The plant with these rows, whose names are those of `scope`: with parameters, lookup tables, and names of states
    /// and inputs.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`ExpressionPlantError::Length`] unless the scope has a state for each row of f.
    pub fn within<S: AsRef<str>>(f: &[S], h: &[S], scope: &Scope) -> Result<Self, ExpressionPlantError> {
        let ((expected, inputs), (states, outputs)) = (scope.counts(), (f.len(), h.len()));
        if states == 0 || outputs == 0 {
            return Err(ExpressionPlantError::Empty { states, outputs });
        }
        if states.max(inputs).max(outputs) > LARGEST {
            return Err(ExpressionPlantError::TooLarge { states, inputs, outputs });
        }
        if states != expected {
            return Err(ExpressionPlantError::Length { what: "f", expected, found: states });
        }
        let parse = |texts: &[S], scope: &Scope, row: fn(usize) -> Row| -> Result<Vec<_>, _> {
            let parsed = texts.iter().map(|text| Expression::parse(text.as_ref(), scope)).enumerate();
            parsed
                .map(|(k, one)| one.map_err(|error| ExpressionPlantError::Expression { row: row(k), error }))
                .collect()
        };
        let f = parse(f, scope, Row::Derivative)?;
        let h = parse(h, scope, Row::Output)?;
        Ok(Self::of_rows(f, h, inputs))
    }

    fn of_rows(f: Vec<Expression>, h: Vec<Expression>, inputs: usize) -> Self {
        Self(Arc::new(Rows {
            f,
            h,
            inputs,
            values: OnceLock::new(),
            jacobians: OnceLock::new(),
            affine: OnceLock::new(),
            linear_between_samples: OnceLock::new(),
        }))
    }

    /// The rows of f.
    pub fn f(&self) -> &[Expression] {
        &self.0.f
    }

    /// The rows of h.
    pub fn h(&self) -> &[Expression] {
        &self.0.h
    }

    /// As [`record`](crate::record), for observers of this plant: its lookup tables have the numbers that they have in
    /// its [`routines`](Self::routines), and others follow.
    pub fn record<R>(&self, run: impl FnOnce(&mut Recording) -> R) -> R {
        with_tables(self.routines().f.tables, run)
    }

    /// The right-hand sides as straight-line code: what is evaluated over numbers, and what is exported.
    pub fn routines(&self) -> Routines {
        let mut graph = Graph::default();
        let (f, h) = self.nodes(&mut graph);
        let df = graph.jacobian(&f, self.f().len());
        let dh = graph.jacobian(&h, self.f().len());
        Routines {
            f: graph.routine(&f),
            h: graph.routine(&h),
            motion: graph.routine(&[f, df].concat()),
            measurement: graph.routine(&[h, dh].concat()),
        }
    }

    fn nodes(&self, graph: &mut Graph) -> (Vec<u32>, Vec<u32>) {
        let mut of = |rows: &[Expression]| rows.iter().map(|row| graph.expression(&row.tree)).collect();
        (of(self.f()), of(self.h()))
    }

    fn values(&self) -> &Values {
        self.0.values.get_or_init(|| {
            let mut graph = Graph::default();
            let (f, h) = self.nodes(&mut graph);
            Values { f: graph.routine(&f), h: graph.routine(&h) }
        })
    }

    fn jacobians(&self) -> &Jacobians {
        self.0.jacobians.get_or_init(|| {
            let mut graph = Graph::default();
            let (f, h) = self.nodes(&mut graph);
            let n = self.f().len();
            let (df, dh) = (graph.jacobian(&f, n), graph.jacobian(&h, n));
            let columns = |rows: &[Id]| (0..n).flat_map(|j| rows.iter().skip(j).step_by(n).copied()).collect();
            Jacobians {
                df: graph.routine(&df),
                dh: graph.routine(&dh),
                motion: graph.routine(&[f, columns(&df)].concat()),
                measurement: graph.routine(&[h, columns(&dh)].concat()),
            }
        })
    }

    /// The rows of f or h into `out`: over numbers, and while a body is recorded, by the graph; else by the tape of
    /// each row.
    fn fill<T: RealField + Copy>(&self, family: Row, t: T, x: &[T], u: &[T], out: &mut [T]) {
        let (rows, routine): (_, fn(&Values) -> &Routine) = match family {
            Row::Derivative(_) => (self.f(), |values| &values.f),
            Row::Output(_) => (self.h(), |values| &values.h),
        };
        if is_number::<T>() || is_recorded::<T>() {
            routine(self.values()).evaluate(t, x, u, |k, value| out[k] = value);
        } else {
            out.iter_mut().zip(rows).for_each(|(out, row)| *out = row.evaluate(t, x, u));
        }
    }

    /// The rows of f or h and their Jacobian by columns: over numbers in one routine, else each by its own.
    fn joint<T: RealField + Copy>(
        &self,
        family: Row,
        (t, x, u): (T, &[T], &[T]),
        (values, jacobian): (&mut [T], &mut [T]),
    ) -> bool {
        let (Dimensions { states, inputs, outputs }, all) = (self.size(), self.jacobians());
        let (rows, joint, alone) = match family {
            Row::Derivative(_) => (states, &all.motion, &all.df),
            Row::Output(_) => (outputs, &all.measurement, &all.dh),
        };
        let fits = (x.len(), u.len(), values.len(), jacobian.len()) == (states, inputs, rows, rows * states);
        if fits && (is_number::<T>() || is_recorded::<T>()) {
            joint.evaluate(t, x, u, |k, value| match k.checked_sub(rows) {
                None => values[k] = value,
                Some(k) => jacobian[k] = value,
            });
        } else if fits {
            self.fill(family, t, x, u, values);
            alone.evaluate(t, x, u, |k, value| jacobian[k % states * rows + k / states] = value);
        }
        fits
    }

    /// The first output whose expression uses an input, from 0, if there is one: then y depends on u at once.
    pub fn feedthrough(&self) -> Option<usize> {
        self.h().iter().position(Expression::uses_inputs)
    }

    /// Checks that f, h and their Jacobians are finite at a point, such as the start of a run.
    ///
    /// ```
    /// use luenberger_expression::{ExpressionPlant, Parameters};
    /// let plant = ExpressionPlant::new(&["ln(x1)"], &["x1"], 0, &Parameters::new())?;
    /// let error = plant.check_at(0.0, &[-1.0], &[]).unwrap_err();
    /// assert_eq!(error.to_string(), "f1 = ln(x1): `ln(x1)` is not defined: `x1` is -1, at x = [-1.0]");
    /// # Ok::<(), luenberger_expression::ExpressionPlantError>(())
    /// ```
    /// # Errors
    /// [`ExpressionPlantError::Length`] and [`NotFinite`](ExpressionPlantError::NotFinite) for the point,
    /// [`Undefined`](ExpressionPlantError::Undefined) for the first row that has no value or no derivative there.
    pub fn check_at(&self, t: f64, x: &[f64], u: &[f64]) -> Result<(), ExpressionPlantError> {
        let size = self.size();
        let point = |what, expected: usize, column: &[f64]| match column.iter().position(|entry| !entry.is_finite()) {
            _ if column.len() != expected => Err(ExpressionPlantError::Length { what, expected, found: column.len() }),
            Some(index) => Err(ExpressionPlantError::NotFinite { what, index, value: column[index] }),
            None => Ok(()),
        };
        point("the state", size.states, x)?;
        point("the input", size.inputs, u)?;
        point("the time", 1, &[t])?;
        for (row, expression) in self.rows() {
            let seen = |undefined| self.undefined(row, undefined, x, u);
            expression.gradient(t, x, u).map_err(seen)?;
            expression.input_gradient(t, x, u).map_err(seen)?;
        }
        Ok(())
    }

    /// The matrices of a plant that is affine by its form, see [`Expression::affine`]: exact up to the rounding of what
    /// is written.
    ///
    /// ```
    /// use luenberger_expression::{ExpressionPlant, Parameters};
    /// use nalgebra::dmatrix;
    /// let parameters = Parameters::from([("m".to_owned(), 2.0)]);
    /// let plant = ExpressionPlant::new(&["x2", "(u1 - 3*x1)/m"], &["x1"], 1, &parameters)?.affine()?;
    /// assert!(plant.is_linear());
    /// assert_eq!(plant.linear.a, dmatrix![0.0, 1.0; -1.5, 0.0]);
    /// assert_eq!(plant.linear.b, dmatrix![0.0; 0.5]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`ExpressionPlantError::NotAffine`] names the first part that is not;
    /// [`Undefined`](ExpressionPlantError::Undefined) a coefficient that is not finite.
    pub fn affine(&self) -> Result<AffinePlant, ExpressionPlantError> {
        for (row, expression) in self.rows() {
            expression.affine().map_err(|part| ExpressionPlantError::NotAffine {
                row,
                text: expression.text().to_owned(),
                part: part.to_owned(),
            })?;
        }
        let size = self.size();
        let (x, u) = (vec![0.0; size.states], vec![0.0; size.inputs]);
        self.check_at(0.0, &x, &u)?;
        let gradients = |rows: &[Expression], by: fn(&Expression, &[f64], &[f64]) -> Vec<f64>, columns: usize| {
            let entries: Vec<f64> = rows.iter().flat_map(|row| by(row, &x, &u)).collect();
            DMatrix::from_row_slice(rows.len(), columns, &entries)
        };
        // Checked above, so that nothing is left out.
        let by_state = |row: &Expression, x: &[f64], u: &[f64]| row.gradient(0.0, x, u).unwrap_or_default();
        let by_input = |row: &Expression, x: &[f64], u: &[f64]| row.input_gradient(0.0, x, u).unwrap_or_default();
        let a = gradients(self.f(), by_state, size.states);
        let b = gradients(self.f(), by_input, size.inputs);
        let c = gradients(self.h(), by_state, size.states);
        let values =
            |rows: &[Expression]| DVector::from_iterator(rows.len(), rows.iter().map(|row| row.evaluate(0.0, &x, &u)));
        let mut linear = StateSpace::new(a, b, c)?;
        if self.feedthrough().is_some() {
            linear = linear.with_feedthrough(gradients(self.h(), by_input, size.inputs))?;
        }
        Ok(AffinePlant { linear, f0: values(self.f()), h0: values(self.h()) })
    }

    /// A, B and c of `f = A x + B u + c`, if that is its form and the time is not in it; none otherwise, and for a
    /// coefficient that is not finite. Nothing is asked of h.
    pub fn affine_motion(&self) -> Option<(DMatrix<f64>, DMatrix<f64>, DVector<f64>)> {
        let rows = self.f();
        if rows.iter().any(|row| row.uses_time() || row.affine().is_err()) {
            return None;
        }
        let (n, m) = (rows.len(), self.0.inputs);
        let (x, u) = (vec![0.0; n], vec![0.0; m]);
        let by_states = rows.iter().map(|row| row.gradient(0.0, &x, &u).ok());
        let by_inputs = rows.iter().map(|row| row.input_gradient(0.0, &x, &u).ok());
        let a = DMatrix::from_row_slice(n, n, &by_states.collect::<Option<Vec<_>>>()?.concat());
        let b = DMatrix::from_row_slice(n, m, &by_inputs.collect::<Option<Vec<_>>>()?.concat());
        let c = DVector::from_iterator(n, rows.iter().map(|row| row.evaluate(0.0, &x, &u)));
        let is_finite = a.iter().chain(b.iter()).chain(c.iter()).all(|entry| entry.is_finite());
        is_finite.then_some((a, b, c))
    }

    /// The plant with the outputs of this one and the motion `A x + B u + c`.
    ///
    /// ```
    /// use luenberger_expression::{ExpressionPlant, Parameters};
    /// use nalgebra::{dmatrix, dvector};
    /// let plant = ExpressionPlant::new(&["x2", "u1"], &["x1^2"], 1, &Parameters::new())?;
    /// let (a, b, c) = plant.affine_motion().ok_or("f is affine")?;
    /// assert_eq!((a, b, c), (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dvector![0.0, 0.0]));
    /// let other = plant.with_motion(&dmatrix![1.0, 0.5; 0.0, 1.0], &dmatrix![0.0; -2.0], &dvector![0.0, 3.0])?;
    /// assert_eq!(other.f().iter().map(|row| row.text()).collect::<Vec<_>>(), ["x1 + 0.5*x2", "x2 + (-2.0)*u1 + 3.0"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`ExpressionPlantError::Length`] for matrices of other sizes; [`Expression`](ExpressionPlantError::Expression)
    /// for an entry that is not finite.
    pub fn with_motion(
        &self,
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        c: &DVector<f64>,
    ) -> Result<Self, ExpressionPlantError> {
        let (n, m) = (self.0.f.len(), self.0.inputs);
        for (what, expected, found) in [
            ("rows of A", n, a.nrows()),
            ("columns of A", n, a.ncols()),
            ("rows of B", n, b.nrows()),
            ("columns of B", m, b.ncols()),
            ("c", n, c.len()),
        ] {
            if expected != found {
                return Err(ExpressionPlantError::Length { what, expected, found });
            }
        }
        let number = |x: f64| if x < 0.0 { format!("({x:?})") } else { format!("{x:?}") };
        let term = |(factor, name): (f64, String)| match factor {
            0.0 => None,
            1.0 => Some(name),
            factor => Some(format!("{}*{name}", number(factor))),
        };
        let scope = Scope::plant(n, m);
        let f: Result<Vec<Expression>, ExpressionPlantError> = (0..n)
            .map(|i| {
                let states = (0..n).map(|j| (a[(i, j)], format!("x{}", j + 1)));
                let inputs = (0..m).map(|j| (b[(i, j)], format!("u{}", j + 1)));
                let constant = (c[i] != 0.0).then(|| number(c[i]));
                let terms: Vec<String> = states.chain(inputs).filter_map(term).chain(constant).collect();
                let text = if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") };
                let row = Row::Derivative(i);
                Expression::parse(&text, &scope).map_err(|error| ExpressionPlantError::Expression { row, error })
            })
            .collect();
        Ok(Self::of_rows(f?, self.0.h.clone(), m))
    }

    /// The same plant with its sizes in the type.
    ///
    /// # Errors
    /// [`ExpressionPlantError::Sizes`] if they are others.
    pub fn fixed<const N: usize, const M: usize, const P: usize>(
        &self,
    ) -> Result<Fixed<N, M, P>, ExpressionPlantError> {
        let expected = Dimensions { states: N, inputs: M, outputs: P };
        let found = self.size();
        if expected == found { Ok(Fixed(self.clone())) } else { Err(ExpressionPlantError::Sizes { expected, found }) }
    }

    /// Whether the rows are affine by their form, and time occurs in none of them.
    fn has_affine_rows(&self) -> bool {
        *self.0.affine.get_or_init(|| self.rows().all(|(_, row)| !row.uses_time()) && self.affine().is_ok())
    }

    fn size(&self) -> Dimensions {
        Dimensions { states: self.0.f.len(), inputs: self.0.inputs, outputs: self.0.h.len() }
    }

    fn rows(&self) -> impl Iterator<Item = (Row, &Expression)> {
        let f = self.0.f.iter().enumerate().map(|(k, row)| (Row::Derivative(k), row));
        f.chain(self.0.h.iter().enumerate().map(|(k, row)| (Row::Output(k), row)))
    }

    fn undefined(&self, row: Row, undefined: Undefined, x: &[f64], u: &[f64]) -> ExpressionPlantError {
        let undefined = Box::new(undefined);
        let text = match row {
            Row::Derivative(k) => &self.0.f[k],
            Row::Output(k) => &self.0.h[k],
        };
        let text = text.text().to_owned();
        ExpressionPlantError::Undefined { row, text, undefined, x: x.to_vec(), u: u.to_vec() }
    }
}

impl Shape for ExpressionPlant {
    fn dimensions(&self) -> Dimensions {
        self.size()
    }
}

impl<T: RealField + Copy> Plant<T> for ExpressionPlant {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        let mut slope = DVector::zeros(self.0.f.len());
        self.fill(Row::Derivative(0), t, x.as_slice(), u.as_slice(), slope.as_mut_slice());
        slope
    }

    fn output(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        let mut y = DVector::zeros(self.0.h.len());
        self.fill(Row::Output(0), t, x.as_slice(), u.as_slice(), y.as_mut_slice());
        y
    }

    fn is_affine(&self) -> bool {
        self.has_affine_rows()
    }

    fn derivative_into(&self, t: T, x: &[T], u: &[T], slope: &mut [T]) -> bool {
        let size = self.size();
        let fits = (x.len(), u.len(), slope.len()) == (size.states, size.inputs, size.states);
        if fits {
            self.fill(Row::Derivative(0), t, x, u, slope);
        }
        fits
    }

    fn output_into(&self, t: T, x: &[T], u: &[T], y: &mut [T]) -> bool {
        let size = self.size();
        let fits = (x.len(), u.len(), y.len()) == (size.states, size.inputs, size.outputs);
        if fits {
            self.fill(Row::Output(0), t, x, u, y);
        }
        fits
    }
}

/// Derivatives are symbolic, so that a Jacobian is one evaluation.
impl<T: RealField + Copy> Differentiable<T, Dyn, Dyn, Dyn> for ExpressionPlant {
    fn directional(&self, t: T, x: &DVector<T>, u: &DVector<T>, v: &DVector<T>) -> (DVector<T>, DVector<T>) {
        (self.derivative(t, x, u), self.state_jacobian(t, x, u) * v)
    }

    fn output_directional(&self, t: T, x: &DVector<T>, u: &DVector<T>, v: &DVector<T>) -> (DVector<T>, DVector<T>) {
        (self.output(t, x, u), self.output_jacobian(t, x, u) * v)
    }

    fn state_jacobian(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> DMatrix<T> {
        let n = self.0.f.len();
        let mut jacobian = DMatrix::zeros(n, n);
        self.jacobians().df.evaluate(t, x.as_slice(), u.as_slice(), |k, value| jacobian[(k / n, k % n)] = value);
        jacobian
    }

    fn output_jacobian(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> DMatrix<T> {
        let n = self.0.f.len();
        let mut jacobian = DMatrix::zeros(self.0.h.len(), n);
        self.jacobians().dh.evaluate(t, x.as_slice(), u.as_slice(), |k, value| jacobian[(k / n, k % n)] = value);
        jacobian
    }

    fn is_linear_between_samples(&self) -> bool {
        *self.0.linear_between_samples.get_or_init(|| self.0.f.iter().all(Expression::is_affine_in_states))
    }

    fn motion(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> (DVector<T>, DMatrix<T>) {
        let (n, nan) = (self.0.f.len(), convert(f64::NAN));
        let (mut f, mut df) = (DVector::repeat(n, nan), DMatrix::repeat(n, n, nan));
        self.motion_into(t, x.as_slice(), u.as_slice(), f.as_mut_slice(), df.as_mut_slice());
        (f, df)
    }

    fn measurement(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> (DVector<T>, DMatrix<T>) {
        let (n, p, nan) = (self.0.f.len(), self.0.h.len(), convert(f64::NAN));
        let (mut h, mut dh) = (DVector::repeat(p, nan), DMatrix::repeat(p, n, nan));
        self.measurement_into(t, x.as_slice(), u.as_slice(), h.as_mut_slice(), dh.as_mut_slice());
        (h, dh)
    }

    fn motion_into(&self, t: T, x: &[T], u: &[T], f: &mut [T], df: &mut [T]) -> bool {
        self.joint(Row::Derivative(0), (t, x, u), (f, df))
    }

    fn measurement_into(&self, t: T, x: &[T], u: &[T], h: &mut [T], dh: &mut [T]) -> bool {
        self.joint(Row::Output(0), (t, x, u), (h, dh))
    }
}

/// An [`ExpressionPlant`] with n, m and p in its type: for designs that need them there, such as the numerical KKL
/// observer.
///
/// ```
/// use luenberger_plants::Plant;
/// use luenberger_expression::{ExpressionPlant, Parameters};
/// use nalgebra::{SVector, Vector2};
/// let duffing = ExpressionPlant::new(&["x2^3", "-x1"], &["x1"], 0, &Parameters::new())?;
/// let (fixed, x) = (duffing.fixed::<2, 0, 1>()?, Vector2::new(1.0, 2.0));
/// assert_eq!(fixed.derivative(0.0, &x, &SVector::zeros()), Vector2::new(8.0, -1.0));
/// assert!(duffing.fixed::<2, 1, 1>().is_err());
/// # Ok::<(), luenberger_expression::ExpressionPlantError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Fixed<const N: usize, const M: usize, const P: usize>(ExpressionPlant);

impl<const N: usize, const M: usize, const P: usize> Fixed<N, M, P> {
    /// The plant.
    pub fn plant(&self) -> &ExpressionPlant {
        &self.0
    }
}

impl<const N: usize, const M: usize, const P: usize> Shape for Fixed<N, M, P> {
    fn dimensions(&self) -> Dimensions {
        self.0.size()
    }
}

impl<T: RealField + Copy, const N: usize, const M: usize, const P: usize> Plant<T> for Fixed<N, M, P> {
    type State = SVector<T, N>;
    type Input = SVector<T, M>;
    type Output = SVector<T, P>;

    fn derivative(&self, t: T, x: &SVector<T, N>, u: &SVector<T, M>) -> SVector<T, N> {
        let mut slope = SVector::<T, N>::zeros();
        self.0.fill(Row::Derivative(0), t, x.as_slice(), u.as_slice(), slope.as_mut_slice());
        slope
    }

    fn output(&self, t: T, x: &SVector<T, N>, u: &SVector<T, M>) -> SVector<T, P> {
        let mut y = SVector::<T, P>::zeros();
        self.0.fill(Row::Output(0), t, x.as_slice(), u.as_slice(), y.as_mut_slice());
        y
    }

    fn is_affine(&self) -> bool {
        self.0.has_affine_rows()
    }

    fn derivative_into(&self, t: T, x: &[T], u: &[T], slope: &mut [T]) -> bool {
        let size = self.0.size();
        let fits = (x.len(), u.len(), slope.len()) == (size.states, size.inputs, size.states);
        if fits {
            self.0.fill(Row::Derivative(0), t, x, u, slope);
        }
        fits
    }

    fn output_into(&self, t: T, x: &[T], u: &[T], y: &mut [T]) -> bool {
        let size = self.0.size();
        let fits = (x.len(), u.len(), y.len()) == (size.states, size.inputs, size.outputs);
        if fits {
            self.0.fill(Row::Output(0), t, x, u, y);
        }
        fits
    }
}

impl<T: RealField + Copy, const N: usize, const M: usize, const P: usize>
    Differentiable<T, Const<N>, Const<M>, Const<P>> for Fixed<N, M, P>
{
    fn directional(
        &self,
        t: T,
        x: &SVector<T, N>,
        u: &SVector<T, M>,
        v: &SVector<T, N>,
    ) -> (SVector<T, N>, SVector<T, N>) {
        (self.derivative(t, x, u), self.state_jacobian(t, x, u) * v)
    }

    fn output_directional(
        &self,
        t: T,
        x: &SVector<T, N>,
        u: &SVector<T, M>,
        v: &SVector<T, N>,
    ) -> (SVector<T, P>, SVector<T, P>) {
        (self.output(t, x, u), self.output_jacobian(t, x, u) * v)
    }

    fn state_jacobian(&self, t: T, x: &SVector<T, N>, u: &SVector<T, M>) -> SMatrix<T, N, N> {
        let mut jacobian = SMatrix::zeros();
        let df = &self.0.jacobians().df;
        df.evaluate(t, x.as_slice(), u.as_slice(), |k, value| jacobian[(k / N, k % N)] = value);
        jacobian
    }

    fn output_jacobian(&self, t: T, x: &SVector<T, N>, u: &SVector<T, M>) -> SMatrix<T, P, N> {
        let mut jacobian = SMatrix::zeros();
        let dh = &self.0.jacobians().dh;
        dh.evaluate(t, x.as_slice(), u.as_slice(), |k, value| jacobian[(k / N, k % N)] = value);
        jacobian
    }

    fn motion(&self, t: T, x: &SVector<T, N>, u: &SVector<T, M>) -> (SVector<T, N>, SMatrix<T, N, N>) {
        let nan = convert(f64::NAN);
        let (mut f, mut df) = (SVector::<T, N>::repeat(nan), SMatrix::<T, N, N>::repeat(nan));
        self.motion_into(t, x.as_slice(), u.as_slice(), f.as_mut_slice(), df.as_mut_slice());
        (f, df)
    }

    fn measurement(&self, t: T, x: &SVector<T, N>, u: &SVector<T, M>) -> (SVector<T, P>, SMatrix<T, P, N>) {
        let nan = convert(f64::NAN);
        let (mut h, mut dh) = (SVector::<T, P>::repeat(nan), SMatrix::<T, P, N>::repeat(nan));
        self.measurement_into(t, x.as_slice(), u.as_slice(), h.as_mut_slice(), dh.as_mut_slice());
        (h, dh)
    }

    fn motion_into(&self, t: T, x: &[T], u: &[T], f: &mut [T], df: &mut [T]) -> bool {
        self.0.joint(Row::Derivative(0), (t, x, u), (f, df))
    }

    fn measurement_into(&self, t: T, x: &[T], u: &[T], h: &mut [T], dh: &mut [T]) -> bool {
        self.0.joint(Row::Output(0), (t, x, u), (h, dh))
    }
}
