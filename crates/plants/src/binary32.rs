//! Elementary functions of binary32 numbers in binary32 arithmetic alone.
//!
//! The `sinf`, `cosf`, `tanf` and `asinf` of libm compute in binary64, in software on a processor whose floating-point
//! unit has single precision (Cortex-M4F). These four take their place wherever an expression is evaluated in binary32:
//! in simulations, and in exported C and Rust, whose operations are the same in the same order. The other functions of
//! libm for binary32 that expressions call have no operation of binary64.
//!
//! | function | largest error seen on one number in 29 of all | tests refuse |
//! |---|---:|---:|
//! | [`sin`] | 0.89 units in the last place | 1 |
//! | [`cos`] | 0.89 | 1 |
//! | [`tan`] | 1.70 | 2 |
//! | [`asin`] | 0.95 | 1 |
//!
//! The argument is reduced to two numbers, for every finite argument: below 402 by three parts of pi/2
//! (W. J. Cody, W. Waite, Software Manual for the Elementary Functions, 1980), above by a product of integers with the
//! bits of 2/pi (M. H. Payne, R. N. Hanek, Radian reduction for trigonometric functions, SIGNUM Newsletter 18, 1983).
//! The polynomials are minimax in the relative error on [-pi/4, pi/4], their coefficients rounded one after the other,
//! the rest fitted again after each.
//!
//! A plant written in Rust over every scalar calls nalgebra's functions, over `f32` those of libm. To have these, it
//! implements [`Plant<f32>`](crate::Plant) with calls of this module.

/// The bits of 2/pi, after 32 bits before the point.
const TWO_OVER_PI: [u32; 8] = [0, 0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab];

/// From here arguments are reduced in integers.
const LARGE: f32 = 402.0;

/// N modulo 4 and `x - N pi/2` in two pieces, for finite x from [`LARGE`].
fn reduced_large(x: f32) -> (u32, f32, f32) {
    let bits = x.to_bits();
    let m = u64::from((bits & 0x007f_ffff) | 0x0080_0000);
    let first = (bits >> 23).wrapping_sub(120);
    let word = |k: usize| u64::from(TWO_OVER_PI[((first >> 5) as usize).wrapping_add(k) & 7]);
    let piece = |k: usize| ((word(k) << 32 | word(k + 1)) >> (32 - (first & 31))) & 0xffff_ffff;
    let quarters = ((m * piece(0)) << 32).wrapping_add(m * piece(1)).wrapping_add((m * piece(2)) >> 32);
    let n = (quarters.wrapping_add(1 << 61) >> 62) as u32;
    let part = (quarters << 2).cast_signed();
    let sign = if part < 0 { -1.0 } else { 1.0 };
    let part = part.unsigned_abs();
    let zeros = part.leading_zeros().min(34);
    let scale = sign * f32::from_bits(98_u32.wrapping_sub(zeros) << 23);
    let v = ((((part << zeros) >> 32) * 0xc90f_daa2) >> 34) as i32;
    let head = v as f32;
    (n, head * scale, v.wrapping_sub(head as i32) as f32 * scale)
}

/// `N = rint(x 2/pi)` modulo 4 and `x - N pi/2` in two pieces, for finite x >= 0.
fn reduced(x: f32) -> (u32, f32, f32) {
    // The first number above pi/4.
    if x < core::f32::consts::FRAC_PI_4 {
        return (0, x, 0.0);
    }
    if x >= LARGE {
        return reduced_large(x);
    }
    let n = (x * 0.63661975 + 0.5) as u32;
    let multiple = n as f32;
    let first = x - multiple * 1.5707703;
    let w = multiple * 2.6063062e-5;
    let r = first - w;
    let w = ((first - r) - w) - multiple * 6.0771006e-11;
    let head = r + w;
    (n & 3, head, (r - head) + w)
}

/// `sin(x + y)` on [-pi/4, pi/4], y the tail of x.
fn sin_near(x: f32, y: f32) -> f32 {
    let z = x * x;
    let r = -0.16666655 + z * (0.008332189 + z * -0.00019518289);
    x + (z * (x * r - 0.5 * y) + y)
}

