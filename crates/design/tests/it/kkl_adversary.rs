//! KKL candidates whose answers are known by construction, seeded: no wrong `Proved`, no wrong `Refuted`.
//!
//! Plants and maps are polynomials with small dyadic coefficients, so that B is computed exactly from
//! `B = Dphi f - Lambda phi` where y = x, and perturbed by a power of two. In a process of its own, one test at a time,
//! because a comparison in another thread takes the result of every exploration that runs meanwhile.

use std::any::{Any, TypeId};
use std::sync::{Mutex, MutexGuard, PoisonError};

use luenberger_design::kkl::{CouplingObjection, KklError, KklReport, KklSettings};
use luenberger_design::{KklCandidate, KklDesign, Region, SymbolicPolynomial};
use luenberger_observers::{KklMap, ObserverDimensions};
use luenberger_plants::{Dimensions, Plant, Shape};
use luenberger_proof::Verdict;
use luenberger_random::Random;
use nalgebra::{DMatrix, DVector, Dyn, RealField, convert, dmatrix};

static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A quarter of an integer from -8 to 8 that is not 0.
fn quarter(random: &mut Random) -> f64 {
    let magnitude = (1 + random.below(8)) as f64 / 4.0;
    if random.below(2) == 0 { magnitude } else { -magnitude }
}

/// A polynomial: coefficients and exponents.
#[derive(Clone, Debug, PartialEq)]
struct Terms(Vec<(f64, Vec<u32>)>);

impl Terms {
    fn at<T: RealField + Copy>(&self, x: &[T]) -> T {
        self.0.iter().fold(T::zero(), |sum, (coefficient, powers)| {
            let powers = powers.iter().zip(x);
            sum + powers.fold(convert(*coefficient), |product: T, (&power, &x)| {
                (0..power).fold(product, |product, _| product * x)
            })
        })
    }

    fn single(n: usize, k: usize, coefficient: f64) -> Self {
        Self(vec![(coefficient, (0..n).map(|i| u32::from(i == k)).collect())])
    }

    /// Up to three terms of degree two or less in each of the first `among` of n variables.
    fn random(random: &mut Random, n: usize, among: usize) -> Self {
        let count = random.below(3) + 1;
        Self(
            (0..count)
                .map(|_| {
                    let powers = (0..n).map(|k| if k < among { random.below(3) as u32 } else { 0 }).collect();
                    (quarter(random), powers)
                })
                .collect(),
        )
    }

    fn plus(mut self, other: &Self, factor: f64) -> Self {
        self.0.extend(other.0.iter().map(|(coefficient, powers)| (factor * coefficient, powers.clone())));
        self
    }

    fn times(&self, other: &Self) -> Self {
        Self(
            self.0
                .iter()
                .flat_map(|(x, p)| {
                    other.0.iter().map(move |(y, q)| (x * y, p.iter().zip(q).map(|(p, q)| p + q).collect()))
                })
                .collect(),
        )
    }

    fn partial(&self, k: usize) -> Self {
        Self(
            self.0
                .iter()
                .filter(|(_, powers)| powers[k] > 0)
                .map(|(coefficient, powers)| {
                    let mut lower = powers.clone();
                    lower[k] -= 1;
                    (coefficient * f64::from(powers[k]), lower)
                })
                .collect(),
        )
    }
}

/// `x' = f(x), y = h(x)`.
#[derive(Clone, Debug)]
struct System {
    f: Vec<Terms>,
    h: Vec<Terms>,
}

impl Shape for System {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: self.f.len(), inputs: 0, outputs: self.h.len() }
    }
}

impl<T: RealField + Copy> Plant<T> for System {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    fn derivative(&self, _t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        DVector::from_iterator(self.f.len(), self.f.iter().map(|f| f.at(x.as_slice())))
    }
    fn output(&self, _t: T, x: &DVector<T>, _u: &Self::Input) -> DVector<T> {
        DVector::from_iterator(self.h.len(), self.h.iter().map(|h| h.at(x.as_slice())))
    }
}

