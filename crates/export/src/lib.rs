//! Designed observers as source code for the target: C99, Rust or FMU, bit for bit what was simulated.
//!
//! An [`Export`] is a sampled observer with its names, units and the statement of its certificate. [`Export::c`] and
//! [`Export::rust`] give the files of a small project: source, a test with golden vectors, a build file and a README.
//! The emitted C performs the operations of `luenberger-observers` in the same order on the same stored numbers, so
//! that a compiler that neither contracts nor reorders floating-point operations gives the same bits; the golden
//! vectors are computed by the Rust observer and compared by the emitted test.
//!
//! The emitted code belongs to the user; no licence of this project applies to it.
//!
//! ```
//! use luenberger_export::{Export, Names, ExportableObserver, Scalar};
//! use luenberger_observers::DiscreteLinearObserver;
//! use luenberger_plants::StateSpace;
//! use nalgebra::dmatrix;
//! let plant = StateSpace::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0])?;
//! let observer = DiscreteLinearObserver::new(plant, dmatrix![0.9; 2.0], 0.1)?;
//! let names = Names::numbered(2, 1, 1);
//! let export = Export::new("cart", ExportableObserver::Linear(observer), Scalar::Binary32, &[0.0, 0.0], names)?;
//! let files = export.c()?;
//! assert!(files.iter().any(|file| file.name == "cart.c" && file.text.contains("void cart_step(")));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | file | subject |
//! |---|---|
//! | [`exportable_observer`] | the observers that can be exported |
//! | `cast` | their steps in the target's format |
//! | [`kkl`] | numerical KKL observers with their sizes erased |
//! | [`moving_horizon`] | moving-horizon estimators with their sizes erased |
//! | [`golden`] | test vectors |
//! | `matrix` | which matrix of an observer an exported one is |
//! | [`names`] | names as identifiers |
//! | `operations` | operations and stored numbers of a step |
//! | `program` | steps that are recorded where they are written |
//! | [`number`] | floating-point numbers as literals of C and Rust |
//! | `c`, `rust` | the files |
//! | `fixed_point` | linear observers in fixed point |
//! | [`fmu`] | functional mock-up units |
//! | [`c_math`] | the elementary functions of libm as C |

#![deny(missing_docs)]

mod c;
pub mod c_math;
mod cast;
mod error;
pub mod exportable_observer;
pub mod extension;
mod fixed_point;
pub mod fmu;
pub mod golden;
pub mod kkl;
mod matrix;
pub mod moving_horizon;
pub mod names;
pub mod number;
mod operations;
mod program;
mod rust;
mod scalar;
pub mod step;

pub use c::Layout;
pub use error::ExportError;
pub use exportable_observer::ExportableObserver;
pub use fixed_point::FixedPointExport;
/// The formats of [`Export::fixed_point`].
pub use luenberger_observers::{FixedPointFormat, FixedPointFormats};
pub use matrix::ExportedMatrix;
pub use nalgebra;
pub use names::Names;
pub use scalar::Scalar;

use std::fmt::Write;

use luenberger_expression::MathFunction;
use luenberger_observers::numerical_kkl::Search;
use nalgebra::DMatrix;
use sha2::{Digest, Sha256};

/// The SHA-256 of some bytes, in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        _ = write!(text, "{byte:02x}");
        text
    })
}

/// A file of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// The name, relative to the folder of the export.
    pub name: String,
    /// The content.
    pub text: String,
}

/// A sampled observer, ready to be written as source code.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    identifier: String,
    observer: ExportableObserver,
    scalar: Scalar,
    initial: Vec<f64>,
    names: Names,
    statement: Vec<String>,
    sources: Vec<(String, String)>,
    samples: Vec<(Vec<f64>, Vec<f64>)>,
    test_steps: usize,
    feedback: Option<DMatrix<f64>>,
    update: Option<DMatrix<f64>>,
    title: Option<&'static str>,
    functions_of_target: bool,
}

