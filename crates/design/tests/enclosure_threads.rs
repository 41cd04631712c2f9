//! A right-hand side that compares in threads of its own. By itself, because meanwhile no other enclosure has a result.

use luenberger_design::Region;
use luenberger_design::enclosure::{EnclosureError, enclose};
use luenberger_plants::{Dimensions, Plant, Shape};
use nalgebra::{RealField, SVector, Vector1, convert};

struct Threaded;

impl Shape for Threaded {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 1, inputs: 0, outputs: 1 }
    }
}

impl<T: RealField + Copy> Plant<T> for Threaded {
    type State = Vector1<T>;
    type Input = SVector<T, 0>;
    type Output = Vector1<T>;

    fn derivative(&self, _t: T, x: &Vector1<T>, _u: &SVector<T, 0>) -> Vector1<T> {
        let (x, cut) = (x[0], convert::<f64, T>(0.5));
        let square = std::thread::scope(|scope| scope.spawn(|| if x > cut { x * x } else { x - cut * cut }).join());
        Vector1::new(square.unwrap_or(x))
    }

    fn output(&self, _t: T, x: &Vector1<T>, _u: &Self::Input) -> Vector1<T> {
        *x
    }
}

#[test]
fn a_comparison_in_another_thread_is_an_error_and_not_an_answer() {
    let error = enclose(&Threaded, &Region::new(&[(-1.0, 1.0)])).unwrap_err();
    assert!(matches!(error, EnclosureError::Undefined { operation: "a comparison in another thread", .. }), "{error}");
    // Where the comparison is decided, there is nothing wrong with threads.
    let slope = enclose(&Threaded, &Region::new(&[(1.0, 2.0)])).unwrap().a[(0, 0)];
    assert!(slope.lo() <= 2.0 && slope.hi() >= 4.0 && slope.width() < 2.1);
}