/// `cos(x + y)` on [-pi/4, pi/4], y the tail of x.
fn cos_near(x: f32, y: f32) -> f32 {
    let z = x * x;
    let r = 0.041666646 + z * (-0.001388731 + z * 2.4432327e-5);
    let half = 0.5 * z;
    let w = 1.0 - half;
    w + (((1.0 - w) - half) + (z * (z * r) - x * y))
}

/// `tan(x + y)` on [-pi/4, pi/4], y the tail of x.
fn tan_near(x: f32, y: f32) -> f32 {
    const T: [f32; 7] = [0.3333335, 0.13332675, 0.054058913, 0.021286208, 0.010827444, 9.82216e-5, 0.0043727397];
    let z = x * x;
    let r = T[0] + z * (T[1] + z * (T[2] + z * (T[3] + z * (T[4] + z * (T[5] + z * T[6])))));
    x + (z * (x * r + y) + y)
}

/// The sine.
///
/// ```
/// use luenberger_plants::binary32::sin;
/// assert_eq!(sin(0.5), 0.47942555);
/// // The next number to 1e30 is 7.6e22 away, and still the sine is that of 1e30f32.
/// assert_eq!(sin(1e30), f64::sin(f64::from(1e30_f32)) as f32);
/// assert!(sin(f32::INFINITY).is_nan());
/// ```
pub fn sin(x: f32) -> f32 {
    if !x.is_finite() {
        return f32::NAN;
    }
    let (n, head, tail) = reduced(x.abs());
    let r = if n & 1 == 0 { sin_near(head, tail) } else { cos_near(head, tail) };
    if n >> 1 == x.to_bits() >> 31 { r } else { -r }
}

/// The cosine.
///
/// ```
/// use luenberger_plants::binary32::cos;
/// assert_eq!([cos(0.0), cos(0.5)], [1.0, 0.87758255]);
/// ```
pub fn cos(x: f32) -> f32 {
    if !x.is_finite() {
        return f32::NAN;
    }
    let (n, head, tail) = reduced(x.abs());
    let r = if n & 1 == 0 { cos_near(head, tail) } else { sin_near(head, tail) };
    if (n + 1) & 2 == 0 { r } else { -r }
}

/// The tangent. No number is an odd multiple of pi/2: it is finite for every finite x.
///
/// ```
/// use luenberger_plants::binary32::tan;
/// assert_eq!(tan(0.5), 0.5463025);
/// // By mpmath -22877332.43, where the next numbers are 2 away.
/// assert!((tan(core::f32::consts::FRAC_PI_2) + 22877332.43).abs() <= 2.0);
/// ```
pub fn tan(x: f32) -> f32 {
    if !x.is_finite() {
        return f32::NAN;
    }
    let (n, head, tail) = reduced(x.abs());
    let near = tan_near(head, tail);
    let r = if n & 1 == 0 { near } else { -1.0 / near };
    if x.to_bits() >> 31 == 0 { r } else { -r }
}

/// The arc sine, NaN beyond [-1, 1]: with the branches and the rational function of FreeBSD's msun (`e_asin.c`,
/// `e_asinf.c`).
///
/// ```
/// use luenberger_plants::binary32::asin;
/// assert_eq!([asin(0.5), asin(-1.0)], [0.5235988, -core::f32::consts::FRAC_PI_2]);
/// ```
pub fn asin(argument: f32) -> f32 {
    // pi/2 and what it lacks.
    const HIGH: f32 = core::f32::consts::FRAC_PI_2;
    const LOW: f32 = -4.371139e-8;
    let rational = |z: f32| z * (0.16666587 + z * (-0.042743422 + z * -0.008656363)) / (1.0 + z * -0.70662963);
    let x = argument.abs();
    if x < 0.5 {
        return argument + argument * rational(x * x);
    }
    if x == 1.0 {
        return argument * HIGH;
    }
    if x.is_nan() || x > 1.0 {
        return f32::NAN;
    }
    let z = (1.0 - x) * 0.5;
    let s = nalgebra::ComplexField::sqrt(z);
    // The square of f is exact, and s = f + c.
    let f = f32::from_bits(s.to_bits() & 0xffff_f000);
    let c = (z - f * f) / (s + f);
    let r = 2.0 * s * rational(z) - (LOW - 2.0 * c);
    let r = 0.5 * HIGH - (r - (0.5 * HIGH - 2.0 * f));
    if argument < 0.0 { -r } else { r }
}