impl Export {
    /// The kind of observer in words, with the feedback.
    pub(crate) fn kind(&self) -> String {
        let observer = match &self.observer {
            _ if self.title.is_some() => self.title.unwrap_or_default(),
            ExportableObserver::Linear(_) if self.is_filter() => "Stationary Kalman filter",
            ExportableObserver::Linear(_) => "Sampled linear observer",
            ExportableObserver::Cubic(_) => "Sampled cubic observer",
            ExportableObserver::Varying(_) => "Sampled cubic observer at varying periods",
            ExportableObserver::Kalman(filter) if filter.unit_vectors().is_some() => "Error-state Kalman filter",
            ExportableObserver::Kalman(filter) if filter.iterations() > 1 => "Iterated extended Kalman filter",
            ExportableObserver::Kalman(_) => "Extended Kalman filter",
            ExportableObserver::Unscented(_) => "Unscented Kalman filter",
            ExportableObserver::MovingHorizon(_) => "Moving-horizon estimator",
            ExportableObserver::Kkl(_) => "Numerical KKL observer",
            ExportableObserver::Extension(_) | ExportableObserver::Step(_) => "Observer of expressions",
            ExportableObserver::SampledNonlinear(_) | ExportableObserver::Discrete(_) => {
                "Copy of the plant with a constant gain"
            }
        };
        let feedback = if self.feedback.is_some() { " with the feedback u = r - K xhat" } else { "" };
        format!("{observer}{feedback}")
    }

    /// The observer under the name `identifier`, in the format `scalar`, with the first estimate `initial`
    /// (n entries).
    ///
    /// # Errors
    /// [`ExportError::Identifier`] for a name that is no identifier of C and Rust or is reserved;
    /// [`ExportError::Length`] for names or an estimate that do not fit; [`ExportError::Format`] for a number beyond
    /// the range of the format, and for gains that the observer's constructor refuses after rounding.
    pub fn new(
        identifier: &str,
        observer: ExportableObserver,
        scalar: Scalar,
        initial: &[f64],
        names: Names,
    ) -> Result<Self, ExportError> {
        names::check(identifier)?;
        let size = observer.dimensions();
        let fits = |what, expected: usize, found: usize| {
            if expected == found { Ok(()) } else { Err(ExportError::Length { what, expected, found }) }
        };
        fits("the first estimate", size.estimate, initial.len())?;
        fits("the list of states", size.estimate, names.states.len())?;
        fits("the list of inputs", observer.plant_inputs(), names.inputs.len())?;
        fits("the list of outputs", size.outputs, names.outputs.len())?;
        observer.check(scalar)?;
        let initial: Vec<f64> = initial.iter().map(|x| scalar.round(*x)).collect();
        if let Some(index) = initial.iter().position(|x| !x.is_finite()) {
            let what = format!("entry {} of the first estimate", index + 1);
            return Err(ExportError::Format { what, format: scalar.name() });
        }
        let identifier = identifier.to_owned();
        Ok(Self {
            identifier,
            observer,
            scalar,
            initial,
            names,
            statement: Vec::new(),
            sources: Vec::new(),
            samples: Vec::new(),
            test_steps: golden::STEPS,
            feedback: None,
            update: None,
            title: None,
            functions_of_target: false,
        })
    }

    /// Adds sentences to the header of the code, such as the statement that is proved.
    #[must_use]
    pub fn statement(mut self, sentences: &[String]) -> Self {
        self.statement = sentences.to_vec();
        self
    }

    /// Adds the SHA-256 of a source of the observer (`the study`) or of its proof (`certificate.json`) to the header.
    #[must_use]
    pub fn source(mut self, what: &str, digest: &str) -> Self {
        self.sources.push((what.to_owned(), digest.to_owned()));
        self
    }

    /// Adds the feedback `u = r - K xhat`, K m x n: the step takes r and y, and returns u as well.
    ///
    /// # Errors
    /// [`ExportError::Gain`] for another shape; [`ExportError::Format`] for an entry beyond the range of the format;
    /// [`ExportError::FilterForm`] for an observer in filter form.
    pub fn with_feedback(mut self, k: &DMatrix<f64>) -> Result<Self, ExportError> {
        if self.update.is_some() {
            return Err(ExportError::FilterForm { what: "feedback".to_owned() });
        }
        if self.observer.takes_time() {
            return Err(ExportError::VaryingPeriods { what: "with one, which takes the estimate for the next sample" });
        }
        let size = self.observer.dimensions();
        let (expected, found) = ((size.inputs, size.estimate), k.shape());
        if expected != found || k.is_empty() {
            return Err(ExportError::Gain { expected, found });
        }
        if let Some(k) = k.iter().find(|x| !self.scalar.round(**x).is_finite()) {
            return Err(ExportError::Format { what: format!("the entry {k} of K"), format: self.scalar.name() });
        }
        self.feedback = Some(k.clone());
        Ok(self)
    }

