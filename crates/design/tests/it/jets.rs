//! Power series in time: the functions of [`Jet`] against each other and against the books.

use luenberger_design::nonlinear_observability::{HIGHEST_ORDER, Jet};
use nalgebra::{ComplexField, RealField, convert};
use num_traits::{One, Zero};

fn number(x: f64) -> Jet {
    convert(x)
}

/// `0.6 + s/4 - s^2/8 + ..`, with derivatives along a direction that depends on the order.
fn curve(at: f64) -> Jet {
    Jet::from_fn(|k| {
        let share = 0.25 / (1 + k * k) as f64;
        (if k == 0 { at } else { share * (1.0 - 2.0 * (k % 2) as f64) }, 1.0 - share)
    })
}

/// Each of some 300 operations rounds by half an ulp of numbers up to about 1e3 here.
const ROUNDING: f64 = 300.0 * 1e3 * f64::EPSILON;

fn agree(what: &str, x: &Jet, y: &Jet) {
    for k in 0..=HIGHEST_ORDER {
        let ((x, of_x), (y, of_y)) = ((x.coefficient(k), x.slope(k)), (y.coefficient(k), y.slope(k)));
        let bound = ROUNDING * (1.0 + y.abs() + of_y.abs());
        assert!((x - y).abs() <= bound, "{what}, order {k}: {x} against {y}");
        assert!((of_x - of_y).abs() <= bound, "{what}, order {k}: slope {of_x} against {of_y}");
    }
}

#[test]
fn a_function_and_its_inverse_give_the_series_back() {
    for at in [0.6, -0.4, 1e-3] {
        let x = curve(at);
        agree("ln exp", &x.exp().ln(), &x);
        agree("ln_1p exp_m1", &x.exp_m1().ln_1p(), &x);
        agree("asin sin", &x.sin().asin(), &x);
        agree("acos cos", &(x + Jet::one()).cos().acos(), &(x + Jet::one()));
        agree("atan tan", &x.tan().atan(), &x);
        agree("atan2", &x.sin().atan2(x.cos()), &x);
        agree("atan2 on the left", &x.cos().atan2(-x.sin()), &(x + Jet::frac_pi_2()));
        agree("asinh sinh", &x.sinh().asinh(), &x);
        agree("atanh tanh", &x.tanh().atanh(), &x);
        agree("acosh cosh", &(x + Jet::one()).cosh().acosh(), &(x + Jet::one()));
        agree("sqrt squared", &(x + Jet::one()).sqrt().powi(2), &(x + Jet::one()));
        agree("x/y y", &(x / (x + number(2.0)) * (x + number(2.0))), &x);
    }
    for at in [0.6, -0.8] {
        agree("cbrt cubed", &curve(at).cbrt().powi(3), &curve(at));
    }
}

#[test]
fn functions_that_are_made_of_others_are_so_as_series() {
    let x = curve(0.6);
    let (s, c) = x.sin_cos();
    agree("sin^2 + cos^2", &(s * s + c * c), &Jet::one());
    agree("tan", &x.tan(), &(s / c));
    let (s, c) = x.sinh_cosh();
    agree("cosh^2 - sinh^2", &(c * c - s * s), &Jet::one());
    agree("tanh", &x.tanh(), &(s / c));
    agree("hypot", &x.hypot(number(2.0)), &(x * x + number(4.0)).sqrt());
    agree("powf", &x.powf(number(2.5)), &(x.sqrt() * x * x));
    agree("powf of a series", &x.powf(x), &(x * x.ln()).exp());
    agree("powi", &x.powi(-3), &(Jet::one() / (x * x * x)));
    agree("exp2", &x.exp2().log2(), &x);
    agree("log", &x.log(number(10.0)), &x.log10());
    agree("abs", &ComplexField::abs(curve(-0.5)), &-curve(-0.5));
    agree("remainder", &((x + number(2.0)) % Jet::one()), &x);
    agree("max", &RealField::max(x, Jet::zero()), &x);
}

#[test]
fn the_series_of_the_books() {
    let s = Jet::time(0.0);
    let mut factorial = 1.0;
    for k in 1..=HIGHEST_ORDER {
        factorial *= k as f64;
        let even = k % 2 == 0;
        let near = |x: f64, y: f64| assert!((x - y).abs() <= 4.0 * f64::EPSILON * y.abs(), "order {k}: {x} for {y}");
        near(s.exp().coefficient(k), 1.0 / factorial);
        near(s.ln_1p().coefficient(k), if even { -1.0 } else { 1.0 } / k as f64);
        near(s.sin().coefficient(k), if even { 0.0 } else { [1.0, -1.0][k / 2 % 2] / factorial });
        near(s.atan().coefficient(k), if even { 0.0 } else { [1.0, -1.0][k / 2 % 2] / k as f64 });
        near((Jet::one() - s).recip().coefficient(k), 1.0);
    }
    // Powers at 0, where the logarithm has no value.
    assert_eq!((s.powi(3).coefficient(3), s.powi(3).coefficient(2)), (1.0, 0.0));
    assert!(!ComplexField::is_finite(&s.sqrt()) && ComplexField::is_finite(&Jet::zero().sqrt()));
}