/// Where B is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Where {
    Here,
    /// In a thread of its own.
    Thread,
    /// Here, with a comparison `y1 > 0` in a thread of its own that adds `step` to the first entry.
    Compared,
    /// Once, over [`SymbolicPolynomial`]: the values are kept from one evaluation to the next.
    Kept,
}

static KEPT: Mutex<Option<Box<dyn Any + Send>>> = Mutex::new(None);

#[derive(Clone, Debug)]
struct Maps {
    lambda: DMatrix<f64>,
    /// Of xi and then y.
    b: Vec<Terms>,
    phi: Vec<Terms>,
    outputs: usize,
    states: usize,
    place: Where,
    step: f64,
}

impl<T: RealField + Copy> KklMap<T> for Maps {
    type Xi = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Estimate = Dyn;
    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: self.phi.len(), inputs: 0, outputs: self.outputs, estimate: self.states }
    }
    fn lambda(&self, _t: T, _u: &DVector<T>, _y: &DVector<T>) -> DMatrix<T> {
        self.lambda.map(convert)
    }
    fn injection(&self, _t: T, xi: &DVector<T>, _u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        let arguments: Vec<T> = xi.iter().chain(y.iter()).copied().collect();
        let all = || DVector::from_iterator(self.b.len(), self.b.iter().map(|b| b.at(&arguments)));
        match self.place {
            Where::Thread => std::thread::scope(|scope| scope.spawn(all).join()).unwrap(),
            Where::Compared => {
                let mut b = all();
                let above = std::thread::scope(|scope| scope.spawn(|| y[0] > T::zero()).join()).unwrap();
                if above {
                    b[0] += convert::<f64, T>(self.step);
                }
                b
            }
            Where::Kept if TypeId::of::<T>() == TypeId::of::<SymbolicPolynomial>() => {
                let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
                let kept = kept.get_or_insert_with(|| Box::new(all()));
                kept.downcast_ref::<DVector<T>>().unwrap().clone()
            }
            Where::Here | Where::Kept => all(),
        }
    }
    fn left_inverse(&self, _t: T, _xi: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        DVector::from_element(self.states, T::zero())
    }
    fn image(&self, _t: T, xhat: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        DVector::from_iterator(self.phi.len(), self.phi.iter().map(|phi| phi.at(xhat.as_slice())))
    }
}

fn region(n: usize) -> Region {
    Region::new(&vec![(-1.0, 1.0); n]).inputs(&[]).subdivisions(40)
}

fn settings(tolerance: f64) -> KklSettings {
    KklSettings { tolerance, samples: 24, ..KklSettings::default() }
}

fn report(plant: &System, maps: &Maps, tolerance: f64) -> Result<KklReport, KklError> {
    let all: Vec<usize> = (0..maps.states).collect();
    KklCandidate::new(plant, maps, &all)?.check(&region(maps.states), &settings(tolerance))
}

/// A diagonal Lambda, phi, f of random polynomials and h = x, with the B that solves (4) exactly.
fn solved(random: &mut Random, n: usize) -> (System, Maps) {
    let f: Vec<Terms> = (0..n).map(|_| Terms::random(random, n, n)).collect();
    let phi: Vec<Terms> = (0..n).map(|_| Terms::random(random, n, n)).collect();
    let lambda = DMatrix::from_fn(n, n, |i, j| if i == j { -1.0 - i as f64 } else { 0.0 });
    let b = phi.iter().enumerate().map(|(i, phi)| {
        let along = (0..n).fold(Terms(Vec::new()), |sum, k| sum.plus(&phi.partial(k).times(&f[k]), 1.0));
        let b = along.plus(phi, -lambda[(i, i)]);
        // Of y, which follows xi.
        Terms(b.0.into_iter().map(|(x, powers)| (x, [vec![0; n], powers].concat())).collect())
    });
    let maps = Maps { b: b.collect(), phi, lambda, outputs: n, states: n, place: Where::Here, step: 0.0 };
    (System { f, h: (0..n).map(|k| Terms::single(n, k, 1.0)).collect() }, maps)
}