    /// A linear observer in filter form: the step returns the estimate at its sample, `xhat + K (y - C xhat - D u)` for
    /// the prediction xhat, K n x p.
    ///
    /// # Errors
    /// [`ExportError::FilterForm`] for an observer that is not linear, and with feedback; [`ExportError::Gain`] for
    /// another shape; [`ExportError::Format`] for an entry beyond the range of the format.
    pub fn with_update(mut self, k: &DMatrix<f64>) -> Result<Self, ExportError> {
        if !matches!(self.observer, ExportableObserver::Linear(_)) {
            return Err(ExportError::FilterForm { what: self.kind() });
        }
        if self.feedback.is_some() {
            return Err(ExportError::FilterForm { what: "feedback".to_owned() });
        }
        let size = self.observer.dimensions();
        let (expected, found) = ((size.estimate, size.outputs), k.shape());
        if expected != found {
            return Err(ExportError::Gain { expected, found });
        }
        if let Some(k) = k.iter().find(|x| !self.scalar.round(**x).is_finite()) {
            return Err(ExportError::Format { what: format!("the entry {k} of K"), format: self.scalar.name() });
        }
        self.update = Some(k.clone());
        Ok(self)
    }

    /// Under this title, in words, in place of that of its form.
    #[must_use]
    pub fn titled(self, title: &'static str) -> Self {
        Self { title: Some(title), ..self }
    }

    /// C that calls the elementary functions of the target's library in place of those of the design: the results are
    /// no longer those of the design to the last bit, which the header says; the golden test compares to half of the
    /// digits.
    #[must_use]
    pub fn with_functions_of_target(self) -> Self {
        Self { functions_of_target: true, ..self }
    }

    /// Whether it calls functions of the target's library.
    pub(crate) fn calls_target(&self) -> bool {
        self.functions_of_target && self.functions().is_some()
    }

    /// Which elementary functions the step calls, whose they are, and their errors in binary32; none if it calls none.
    pub fn functions(&self) -> Option<String> {
        let called = self.observer.maps()?.functions();
        let names = |of: &dyn Fn(&MathFunction) -> String| called.iter().map(of).collect::<Vec<_>>().join(", ");
        let named = || names(&|function| function.name().to_owned());
        let sentence = match self.scalar {
            _ if self.functions_of_target => format!(
                "Functions: {}, those of the target's C library. The results are not those of the design to the last bit, and no bound and no comparison counts the errors of that library.",
                named()
            ),
            Scalar::Binary32 => format!(
                "Functions: {}, in float arithmetic alone; in brackets the largest error in units in the last place.",
                names(&|function| format!("{} ({})", function.name(), c_math::units(*function)))
            ),
            Scalar::Binary64 => format!("Functions: {}, those of the Rust crate libm.", named()),
        };
        (!called.is_empty()).then_some(sentence)
    }

    /// The gain K of the measurement update, of an observer in filter form.
    pub fn update_gain(&self) -> Option<&DMatrix<f64>> {
        self.update.as_ref()
    }

    /// The first estimate, as stored in the format.
    pub fn first_estimate(&self) -> &[f64] {
        &self.initial
    }

    /// The names of the entries of the estimate.
    pub fn states(&self) -> &[String] {
        &self.names.states
    }

    /// Whether the estimate uses the measurement of its sample.
    pub fn is_filter(&self) -> bool {
        self.update.is_some()
    }

    /// Whether the estimate after a step is that of its sample, and not for the next one.
    pub fn is_of_sample(&self) -> bool {
        self.is_filter() || matches!(&self.observer, ExportableObserver::Step(step) if step.is_of_sample())
    }

