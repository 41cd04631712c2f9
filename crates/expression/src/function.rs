//! The functions of expressions: names, numbers of arguments, and evaluation over any scalar.
//!
//! An operation is written once, for every [`RealField`]: numbers, dual numbers, intervals with derivatives. Four have
//! special cases, each for the sake of derivatives:
//! - `x^n` at x = 0 with n > 1 is 0 with derivative 0, where `exp(n ln x)` has none;
//! - `atan2(y, x)` near the axis x = 0 is `+-pi/2 - atan(x/y)`, whose derivative exists there;
//! - `tanh` beyond 300 is `(1 - exp(-2x))/(1 + exp(-2x))`, where `sinh/cosh` is infinity by infinity;
//! - `ln(a + exp(z))` for z > 1 is `z + ln(1 + a exp(-z))`, which does not overflow and loses less over an interval.
//!
//! Over numbers (f32, f64) every operation is one that emitted C has as well, with the same result to the last bit:
//! integer powers are products in a fixed order, and `min` and `max` are one comparison each, which keeps a NaN in the
//! first argument. Elementary functions are those of libm; in binary32 `sin`, `cos`, `tan` and `asin`, which libm
//! computes in binary64, are those of [`binary32`].

use core::any::{Any, TypeId};

use luenberger_plants::angle::wrapped;
use luenberger_plants::binary32;
use nalgebra::{ComplexField, RealField, convert};
use num_dual::{Dual32, Dual64};

/// The largest exponent that becomes a product.
pub(crate) const LARGEST_PRODUCT: f64 = 1000.0;

/// Whether the scalar is a floating-point number, which has neither derivative nor width.
pub(crate) fn is_number<T: 'static>() -> bool {
    TypeId::of::<T>() == TypeId::of::<f64>() || TypeId::of::<T>() == TypeId::of::<f32>()
}

/// A function of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Unary {
    Negate,
    Reciprocal,
    Abs,
    Sign,
    Step,
    Floor,
    Sqrt,
    Exp,
    Ln,
    Log10,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
}

/// An operation or a function of two arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Atan2,
    Min,
    Max,
    /// `x - y floor(x/y)`.
    Modulo,
    /// The angle x less a multiple of the full turn y, in (-y/2, y/2].
    Wrap,
    /// `ln(x + exp(y))`, which a compiled expression has in place of its three operations.
    LnPlusExp,
    /// `ln(exp(x) + y)`.
    LnExpPlus,
}

/// The meaning of a name before a parenthesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Unary(Unary),
    /// Of two arguments.
    Binary(Binary),
    /// Of two or more: the smallest, the largest.
    Fold(Binary),
    /// `sat(x)` or `sat(x, low, high)`.
    Saturate,
    /// `wrap(x)`, an angle in radians, or `wrap(x, turn)`.
    Wrap,
    /// `if(condition, x, y)`.
    If,
}

/// A comparison of two numbers. With NaN all are false but `!=`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Comparison {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
}

impl Comparison {
    /// As it is written.
    pub(crate) fn sign(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::Greater => ">",
            Self::GreaterOrEqual => ">=",
            Self::Equal => "==",
            Self::NotEqual => "!=",
        }
    }

    pub(crate) fn at<T: PartialOrd + Copy>(self, x: T, y: T) -> bool {
        match self {
            Self::Less => x < y,
            Self::LessOrEqual => x <= y,
            Self::Greater => x > y,
            Self::GreaterOrEqual => x >= y,
            Self::Equal => x == y,
            Self::NotEqual => x != y,
        }
    }
}

/// All functions by name.
const FUNCTIONS: [(&str, Function); 28] = [
    ("abs", Function::Unary(Unary::Abs)),
    ("acos", Function::Unary(Unary::Acos)),
    ("acosh", Function::Unary(Unary::Acosh)),
    ("asin", Function::Unary(Unary::Asin)),
    ("asinh", Function::Unary(Unary::Asinh)),
    ("atan", Function::Unary(Unary::Atan)),
    ("atan2", Function::Binary(Binary::Atan2)),
    ("atanh", Function::Unary(Unary::Atanh)),
    ("cos", Function::Unary(Unary::Cos)),
    ("cosh", Function::Unary(Unary::Cosh)),
    ("exp", Function::Unary(Unary::Exp)),
    ("floor", Function::Unary(Unary::Floor)),
    ("if", Function::If),
    ("ln", Function::Unary(Unary::Ln)),
    ("log10", Function::Unary(Unary::Log10)),
    ("max", Function::Fold(Binary::Max)),
    ("min", Function::Fold(Binary::Min)),
    ("mod", Function::Binary(Binary::Modulo)),
    ("pow", Function::Binary(Binary::Power)),
    ("sat", Function::Saturate),
    ("sign", Function::Unary(Unary::Sign)),
    ("sin", Function::Unary(Unary::Sin)),
    ("sinh", Function::Unary(Unary::Sinh)),
    ("sqrt", Function::Unary(Unary::Sqrt)),
    ("step", Function::Unary(Unary::Step)),
    ("tan", Function::Unary(Unary::Tan)),
    ("tanh", Function::Unary(Unary::Tanh)),
    ("wrap", Function::Wrap),
];

