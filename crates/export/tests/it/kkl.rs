//! Random numerical KKL observers of every size and form, as C and as Rust.

use luenberger_export::kkl::{Interpolated, Inverse, Kkl, KklExportError, LowRank};
use luenberger_export::{ExportableObserver, Scalar, golden};
use luenberger_expression::ExpressionPlant;
use luenberger_observers::numerical_kkl::held_inputs::InverseOnHeap;
use luenberger_observers::numerical_kkl::held_trees::TreesOnHeap;
use luenberger_observers::numerical_kkl::polynomial_tree::monomial_count;
use luenberger_observers::numerical_kkl::{
    Branch, Coordinates, HeldInputTables, Node, PolynomialInverse, PolynomialTree, SampledFilter, Search, TensorSpline,
    TensorTrain,
};
use luenberger_plants::Shape;
use luenberger_random::Random;
use nalgebra::{SMatrix, SVector};

use crate::compiled::{self, SANITISERS, can_sanitise, compilers, is_complete};
use crate::fuzz::{compare, export, plant, write};

/// Steps that are compared: most of them search from all starts.
const STEPS: usize = 150;

/// A tree of three comparisons with polynomials of degree two in `I` variables.
fn tree<const I: usize, const O: usize>(random: &mut Random) -> PolynomialTree<f64, Vec<Node<f64>>, Vec<f64>, I, O> {
    let mut nodes = Vec::new();
    let branches =
        [(Branch::Node(1), Branch::Node(2)), (Branch::Leaf(0), Branch::Leaf(1)), (Branch::Leaf(2), Branch::Leaf(3))];
    // Every second tree is one polynomial.
    let count = if random.below(2) == 0 { 1 } else { 4 };
    if count == 4 {
        for (below, above) in branches {
            nodes.push(Node { axis: random.below(I) as u16, threshold: 0.3 * random.unit(), below, above });
        }
    }
    let mut leaves = Vec::new();
    for _ in 0..count {
        leaves.extend((0..I).map(|_| 0.2 * random.unit()));
        leaves.extend((0..I).map(|_| 1.0 + 0.5 * random.unit()));
        leaves.extend([-1.5; O]);
        leaves.extend([1.25; O]);
        leaves.extend((0..O * monomial_count(I, 2)).map(|_| 0.4 * random.unit()));
    }
    PolynomialTree::new(2, nodes, leaves).unwrap()
}

fn filter<const Z: usize>(random: &mut Random) -> SampledFilter<f64, 1, Z> {
    let d = SMatrix::from_fn(|i, j| 0.2 * random.unit() - if i == j { 1.0 } else { 0.0 });
    let (b, substeps) = (SMatrix::from_fn(|_, _| 0.4 * random.unit()), 1 + random.below(2));
    SampledFilter { d, b, period: 0.05, substeps }
}

fn coordinates<const Z: usize>(random: &mut Random) -> Coordinates<f64, Z> {
    let mean = SVector::from_fn(|_, _| 0.1 * random.unit());
    let square = |random: &mut Random| SMatrix::from_fn(|_, _| 2.0 * random.unit());
    Coordinates::new(mean, square(random), square(random)).unwrap()
}

fn bounds<const N: usize>() -> (SVector<f64, N>, SVector<f64, N>) {
    (SVector::repeat(-1.25), SVector::repeat(1.0))
}

fn inverse<const N: usize, const Z: usize>(random: &mut Random) -> Inverse<f64, N, Z> {
    let coordinates = coordinates(random);
    PolynomialInverse::new(coordinates, bounds(), tree(random), tree(random)).unwrap()
}

fn table<const N: usize, const Z: usize>(random: &mut Random, points: [usize; N]) -> TensorSpline<f64, Vec<f64>, N, Z> {
    let count = points.iter().map(|count| count + 2).product::<usize>() * Z;
    let coefficients = (0..count).map(|_| random.unit()).collect();
    let (lower, upper) = bounds();
    TensorSpline::new(lower, upper, points, coefficients).unwrap()
}

fn search(random: &mut Random) -> Search<f64> {
    Search { max_evaluations: 1 + random.below(8), tolerance: 0.1, fallback: random.below(3) }
}

/// The interpolated form of a left inverse: a table that does not belong to the tree, so that searches end at faces of
/// the box, at local minima and at the coarse grid.
fn interpolated<const N: usize, const Z: usize>(random: &mut Random) -> Interpolated<f64, N, Z> {
    let points = std::array::from_fn(|_| 2 + random.below(if N > 3 { 2 } else { 4 }));
    Interpolated::new(table(random, points), inverse(random), search(random)).unwrap()
}

