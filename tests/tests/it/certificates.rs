//! From design to file to checker: the theorems of the cubic paper and every other design with a certificate, and the
//! rejection of modified files.

use luenberger_design::lipschitz::{LipschitzPlant, Sector};
use luenberger_design::mean_value::{ContractingCoordinates, MeanValueDesign};
use luenberger_design::robust::{PolytopicDesign, certify_gain, fixed_gain_margin, theorem5_bound};
use luenberger_design::{
    Certified, CubicDesign, CubicGain, FeedbackDesign, LinearDesign, LipschitzDesign, LpvDesign, Region,
    SampledCubicDesign, Theorem1, cubic_lmi_design, deployed_linear, theta_from_importance,
};
use luenberger_linalg::{lambda_min, lqr, lyapunov, stein};
use luenberger_lmi::{Problem, dynamic_matrix, he};
use luenberger_plants::{StateSpace, double_integrator, flexible_joint, third_order};
use luenberger_proof::certificate::Region::{Everywhere, Within};
use luenberger_proof::certificate::{
    CertificateFile, Claim, ClaimedBall, Equation, Number, Proved, Rejection, StructuredCubicConvergence, Theorem,
    digest, verify,
};
use luenberger_proof::statement::{Format, Operation, Step};
use luenberger_proof::wording::exact;
use luenberger_proof::{Interval, Matrix, Verdict};
use luenberger_tests::solution_certificate;
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;

use crate::examples::example_1;
use crate::generators::{accretive, linear, matrix, stabilisable_plant};