/// A monomial times `2^-k` added to an entry of B is the residual, and its largest value on [-1, 1]^n is `2^-k`.
#[test]
fn residuals_known_by_construction() {
    let _alone = alone();
    let mut random = Random(1);
    let mut counts = [0; 3];
    for case in 0..60 {
        let n = 1 + case % 3;
        let (plant, mut maps) = solved(&mut random, n);
        maps.place = [Where::Here, Where::Here, Where::Thread][random.below(3)];
        let row = random.below(n);
        let truth = if random.below(4) == 0 { 0.0 } else { 0.5f64.powf(random.below(48) as f64) };
        let powers = [vec![0; n], (0..n).map(|_| random.below(3) as u32).collect()].concat();
        maps.b[row].0.push((truth, powers));
        let tolerance = KklSettings::default().tolerance;
        let found = report(&plant, &maps, tolerance).unwrap().residual;
        assert!(found.bounds[row] >= truth, "{truth:e} {found:?} {plant:?} {maps:?}");
        let allowed = tolerance * found.scales[row];
        match &found.verdict {
            Verdict::Proved { .. } => assert!(truth <= allowed, "{truth:e} {allowed:e} {maps:?}"),
            Verdict::Refuted { witness } => {
                assert!(
                    witness.row == row && truth > allowed && witness.at_least <= truth,
                    "{truth:e} {witness} {maps:?}"
                );
            }
            Verdict::Undecided { .. } => assert!(maps.place == Where::Thread, "{truth:e} {found:?} {maps:?}"),
        }
        counts[match found.verdict {
            Verdict::Proved { .. } => 0,
            Verdict::Refuted { .. } => 1,
            Verdict::Undecided { .. } => 2,
        }] += 1;
    }
    assert!(counts[0] > 10 && counts[1] > 10, "{counts:?}");
}

/// Candidates that nothing is known of but their images.
fn images(phi: Vec<Terms>, h: Vec<Terms>, n: usize) -> Verdict<luenberger_design::kkl::CommonImage> {
    let order = phi.len();
    let plant = System { f: (0..n).map(|k| Terms::single(n, k, -1.0)).collect(), h };
    let b = vec![Terms(Vec::new()); order];
    let lambda = -DMatrix::identity(order, order);
    let maps = Maps { b, phi, lambda, outputs: plant.h.len(), states: n, place: Where::Here, step: 0.0 };
    let found = report(&plant, &maps, 1.0).unwrap().injectivity;
    if let Verdict::Refuted { witness } = &found.verdict {
        // Checked by this file's own polynomials: images agree to rounding, the states differ.
        let second: Vec<f64> = witness.second.iter().map(|x| 0.5 * (x.lo() + x.hi())).collect();
        assert!(witness.second.iter().zip(&witness.first).any(|(second, first)| !second.contains(*first)));
        for row in maps.phi.iter().chain(&plant.h) {
            let (first, second) = (row.at(&witness.first), row.at(&second));
            assert!((first - second).abs() < 1e-11, "{witness:?} {first} {second}");
        }
        assert!(second.iter().all(|x| x.abs() <= 1.0));
    }
    found.verdict
}

