//! As on a bare target, `--no-default-features`: no dual numbers, and the converter's I&IO is the same.
#![cfg(not(feature = "dual"))]

use luenberger_observers::{Observer, cuk};
use luenberger_plants::{CukConverter, Plant};
use nalgebra::{Vector1, Vector2, Vector4};

/// (18) by hand: `e_i1' = -g1 w e_i1`, `e_v4' = -(G/C4 + g2) e_v4`.
#[test]
fn the_iio_of_the_converter_needs_no_dual_numbers() {
    let (plant, tuning) = (CukConverter::default(), cuk::Tuning::<f64>::default());
    let observer = cuk::immersion_invariance(plant, &tuning).unwrap();
    let (x, e, u) = (Vector4::new(0.5, 20.0, -0.25, -8.0), Vector2::new(0.25, -3.0), Vector1::new(0.4));
    let (y, rate) = (plant.output(0.0, &x), plant.derivative(0.0, &x, &u));
    let chi = observer.initial(0.0, &Vector2::new(x[0] + e[0], x[3] + e[1]), &u, &y);
    let slope = observer.derivative(0.0, &chi, &u, &y);
    // beta' - phi'.
    let moved = Vector2::new(
        slope[0] + plant.c2 * tuning.g1 * rate[1] - rate[0],
        slope[1] - plant.l3 * tuning.g2 * rate[2] - rate[3],
    );
    let claimed = Vector2::new(-tuning.g1 * 0.6 * e[0], -(plant.g / plant.c4 + tuning.g2) * e[1]);
    // Terms of 1 A and of G 8 V over 23 uF.
    assert!((moved - claimed).amax() <= 16.0 * f64::EPSILON * 5e4, "{moved} {claimed}");
}
