//! The Lyapunov matrix for which a stored cubic gain has the structure of the theorem exactly.

use luenberger_proof::internals::structured_for;
use luenberger_proof::{Exact, Matrix};
use proptest::prelude::*;

proptest! {
    /// `P~ N = C'X C N` also for an N far from any design: the identity holds for arbitrary P, C and N.
    #[test]
    fn the_repaired_matrix_has_the_structure_for_any_gain(
        (n, outputs, entries) in (1..=5_usize).prop_flat_map(|n| (Just(n), 1..=n)).prop_flat_map(|(n, p)| {
            (Just(n), Just(p), prop::collection::vec(-1.0..1.0_f64, 80))
        }),
    ) {
        let p = Matrix::from_fn(n, n, |i, j| entries[i.max(j) * 5 + i.min(j)]);
        let c = Matrix::from_fn(outputs, n, |i, j| entries[25 + i * 5 + j]);
        let x = Matrix::from_fn(outputs, outputs, |i, j| entries[50 - i.max(j) * 5 - i.min(j)]);
        let gain = Matrix::from_fn(n, outputs, |i, j| entries[51 + i * 5 + j] + if i == j { 3.0 } else { 0.0 });
        let repaired = structured_for(&p, &c, &x, &gain).expect("shapes agree").expect("the gain has full column rank");
        let image = repaired.product(&Matrix::embed(&gain, "N").expect("finite")).expect("shapes agree");
        let c = Matrix::<Exact>::embed(&c, "C").expect("finite");
        let x = Matrix::<Exact>::embed(&x, "X").expect("finite");
        let gain = Matrix::<Exact>::embed(&gain, "N").expect("finite");
        let seen = c.product(&gain).and_then(|cn| x.product(&cn)).and_then(|xcn| c.transpose().product(&xcn)).expect("shapes agree");
        for (enclosed, exact) in image.as_slice().iter().zip(seen.as_slice()) {
            let value = exact.enclosure();
            prop_assert!(enclosed.lo() <= value.lo() && value.hi() <= enclosed.hi(), "{enclosed:?} {value:?}");
            prop_assert!(enclosed.width() < 1e-10);
        }
    }
}