/// `phi_k = c_k x_k + p(x_1 .. x_(k-1))` with c_k down to 2^-40 is injective; what depends on a coordinate by its
/// square only, or on fewer directions than there are states, is not.
#[test]
fn injectivity_known_by_construction() {
    let _alone = alone();
    let mut random = Random(2);
    let (mut proved, mut refuted) = (0, 0);
    for case in 0..60 {
        let n = 1 + case % 3;
        let small = 0.5f64.powf(random.below(41) as f64);
        let triangular: Vec<Terms> =
            (0..n).map(|k| Terms::random(&mut random, n, k).plus(&Terms::single(n, k, small), 1.0)).collect();
        let output = vec![Terms::random(&mut random, n, n)];
        let verdict = images(triangular, output, n);
        assert!(!verdict.is_refuted(), "{verdict:?}");
        proved += usize::from(verdict.is_proved());
        // Even in the last coordinate.
        let even = |random: &mut Random| {
            let square =
                |powers: &[u32]| powers.iter().enumerate().map(|(k, p)| if k + 1 == n { 2 * p } else { *p }).collect();
            Terms(Terms::random(random, n, n).0.iter().map(|(x, powers)| (*x, square(powers))).collect())
        };
        let (phi, h) = ((0..=n).map(|_| even(&mut random)).collect(), vec![even(&mut random)]);
        let verdict = images(phi, h, n);
        assert!(verdict.is_refuted(), "{verdict:?}");
        refuted += 1;
        // Linear, of rank n - 1: the last column is the sum of the others.
        let rows: Vec<Terms> = (0..n + 2)
            .map(|_| {
                let mut entries: Vec<f64> = (1..n).map(|_| quarter(&mut random)).collect();
                entries.push(entries.iter().sum());
                entries
                    .iter()
                    .enumerate()
                    .fold(Terms(Vec::new()), |sum, (k, x)| sum.plus(&Terms::single(n, k, *x), 1.0))
            })
            .collect();
        let verdict = images(rows[1..].to_vec(), rows[..1].to_vec(), n);
        assert!(verdict.is_refuted(), "{verdict:?} {rows:?}");
    }
    assert!(proved > 10 && refuted == 60, "{proved}");
}

/// `2^-27 x2` with y = x1 is injective: eight digits are no witness. With 2^-27 of `x2^2` it is not.
#[test]
fn eight_digits_are_no_witness() {
    let _alone = alone();
    let x1 = || vec![Terms::single(2, 0, 1.0)];
    assert!(images(vec![Terms::single(2, 1, 2f64.powi(-27))], x1(), 2).is_proved());
    // x1 + 2^-30 x2 beside x1: nearly one direction, and two.
    let nearly = Terms::single(2, 0, 1.0).plus(&Terms::single(2, 1, 2f64.powi(-30)), 1.0);
    assert!(!images(vec![nearly], x1(), 2).is_refuted());
    let tiny = Terms(vec![(2f64.powi(-27), vec![0, 2])]);
    assert!(images(vec![tiny], x1(), 2).is_refuted());
    // x^3 - x/4 takes 0 at 0 and at 1/2: square, no symmetry with one row, and solved for.
    let cubic = Terms(vec![(1.0, vec![3]), (-0.25, vec![1])]);
    assert!(images(vec![cubic.clone()], vec![cubic], 1).is_refuted());
}

/// B of random monomials in xi and y. It may read what is before its row, where Lambda has no way back.
#[test]
fn readings_known_by_construction() {
    let _alone = alone();
    let mut random = Random(3);
    let mut counts = [0; 3];
    for case in 0..80 {
        let n = 1 + case % 3;
        let (plant, mut maps) = solved(&mut random, n);
        if n > 1 && random.below(3) == 0 {
            // Lambda acts from the second entry on the first.
            maps.lambda[(0, 1)] = quarter(&mut random);
        }
        let mut reads = Vec::new();
        for row in 0..n {
            if random.below(2) == 0 {
                let entry = random.below(n);
                let power = 1 + random.below(2) as u32;
                let mut powers = vec![0; 2 * n];
                powers[entry] = power;
                let coefficient = quarter(&mut random);
                maps.b[row].0.push((coefficient, powers.clone()));
                if random.below(4) == 0 {
                    // It cancels.
                    maps.b[row].0.push((-coefficient, powers));
                } else {
                    reads.push((row, entry));
                }
            }
        }
        let coupling = report(&plant, &maps, 1.0).unwrap().coupling;
        let back = maps.lambda.nrows() > 1 && maps.lambda[(0, 1)] != 0.0;
        let itself = reads.iter().any(|(row, entry)| entry >= row);
        // Of the entries before it, the second reads the first: the only way back there is; or through the third, which
        // nothing leads back from.
        let allowed = !(itself || back && reads.contains(&(1, 0)));
        assert_eq!(coupling.verdict.is_refuted(), itself, "{coupling:?} {maps:?}");
        assert_eq!(coupling.verdict.is_proved(), allowed, "{coupling:?} {maps:?}");
        assert_eq!(coupling.objection.is_none(), allowed);
        counts[if itself {
            0
        } else if allowed {
            1
        } else {
            2
        }] += 1;
    }
    assert!(counts.iter().all(|count| *count > 2), "{counts:?}");
}

