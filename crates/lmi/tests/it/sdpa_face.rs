//! Constraints that confine the dual matrix to a face of the cone.

use luenberger_lmi::internals::confines_dual;
use luenberger_lmi::sdpa::read;

#[test]
fn a_square_with_zero_on_the_right_confines_and_others_do_not() {
    // tr(F Y) = c for F = [1 1; 1 1], [1 2; 2 1], [0 1; 1 0], I, and -[1 1; 1 1].
    for (entries, cost, confines) in [
        ("1 1 1 1 1\n1 1 1 2 1\n1 1 2 2 1\n", "0", true),
        ("1 1 1 1 -1\n1 1 1 2 -1\n1 1 2 2 -1\n", "0.0", true),
        ("1 1 1 1 1\n1 1 1 2 1\n1 1 2 2 1\n", "1e-3", false),
        ("1 1 1 1 1\n1 1 1 2 2\n1 1 2 2 1\n", "0", false),
        ("1 1 1 2 1\n", "0", false),
        ("1 1 1 1 1\n1 1 2 2 -1\n", "0", false),
    ] {
        let program = read(format!("1\n1\n2\n{cost}\n{entries}").as_bytes()).unwrap();
        assert_eq!(confines_dual(&program), confines, "{entries}{cost}");
    }
}
