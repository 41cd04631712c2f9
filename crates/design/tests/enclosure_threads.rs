//! A right-hand side that compares in threads of its own. By itself, because meanwhile no other enclosure has a result.

use luenberger_design::Region;
use luenberger_design::enclosure::{EnclosureError, enclose};
use luenberger_plants::plant;
use nalgebra::convert;

struct Threaded;

plant!(
    Threaded,
    (1, 0, 1),
    |plant, t, x, u| {
        let (x, cut) = (x[0], convert::<f64, T>(0.5));
        let square = std::thread::scope(|scope| scope.spawn(|| if x > cut { x * x } else { x - cut * cut }).join());
        [square.unwrap_or(x)]
    },
    *x
);

#[test]
fn a_comparison_in_another_thread_is_an_error_and_not_an_answer() {
    let error = enclose(&Threaded, &Region::new(&[(-1.0, 1.0)])).unwrap_err();
    assert!(matches!(error, EnclosureError::Undefined { operation: "a comparison in another thread", .. }), "{error}");
    // Where the comparison is decided, there is nothing wrong with threads.
    let slope = enclose(&Threaded, &Region::new(&[(1.0, 2.0)])).unwrap().a[(0, 0)];
    assert!(slope.lo() <= 2.0 && slope.hi() >= 4.0 && slope.width() < 2.1);
}
