//! Studies with conditions, lookup tables and derived parameters: values, certified designs, and mistakes.

use luenberger_design::Region;
use luenberger_design::enclosure::{EnclosureError, enclose};
use luenberger_expression::{
    ExpressionPlant, Extrapolation, Interpolation, LookupTable, Scope, Surface, Table, Tables,
};
use luenberger_study::Step;

use crate::studies::{executed, mistakes};

const MOTOR: &str = r#"
[plant]
f = ["w", "(torque(w) - friction*if(w > 0, w, 2*w) + current)/J"]
h = ["angle"]
states = ["angle", "w"]
inputs = ["current"]
parameters = { J = "m*r^2/2", m = 2.0, r = 0.1, friction = "0.05*J/J0", J0 = "m*0.1^2/2" }
[plant.tables.torque]
x = [-10, 0, 5, 10]
y = [0.2, 0.0, -0.1, -0.4]
method = "monotone-cubic"
extrapolation = "linear"
[simulation]
x0 = [1, -2]
duration = 5
[[observer]]
name = "lpv"
kind = "lpv"
decay_rate = 0.5
region = { states = [[-inf, inf], [-9, 9]] }
[[observer]]
name = "ekf"
kind = "extended-kalman"
w = 0.01
v = 0.01
period = 0.05
"#;

/// A kink and a table are certified with both of their sides, and run.
#[test]
fn a_motor_with_a_torque_curve() {
    let results = executed(MOTOR, Step::Run);
    assert_eq!(results.failures(), Vec::<String>::new());
    let parameter = |name: &str| results.plant.parameters.iter().find(|p| p.name == name).map(|p| p.value);
    assert_eq!((parameter("J"), parameter("friction")), (Some(0.010000000000000002), Some(0.05)));
    let lpv = results.observers[0].design.as_ref().unwrap();
    assert_eq!(lpv.verdict.word(), "proved");
    for row in &results.simulation.as_ref().unwrap().rows {
        let merits = row.merits.as_ref().unwrap_or_else(|| panic!("{row:?}"));
        for state in &merits.states {
            assert!(state.last.abs() < 0.05, "{}: {state:?}", row.observer);
        }
    }
}

fn plant(f: &str, tables: &[(&str, Interpolation)]) -> ExpressionPlant {
    let table = |interpolation| {
        LookupTable::from(Table::new(&[0.0, 1.0, 3.0], &[1.0, -3.0, 2.0], interpolation, Extrapolation::Hold).unwrap())
    };
    let tables: Tables = tables.iter().map(|(name, kind)| ((*name).to_owned(), table(*kind))).collect();
    ExpressionPlant::within(&[f], &["x1"], &Scope::plant(1, 0).tables(&tables).unwrap()).unwrap()
}

/// Over a box the Jacobian contains the slopes of all branches possible on it, and little more.
#[test]
fn kinks_are_enclosed_with_both_sides() {
    let slopes = |f: &str, region: (f64, f64)| {
        let tables = [("line", Interpolation::Linear), ("cubic", Interpolation::MonotoneCubic)];
        let found = enclose(&plant(f, &tables), &Region::new(&[region])).unwrap_or_else(|error| panic!("{f}: {error}"));
        (found.a[(0, 0)].lo(), found.a[(0, 0)].hi())
    };
    for (f, region, (low, high)) in [
        ("if(x1 > 1, 3*x1, x1^2 + 2)", (0.0, 2.0), (0.0, 3.0)),
        ("if(x1 > 1, 3*x1, x1^2 + 2)", (1.5, 2.0), (3.0, 3.0)),
        ("if(x1 < 0 || x1 > 1, 2*x1 - 2*max(0, min(x1, 1)), 0)", (-1.0, 2.0), (0.0, 2.0)),
        ("line(x1)", (0.25, 0.75), (-4.0, -4.0)),
        ("line(x1)", (0.5, 2.0), (-4.0, 2.5)),
        ("line(x1)", (-1.0, 9.0), (-4.0, 2.5)),
        // The slopes of scipy's PCHIP: -6.1667 at 0, 0 at 1.
        ("cubic(x1)", (0.0, 1.0), (-6.166_666_666_666_667, 0.0)),
    ] {
        let (found_low, found_high) = slopes(f, region);
        let room = 0.05 * (high - low) + 1e-9;
        assert!(found_low <= low + 1e-12 && found_low >= low - room, "{f}: {found_low}, expected {low}");
        assert!(found_high >= high - 1e-12 && found_high <= high + room, "{f}: {found_high}, expected {high}");
    }
}

