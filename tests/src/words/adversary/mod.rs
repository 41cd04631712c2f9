//! Tries to contradict a sentence.
//!
//! A claim about linear error dynamics is decided exactly, or computed by another algorithm. A claim about a
//! nonlinear plant, and one that quantifies over noise and disturbances, is held against trajectories: from first
//! states and estimates within the hypothesis, with inputs, noise and disturbances at their bounds that change sign.
//! What looks like a violation is computed again with a hundredth of the tolerance before it counts.

mod bounds;
mod cubic;
mod maps;
mod norms;
mod rates;
mod refusals;
mod runs;

use std::cell::{Cell, RefCell};

use luenberger_random::Random;
use luenberger_study::Study;
use luenberger_study::design::Designed;
use luenberger_study::study::ObserverSpec;
use nalgebra::DMatrix;

use super::document::Table;
use super::plant::Plant;
use super::said::{Said, matrix};
use super::sentences::{Claim, Sentence, rate};

/// How a sentence was held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Held {
    /// Against trajectories.
    Simulated,
    /// Exactly, or by another algorithm.
    Computed,
    /// It claims nothing here, or nothing that is decided here.
    Unchecked,
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Wrong {
    /// The claim is false.
    False(String),
    /// A number is rounded to the wrong side.
    Rounded(String),
}

pub(super) type Verdict = Result<Held, Wrong>;

fn wrong(why: String) -> Wrong {
    Wrong::False(why)
}

/// An observer of a study.
pub(super) struct Subject<'a> {
    pub(super) study: &'a Study,
    pub(super) plant: &'a Plant,
    pub(super) spec: &'a ObserverSpec,
    /// Its table in the study.
    pub(super) own: &'a Table,
    pub(super) designed: Option<&'a Designed>,
    /// The other observers of the study that are said to be proved, by name.
    pub(super) proved: &'a [String],
    pub(super) random: RefCell<Random>,
    /// Of trajectories.
    pub(super) tolerance: Cell<f64>,
}

/// A, B and C.
struct Matrices {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
}

/// Points of the time grid of a trajectory.
const INTERVALS: usize = 96;

/// Trajectories for a claim.
const TRIES: usize = 4;

const TOLERANCE: f64 = 1e-9;

const BUDGET: usize = 30_000;

