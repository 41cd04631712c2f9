//! Jumps that are due after a number of samples.

use luenberger_observers::{Observer, ObserverDimensions, SampledJumps};
use nalgebra::{SVector, U2, Vector1, Vector2};

/// Its jump halves its state.
struct Halved;

impl Observer<f64> for Halved {
    type State = Vector1<f64>;
    type Input = SVector<f64, 0>;
    type Output = Vector1<f64>;
    type Estimate = Vector1<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 1, inputs: 0, outputs: 1, estimate: 1 }
    }

    fn derivative(&self, _t: f64, z: &Vector1<f64>, _u: &SVector<f64, 0>, y: &Vector1<f64>) -> Vector1<f64> {
        y - z
    }

    fn estimate(&self, _t: f64, z: &Vector1<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector1<f64> {
        *z
    }

    fn initial(&self, _t: f64, x: &Vector1<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector1<f64> {
        *x
    }

    fn jump(&self, _t: f64, z: &Vector1<f64>, _u: &SVector<f64, 0>, _y: &Vector1<f64>) -> Vector1<f64> {
        z / 2.0
    }
}

/// Due at every third sample, the first of which is the one after three samples.
#[test]
fn a_jump_is_due_after_its_samples() {
    let observer = SampledJumps::<_, U2>::new(Halved, 3);
    let (u, y) = (SVector::zeros(), Vector1::new(1.0));
    let mut state = observer.initial(0.0, &Vector1::new(16.0), &u, &y);
    let mut seen = Vec::new();
    for _ in 0..9 {
        state = observer.jump(0.0, &state, &u, &y);
        seen.push(observer.estimate(0.0, &state, &u, &y)[0]);
    }
    assert_eq!(seen, [16.0, 16.0, 16.0, 8.0, 8.0, 8.0, 4.0, 4.0, 4.0]);
    // The count stands still between samples.
    assert_eq!(observer.derivative(0.0, &Vector2::new(3.0, 2.0), &u, &y), Vector2::new(-2.0, 0.0));
}