/// A drag that grows with the speed and the density, through a table of two variables.
const DRAG: &str = r#"
[plant]
f = ["v", "-drag(v, rho)/2 + force", "-0.1*(rho - 1)"]
h = ["p", "rho"]
states = ["p", "v", "rho"]
inputs = ["force"]
[plant.tables.drag]
x = [0, 1, 3]
y = [0.5, 2]
z = [[0, 0], [0.5, 2], [4, 16]]
[simulation]
x0 = [0, 2, 1.5]
duration = 120
[[observer]]
name = "lpv"
kind = "lpv"
decay_rate = 0.05
region = { states = [[-inf, inf], [0, 3], [0.5, 2]] }
[[observer]]
name = "ekf"
kind = "extended-kalman"
w = 0.01
v = 0.01
period = 0.05
"#;

/// Designs, certificates and simulations of a plant with a table of two variables; its derivatives over a box are
/// those on it, by hand: by v from 0.5 (rho = 0.5, first piece) to 7 (rho = 2, second piece), and by rho from 0 to 8.
#[test]
fn a_table_of_two_variables_is_a_function_like_another() {
    let results = executed(DRAG, Step::Run);
    assert_eq!(results.failures(), Vec::<String>::new());
    assert_eq!(results.observers[0].design.as_ref().unwrap().verdict.word(), "proved");
    for row in &results.simulation.as_ref().unwrap().rows {
        let last: Vec<f64> = row.merits.as_ref().unwrap().states.iter().map(|state| state.last.abs()).collect();
        assert!(last.iter().all(|last| *last < 0.05), "{}: {last:?}", row.observer);
    }
    let z = [vec![0.0, 0.0], vec![0.5, 2.0], vec![4.0, 16.0]];
    let drag = Surface::new(&[0.0, 1.0, 3.0], &[0.5, 2.0], &z, Extrapolation::Hold).unwrap();
    let scope = Scope::plant(2, 0).tables(&Tables::from([("drag".to_owned(), drag.into())])).unwrap();
    let plant = ExpressionPlant::within(&["drag(x1, x2)", "-x2"], &["x1"], &scope).unwrap();
    let over = |v: (f64, f64), rho: (f64, f64)| enclose(&plant, &Region::new(&[v, rho])).unwrap();
    for (v, rho, by_v, by_rho) in [
        ((0.0, 3.0), (0.5, 2.0), (0.5, 7.0), (0.0, 8.0)),
        ((0.25, 0.75), (0.5, 2.0), (0.5, 2.0), (0.25, 0.75)),
        ((0.5, 2.0), (1.25, 1.25), (1.25, 4.375), (0.5, 4.5)),
    ] {
        let found = over(v, rho);
        for (entry, (low, high)) in [(found.a[(0, 0)], by_v), (found.a[(0, 1)], by_rho)] {
            let room = 0.1 * (high - low) + 1e-9;
            assert!(entry.lo() <= low + 1e-12 && entry.lo() >= low - room, "{v:?} {rho:?}: {entry:?}, {low} to {high}");
            assert!(
                entry.hi() >= high - 1e-12 && entry.hi() <= high + room,
                "{v:?} {rho:?}: {entry:?}, {low} to {high}"
            );
        }
    }
    for (old, new, line, column, message) in [
        ("[4, 16]]", "[4, 16], [5, 20]]", 10, 5, "x has 3 entries, and z has 4 rows"),
        ("[4, 16]]", "[4]]", 10, 24, "row 3 of `z` has length 1, row 1 has length 2"),
        ("z = [[0, 0], [0.5, 2], [4, 16]]", "z = [[0], [0.5], [4]]", 10, 6, "y has 2 entries, and row 1 of z has 1"),
        ("y = [0.5, 2]", "y = [2, 0.5]", 9, 5, "along y: x must increase: entry 2 is 0.5, after 2"),
        ("z = [[0, 0]", "method = \"monotone-cubic\"\nz = [[0, 0]", 10, 10, "a table of two variables is linear"),
        ("drag(v, rho)", "drag(v)", 3, 13, "`drag` is a lookup table and takes two arguments"),
    ] {
        let found = mistakes(&DRAG.replace(old, new));
        let first = found.iter().find(|found| found.message.starts_with(message));
        let first = first.unwrap_or_else(|| panic!("{new}: {found:?}"));
        assert_eq!((first.line, first.column), (line, column), "{new}: {first:?}");
    }
}