    /// Whether the step of the emitted code has its halves apart, update and prediction: a filter's, and that of an
    /// observer at varying periods. A block with feedback has none, because the feedback takes the estimate between
    /// them.
    pub fn has_halves(&self) -> bool {
        let is_filter = match &self.observer {
            ExportableObserver::Kalman(_) | ExportableObserver::Unscented(_) | ExportableObserver::Varying(_) => true,
            _ => self.is_filter(),
        };
        is_filter && self.feedback.is_none()
    }

    /// Whether the step includes a feedback.
    pub fn has_feedback(&self) -> bool {
        self.feedback.is_some()
    }

    /// Sets recorded inputs and outputs, one pair for each sample, as golden vectors of an observer of a nonlinear
    /// plant, which may not be defined at arbitrary values.
    #[must_use]
    pub fn samples(mut self, samples: Vec<(Vec<f64>, Vec<f64>)>) -> Self {
        self.samples = samples;
        self
    }

    /// Sets the number of steps in the golden test (default [`golden::STEPS`]).
    #[must_use]
    pub fn test_steps(mut self, count: usize) -> Self {
        self.test_steps = count;
        self
    }

    /// The lines `SHA-256 of ..: ..`, of the numbers and of the sources.
    pub(crate) fn digests(&self) -> Vec<String> {
        self.digests_with(&self.digest())
    }

    /// The same with another digest of the numbers.
    pub(crate) fn digests_with(&self, numbers: &str) -> Vec<String> {
        let numbers = format!("SHA-256 of the numbers: {numbers}");
        let others = self.sources.iter().map(|(what, digest)| format!("SHA-256 of {what}: {digest}"));
        std::iter::once(numbers).chain(others).collect()
    }