impl Subject<'_> {
    /// Holds a sentence of a statement, or of a header that repeats it. What is false is held again with a hundredth of
    /// the tolerance.
    pub(super) fn check(&self, said: &Said, sentence: &Sentence) -> Verdict {
        let state = self.random.borrow().0;
        self.tolerance.set(TOLERANCE);
        let verdict = self.held(said, sentence);
        if !matches!(verdict, Err(Wrong::False(_))) {
            return verdict;
        }
        *self.random.borrow_mut() = Random(state);
        self.tolerance.set(1e-2 * TOLERANCE);
        match self.held(said, sentence) {
            Err(wrong) => Err(wrong),
            Ok(_) => Ok(Held::Unchecked),
        }
    }

    fn held(&self, said: &Said, sentence: &Sentence) -> Verdict {
        let Some(claim) = sentence.claim else { return Ok(Held::Unchecked) };
        let is_proved = said.verdict == "proved";
        match claim {
            // Claims of impossibility are made where there is no design.
            Claim::NotObservable => self.not_observable(),
            Claim::NotDetectable => self.not_detectable(),
            Claim::Observable => self.is_observable(),
            Claim::Detectable => self.is_detectable(),
            Claim::NoGainOfNorm => self.no_gain_of_norm(sentence),
            Claim::NoGainOfWidth => self.no_gain_of_width(),
            Claim::NotHurwitz | Claim::NotSchur => self.not_stable(claim == Claim::NotSchur),
            Claim::Infeasible => self.infeasible(),
            Claim::Unmatched => self.unmatched(),
            Claim::Feedthrough => self.feedthrough(),
            // Those of headers are held in `header`; a zero, and what is exact at a sample, are not held.
            Claim::Nothing
            | Claim::UnstableZero
            | Claim::ExactAtSamples
            | Claim::HeaderStored
            | Claim::HeaderSame
            | Claim::HeaderProved
            | Claim::HeaderBound
            | Claim::HeaderLoop => Ok(Held::Unchecked),
            _ if said.verdict == "refuted" => self.refuted(claim, sentence),
            Claim::Tables if said.verdict == "measured" => self.tables(said),
            _ if !is_proved => Ok(Held::Unchecked),
            Claim::Decay => self.decay(sentence, said, false),
            Claim::WithoutW => self.decay(sentence, said, self.is_discrete()),
            Claim::DiscreteDecay => self.decay(sentence, said, true),
            Claim::Ultimate => self.ultimate(sentence),
            Claim::CubicDecrease => self.cubic(0.0, said, true),
            Claim::CubicEverywhere => self.cubic(f64::INFINITY, said, false),
            Claim::CubicWithin => self.cubic(
                sentence
                    .holes
                    .last()
                    .and_then(|ball| ball.parse().ok())
                    .unwrap_or_else(|| said.sealed.and_then(|sealed| sealed.ball).unwrap_or(0.0)),
                said,
                false,
            ),
            Claim::SampledCubic => self.sampled_cubic(sentence, said),
            Claim::Varying => rounded_up(
                sentence.holes.last().and_then(|factor| factor.parse().ok()),
                said.number("factor of V from correction to correction"),
                "the factor",
            ),
            Claim::Envelope => {
                let factor = sentence.number(1).unwrap_or(f64::NAN);
                rounded_up(Some(factor), said.number("overshoot"), "the overshoot")?;
                self.envelope(sentence.hole(0), factor, rate(sentence.hole(2)), false)
            }
            Claim::DiscreteEnvelope => {
                let (factor, q) = (sentence.number(1).unwrap_or(f64::NAN), sentence.number(2).unwrap_or(f64::NAN));
                rounded_up(Some(factor), said.number("overshoot"), "the overshoot")?;
                rounded_up(Some(q), said.number("factor of a step"), "q")?;
                let dt = self.plant.dt.unwrap_or(1.0);
                self.envelope(sentence.hole(0), factor, Some(-q.ln() / dt), false)
            }
            Claim::DiscreteConverges => {
                let factor = sentence.number(1).unwrap_or(f64::NAN);
                self.envelope(sentence.hole(0), factor, Some(0.0), false)
            }
            Claim::Sectors => self.sectors(sentence),
            Claim::MeanValue => {
                let factor = sentence.number(1).unwrap_or(f64::NAN);
                rounded_up(Some(factor), said.number("overshoot"), "the overshoot")?;
                self.envelope(sentence.hole(0), factor, rate(sentence.hole(2)), true)
            }
            Claim::Disturbance => self.disturbance(sentence, said),
            Claim::UnknownInput => self.unknown_input(sentence, said),
            Claim::UnknownInputOfSamples => self.unknown_input_at_samples(said),
            Claim::Encloses | Claim::EnclosesSampled => self.encloses(),
            Claim::Widths => self.widths(sentence, said),
            Claim::FiniteTime => self.finite_time(sentence, said),
            Claim::Reduced => self.reduced(sentence, said),
            Claim::HInfinity | Claim::H2 => self.norm(claim, sentence),
            Claim::KklConverges => self.kkl(None),
            Claim::KklGuaranteed => self.kkl(Some(sentence)),
            Claim::KklLimit => self.kkl_limit(sentence),
            Claim::ImmersionConverges => self.immersion(sentence),
            Claim::Loop => self.in_loop(),
            Claim::Tables => self.tables(said),
        }
    }

    fn kind(&self) -> &str {
        self.spec.kind.name()
    }

    fn is_discrete(&self) -> bool {
        self.plant.dt.is_some()
    }

    fn n(&self) -> usize {
        self.plant.states.len()
    }

    /// The matrices of the plant, or of its linearisation at the operating point of the study.
    fn matrices(&self) -> Option<Matrices> {
        if let Some((a, b, c, _)) = self.plant.matrices() {
            return Some(Matrices { a: a.clone(), b: b.clone(), c: c.clone() });
        }
        let linear = self.study.plant.model.linear();
        let linear = linear.or(self.study.operating_point.as_ref().map(|point| &point.linear))?;
        Some(Matrices { a: linear.a.clone(), b: linear.b.clone(), c: linear.c.clone() })
    }

    fn gain(&self) -> Option<DMatrix<f64>> {
        matrix(&self.designed?.report, "L")
    }

    /// A, L and C of the error of the observer.
    fn error(&self) -> Option<(DMatrix<f64>, DMatrix<f64>, DMatrix<f64>)> {
        let Matrices { a, c, .. } = self.matrices()?;
        let l = self.gain()?;
        (l.nrows() == a.nrows() && l.ncols() == c.nrows()).then_some((a, l, c))
    }
}

