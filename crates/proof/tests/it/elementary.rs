//! Elementary functions of intervals against values from multiple precision, and as properties.
//!
//! The table is from mpmath 1.3 at 400 bits: f(x) is the sum of the last two columns to about 1e-32 of it, x being the
//! binary64 number itself.

// Some of the values are well known.
#![allow(clippy::approx_constant)]

use luenberger_proof::{Exact, Interval, Ring};
use proptest::prelude::*;

const TABLE: &[(&str, f64, f64, f64)] = &[
    ("exp", 1.0, 2.718281828459045, 1.4456468917292502e-16),
    ("exp", -0.1, 0.9048374180359595, 5.055984668733208e-17),
    ("exp", 700.0, 1.0142320547350045e+304, 1.6666571920734673e+287),
    ("exp", -700.0, 9.85967654375977e-305, 8.5e-322),
    ("exp", 1e-10, 1.0000000001, -8.269037096265652e-18),
    ("exp_m1", 1e-10, 1.00000000005e-10, 3.3900133221217734e-27),
    ("exp_m1", -3.0, -0.950212931632136, -8.422032873046665e-18),
    ("exp_m1", 2.5, 11.182493960703473, 2.0334002173348147e-16),
    ("ln", 0.1, -2.3025850929940455, -1.7150243628057985e-16),
    ("ln", 3.0, 1.0986122886681098, -9.07129723500153e-17),
    ("ln", 1e+300, 690.7755278982137, 2.3747660028800243e-14),
    ("ln", 1.0000000001, 1.000000082690371e-10, -4.2169170658954805e-27),
    ("ln_1p", 1e-10, 9.999999999500001e-11, -3.389513322121794e-27),
    ("ln_1p", -0.9, -2.302585092994046, -4.968982586806388e-18),
    ("ln_1p", 7.0, 2.0794415416798357, 1.8059370687790465e-16),
    ("sin", 1.0, 0.8414709848078965, 1.776845092935536e-18),
    ("sin", 3.0, 0.1411200080598672, 8.577269787017502e-18),
    ("sin", 100000.0, 0.03574879797201651, 1.5429743706109861e-18),
    ("sin", -2.5, -0.5984721441039565, 5.521403334082375e-17),
    ("sin", 100000000000.0, 0.928693660496592, -1.330083705997086e-17),
    ("cos", 1.0, 0.5403023058681398, -4.760954612604417e-17),
    ("cos", 1.5707963267948966, 6.123233995736766e-17, -1.4973849048591698e-33),
    ("cos", 100000.0, -0.9993608074382124, -2.3447088905187402e-17),
    ("cos", -4.0, -0.6536436208636119, 2.5846614087018284e-17),
    ("tan", 1.0, 1.5574077246549023, -6.186464176037592e-17),
    ("tan", 1.5, 14.101419947171719, 6.270315165067482e-16),
    ("tan", -0.3, -0.30933624960962325, 2.7475966183811927e-17),
    ("atan", 1.0, 0.7853981633974483, 3.061616997868383e-17),
    ("atan", 10000000000.0, 1.5707963266948965, 6.950637705727703e-17),
    ("atan", -0.1, -0.09966865249116204, 5.190520336352787e-18),
    ("asin", 0.5, 0.5235987755982989, -5.360408832255455e-17),
    ("asin", -0.999, -1.526071239626163, -7.84631528833658e-17),
    ("acos", 0.5, 1.0471975511965979, -1.072081766451091e-16),
    ("acos", -0.999, 3.09686756642106, -8.234911208429785e-17),
    ("sinh", 1.0, 1.1752011936438014, 7.849672142285669e-17),
    ("sinh", -20.0, -242582597.70489514, 7.865629467297586e-10),
    ("sinh", 1e-05, 1.0000000000166668e-05, -6.182319396196156e-22),
    ("cosh", 1.0, 1.5430806348152437, 6.606796775006833e-17),
    ("cosh", -20.0, 242582597.70489514, 1.2745906757087991e-09),
    ("tanh", 1.0, 0.7615941559557649, 3.7090214482164924e-17),
    ("tanh", 0.001, 0.0009999996666668, 1.7800613799166557e-20),
    ("tanh", -5.0, -0.9999092042625951, -2.298523750966507e-17),
    ("sqrt", 2.0, 1.4142135623730951, -9.667293313452913e-17),
    ("sqrt", 1e-300, 1e-150, 6.234187685431415e-168),
    ("cbrt", 2.0, 1.2599210498948732, -2.589933375300507e-17),
];