/// Written, read, compared, checked.
fn goes_the_whole_way<E: std::fmt::Debug>(file: Result<CertificateFile, E>) -> Proved {
    let file = file.unwrap();
    let text = file.to_json();
    let read = CertificateFile::read(text.as_bytes()).unwrap();
    assert_eq!((read.theorem(), read.claims()), (file.theorem(), file.claims()));
    let proved = verify(text.as_bytes()).unwrap_or_else(|why| panic!("{why}\n{text}"));
    for (fact, claim) in proved.facts.iter().zip(file.claims()) {
        // The file leaves a millionth of what is proved.
        let (margin, claimed) = (fact.verdict.margin().unwrap(), claim.margin.to_f64().unwrap());
        assert!((margin * (1.0 - 1.0 / 524_288.0)..=margin).contains(&claimed), "{claimed}: {fact}");
    }
    proved
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]

    /// Theorems 1 and 2: the linear observer, the cubic one for any admissible S, and both with the margins that the
    /// design has.
    #[test]
    fn theorems_1_and_2_go_into_files(plant in stabilisable_plant(1..=6), d in matrix(6, 6), k in matrix(6, 6)) {
        let p = plant.c.nrows();
        let linear = linear(&plant, 1.0);
        let proved = goes_the_whole_way(linear.certificate_file("Theorem 1"));
        for (fact, own) in proved.facts.iter().zip(linear.certificate.facts()) {
            prop_assert_eq!(fact.verdict.margin(), own.verdict.margin());
        }
        let cubic = CubicDesign::new(&linear, &DMatrix::identity(p, p), &CubicGain::General(accretive(p, &d, &k))).unwrap();
        let proved = goes_the_whole_way(cubic.certificate_file("Theorem 2"));
        let everywhere = proved.statement.contains("With the gains L and N exactly as stored, e tends to 0 exponentially, from every e(0).");
        prop_assert_eq!(everywhere, cubic.certificate.converges_from_everywhere());
    }

    /// The joint design, with a rate.
    #[test]
    fn the_joint_design_goes_into_a_file(plant in stabilisable_plant(1..=5), rate in 0.1..1.0) {
        let p = plant.c.nrows();
        let design = cubic_lmi_design(&plant, &DMatrix::identity(p, p), rate, 1.0).unwrap();
        let proved = goes_the_whole_way(design.certificate_file("the joint design"));
        let said = format!("V(t) <= exp(-2 rate t) V(0) with rate = {}, so that", exact(rate));
        prop_assert!(proved.statement.contains(&said), "{}", proved.statement);
    }

    /// Theorem 4: one gain for a polytope, feasible by construction (see `theorems_cubic.rs`). Theorem 5: (23) as a
    /// polytope of two.
    #[test]
    fn theorems_4_and_5_go_into_files(plant in stabilisable_plant(2..=5), spread in matrix(5, 5)) {
        let n = plant.a.nrows();
        let nominal = linear(&plant, 1.0);
        let direction = spread.view((0, 0), (n, n)) + DMatrix::identity(n, n) * 0.01;
        let step = &direction * (0.2 / (nominal.p.norm() * direction.norm()));
        let design = PolytopicDesign::new(&plant, &[&plant.a - &step, &plant.a + &step], 0.0).unwrap();
        prop_assert_eq!(goes_the_whole_way(design.certificate_file("Theorem 4")).facts.len(), 4);
        // A + eps I with eps below (23), the same L and P: the design for the shifted plant keeps them.
        let eps = 0.99 * theorem5_bound(&nominal.p, &nominal.q).unwrap();
        let shifted = StateSpace::new(&plant.a + DMatrix::identity(n, n) * eps, plant.b.clone(), plant.c.clone()).unwrap();
        let shifted = LinearDesign::with_gain(&shifted, nominal.l()).unwrap();
        goes_the_whole_way(shifted.certificate_file("Theorem 5"));
    }

    /// Theorem 6 and Corollary 1.
    #[test]
    fn theorem_6_goes_into_a_file(plant in stabilisable_plant(1..=6)) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let k = lqr(&plant.a, &plant.b, &DMatrix::identity(n, n), &DMatrix::identity(n, n)).unwrap().k;
        let observer = CubicDesign::new(&linear(&plant, 1.0), &DMatrix::identity(p, p), &CubicGain::Gamma(1.0)).unwrap();
        let feedback = FeedbackDesign::cubic(&observer, &k).unwrap();
        let proved = goes_the_whole_way(feedback.certificate_file("Theorem 6"));
        prop_assert_eq!(proved.facts.len(), 7);
        prop_assert_eq!(proved.facts[6].verdict.margin(), feedback.certificate.facts().last().unwrap().verdict.margin());
    }

    #[test]
    fn the_sampled_observer_goes_into_a_file(plant in stabilisable_plant(1..=6), period in 1e-3..0.3, w in 0.1..100.0) {
        let p = plant.c.nrows();
        let design = SampledCubicDesign::new(&linear(&plant, 1.0), &DMatrix::identity(p, p), w, period).unwrap();
        goes_the_whole_way(design.certificate_file("sampled"));
        goes_the_whole_way(design.linear_certificate_file("sampled, linear"));
    }

    /// Answers of `lmi`: the same inequality at a rate that is possible and at one that is not.
    #[test]
    fn solved_and_refuted_inequalities_go_into_files(a in matrix(3, 3)) {
        let stable = &a - DMatrix::identity(3, 3) * (a.norm() + 0.1);
        for (a, name) in [(&stable, "matrix-inequality-holds"), (&-&stable, "matrix-inequality-refuted")] {
            let mut lmi = Problem::new();
            let p = lmi.symmetric("P", 3);
            lmi.constrain("P > 0", &p >> 0.0);
            lmi.constrain("decrease", he(&p * a) << 0.0);
            let solution = lmi.solve().unwrap();
            let file = lmi.certificate_file("a Lyapunov inequality", &solution).unwrap();
            prop_assert_eq!(file.theorem().name(), name);
            prop_assert!(verify(file.to_json().as_bytes()).is_ok());
        }
    }

    /// A file with bytes changed, and its digest made to agree: never a panic, and what is proved is proved of what is
    /// written.
    #[test]
    fn tampering_never_panics(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..3)) {
        let mut bytes = example_1().2.certificate_file("Example 1").unwrap().to_json().into_bytes();
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let _ = verify(&bytes);
        if let Ok(text) = String::from_utf8(bytes)
            && digest(text.as_bytes()).is_ok()
            && text.contains(SEAL)
        {
            let _ = verify(resealed(&text).as_bytes());
        }
    }
}