/// The rate of a hole: a number, or as in `tends to 0, at least as fast as exp(-2 t)`.
fn of_sentence(sentence: &Sentence, hole: usize) -> f64 {
    sentence.number(hole).or_else(|| rate(sentence.hole(hole))).unwrap_or(0.0)
}

/// A printed upper bound is not below the number.
fn rounded_up(printed: Option<f64>, number: Option<f64>, what: &str) -> Verdict {
    match (printed, number) {
        (Some(printed), Some(number)) if printed < number => {
            Err(Wrong::Rounded(format!("{what} {printed} is less than {number}")))
        }
        (Some(_), Some(_)) => Ok(Held::Computed),
        _ => Ok(Held::Unchecked),
    }
}

/// The verdict against the certificate.
pub(super) fn verdict(said: &Said) -> Verdict {
    match (said.verdict.as_str(), &said.sealed) {
        ("proved", None) => Err(wrong("proved, and there is no certificate".to_owned())),
        ("proved", Some(sealed)) if !sealed.is_proved => {
            Err(wrong("proved, and the certificate has an inequality that is not proved".to_owned()))
        }
        ("refuted", Some(sealed)) if !sealed.is_refuted => {
            Err(wrong("refuted, and no inequality of the certificate is".to_owned()))
        }
        ("proved" | "refuted" | "undecided", Some(_)) => Ok(Held::Computed),
        _ => Ok(Held::Unchecked),
    }
}

/// Sentences of a statement against each other and against the ball of a cubic certificate.
pub(super) fn coherence(said: &Said, sentences: &[Sentence]) -> Verdict {
    let of = |claim| sentences.iter().find(|sentence| sentence.claim == Some(claim));
    if let (Some(_), Some(bound)) = (of(Claim::KklConverges), of(Claim::KklGuaranteed))
        && said.verdict == "proved"
        && bound.holes.last().is_some_and(|limit| limit.starts_with("it is in the limit"))
    {
        return Err(wrong(format!("the estimation error tends to 0, and {} only", bound.hole(3))));
    }
    if let (Some(_), Some(limit)) = (of(Claim::KklConverges), of(Claim::KklLimit)) {
        return Err(wrong(format!("the estimation error tends to 0, and: {}", limit.text)));
    }
    let Some(ball) = said.sealed.and_then(|sealed| sealed.ball).filter(|_| said.verdict == "proved") else {
        return Ok(Held::Unchecked);
    };
    let from_everywhere = sentences.iter().find(|sentence| {
        matches!(
            sentence.claim,
            Some(
                Claim::Loop
                    | Claim::Disturbance
                    | Claim::UnknownInput
                    | Claim::UnknownInputOfSamples
                    | Claim::CubicEverywhere
            )
        ) && !sentence.text.contains("e'Pe <")
    });
    match from_everywhere {
        Some(sentence) => Err(wrong(format!(
            "the certificate has convergence from errors of norm below {ball:e} only, and it is said: {}",
            sentence.text
        ))),
        None => Ok(Held::Computed),
    }
}