type Function = fn(&Interval) -> Option<Interval>;

type Library = fn(f64) -> f64;

/// The functions, and the library.
const FUNCTIONS: &[(&str, Function, Library)] = &[
    ("exp", |x| Some(x.exp()), f64::exp),
    ("exp_m1", |x| Some(x.exp_m1()), f64::exp_m1),
    ("ln", Interval::ln, f64::ln),
    ("ln_1p", Interval::ln_1p, f64::ln_1p),
    ("sin", |x| Some(x.sin()), f64::sin),
    ("cos", |x| Some(x.cos()), f64::cos),
    ("tan", Interval::tan, f64::tan),
    ("atan", |x| Some(x.atan()), f64::atan),
    ("asin", Interval::asin, f64::asin),
    ("acos", Interval::acos, f64::acos),
    ("sinh", |x| Some(x.sinh()), f64::sinh),
    ("cosh", |x| Some(x.cosh()), f64::cosh),
    ("tanh", |x| Some(x.tanh()), f64::tanh),
    ("sqrt", Interval::sqrt, f64::sqrt),
    ("cbrt", |x| Some(x.cbrt()), f64::cbrt),
    ("recip", Interval::recip, f64::recip),
    ("abs", |x| Some(x.abs()), f64::abs),
];

fn point(x: f64) -> Interval {
    Interval::from_f64(x).unwrap()
}

