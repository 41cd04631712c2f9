//! A kind of another crate: one declaration and one call make it a kind like the others. In a process of its own, since
//! a registered kind is there for all studies of a process.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use luenberger_export::Scalar;
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Recorded, Recording};
use luenberger_observers::{Observer, ObserverDimensions};
use luenberger_plants::StateSpace;
use luenberger_sim::{AnyObserver, Continuous};
use luenberger_study::advise::{AdviseOptions, advise};
use luenberger_study::deployment::{exported, sampled};
use luenberger_study::design::{Designed, NoObserver, design};
use luenberger_study::kinds::{
    Declaration, Information, Kind, Plan, Rule, Running, StepOf, Tuning, Value, as_kind, named, register,
};
use luenberger_study::results::DesignReport;
use luenberger_study::schema::schema;
use luenberger_study::study::{ObserverKind, PlantClass, Specification, Time};
use luenberger_study::{Format, RunOptions, Step, Study, StudyError, execute, keys};
use nalgebra::{DMatrix, DVector, RealField, convert};

static TRANSPOSED: Declaration = Declaration {
    name: "transposed-output",
    about: "Copy of a linear plant with the gain L = k C'.",
    source: "made for a test",
    plant: PlantClass::Linear(Time::OF_STATE),
    keys: &[TransposedOutput::KEYS],
    kind: as_kind::<TransposedOutput>,
    read: |given, reader| Some(TransposedOutput::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "transposed-output",
        turn: 0,
        tuning: "twice the decay rate",
        source: "made for a test",
        character: "its gain has the direction of the output",
        information: &[Information::Settling],
        keys: |context| Ok(vec![vec![("k", Value::Number(2.0 * context.rate()))]]),
    }]),
};

keys! {
    #[derive(Debug, PartialEq)]
    struct TransposedOutput {
        /// The gain k.
        k: f64 as Number(Positive),
    }
}

impl Specification for TransposedOutput {
    fn name(&self) -> &'static str {
        TRANSPOSED.name
    }

    fn plant(&self) -> PlantClass {
        TRANSPOSED.plant
    }
}

impl Kind for TransposedOutput {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let StateSpace { a, b, c, .. } = plan.linear()?.clone();
        let observer = Injected { a, b, l: c.transpose() * self.k, c };
        Ok(Designed::new(observer.into(), DesignReport::default(), None))
    }
}

/// `xhat' = A xhat + B u + L (y - C xhat)`.
#[derive(Debug, Clone)]
struct Injected<T> {
    a: DMatrix<T>,
    b: DMatrix<T>,
    c: DMatrix<T>,
    l: DMatrix<T>,
}

impl<T: RealField + Copy> Observer<T> for Injected<T> {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    type Estimate = DVector<T>;

    fn dimensions(&self) -> ObserverDimensions {
        let n = self.a.nrows();
        ObserverDimensions { state: n, inputs: self.b.ncols(), outputs: self.c.nrows(), estimate: n }
    }

    fn derivative(&self, _t: T, xhat: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        &self.a * xhat + &self.b * u + &self.l * (y - &self.c * xhat)
    }

    fn estimate(&self, _t: T, xhat: &DVector<T>, _u: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        xhat.clone()
    }

    fn initial(&self, _t: T, xhat: &DVector<T>, _u: &DVector<T>, _y: &DVector<T>) -> DVector<T> {
        xhat.clone()
    }
}

impl Running for Injected<f64> {
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        Arc::new(Continuous::new(self))
    }

    fn record(&self, _of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        let [a, b, c, l] = [&self.a, &self.b, &self.c, &self.l].map(|m| m.map(convert::<f64, Recorded>));
        Ok(RecordedObserver::new(recording, &Injected { a, b, c, l })?)
    }
}

const PLANT: &str = "[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
[simulation]
duration = 4
x0 = [1, 0.5]
noise = { amplitude = [0.01], period = 0.1 }
";

/// The double integrator with this observer.
fn read(observer: &str) -> Result<Study, StudyError> {
    Study::from_text("study.toml", &format!("{PLANT}{observer}"), Format::Toml, ".".as_ref())
}

#[test]
fn a_kind_of_another_crate_is_a_kind_like_the_others() {
    assert!(register(&TRANSPOSED));
    assert!(!register(&TRANSPOSED), "a second kind of the same name");
    assert_eq!(named("transposed-output").map(|kind| kind.source), Some("made for a test"));
    assert!(schema().contains("\"transposed-output\""));

    let study = read("[[observer]]\nkind = \"transposed-output\"\nk = 3\ninitial = [1, 0]\n").unwrap();
    let observer = &study.observers[0];
    assert_eq!(observer.kind.of::<TransposedOutput>(), Some(&TransposedOutput { k: 3.0 }));
    assert_eq!(observer.kind, ObserverKind::from(TransposedOutput { k: 3.0 }));
    assert_ne!(observer.kind, ObserverKind::from(TransposedOutput { k: 4.0 }));

    // x1' = x2, x2' = u, y = x1: xhat1' = xhat2 + 3 (y - xhat1).
    let designed = design(&study, observer, &AtomicBool::new(false)).unwrap();
    assert_eq!(designed.runnable.motion(0.0, &[1.0, 0.5], &[2.0], &[0.0]), Some(vec![-2.5, 2.0]));
    let results = execute(&study, Step::Run, &RunOptions::default()).unwrap();
    assert!(results.failures().is_empty() && results.observers[0].kind == "transposed-output");

    // Its exported step is that of its body.
    let step = sampled(&study, observer, Some(0.1), None).unwrap();
    let export = exported(&study, observer, step.design, Scalar::Binary64, None).unwrap();
    assert!(export.operations() > 0);

    let options = AdviseOptions { budget: 20.0, ..AdviseOptions::default() };
    let advice = advise(&study, &options).unwrap().0;
    let text = format!("{advice:?}");
    assert!(text.contains("transposed-output"), "{text}");

    // A mistake in its keys is reported like any other.
    let wrong = "[[observer]]\nkind = \"transposed-output\"\nkk = -3\n";
    let error = read(wrong).unwrap_err().to_string();
    assert!(error.contains("`kk` is not a key of [[observer]] of the kind transposed-output"), "{error}");
    assert!(error.contains("has no `k`") && error.contains("The gain k."), "{error}");
}