/// A jump has no certificate, whatever makes it, and the error says where it is and what a certificate needs.
#[test]
fn jumps_are_refused_by_name() {
    for (f, words) in [
        ("-x1 + if(x1 > 0.5, 0.01, 0)", "f jumps at"),
        ("-x1 + step(x1 - 0.5)", "f jumps at"),
        ("-x1 + sign(x1 - 0.5)", "f jumps"),
        ("if(x1 == 0.5, 1, -x1)", "f jumps at"),
    ] {
        let error = enclose(&plant(f, &[]), &Region::new(&[(0.0, 2.0)])).unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, EnclosureError::Undefined { .. }), "{f}: {text}");
        assert!(
            text.contains(words) && text.contains("certified designs need a continuous right-hand side"),
            "{f}: {text}"
        );
        assert!(text.contains("0.5"), "{f}: {text}");
        // Away from it there is none.
        assert!(enclose(&plant(f, &[]), &Region::new(&[(0.6, 2.0)])).is_ok(), "{f}");
    }
    let failure = executed(
        &MOTOR.replace("if(w > 0, w, 2*w)", "sign(w)").replace("[[observer]]\nname = \"ekf\"", "[[observer]]"),
        Step::Design,
    );
    let failure = failure.observers[0].failure.clone().unwrap_or_else(|| panic!("it fits"));
    assert!(failure.hypothesis.contains("f jumps"), "{}", failure.hypothesis);
}

#[test]
fn mistakes_have_their_place() {
    for (old, new, line, column, message) in [
        ("r = 0.1,", "r = \"J + 1\",", 7, 20, "the parameters depend on each other in a circle"),
        ("m*r^2/2", "m*q^2/2", 7, 23, "there is no `q`; known are"),
        ("m*r^2/2", "m*w^2/2", 7, 23, "there is no `w`; known are"),
        ("m*r^2/2", "m*t^2/2", 7, 23, "`t` may not be used here: a parameter is a number"),
        ("m*r^2/2", "m/(r - 0.1)", 7, 20, "the parameter `J`: `m/(r - 0.1)` is infinite"),
        ("m = 2.0", "m = true", 7, 35, "the parameter `m` is true"),
        ("[-10, 0, 5, 10]", "[-10, 0, 0, 10]", 9, 5, "x must increase: entry 3 is 0, after 0"),
        ("[-10, 0, 5, 10]", "[-10, 0, 5]", 10, 5, "x has 3 entries, and y has 4"),
        ("monotone-cubic", "cubic", 11, 10, "`method` is the text \"cubic\""),
        ("extrapolation =", "extrapolate =", 12, 1, "`extrapolate` is not a key of [plant.tables.NAME]"),
        ("[plant.tables.torque]", "[plant.tables.sin]", 8, 15, "`sin` cannot be the name of a lookup table"),
        ("torque(w)", "torqe(w)", 3, 13, "there is no function `torqe`; did you mean `torque`?"),
        ("if(w > 0, w, 2*w)", "if(w, w, 2*w)", 3, 37, "`w` is a number and not a condition"),
    ] {
        let found = mistakes(&MOTOR.replace(old, new));
        let first = found.iter().find(|found| found.message.starts_with(message));
        let first = first.unwrap_or_else(|| panic!("{new}: {found:?}"));
        assert_eq!((first.line, first.column), (line, column), "{new}: {first:?}");
    }
}