/// `x' = -x` with phi = x: Lambda = -1 and B = 2 xi is `xi' = +xi`, though (4) holds with the plant `x' = x`.
#[test]
fn an_unstable_observer_is_no_design() {
    let _alone = alone();
    let plant = System { f: vec![Terms::single(1, 0, 1.0)], h: vec![Terms::single(1, 0, 1.0)] };
    let b = vec![Terms::single(2, 0, 2.0)];
    let phi = vec![Terms::single(1, 0, 1.0)];
    let maps = Maps { lambda: dmatrix![-1.0], b, phi, outputs: 1, states: 1, place: Where::Here, step: 0.0 };
    let found = report(&plant, &maps, 1e-8).unwrap();
    assert!(found.residual.verdict.is_proved() && found.stability.is_proved() && found.injectivity.verdict.is_proved());
    assert!(!found.is_proved(), "{found}");
    let refused = KklDesign::new(&plant, maps.clone(), &[0], &region(1), &settings(1e-8));
    let Err(KklError::ReadsItself(witness)) = refused else { panic!("{refused:?}") };
    assert!(witness.row == 0 && witness.entry == 0 && witness.slope.contains(2.0) && witness.slope.width() < 1e-9);
    // An entry that is only integrated keeps its error, and hands it on.
    let two = System { f: vec![Terms(Vec::new()), Terms::single(2, 1, -1.0)], h: vec![Terms::single(2, 1, 1.0)] };
    let phi = vec![Terms::single(2, 0, 1.0), Terms::single(2, 1, 1.0)];
    let b = vec![Terms(Vec::new()), Terms::single(3, 0, 1.0)];
    let maps =
        Maps { lambda: dmatrix![0.0, 0.0; 0.0, -1.0], b, phi, outputs: 1, states: 2, place: Where::Here, step: 0.0 };
    let coupling = report(&two, &maps, 1.0).unwrap().coupling;
    assert!(
        !coupling.verdict.is_proved() && coupling.objection.unwrap().why == CouplingObjection::Integrated,
        "{coupling:?}"
    );
}

/// B = 1e-3 where 0 solves (4): whatever thread computes it, and whatever is kept, the bound of the residual is 1e-3.
#[test]
fn what_other_threads_and_evaluations_made_is_no_zero() {
    let _alone = alone();
    let plant = System { f: vec![Terms::single(1, 0, -1.0)], h: vec![Terms::single(1, 0, 1.0)] };
    let wrong = Terms(vec![(1e-3, vec![0, 0])]);
    let phi = vec![Terms::single(1, 0, 1.0)];
    for place in [Where::Here, Where::Thread, Where::Kept] {
        let maps = Maps {
            lambda: dmatrix![-1.0],
            b: vec![wrong.clone()],
            phi: phi.clone(),
            outputs: 1,
            states: 1,
            place,
            step: 0.0,
        };
        // The second time, what is kept is of another arena.
        for _ in 0..3 {
            let found = report(&plant, &maps, 0.01).unwrap().residual;
            assert!(found.bounds[0] >= 1e-3, "{place:?}: {found:?}");
        }
        let collected = report(&plant, &maps, 0.01).unwrap().residual.collected;
        assert_eq!(collected.is_ok(), place == Where::Here, "{place:?}: {collected:?}");
    }
    // A comparison in another thread: the answer steers, and no value of the arena shows it.
    let maps = Maps {
        lambda: dmatrix![-1.0],
        b: vec![Terms(Vec::new())],
        phi,
        outputs: 1,
        states: 1,
        place: Where::Compared,
        step: 1e-3,
    };
    match report(&plant, &maps, 0.01) {
        Ok(found) => assert!(found.residual.bounds[0] >= 1e-3 && found.residual.collected.is_err(), "{found}"),
        Err(error) => assert!(matches!(error, KklError::Undefined { .. }), "{error}"),
    }
}

