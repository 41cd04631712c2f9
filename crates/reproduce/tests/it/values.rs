//! Printed values: their digits, their shapes, and what they are compared with.

use luenberger_reproduce::evidence::{JudgeError, judge};
use luenberger_reproduce::value::PrintedError;
use luenberger_reproduce::{Evidence, Printed, Tolerance, Value};
use nalgebra::DMatrix;

#[test]
fn half_a_unit_of_the_last_digit_is_read_off_the_text() {
    for (text, number, half_unit) in [
        ("1.18", 1.18, 0.005),
        ("-.0014", -0.0014, 0.00005),
        ("500", 500.0, 0.5),
        ("1.0", 1.0, 0.05),
        ("2.5e3", 2500.0, 50.0),
    ] {
        let judged = judge(&Printed::Decimals(text), Tolerance::AsPrinted, &Evidence::value(number)).unwrap();
        assert_eq!(
            (judged.printed, judged.tolerance),
            (Value::Number(number), Some(Value::Number(half_unit))),
            "{text}"
        );
    }
}

#[test]
fn what_is_no_decimal_is_refused_by_name() {
    for bad in [".", "-", "1.2.3", "8.49.67", "inf", "NaN", "1,5", "x"] {
        assert_eq!(Printed::Decimals(bad).value(), Err(PrintedError::NotDecimal { entry: bad.to_owned() }));
    }
    assert_eq!(
        Printed::Decimals("1 2; 3 8.49.67").value(),
        Err(PrintedError::NotDecimal { entry: "8.49.67".to_owned() })
    );
    assert_eq!(Printed::Decimals("1 2; 3").value(), Err(PrintedError::Ragged { row: 2, expected: 2, found: 1 }));
    for empty in ["", " ", "1 2;"] {
        assert_eq!(Printed::Decimals(empty).value(), Err(PrintedError::Empty), "{empty:?}");
    }
}

#[test]
fn shapes_follow_the_separators() {
    let value = |text| Printed::Decimals(text).value().unwrap();
    assert_eq!(value("7.5"), Value::Number(7.5));
    assert_eq!(value("0.48 1.18"), Value::Vector(vec![0.48, 1.18]));
    assert_eq!(value("7.5; 3.1"), Value::Matrix(vec![vec![7.5], vec![3.1]]));
    assert_eq!(value("1 2; 3 4"), Value::Matrix(vec![vec![1.0, 2.0], vec![3.0, 4.0]]));
}

#[test]
fn matrices_are_nested_row_by_row_and_lose_no_digit() {
    let m = DMatrix::from_row_slice(2, 3, &[1.0, 0.1 + 0.2, 3.0, 4.0, 5.0, f64::NAN]);
    assert_eq!(serde_json::to_string(&Value::from(&m)).unwrap(), "[[1.0,0.30000000000000004,3.0],[4.0,5.0,null]]");
    assert_eq!(serde_json::to_string(&Value::from(true)).unwrap(), "true");
}

#[test]
fn a_vector_may_stand_for_a_row_or_a_column_but_not_for_a_truth() {
    let comparable = |printed: &Value, computed: &Value| match judge(
        &Printed::Exactly(printed.clone()),
        Tolerance::AsPrinted,
        &Evidence::value(computed.clone()),
    ) {
        Ok(_) => true,
        Err(JudgeError::Incomparable { .. }) => false,
        Err(other) => panic!("{other}"),
    };
    let vector = Value::from([1.0, 2.0]);
    let (row, column) = (Value::Matrix(vec![vec![1.0, 2.0]]), Value::Matrix(vec![vec![1.0], vec![2.0]]));
    assert!(comparable(&vector, &row) && comparable(&vector, &column));
    assert!(!comparable(&row, &column));
    assert!(!comparable(&Value::Truth(true), &Value::Number(1.0)));
    assert!(!comparable(&Value::Truth(true), &Value::Vector(vec![])));
}