fn between(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

fn exact(x: f64) -> Exact {
    Exact::from_f64(x).unwrap()
}

#[test]
fn the_true_value_is_inside_and_the_interval_is_narrow() {
    for &(name, x, head, tail) in TABLE {
        let (_, f, _) = FUNCTIONS.iter().find(|(other, ..)| *other == name).unwrap();
        let y = f(&point(x)).unwrap();
        let value = exact(head).add(&exact(tail));
        assert!(exact(y.lo()) <= value && value <= exact(y.hi()), "{name}({x}) is not in {y:?}");
        // Eight units on either side of a value that is off by less than one.
        let unit = head.abs().next_up() - head.abs();
        assert!(y.width() <= 20.0 * unit, "{name}({x}): {y:?}");
    }
}

#[test]
fn extrema_inside_are_found() {
    assert_eq!(between(3.0, 3.2).cos().lo(), -1.0);
    assert_eq!(between(-0.1, 0.1).cos().hi(), 1.0);
    assert_eq!(between(1.5, 1.6).sin().hi(), 1.0);
    assert_eq!(between(-1.6, -1.5).sin().lo(), -1.0);
    assert!(between(-1.6, -1.5).sin().hi() < -0.99);
    assert_eq!(between(0.0, 7.0).sin(), between(-1.0, 1.0));
    assert_eq!(Interval::UNBOUNDED.cos(), between(-1.0, 1.0));
    assert_eq!(point(1e300).sin(), between(-1.0, 1.0));
    // The float nearest to pi lies below pi: the extremum is not inside, but nearer than the enclosure of pi can tell.
    assert_eq!(between(3.0, core::f64::consts::PI).cos().lo(), -1.0);
    assert_eq!(between(-2.0, 3.0).cosh().lo(), 1.0);
    assert_eq!(between(-2.0, 3.0).abs(), between(0.0, 3.0));
    assert_eq!(between(-2.0, 3.0).powi(2).unwrap().lo(), 0.0);
}

#[test]
fn where_a_function_is_not_defined_there_is_no_value() {
    let zero_inside = [between(-1.0, 2.0), between(0.0, 1.0), between(-1.0, 0.0), point(0.0), Interval::UNBOUNDED];
    for x in &zero_inside {
        assert_eq!((x.recip(), x.ln(), x.powi(-3), Interval::ONE.quotient(x)), (None, None, None, None));
    }
    assert_eq!(between(-1e-300, 1.0).sqrt(), None);
    assert_eq!(between(-1.0, 1.0).ln_1p(), None);
    assert_eq!(between(0.0, 1.0 + f64::EPSILON).asin(), None);
    assert_eq!(between(-1.5, 0.0).acos(), None);
    assert_eq!((between(1.5, 1.6).tan(), Interval::UNBOUNDED.tan(), point(1e300).tan()), (None, None, None));
    assert!(between(-1.5, 1.5).tan().is_some() && between(1.6, 4.7).tan().is_some());
}

#[test]
fn infinite_ends_have_their_limits() {
    let (right, left) = (between(1.0, f64::INFINITY), between(f64::NEG_INFINITY, -1.0));
    assert_eq!(right.recip().unwrap(), between(0.0, 1.0));
    assert_eq!(left.recip().unwrap(), between(-1.0, 0.0));
    assert_eq!((left.exp().lo(), right.exp().hi()), (0.0, f64::INFINITY));
    assert!(left.exp().hi() < 0.3679);
    assert_eq!(Interval::UNBOUNDED.tanh(), between(-1.0, 1.0));
    assert!(Interval::UNBOUNDED.atan().width() < 3.141_592_653_589_8);
    assert_eq!(right.sqrt().unwrap(), between(1.0, f64::INFINITY));
    assert_eq!(Interval::UNBOUNDED.powi(2).unwrap(), between(0.0, f64::INFINITY));
    assert_eq!(left.powi(3).unwrap(), left);
    // Overflow is not infinity: the number is finite and somewhere beyond the largest float.
    assert_eq!(point(1e200).powi(2).unwrap(), between(f64::MAX, f64::INFINITY));
    assert!(point(1000.0).exp().lo() > 1e308 && point(1000.0).exp().hi() == f64::INFINITY);
    assert!(point(-1000.0).exp().lo() == 0.0 && point(-1000.0).exp().hi() > 0.0);
    assert_eq!(point(2.0).powi(i32::MIN).unwrap().lo(), 0.0);
}

#[test]
fn small_cases_are_exact() {
    assert_eq!(point(4.0).sqrt().unwrap(), point(2.0));
    assert_eq!(point(0.0).exp(), Interval::ONE);
    assert_eq!(point(0.0).cos(), Interval::ONE);
    assert_eq!(Interval::ONE.ln().unwrap(), point(0.0));
    assert_eq!(point(3.0).powi(1).unwrap(), point(3.0));
    assert_eq!(point(3.0).powi(0).unwrap(), Interval::ONE);
    assert_eq!(point(3.0).quotient(&Interval::ONE).unwrap(), point(3.0));
}

fn pair() -> impl Strategy<Value = (f64, f64)> {
    let scale = prop_oneof![Just(1e-3), Just(1.0), Just(10.0), Just(300.0)];
    (scale, -1.0f64..1.0, -1.0f64..1.0).prop_map(|(scale, x, y)| (scale * x.min(y), scale * x.max(y)))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the argument, the value at a point of it is inside. The value is the library's, which errs by less than
    /// the bounds are moved.
    #[test]
    fn values_inside_are_inside((lo, hi) in pair(), share in 0.0f64..1.0) {
        let x = between(lo, hi);
        let inside = (lo + share * (hi - lo)).clamp(lo, hi);
        for (name, f, value) in FUNCTIONS {
            if let Some(y) = f(&x) {
                prop_assert!(y.contains(value(inside)), "{name} at {inside} of {x:?}: {} not in {y:?}", value(inside));
            }
        }
        for n in -3..5 {
            if let Some(y) = x.powi(n) {
                // The library's power is rounded a few times.
                let value = inside.powi(n);
                prop_assert!(y.lo() <= value + 4.0 * f64::EPSILON * value.abs() && value - 4.0 * f64::EPSILON * value.abs() <= y.hi());
            }
        }
    }

    /// A part of an argument has no more values than the whole.
    #[test]
    fn inclusion_is_kept((lo, hi) in pair(), first in 0.0f64..1.0, second in 0.0f64..1.0) {
        let at = |share: f64| (lo + share * (hi - lo)).clamp(lo, hi);
        let (x, part) = (between(lo, hi), between(at(first.min(second)), at(first.max(second))));
        for (name, f, _) in FUNCTIONS {
            if let Some(whole) = f(&x) {
                let y = f(&part).unwrap();
                // The bounds of neighbouring arguments are moved alike, so that their order is that of the library: off
                // by a few units.
                let slack = 32.0 * f64::EPSILON * y.magnitude();
                prop_assert!(whole.lo() <= y.lo() + slack && y.hi() - slack <= whole.hi(), "{name}: {part:?} {x:?}");
            }
        }
    }

    /// Quotients of numbers inside are inside.
    #[test]
    fn quotients_are_inside((a, b) in pair(), (c, d) in pair(), s in 0.0f64..1.0, r in 0.0f64..1.0) {
        let (x, y) = (between(a, b), between(c, d));
        if let Some(q) = x.quotient(&y) {
            let value = (a + s * (b - a)).clamp(a, b) / (c + r * (d - c)).clamp(c, d);
            prop_assert!(q.contains(value));
        } else {
            prop_assert!(y.contains(0.0));
        }
    }
}
