//! Shared data of the checks and figures of one run: the output folder, and cached results.

use std::any::Any;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Any error of a check. It marks the claim as failed and the run as unsuccessful.
pub type CheckError = Box<dyn std::error::Error + Send + Sync>;

/// A shared result, once it is computed.
type Shared = Option<Arc<dyn Any + Send + Sync>>;

/// Handed to every check and figure.
#[derive(Debug)]
pub struct Context {
    out: PathBuf,
    shared: Mutex<HashMap<&'static str, Arc<Mutex<Shared>>>>,
}

impl Context {
    /// A context that writes below `out` (nothing is created yet).
    pub fn new(out: impl Into<PathBuf>) -> Self {
        Self { out: out.into(), shared: Mutex::new(HashMap::new()) }
    }

    /// The folder of the run's output.
    pub fn out(&self) -> &Path {
        &self.out
    }

    /// The result of `compute`, computed once per run: a trajectory that several claims and figures read.
    ///
    /// ```
    /// use luenberger_reproduce::{CheckError, Context};
    /// fn squares(context: &Context) -> Result<std::sync::Arc<Vec<f64>>, CheckError> {
    ///     context.once("demo.squares", || Ok((0..4).map(|k| f64::from(k * k)).collect()))
    /// }
    /// assert_eq!(*squares(&Context::new(".")).unwrap(), [0.0, 1.0, 4.0, 9.0]);
    /// ```
    /// # Errors
    /// Those of `compute` (which are not kept: the next caller tries again), and [`TypeOfKey`] if `key` names a result
    /// of another type.
    pub fn once<T: Any + Send + Sync>(
        &self,
        key: &'static str,
        compute: impl FnOnce() -> Result<T, CheckError>,
    ) -> Result<Arc<T>, CheckError> {
        // The lock of the map is not held while computing, so that a computation may ask for another shared result:
        // that of the key is, and the others wait for it. A panic leaves the place empty, so poison is of no
        // consequence.
        let place = Arc::clone(self.shared.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_default());
        let mut place = place.lock().unwrap_or_else(PoisonError::into_inner);
        let result = match &*place {
            Some(known) => Arc::clone(known),
            None => Arc::clone(place.insert(Arc::new(compute()?))),
        };
        result.downcast::<T>().map_err(|_| TypeOfKey { key, wanted: std::any::type_name::<T>() }.into())
    }
}

/// Two callers of [`Context::once`] disagree about the type behind a key.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the shared result {key:?} is not a {wanted}")]
pub struct TypeOfKey {
    /// The key.
    pub key: &'static str,
    /// The requested type.
    pub wanted: &'static str,
}