#[test]
fn the_examples_of_the_paper_go_into_files() {
    let (plant, linear, cubic) = example_1();
    let proved = goes_the_whole_way(linear.certificate_file("Example 1, linear"));
    assert!(proved.statement.starts_with("For the plant x' = Ax + Bu, y = Cx with 2 states, 1 input and 1 output"));
    let proved = goes_the_whole_way(cubic.certificate_file("Example 1"));
    assert_eq!(proved.facts.len(), 5);
    let o = &cubic.observer;
    // Theorem 1 to the last bit: false for the N that was rounded, and then there is no file.
    let examined = Theorem1::examine(&plant, &o.l, &o.n, &o.theta, &cubic.p).unwrap();
    let why = examined.certificate_file("Theorem 1").unwrap_err();
    assert!(why.to_string().starts_with("P N C + C'N'P <= 0 (13') is false: v = ("), "{why}");
    // P N = -C' in integers: P = [2 -1; -1 1], N = -(1, 1).
    let (l, n, p) = (dmatrix![3.0; 3.0], dmatrix![-1.0; -1.0], dmatrix![2.0, -1.0; -1.0, 1.0]);
    let file = Theorem1::examine(&plant, &l, &n, &dmatrix![1.0], &p).unwrap().certificate_file("Theorem 1");
    assert_eq!(goes_the_whole_way(file).facts[3].verdict.margin(), Some(0.0));

    let third = third_order::example3().to_dynamic();
    let l = dmatrix![0.267; -1.429; 3.904];
    let gain = certify_gain(&third, &l, &(&l * -10.0)).unwrap();
    goes_the_whole_way(gain.certificate_file("Example 3 with the other sign"));
    let margin = fixed_gain_margin(&third, &l, &(&l * -10.0), 1e-3).unwrap();
    goes_the_whole_way(margin.at_margin.certificate_file("Example 3 at its margin"));
}

/// A weight that ignores an output: N lacks rank, and convergence is proved from an ellipsoid, or of the real gain
/// alone.
#[test]
fn a_singular_weight_goes_into_a_file_that_says_how_far_it_reaches() {
    let plant = StateSpace::new(
        dmatrix![0.1, 1.0, 0.0; 0.0, 0.2, 1.0; -1.0, 0.0, 0.3],
        DMatrix::zeros(3, 0),
        dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0],
    )
    .unwrap();
    let theta = theta_from_importance(&[1.0, 0.0]).unwrap();
    let design = CubicDesign::new(&linear(&plant, 1.0), &theta, &CubicGain::Gamma(1.0)).unwrap();
    assert!(!design.certificate.converges_from_everywhere());
    let file = design.certificate_file("one output ignored").unwrap();
    let proved = goes_the_whole_way(Ok::<_, Rejection>(file.clone()));
    let at = "exactly as stored, e tends to 0 exponentially, from every e(0) with e(0)'P e(0) < ";
    assert!(proved.statement.contains(at), "{}", proved.statement);
    // The next larger level is one too many, and so is everywhere.
    let Theorem::CubicConvergence(theorem) = file.theorem() else { panic!("{}", file.theorem().name()) };
    let Within(level) = theorem.region else { panic!() };
    for region in [Within(level.next_up()), Everywhere] {
        let claimed = luenberger_proof::certificate::CubicConvergence { region, ..theorem.clone() };
        let refused = CertificateFile::prove("too much", claimed);
        assert!(matches!(refused, Err(Rejection::NotProved { .. })), "{refused:?}");
    }
    // The real gain has no such limit.
    let theorem = theorem.clone();
    let structured = StructuredCubicConvergence {
        plant: theorem.plant,
        l: theorem.l,
        theta: theorem.theta,
        p: theorem.p,
        s: theorem.s,
        rate: 0.0,
    };
    let proved = verify(CertificateFile::prove("the real gain", structured).unwrap().to_json().as_bytes()).unwrap();
    assert!(proved.statement.ends_with("from every e(0). Nothing is said of a rounding of N."), "{}", proved.statement);
}

