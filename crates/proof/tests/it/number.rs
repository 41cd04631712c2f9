//! Numbers of certificate files: what is written is read, and what is not a number is refused with a reason.

use dashu_int::ops::Gcd;
use dashu_int::{IBig, UBig};
use luenberger_proof::certificate::{LONGEST_NUMBER, Number, NumberError};
use luenberger_proof::{Exact, Ring};
use proptest::prelude::*;

fn read(text: &str) -> Result<Number, NumberError> {
    text.parse()
}

proptest! {
    #[test]
    fn every_binary64_number_comes_back(bits in any::<u64>()) {
        let x = f64::from_bits(bits);
        if let Some(number) = Number::from_f64(x) {
            prop_assert_eq!(read(&number.to_string()).expect("written by the writer").to_f64(), Some(x));
        } else {
            prop_assert!(!x.is_finite());
        }
    }

    /// The enclosure of a/b holds it, and is one unit in the last place wide: `lo b <= a <= hi b`, exactly.
    #[test]
    fn fractions_are_enclosed_by_their_neighbours(a in any::<i64>(), b in 1..=u64::MAX, shift in 0..2000_usize, down in any::<bool>()) {
        let (numerator, denominator) = (IBig::from(a), UBig::from(b));
        let (numerator, denominator) = if down { (numerator, denominator << shift) } else { (numerator << shift.min(900), denominator) };
        let interval = read(&format!("{numerator}/{denominator}")).expect("a fraction").enclosure();
        let (a, b) = (Exact::new(numerator, 0), Exact::new(IBig::from(denominator), 0));
        let end = |x: f64| Exact::from_f64(x).expect("finite").mul(&b);
        prop_assert!(end(interval.lo()) <= a && a <= end(interval.hi()));
        prop_assert!(interval.is_point() || interval.lo().next_up() == interval.hi());
    }

    /// A fraction is read as its value in lowest terms, which is written and read again.
    #[test]
    fn fractions_come_back(a in any::<i128>(), b in 1..=u128::MAX) {
        let number = read(&format!("{a}/{b}")).expect("a fraction");
        let (a, b) = (IBig::from(a), IBig::from(b));
        match &number {
            Number::Dyadic(x) => prop_assert_eq!(x.mul(&Exact::new(b, 0)), Exact::new(a, 0)),
            Number::Fraction { numerator, denominator } => {
                prop_assert_eq!(numerator * b, a * IBig::from(denominator.clone()));
                prop_assert!(numerator.gcd(denominator).is_one());
            }
        }
        prop_assert_eq!(read(&number.to_string()), Ok(number));
    }

    #[test]
    fn no_text_panics(text in ".{0,40}") {
        let _ = read(&text);
    }
}

#[test]
fn spellings_of_one_number_agree() {
    for text in ["0x1.8p-3", "0x1.80p-3", "0x3p-4", "0x0.3p+0", "3/16", "6/32"] {
        assert_eq!(read(text).expect(text).to_string(), "0x1.8p-3", "{text}");
    }
    assert_eq!(read("-0x0.0p0").expect("zero").to_string(), "0x0p0");
    assert_eq!(read("0x1p-1074").expect("the least").to_f64(), Some(f64::from_bits(1)));
    assert_eq!(read("0x1.fffffffffffffp1023").expect("the largest").to_f64(), Some(f64::MAX));
    assert_eq!(read("-42/85").expect("a fraction").to_string(), "-42/85");
}

#[test]
fn what_is_no_number_of_a_certificate_says_why() {
    let message = |text: &str| read(text).expect_err(text).to_string();
    assert_eq!(message("0x1.zp0"), "\"0x1.zp0\" is not a hexadecimal float such as \"0x1.8p-3\"");
    assert_eq!(message("0x1.8"), "\"0x1.8\" is not a hexadecimal float such as \"0x1.8p-3\"");
    assert_eq!(
        message("0.1"),
        "0.1 is a decimal, which binary64 rounds in silence: write the fraction that is meant (one tenth is \"1/10\"), or the binary64 number that is stored, here \"0x1.999999999999ap-4\""
    );
    assert_eq!(
        message("0x1.00000000000001p0"),
        "\"0x1.00000000000001p0\" is a hexadecimal float that binary64 does not have; the nearest below is \"0x1p0\""
    );
    for text in ["0x1p1024", "-0x1p1024", "0x1p999999", "1e400"] {
        assert!(matches!(read(text), Err(NumberError::Overflow { .. })), "{text}");
    }
    assert!(matches!(read("0x1p-1075"), Err(NumberError::NotBinary64 { .. })));
    assert!(matches!(read("1/0"), Err(NumberError::ZeroDenominator { .. })));
    for text in ["", "-", "NaN", "inf", "Infinity", "--1", "1/-2", "1/2/3", "+1", " 1", "0x", "0X1p0", "1_0", "\u{661}"]
    {
        assert!(
            matches!(
                read(text),
                Err(NumberError::NotANumber { .. } | NumberError::NotHexadecimal { .. } | NumberError::Decimal { .. })
            ),
            "{text}"
        );
    }
    assert!(matches!(read(&"1".repeat(LONGEST_NUMBER + 1)), Err(NumberError::TooLong { .. })));
}
