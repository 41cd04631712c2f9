//! Serialisation of observers (feature `serde`), in any format of serde.
//!
//! An observer is written as its matrices, each an array of rows, under the names of its constructor's arguments; one
//! that is made of another has it under `inner` or `nominal`. It is read through its constructor: a file that was
//! changed by hand gives an observer that its constructor accepts, or the constructor's error. Sizes known at compile
//! time must be those of the file.
//!
//! Observers of a plant of the user's have it under `plant`, if its type implements `Serialize` and `Deserialize`: the
//! copies with a constant gain, the extended and the unscented Kalman filter. Feature `serde` of `luenberger-plants`
//! does it for linear plants.
//!
//! The others have no file, because their numbers are not all that they are: the mean-value observer has a mean and the
//! KKL, parameter-estimation, high-gain and immersion-and-invariance observers have maps that are code of the user's,
//! the inter-sample form and the mapped observer are made of them, numerical KKL observers have tables that the design
//! computes, the moving-horizon estimator and the sliding-mode observers have few numbers, which are the arguments of
//! their constructors. For these the study or the certificate file stores the design, from which they are built again.
//!
//! No evidence is stored here: that is a certificate file.
//!
//! ```
//! use luenberger_observers::{LinearObserver, StaticLinearObserver};
//! use nalgebra::Vector2;
//! let plant = luenberger_plants::double_integrator();
//! let observer = LinearObserver::new(plant.a, plant.b, plant.c, Vector2::new(7.0, 10.0))?;
//! let text = serde_json::to_string(&observer)?;
//! assert_eq!(text, r#"{"a":[[0.0,1.0],[0.0,0.0]],"b":[[0.0],[1.0]],"c":[[1.0,0.0]],"l":[[7.0],[10.0]]}"#);
//! let read: StaticLinearObserver<f64, 2, 1, 1> = serde_json::from_str(&text)?;
//! assert_eq!(read, observer);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod fixed_point;
mod interval;
mod with_inner;

use luenberger_plants::serialization::{Rows, rows};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, Scalar};

use crate::error::ObserverError;

/// The matrix with these rows.
///
/// # Errors
/// [`ObserverError::Matrix`]: rows of different lengths, or another size than the type has.
pub(crate) fn matrix<T: Scalar + Copy, R: Dim, C: Dim>(
    name: &'static str,
    rows: &Rows<T>,
) -> Result<OMatrix<T, R, C>, ObserverError>
where
    DefaultAllocator: Allocator<R, C>,
{
    Ok(luenberger_plants::serialization::matrix(name, rows)?)
}

fn maybe<T: Scalar + Copy, R: Dim, C: Dim>(rows: Option<Rows<T>>) -> Result<Option<OMatrix<T, R, C>>, ObserverError>
where
    DefaultAllocator: Allocator<R, C>,
{
    rows.map(|rows| matrix("D", &rows)).transpose()
}