#[test]
fn designs_for_nonlinear_plants_go_into_files() {
    let lpv = LpvDesign::new(flexible_joint::classical(), &Region::everywhere(4), 1.0).unwrap();
    let proved = goes_the_whole_way(lpv.certificate_file("the flexible joint"));
    assert!(
        proved.statement.starts_with("For all matrices (A(t), C(t)) in the convex hull of the 2 "),
        "{}",
        proved.statement
    );
    assert!(proved.statement.contains("that they do is a hypothesis, of which this certificate says nothing"));
    let a = DMatrix::from_column_slice(4, 4, flexible_joint::classical().linear_part().as_slice());
    let vertices = [-3.33, 3.33].map(|slope| {
        let mut vertex = a.clone();
        vertex[(3, 2)] += slope;
        vertex
    });
    let mean_value = MeanValueDesign::new(&vertices, 2, 1.0).unwrap();
    assert_eq!(goes_the_whole_way(mean_value.certificate_file("mean value")).facts.len(), 3);
    let sine = Sector::structured(dmatrix![0.0; 0.0; 0.0; 1.0], dmatrix![0.0, 0.0, 1.0, 0.0], 3.33);
    let plant = LipschitzPlant::new(a, DMatrix::identity(2, 4), vec![sine]).unwrap();
    let lipschitz = LipschitzDesign::new(&plant, 1.0).unwrap();
    let statement = goes_the_whole_way(lipschitz.certificate_file("Lipschitz")).statement;
    assert!(statement.contains("|w_1| <= high |H_1 e| for high = 0x1.aa3d70a3d70a4p1 (about 3.33)"), "{statement}");
    let coordinates = ContractingCoordinates::new(&[dmatrix![-3.0, 2.0; -2.0, 1.0]], 1, 0.5).unwrap();
    assert_eq!(goes_the_whole_way(coordinates.certificate_file("coordinates")).facts.len(), 3);
}