/// `x' = f(x)` with phi = h = g(x), Lambda = -1.
#[derive(Clone, Copy, Debug)]
enum Curious {
    /// f = 1 - x, g = x, written with an exception at 0; B = 1.
    Exception,
    /// f = -x, g = x below 0 and x - 1/2 above: no two of these branches meet; B = 0 but at the jump.
    Jump,
    /// f = 1, g = (sin 4x, cos 4x), B = (4 y2 + y1, y2 - 4 y1): x and x + pi/2 have one image.
    Circle,
}

impl Curious {
    fn length(self) -> usize {
        if matches!(self, Self::Circle) { 2 } else { 1 }
    }

    fn g<T: RealField + Copy>(self, x: T) -> DVector<T> {
        let four: T = convert(4.0);
        match self {
            Self::Exception => DVector::from_element(1, if x == T::zero() { T::zero() } else { x }),
            Self::Jump => DVector::from_element(1, if x > T::zero() { x - convert(0.5) } else { x }),
            Self::Circle => DVector::from_vec(vec![(four * x).sin(), (four * x).cos()]),
        }
    }
}

impl Shape for Curious {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 1, inputs: 0, outputs: self.length() }
    }
}

impl<T: RealField + Copy> Plant<T> for Curious {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    fn derivative(&self, _t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        let slope = match self {
            Self::Exception => T::one() - x[0],
            Self::Jump => -x[0],
            Self::Circle => T::one(),
        };
        DVector::from_element(1, slope)
    }
    fn output(&self, _t: T, x: &DVector<T>, _u: &Self::Input) -> DVector<T> {
        self.g(x[0])
    }
}

impl<T: RealField + Copy> KklMap<T> for Curious {
    type Xi = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Estimate = Dyn;
    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: self.length(), inputs: 0, outputs: self.length(), estimate: 1 }
    }
    fn lambda(&self, _t: T, _u: &DVector<T>, _y: &DVector<T>) -> DMatrix<T> {
        -DMatrix::identity(self.length(), self.length())
    }
    fn injection(&self, _t: T, _xi: &DVector<T>, _u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        let four: T = convert(4.0);
        match self {
            Self::Exception => DVector::from_element(1, T::one()),
            Self::Jump => DVector::from_element(1, T::zero()),
            Self::Circle => DVector::from_vec(vec![four * y[1] + y[0], y[1] - four * y[0]]),
        }
    }
    fn left_inverse(&self, _t: T, xi: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        DVector::from_element(1, xi[0])
    }
    fn image(&self, _t: T, xhat: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        self.g(xhat[0])
    }
}

fn curious(plant: Curious) -> KklReport {
    KklCandidate::new(&plant, &plant, &[0]).unwrap().check(&region(1), &settings(1e-8)).unwrap()
}

/// The centre of the box is sampled, and there the branch for `x == 0` has another derivative than phi.
#[test]
fn a_branch_at_a_sample_refutes_nothing() {
    let _alone = alone();
    let found = curious(Curious::Exception);
    assert!(!found.residual.verdict.is_refuted(), "{found}");
    assert!(!found.injectivity.verdict.is_refuted());
}

#[test]
fn a_jump_is_not_proved_injective() {
    let _alone = alone();
    let found = curious(Curious::Jump).injectivity;
    // -1/4 and 1/4 have the image -1/4.
    assert!(!found.continuous && !found.verdict.is_proved(), "{found:?}");
}

/// An overdetermined Phi without a symmetry of signs: its common images are not verified, and are reported as what they
/// are.
#[test]
fn a_near_collision_is_undecided_and_has_its_numbers() {
    let _alone = alone();
    let found = curious(Curious::Circle);
    assert!(matches!(found.injectivity.verdict, Verdict::Undecided { .. }), "{found}");
    let pair = found.injectivity.near_collision.unwrap();
    assert!((pair.distance - std::f64::consts::FRAC_PI_2).abs() < 1e-6 && pair.gap < 1e-7, "{pair:?}");
    let refused = KklDesign::new(&Curious::Circle, Curious::Circle, &[0], &region(1), &settings(1e-8));
    assert!(matches!(refused, Err(KklError::Indistinct(_))), "{refused:?}");
}
