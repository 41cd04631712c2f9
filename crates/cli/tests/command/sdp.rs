//! `luenberger sdp` on programs whose optimum is known.

use crate::terminal::{folder, luenberger};

/// Minimise x subject to [[x, 1], [1, x]] >= 0: the optimum is 1.
const ONE: &str = "1\n1\n2\n1.0\n0 1 1 2 -1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n";
/// Minimise x subject to x >= 1 and -x >= 0, which nothing satisfies.
const NONE: &str = "1\n1\n-2\n1.0\n0 1 1 1 1.0\n1 1 1 1 1.0\n1 1 2 2 -1.0\n";

#[test]
fn bounds_enclose_the_optimum() {
    let folder = folder("sdp");
    let file = folder.join("one.dat-s");
    std::fs::write(&file, ONE).unwrap();
    let file = file.to_str().unwrap();
    let ran = luenberger(&["sdp", file, "--json"], "");
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
    let found = ran.json();
    assert_eq!(found["status"], "proved-optimal-bounds");
    let (lower, upper) = (found["lower"].as_f64().unwrap(), found["upper"].as_f64().unwrap());
    // The interior-point method stops at a relative gap of 1e-8 or better.
    assert!(lower <= 1.0 && 1.0 <= upper && upper - lower < 1e-6, "{lower} {upper}");
    let text = luenberger(&["sdp", file], "").stdout;
    assert!(text.starts_with("proved-optimal-bounds after ") && text.contains("<= optimum <="), "{text}");
}

#[test]
fn infeasibility_is_an_answer() {
    let folder = folder("sdp-infeasible");
    let file = folder.join("none.dat-s");
    std::fs::write(&file, NONE).unwrap();
    let ran = luenberger(&["sdp", file.to_str().unwrap(), "--json"], "");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert_eq!(ran.json()["status"], "proved-primal-infeasible");
}

#[test]
fn a_mistake_in_the_file_is_located() {
    let folder = folder("sdp-mistake");
    let file = folder.join("bad.dat-s");
    std::fs::write(&file, ONE.replace("0 1 1 2", "0 1 1 3")).unwrap();
    let file = file.to_str().unwrap();
    let ran = luenberger(&["sdp", file], "");
    assert_eq!(ran.code, Some(2));
    assert_eq!(ran.stderr, format!("error: {file}: line 5: the column is 3; it must be between 1 and 2\n"));
}