/// The same with a table of low rank, its ranks at random.
fn low_rank<const N: usize, const Z: usize>(random: &mut Random) -> LowRank<f64, N, Z> {
    let points: [usize; N] = std::array::from_fn(|_| 2 + random.below(4));
    let ranks: [usize; N] = std::array::from_fn(|axis| if axis == 0 { Z } else { 1 + random.below(5) });
    let size = |axis: usize| (points[axis] + 2) * ranks[axis] * ranks.get(axis + 1).unwrap_or(&1);
    let coefficients = (0..(0..N).map(size).sum()).map(|_| random.unit()).collect();
    let (lower, upper) = bounds();
    let train = TensorTrain::new(lower, upper, points, ranks, coefficients).unwrap();
    LowRank::new(train, inverse(random), search(random)).unwrap()
}

/// A numerical KKL observer of a plant without inputs.
pub(crate) fn plain(random: &mut Random) -> Kkl<f64> {
    let (form, size) = (random.below(2), random.below(2));
    of_plain(random, (2 + size, form))
}

fn of_plain(random: &mut Random, (states, form): (usize, usize)) -> Kkl<f64> {
    let plant = plant(random, (states, 0, 1));
    of_plant(random, &plant, form)
}

/// The embedded form (0) or the interpolated one, for a plant without inputs.
pub(crate) fn of_plant(random: &mut Random, plant: &ExpressionPlant, form: usize) -> Kkl<f64> {
    match (plant.dimensions().states, form) {
        (2, 0) => Kkl::new(plant, filter(random), inverse::<2, 3>(random)),
        (2, _) => Kkl::new(plant, filter(random), interpolated::<2, 3>(random)),
        (3, 0) => Kkl::new(plant, filter(random), inverse::<3, 4>(random)),
        (3, _) => Kkl::new(plant, filter(random), interpolated::<3, 4>(random)),
        (4, 0) => Kkl::new(plant, filter(random), inverse::<4, 5>(random)),
        (4, _) => Kkl::new(plant, filter(random), interpolated::<4, 5>(random)),
        (5, 0) => Kkl::new(plant, filter(random), inverse::<5, 6>(random)),
        (5, _) => Kkl::new(plant, filter(random), low_rank::<5, 6>(random)),
        (_, 0) => Kkl::new(plant, filter(random), inverse::<6, 7>(random)),
        _ => Kkl::new(plant, filter(random), low_rank::<6, 7>(random)),
    }
    .unwrap()
}

/// The values of M inputs with a table: golden inputs are between -0.1 and 0.1, inside and outside.
fn nodes<const M: usize>(random: &mut Random, count: usize) -> Vec<f64> {
    (0..M)
        .flat_map(|_| (0..count).map(|k| 0.03 * k as f64 - 0.05).collect::<Vec<_>>())
        .map(|u| u + 0.01 * random.unit())
        .collect()
}

fn trees<const N: usize, const M: usize, const Z: usize, const ZM: usize, const NM: usize>(
    random: &mut Random,
) -> TreesOnHeap<f64, N, M, Z, ZM, NM> {
    let family = (SVector::repeat(-0.05), SVector::from_fn(|_, _| 0.05 + 0.02 * random.unit()));
    let coordinates = coordinates(random);
    TreesOnHeap::new(coordinates, bounds(), family, (tree(random), tree(random))).unwrap()
}

fn tables<const N: usize, const M: usize, const Z: usize, const ZM: usize>(
    random: &mut Random,
) -> InverseOnHeap<f64, N, M, Z, ZM> {
    let (count, points) = (2 + random.below(2), std::array::from_fn(|_| 2 + random.below(2)));
    let nodes = nodes::<M>(random, count);
    let splines = (0..count.pow(M as u32)).map(|_| table(random, points)).collect();
    let tables = HeldInputTables::new(coordinates(random), nodes, splines).unwrap();
    InverseOnHeap::new(tables, tree(random), Some(search(random))).unwrap()
}

/// A numerical KKL observer for N states and M held inputs, with trees alone or with tables.
pub(crate) fn held(random: &mut Random, (n, m): (usize, usize), is_tree: bool) -> Kkl<f64> {
    let plant = plant(random, (n, m, 1));
    let first = 0.02;
    match (n, m, is_tree) {
        (2, 1, true) => {
            Kkl::held::<_, 2, 1, 3, 5>(&plant, filter(random), trees::<2, 1, 3, 4, 3>(random), [first].into())
        }
        (2, 1, _) => Kkl::held::<_, 2, 1, 3, 5>(&plant, filter(random), tables::<2, 1, 3, 4>(random), [first].into()),
        (2, _, true) => {
            Kkl::held::<_, 2, 2, 3, 5>(&plant, filter(random), trees::<2, 2, 3, 5, 4>(random), [first, -1.0].into())
        }
        (2, _, _) => {
            Kkl::held::<_, 2, 2, 3, 5>(&plant, filter(random), tables::<2, 2, 3, 5>(random), [first, 1.0].into())
        }
        (_, 1, true) => {
            Kkl::held::<_, 3, 1, 4, 7>(&plant, filter(random), trees::<3, 1, 4, 5, 4>(random), [first].into())
        }
        (_, 1, _) => Kkl::held::<_, 3, 1, 4, 7>(&plant, filter(random), tables::<3, 1, 4, 5>(random), [first].into()),
        (_, _, true) => {
            Kkl::held::<_, 3, 2, 4, 7>(&plant, filter(random), trees::<3, 2, 4, 6, 5>(random), [first, 0.0].into())
        }
        _ => Kkl::held::<_, 3, 2, 4, 7>(&plant, filter(random), tables::<3, 2, 4, 6>(random), [first, 0.0].into()),
    }
    .unwrap()
}