/// Names that other languages give to functions there are.
const ELSEWHERE: [(&str, &str); 20] = [
    ("heaviside", "step"),
    ("ifelse", "if"),
    ("iff", "if"),
    ("select", "if"),
    ("where", "if"),
    ("log", "ln"),
    ("arcsin", "asin"),
    ("arccos", "acos"),
    ("arctan", "atan"),
    ("arctan2", "atan2"),
    ("sgn", "sign"),
    ("signum", "sign"),
    ("power", "pow"),
    ("clip", "sat"),
    ("clamp", "sat"),
    ("fmod", "mod"),
    ("remainder", "mod"),
    ("wraptopi", "wrap"),
    ("wrapToPi", "wrap"),
    ("angdiff", "wrap"),
];

/// The function of that name.
pub(crate) fn function(name: &str) -> Option<(&'static str, Function)> {
    FUNCTIONS.into_iter().find(|(known, _)| *known == name)
}

/// The names of all functions.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.into_iter().map(|(name, _)| name)
}

/// The name used here for a function name of another language.
pub(crate) fn elsewhere(name: &str) -> Option<&'static str> {
    ELSEWHERE.into_iter().find(|(theirs, _)| *theirs == name).map(|(_, ours)| ours)
}

impl Function {
    /// The number of arguments as text, and whether a given number is valid.
    pub(crate) fn takes(self, count: usize) -> (&'static str, bool) {
        match self {
            Self::Unary(_) => ("one argument", count == 1),
            Self::Binary(_) => ("two arguments", count == 2),
            Self::Fold(_) => ("two arguments or more", count >= 2),
            Self::Saturate => ("one argument, or three: sat(x, low, high)", count == 1 || count == 3),
            Self::Wrap => ("one argument, or two: wrap(x, turn)", count == 1 || count == 2),
            Self::If => ("three arguments: if(condition, x, y)", count == 3),
        }
    }
}

impl Unary {
    /// Its name as a function.
    pub(crate) fn name(self) -> &'static str {
        let named = FUNCTIONS.into_iter().find(|(_, function)| *function == Function::Unary(self));
        // The two without a name are the signs - and 1/.
        named.map_or(if self == Self::Negate { "-" } else { "1/" }, |(name, _)| name)
    }

    pub(crate) fn at<T: RealField + Copy>(self, x: T) -> T {
        match self {
            Self::Negate => -x,
            Self::Reciprocal => x.recip(),
            Self::Abs => x.abs(),
            // 0 at 0, where the library's sign is that of the zero.
            Self::Sign => {
                if x == T::zero() {
                    T::zero()
                } else {
                    x.signum()
                }
            }
            Self::Step => {
                if x < T::zero() {
                    T::zero()
                } else if x.is_finite() || x > T::zero() {
                    T::one()
                } else {
                    x
                }
            }
            Self::Floor => floor(x),
            Self::Sqrt => x.sqrt(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Log10 => x.log10(),
            Self::Sin => single(x, binary32::sin, binary32::cos).unwrap_or_else(|| x.sin()),
            Self::Cos => single(x, binary32::cos, |x| -binary32::sin(x)).unwrap_or_else(|| x.cos()),
            Self::Tan => single(x, binary32::tan, tan_slope).unwrap_or_else(|| x.tan()),
            Self::Asin => single(x, binary32::asin, asin_slope).unwrap_or_else(|| x.asin()),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => tanh(x),
            Self::Asinh => x.asinh(),
            Self::Acosh => x.acosh(),
            Self::Atanh => x.atanh(),
        }
    }
}