/// Observers of the observable plants, sampled, in the numbers of their targets: what a design proves, the checker
/// proves, and a bound one unit smaller it does not.
#[test]
fn deployed_observers_go_into_files() {
    let plants = [double_integrator().to_dynamic(), third_order::example3().to_dynamic()];
    for plant in plants {
        let n = plant.a.nrows();
        let design = SampledCubicDesign::new(&linear(&plant, 1.0), &dmatrix![1.0], 2.0, 0.1).unwrap();
        let o = &design.observer;
        let sampled = StateSpace::new(o.ad().clone(), o.bd().clone(), o.c().clone()).unwrap();
        let meets = Operation {
            state: vec![2.0; n],
            input: vec![1.0; plant.b.ncols()],
            noise: vec![1e-3],
            error: vec![2.0; n],
            deviation: None,
        };
        let fixed = Format::Fixed { integer_bits: 14, fraction_bits: 30 };
        for format in [Format::Binary32, Format::Binary64, fixed] {
            for step in [Step::Innovation, Step::Joined] {
                let found = deployed_linear(&sampled, o.ld(), step, format.into(), &meets).unwrap();
                let ball = found.deployed.ball().unwrap_or_else(|| panic!("{format} {step:?}: {found:?}"));
                let file = found.certificate_file("deployed").unwrap();
                let proved = goes_the_whole_way(Ok::<_, Rejection>(file.clone()));
                assert_eq!(proved.facts.len(), 4 + n);
                assert!(proved.statement.contains(&format!("stored in {format}, to nearest")), "{}", proved.statement);
                let Theorem::DeployedObserver(theorem) = file.theorem() else { panic!("{}", file.theorem().name()) };
                let mut forged = theorem.clone();
                forged.ball.as_mut().unwrap().entries[n - 1] = ball.entries[n - 1].next_down();
                assert!(CertificateFile::prove("forged", forged).is_err());
            }
            // The root of the cubic observer is not specified in fixed point: its stored numbers are proved, and no
            // ball is claimed.
            let proved = goes_the_whole_way(design.deployed_certificate_file("cubic", format.into(), &meets));
            assert_eq!(proved.facts.len(), if format == fixed { 4 } else { 5 + n }, "{}", proved.statement);
            assert_eq!(proved.statement.ends_with("Nothing is said of the rounding of its steps."), format == fixed);
        }
        // A ball for the cubic observer in fixed point is refused, with the reason.
        let file = design.deployed_certificate_file("cubic", fixed.into(), &meets).unwrap();
        let Theorem::DeployedObserver(theorem) = file.theorem() else { panic!("{}", file.theorem().name()) };
        let mut boast = theorem.clone();
        boast.ball = Some(ClaimedBall { start: 1e6, entries: vec![1e6; n] });
        let why = CertificateFile::prove("boast", boast).unwrap_err().to_string();
        assert!(why.ends_with("the root of the cubic observer is not specified in fixed point"), "{why}");
        // A stored number of N changed by one unit of its format: what is claimed of the others is no longer what is
        // proved.
        let file = design.deployed_certificate_file("cubic", Format::Binary32.into(), &meets).unwrap();
        let Theorem::DeployedObserver(theorem) = file.theorem() else { panic!("{}", file.theorem().name()) };
        let mut finer = theorem.clone();
        let gains = finer.stored.cubic.as_mut().unwrap();
        gains.n[(0, 0)] = gains.n[(0, 0)].next_up();
        let why = CertificateFile::prove("finer", finer).unwrap_err().to_string();
        assert!(why.contains("nearest to the plant's is false: stored.N[0][0] is"), "{why}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]

    /// The exact solution for a random equation: proved as derived, wider as well, and not one unit narrower at either
    /// end of any entry.
    #[test]
    fn exact_solutions_go_into_files(m in matrix(4, 4), q in matrix(4, 4), n in 1..=4_usize, is_stein in any::<bool>()) {
        let (m, q) = (m.view((0, 0), (n, n)).into_owned(), q.view((0, 0), (n, n)).into_owned());
        // Of norm at most 4 for entries in [-1, 1]: shifted, or scaled, it is stable.
        let a = if is_stein { m * 0.2 } else { m - DMatrix::identity(n, n) * 5.0 };
        let q = &q + q.transpose();
        let equation = if is_stein { Equation::Stein } else { Equation::Lyapunov };
        let file = solution_certificate(equation, &a, &q).unwrap();
        goes_the_whole_way(Ok::<_, Rejection>(file.clone()));
        let Theorem::SolutionWithin(theorem) = file.theorem() else { panic!("{}", file.theorem().name()) };
        // Another method: the floating-point solution is near the middle.
        let p = if is_stein { stein(&a, &q).unwrap().p } else { lyapunov(&a, &q).unwrap().p };
        for i in 0..n {
            for j in 0..=i {
                let proved = theorem.p[(i, j)];
                let (lo, hi) = (proved.lo(), proved.hi());
                // The condition of these equations is below 10: the distance is a few roundings of the largest entry.
                let rounding = 1e4 * f64::EPSILON * p.amax();
                prop_assert!(lo - rounding <= p[(i, j)] && p[(i, j)] <= hi + rounding);
                let claim = |lo: f64, hi: f64| {
                    let mut claimed = theorem.clone();
                    claimed.p[(i, j)] = Interval::new(lo, hi).unwrap();
                    claimed.p[(j, i)] = claimed.p[(i, j)];
                    CertificateFile::prove("claimed", claimed)
                };
                prop_assert!(claim(lo.next_down(), hi.next_up()).is_ok());
                prop_assert!(claim(lo.next_up(), hi.next_up()).is_err() && claim(lo.next_down(), hi.next_down()).is_err());
            }
        }
    }
}

/// What is undecided, or another problem's, has no file.
#[test]
fn an_answer_to_another_problem_has_no_file() {
    let posed = |shift: f64| {
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", 2);
        lmi.constrain("P > 0", &p >> 0.0);
        lmi.constrain("decrease", he(&p * dmatrix![shift, 1.0; 0.0, shift]) << 0.0);
        lmi
    };
    let refuted = posed(1.0).solve().unwrap();
    assert!(matches!(refuted.verdict, Verdict::Refuted { .. }));
    assert!(posed(1.0).certificate_file("infeasible", &refuted).is_ok());
    let error = posed(-1.0).certificate_file("feasible", &refuted).unwrap_err();
    assert!(
        error.to_string().starts_with("no certificate file: sum_k tr(F_ki Z_k) = 0 for every unknown x_i is false"),
        "{error}"
    );
    let problem = posed(-1.0);
    let solved = problem.solve().unwrap();
    assert!(problem.certificate_file("feasible", &solved).is_ok());
    let error = posed(-1.0).certificate_file("the unknowns are of another problem", &solved).unwrap_err();
    assert!(error.to_string().contains("x(1, 1) is NaN"), "{error}");
}

// Tampering. The digest catches every change; what the mathematics says is tested with the digest and the words made to
// agree again.

const SEAL: &str = "\"sha256\": \"";

fn sealed(text: &str) -> String {
    let at = text.find(SEAL).unwrap() + SEAL.len();
    let end = at + text[at..].find('"').unwrap_or(0);
    format!("{}{}{}", &text[..at], digest(text.as_bytes()).unwrap_or_default(), &text[end..])
}

/// With the words and the digest that its data call for.
fn resealed(text: &str) -> String {
    let text = sealed(text);
    match CertificateFile::read(text.as_bytes()) {
        Ok(file) => sealed(&text.replace(file.statement(), &file.theorem().words())),
        Err(_) => text,
    }
}

/// Where the numbers of a file stand that are data, not claims.
fn numbers(text: &str) -> Vec<(usize, f64)> {
    let end = text.find("\"margins\"").unwrap();
    let mut found = vec![];
    let mut at = 0;
    while let Some(start) = text[at..end].find(['"']).map(|k| at + k + 1) {
        let length = text[start..].find('"').unwrap();
        if let Ok(number) = text[start..start + length].parse::<Number>() {
            found.push((start, number.to_f64().unwrap()));
        }
        at = start + length + 1;
    }
    found
}

fn with_number(text: &str, at: usize, value: f64) -> String {
    let length = text[at..].find('"').unwrap();
    format!("{}{}{}", &text[..at], Number::from_f64(value).unwrap(), &text[at + length..])
}

/// Every bit of every number of the linear observer of Example 1. With the old digest: rejected, all. With a new one
/// the mathematics decides, and whatever it lets pass is true by another method: the smallest eigenvalues in floating
/// point are not below the margins claimed. What passes: every change of B and of the sign of a zero, and the low bits
/// that happen to increase the margins.
#[test]
fn flipped_bits_are_rejected_or_leave_the_statement_true() {
    let (_, linear, _) = example_1();
    let text = linear.certificate_file("Example 1").unwrap().to_json();
    let (mut rejected, mut accepted) = (0, 0);
    for (at, value) in numbers(&text) {
        for bit in 0..64 {
            let flipped = f64::from_bits(value.to_bits() ^ (1 << bit));
            if !flipped.is_finite() || flipped == value {
                continue;
            }
            let forged = with_number(&text, at, flipped);
            let plain = verify(forged.as_bytes()).unwrap_err();
            assert!(matches!(plain, Rejection::Digest { .. } | Rejection::File(_)), "{plain}");
            let forged = resealed(&forged);
            let Ok(proved) = verify(forged.as_bytes()) else {
                rejected += 1;
                continue;
            };
            accepted += 1;
            let file = CertificateFile::read(forged.as_bytes()).unwrap();
            let Theorem::LinearConvergence(theorem) = file.theorem() else { panic!() };
            let data = |m: &Matrix<luenberger_proof::certificate::Datum>| dynamic_matrix(&m.map(|x| x.interval().lo()));
            let (a, c, l, p) = (
                data(&theorem.plant.a),
                data(&theorem.plant.c),
                dynamic_matrix(&theorem.l),
                dynamic_matrix(&theorem.p),
            );
            let half = &p * (a - l * c) + &p * theorem.rate;
            for (m, fact) in [(p, &proved.facts[0]), (-(&half + half.transpose()), &proved.facts[1])] {
                // Eigenvalues and entries of order 2 to a few roundings.
                let rounding = 32.0 * f64::EPSILON * (m.norm() + half.norm());
                assert!(lambda_min(&m).unwrap() >= fact.verdict.margin().unwrap() - rounding, "{forged}");
            }
        }
    }
    // 11 numbers that matter, 64 bits of each; B and the low bits pass.
    assert!(rejected > 300 && accepted > 100, "{rejected} rejected, {accepted} accepted");
}

/// Changes that make the statement false: rejected by the mathematics alone, with the digest and the words made to
/// agree.
#[test]
fn false_statements_are_rejected_with_a_digest_that_agrees() {
    let (_, _, cubic) = example_1();
    let file = cubic.certificate_file("Example 1").unwrap();
    let text = file.to_json();
    assert!(verify(resealed(&text).as_bytes()).is_ok());
    let Theorem::CubicConvergence(theorem) = file.theorem() else { panic!() };
    let forged = |change: &dyn Fn(&mut luenberger_proof::certificate::CubicConvergence)| {
        let mut theorem = theorem.clone();
        change(&mut theorem);
        CertificateFile::prove("forged", theorem).expect_err("a false statement").to_string()
    };
    let negated = |m: &Matrix<f64>| m.map(|x| -x);
    assert!(forged(&|t| t.l = negated(&t.l)).starts_with("(A - LC)'P + P(A - LC) < 0 (12) is false"));
    assert!(forged(&|t| t.p = negated(&t.p)).starts_with("P > 0 is false"));
    assert!(forged(&|t| t.theta = negated(&t.theta)).starts_with("theta >= 0 is false"));
    assert!(forged(&|t| t.s = negated(&t.s)).starts_with("S + S' >= 0 is false"));
    assert!(forged(&|t| t.n = negated(&t.n)).starts_with("convergence with N as stored, everywhere is not proved"));
    assert!(forged(&|t| std::mem::swap(&mut t.l, &mut t.n)).starts_with("(A - LC)'P + P(A - LC) < 0 (12) is false"));
    assert!(forged(&|t| t.plant.a = t.plant.a.transpose()).starts_with("(A - LC)'P + P(A - LC) < 0 (12) is false"));
    assert!(forged(&|t| t.rate = 5.0).starts_with("(A - LC)'P + P(A - LC) + 2 rate P < 0 (12) is false"));
    // As text: two matrices swapped by their names.
    let swapped = text.replace("\"L\"", "\"X\"").replace("\"N\"", "\"L\"").replace("\"X\"", "\"N\"");
    assert!(verify(swapped.as_bytes()).is_err_and(|why| matches!(why, Rejection::Digest { .. })));
    let why = verify(resealed(&swapped).as_bytes()).unwrap_err();
    assert!(matches!(why, Rejection::NotProved { .. }), "{why}");
    // The sign of any number of the plant, the gains or P but B's.
    for (at, value) in numbers(&text) {
        let line = text[..at].lines().count();
        let is_input =
            text.lines().take(line).filter(|l| l.contains("\": [")).last().is_some_and(|l| l.contains("\"B\""));
        if value != 0.0 && !is_input {
            let why = verify(resealed(&with_number(&text, at, -value)).as_bytes());
            assert!(why.is_err(), "line {line}");
        }
    }
    // A margin one unit in the last place too large.
    let proved = file.check().unwrap().facts;
    for k in 0..file.claims().len() {
        let mut claims = file.claims().to_vec();
        let margin = proved[k].verdict.margin().unwrap().next_up();
        claims[k] = Claim { margin: Number::from_f64(margin).unwrap(), ..claims[k].clone() };
        let why = file.with_claims(&claims).unwrap().check().unwrap_err();
        assert!(matches!(why, Rejection::Margin { index, .. } if index == k), "{why}");
    }
}