    /// The SHA-256 of what is exported: format, sizes, gains, period and first estimate, as they are written, the
    /// right-hand sides of a nonlinear plant, and whether their functions are those of the target.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(self.scalar.name().as_bytes());
        for (which, matrix) in self.matrices() {
            hash.update(format!("{} {} {}", which.name(), matrix.nrows(), matrix.ncols()).as_bytes());
            matrix.iter().for_each(|x| hash.update(x.to_bits().to_le_bytes()));
        }
        for x in self.scalars().iter().map(|(_, x)| x).chain(&self.initial) {
            hash.update(x.to_bits().to_le_bytes());
        }
        if let ExportableObserver::Kkl(observer) = &self.observer {
            for (name, tree) in observer.trees() {
                hash.update(format!("{name} {} {} {}", tree.inputs, tree.outputs, tree.degree).as_bytes());
                for node in &tree.nodes {
                    let (below, above) = (kkl::Tree::code(node.below), kkl::Tree::code(node.above));
                    hash.update(format!("{} {below} {above}", node.axis).as_bytes());
                }
                for x in tree.numbers(self.scalar) {
                    hash.update(x.to_bits().to_le_bytes());
                }
            }
            if let Some(table) = observer.table(self.scalar) {
                let search = table.search.unwrap_or(Search { max_evaluations: 0, tolerance: 0.0, fallback: 0 });
                let Search { max_evaluations, tolerance, fallback } = search;
                hash.update(format!("table {:?} {max_evaluations} {fallback}", table.points).as_bytes());
                let nodes = table.nodes.iter().flatten();
                for x in nodes.chain(&table.coefficients).chain([&tolerance]) {
                    hash.update(x.to_bits().to_le_bytes());
                }
            }
        }
        if let ExportableObserver::MovingHorizon(estimator) = &self.observer {
            let horizon = estimator.horizon();
            hash.update(format!("window {} iterations {}", horizon.window, horizon.iterations).as_bytes());
            for bound in moving_horizon::bounds(estimator) {
                hash.update(format!("{} {}", bound.axis, bound.is_lower).as_bytes());
            }
        }
        if let Some(maps) = self.observer.maps() {
            hash.update(format!("substeps {:?}", self.observer.substeps()).as_bytes());
            let dialect = c::plant::dialect(self, "");
            let routines: Vec<_> = maps.routines().collect();
            for routine in &routines {
                hash.update(routine.source(&dialect).as_bytes());
            }
            for (number, table, used) in exportable_observer::tables(&routines) {
                hash.update(table.source(number, &dialect, used).as_bytes());
            }
        }
        if self.calls_target() {
            hash.update(b"functions of the target");
        }
        hexadecimal(&hash.finalize())
    }

    /// The matrices as they are stored on the target.
    pub fn matrices(&self) -> Vec<(ExportedMatrix, DMatrix<f64>)> {
        let round = |matrix: &DMatrix<f64>| matrix.map(|x| self.scalar.round(x));
        let all = self
            .observer
            .matrices()
            .into_iter()
            .chain(self.feedback.iter().map(|k| (ExportedMatrix::Feedback, k.clone())));
        let all = all.chain(self.update.iter().map(|k| (ExportedMatrix::Update, k.clone())));
        all.map(|(which, matrix)| (which, round(&matrix))).collect()
    }

    /// The scalars as they are stored on the target.
    pub fn scalars(&self) -> Vec<(&'static str, f64)> {
        self.observer.scalars().into_iter().map(|(name, x)| (name, self.scalar.round(x))).collect()
    }

    /// The name in the emitted code.
    pub fn identifier(&self) -> &str {
        &self.identifier
    }

    /// The sampling period with its unit, `0.02 s`.
    pub fn period_text(&self) -> String {
        let unit = if self.names.time_unit.is_empty() { "time units" } else { &self.names.time_unit };
        format!("{} {unit}", self.observer.period())
    }

    /// The observer, with its numbers as designed.
    pub fn observer(&self) -> &ExportableObserver {
        &self.observer
    }

    /// The names; those of the states are of the entries of the estimate.
    pub fn names(&self) -> &Names {
        &self.names
    }

    /// The format.
    pub fn scalar(&self) -> Scalar {
        self.scalar
    }

    /// Floating-point operations of one step, square roots and divisions included; the most that a step takes.
    pub fn operations(&self) -> usize {
        self.observer.operations() + self.operations_of_gains()
    }

    /// The most operations of a step in which no bound is active, of a moving-horizon estimator with bounds.
    pub fn operations_within_bounds(&self) -> Option<usize> {
        self.observer.operations_within_bounds().map(|operations| operations + self.operations_of_gains())
    }

    fn operations_of_gains(&self) -> usize {
        self.feedback.iter().chain(&self.update).map(|k| 2 * k.len()).sum()
    }

    /// Bytes of the stack that the arrays of the window take during a step, of a moving-horizon estimator: the largest
    /// part of its memory.
    pub fn stack_of_window(&self) -> Option<usize> {
        self.observer.numbers_of_window().map(|numbers| numbers * self.scalar.bytes())
    }

    /// Bytes of the constants and of the state.
    pub fn bytes(&self) -> usize {
        let matrices: usize = self.matrices().iter().map(|(_, matrix)| matrix.len()).sum();
        let scalars = self.observer.scalars().len() + self.observer.constants_of_maps();
        let tables = self.observer.numbers_of_trees();
        let halves = self.update.as_ref().map_or(0, |k| k.nrows() + k.ncols());
        let numbers = matrices + scalars + tables + self.initial.len() + halves;
        numbers * self.scalar.bytes() + self.observer.state_bytes(self.scalar) + self.observer.integers() * 4
    }

    /// The files of a C99 project: header, source, test with golden vectors, `CMakeLists.txt` and `README.md`.
    ///
    /// # Errors
    /// [`ExportError::NotFinite`] if the observer leaves the range of the format on the golden vectors.
    pub fn c(&self) -> Result<Vec<File>, ExportError> {
        c::files(self)
    }

    /// The files of [`c`](Self::c) in the folders that the build system of boards or robots expects, with a program to
    /// be filled in that takes the step.
    ///
    /// # Errors
    /// As [`c`](Self::c), and [`ExportError::TimeUnit`] and [`ExportError::Period`] for a period that is not one of a
    /// timer.
    pub fn c_in(&self, layout: Layout) -> Result<Vec<File>, ExportError> {
        layout.place(self, self.c()?, c::scalar(self))
    }

    /// The files of a `no_std` crate on `luenberger-observers` with the gains as constants and the same golden test.
    ///
    /// # Errors
    /// As [`c`](Self::c).
    pub fn rust(&self) -> Result<Vec<File>, ExportError> {
        rust::files(self)
    }
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