impl Binary {
    /// Its name as a function, or its sign.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Power => "^",
            Self::Atan2 => "atan2",
            Self::Min => "min",
            Self::Max => "max",
            Self::Modulo => "mod",
            Self::Wrap => "wrap",
            Self::LnPlusExp | Self::LnExpPlus => "ln",
        }
    }

    pub(crate) fn at<T: RealField + Copy>(self, x: T, y: T) -> T {
        match self {
            Self::Add => x + y,
            Self::Subtract => x - y,
            Self::Multiply => x * y,
            Self::Divide => x / y,
            Self::Power => power(x, y),
            Self::Atan2 if is_number::<T>() => x.atan2(y),
            Self::Atan2 => atan2(x, y),
            Self::Min | Self::Max if is_number::<T>() => {
                let second = if self == Self::Max { y > x } else { y < x };
                if second { y } else { x }
            }
            Self::Min => x.min(y),
            Self::Max => x.max(y),
            Self::Modulo => x - y * floor(x / y),
            Self::Wrap => wrapped(x, y, floor),
            Self::LnPlusExp => ln_plus_exp(x, y),
            Self::LnExpPlus => ln_plus_exp(y, x),
        }
    }
}

/// The largest integer that is not above x. Dual numbers have no `floor` of their own; its derivative is 0.
fn floor<T: RealField + Copy>(x: T) -> T {
    if TypeId::of::<T>() == TypeId::of::<Dual64>() || TypeId::of::<T>() == TypeId::of::<Dual32>() {
        let value: f64 = x.to_subset_unchecked();
        return convert(ComplexField::floor(value));
    }
    x.floor()
}

/// The nearest number to x between low and high.
pub(crate) fn saturate<T: RealField + Copy>(x: T, low: T, high: T) -> T {
    Binary::Min.at(Binary::Max.at(x, low), high)
}

/// `x^n` as a product, n at most 1000.
pub(crate) fn integer_power<T: RealField + Copy>(x: T, n: u32) -> T {
    if is_number::<T>() { square_and_multiply(x, n, T::one(), |a, b| a * b) } else { x.powi(n.cast_signed()) }
}

/// `x^n` by the binary digits of n from the lowest: the squares `x^2, x^4, ..` are multiplied to the power as they
/// come.
pub(crate) fn square_and_multiply<X: Copy>(x: X, mut n: u32, one: X, mut multiply: impl FnMut(X, X) -> X) -> X {
    let (mut square, mut power) = (x, None);
    while n > 0 {
        if n & 1 == 1 {
            power = Some(power.map_or(square, |power| multiply(power, square)));
        }
        n >>= 1;
        if n > 0 {
            square = multiply(square, square);
        }
    }
    power.unwrap_or(one)
}

/// `f(x)` in binary32 arithmetic alone, and by its derivative over dual numbers; none of another scalar.
fn single<T: RealField + Copy>(x: T, f: fn(f32) -> f32, derivative: fn(f32) -> f32) -> Option<T> {
    let mut value = x;
    let number: &mut dyn Any = &mut value;
    if let Some(x) = number.downcast_mut::<f32>() {
        *x = f(*x);
    } else if let Some(x) = number.downcast_mut::<Dual32>() {
        *x = Dual32::new(f(x.re), derivative(x.re) * x.eps);
    } else {
        return None;
    }
    Some(value)
}

fn tan_slope(x: f32) -> f32 {
    let tan = binary32::tan(x);
    1.0 + tan * tan
}

fn asin_slope(x: f32) -> f32 {
    1.0 / ComplexField::sqrt(1.0 - x * x)
}

fn tanh<T: RealField + Copy>(x: T) -> T {
    let far: T = convert(300.0);
    let tail = |q: T| (T::one() - q) / (T::one() + q);
    if x > far {
        tail((-x - x).exp())
    } else if x < -far {
        -tail((x + x).exp())
    } else {
        x.tanh()
    }
}

/// `ln(a + exp(z))`: both branches are the same function, defined where the other is.
fn ln_plus_exp<T: RealField + Copy>(a: T, z: T) -> T {
    if z < T::one() { (a + z.exp()).ln() } else { z + (a * (-z).exp()).ln_1p() }
}

fn power<T: RealField + Copy>(x: T, n: T) -> T {
    if x == T::zero() && n > T::one() { T::zero() } else { x.powf(n) }
}

fn atan2<T: RealField + Copy>(y: T, x: T) -> T {
    let near: T = convert(1e-8);
    if x.abs() < y.abs() * near {
        let quarter = if y > T::zero() { T::frac_pi_2() } else { -T::frac_pi_2() };
        quarter - (x / y).atan()
    } else {
        y.atan2(x)
    }
}