/// Every size and form that is offered.
fn all(random: &mut Random) -> Vec<Kkl<f64>> {
    let mut all = Vec::new();
    for n in 2..=6 {
        all.extend((0..2).map(|form| of_plain(random, (n, form))));
    }
    for (n, m) in [(2, 1), (2, 2), (3, 1), (3, 2)] {
        all.extend([true, false].map(|is_tree| held(random, (n, m), is_tree)));
    }
    all
}

#[test]
fn every_size_and_form_agrees_with_the_design_bit_by_bit() {
    let compilers = compilers();
    let Some(first) = compilers.first() else {
        eprintln!("SKIPPED: no C compiler");
        return;
    };
    let folder = compiled::folder("kkl");
    let mut random = Random(2020);
    let (mut exports, mut runs) = (Vec::new(), Vec::new());
    for (k, observer) in all(&mut random).into_iter().enumerate() {
        let scalar = if (k / 2 + k) % 2 == 0 { Scalar::Binary32 } else { Scalar::Binary64 };
        let export = export(&format!("p{}", exports.len()), ExportableObserver::Kkl(observer), scalar);
        runs.push(golden::steps(&export, STEPS).unwrap_or_else(|error| panic!("{k}: {error}")));
        exports.push(export);
    }
    assert_eq!(exports.len(), 18);
    write(&folder, &exports, &runs);
    for compiler in &compilers {
        compare(&folder, &exports, &runs, compiler, &[compiled::optimisation()]);
    }
    if is_complete() && can_sanitise(first) {
        compare(&folder, &exports, &runs, first, &SANITISERS);
    }
}

/// The header says what the constants take, and the step how it is called.
#[test]
fn the_header_states_the_sizes() {
    let mut random = Random(7);
    let observer = held(&mut random, (3, 2), false);
    let export = export("plant", ExportableObserver::Kkl(observer), Scalar::Binary32);
    let files = export.c().unwrap();
    let header = &files.iter().find(|file| file.name == "plant.h").unwrap().text;
    let line = header.lines().find(|line| line.contains("Constants:")).unwrap();
    let source = &files.iter().find(|file| file.name == "plant.c").unwrap().text;
    let of = |name: &str| {
        let start = source.split(&format!("static const float {name}[")).nth(1).unwrap();
        start.split(']').next().unwrap().parse::<usize>().unwrap()
    };
    let (leaves, table) = (of("INVERSE_LEAVES"), of("TABLE"));
    assert!(line.contains(&format!("combination of inputs, {table} numbers ({} bytes).", 4 * table)), "{line}");
    assert!(line.contains("trees of the left inverse, ") && table > leaves, "{line}");
    assert!(header.contains("#define PLANT_INPUTS 2") && header.contains("float z[4]; /**< Target states. */"));
}

#[test]
fn a_table_that_is_too_large_is_refused_with_its_bytes() {
    let mut random = Random(9);
    let plain_plant = plant(&mut random, (4, 0, 1));
    let inverse = Interpolated::new(table::<4, 5>(&mut random, [17; 4]), inverse(&mut random), search(&mut random));
    let refused = Kkl::new(&plain_plant, filter(&mut random), inverse.unwrap()).unwrap_err();
    // (17 + 2)^4 coefficients of five numbers.
    assert_eq!(refused, KklExportError::Large { numbers: 651_605, tables: 1 });
    assert!(refused.to_string().contains("651605 numbers, 2606420 bytes in f32 and 5212840 in f64"), "{refused}");

    let forced = plant(&mut random, (2, 1, 1));
    let nodes = (0..9).map(f64::from).collect();
    let splines = (0..9).map(|_| table::<2, 3>(&mut random, [99; 2])).collect();
    let tables = HeldInputTables::new(coordinates::<3>(&mut random), nodes, splines).unwrap();
    let inverse = InverseOnHeap::new(tables, tree::<4, 2>(&mut random), Some(search(&mut random))).unwrap();
    let refused = Kkl::held::<_, 2, 1, 3, 5>(&forced, filter(&mut random), inverse, [0.0].into()).unwrap_err();
    assert!(refused.to_string().contains("for 9 combinations of inputs has 275427 numbers"), "{refused}");
    assert!(refused.to_string().contains("fewer `points` or `nodes`"), "{refused}");
}
