//! The header of exported code: what it says is proved, against the verdict of the design and the certificate.

use luenberger_proof::certificate::{DeployedObserver, Theorem};
use luenberger_proof::statement::Format;
use luenberger_study::Study;
use luenberger_study::deployment::{Evidence, evidence, sampled};
use luenberger_study::study::ObserverSpec;
use nalgebra::DMatrix;

use super::adversary::{Held, Verdict, Wrong};
use super::linear;
use super::said::Said;
use super::sentences::{Claim, Sentence, listed};

/// The evidence of an export in this format; none where the export is refused.
pub(super) fn of(study: &Study, observer: &ObserverSpec, format: Format) -> Option<Evidence> {
    let period = study.simulation.as_ref().and_then(|simulation| simulation.hold);
    // The command asks for a period; here it is given.
    let period = period.or(if study.plant.dt.is_some() { None } else { Some(0.01) });
    let period = if observer.kind.period().is_some() { None } else { period };
    let sampled = sampled(study, observer, period, None).ok()?;
    sampled.design.stored_in(observer, format).ok()?;
    Some(evidence(study, observer, &sampled.design, format.into()))
}

/// Holds the sentences of a header.
pub(super) fn check(said: &Said, sentence: &Sentence, evidence: &Evidence) -> Verdict {
    let Some(claim) = sentence.claim else { return Ok(Held::Unchecked) };
    let is_proof = matches!(
        claim,
        Claim::HeaderStored | Claim::HeaderSame | Claim::HeaderProved | Claim::HeaderBound | Claim::HeaderLoop
    );
    if !is_proof {
        return Ok(Held::Unchecked);
    }
    let Some(file) = &evidence.file else {
        return Err(Wrong::False("it says proved, and there is no certificate".to_owned()));
    };
    // What repeats the statement of the design has its verdict; an export of a linear plant has a design of its own.
    if claim == Claim::HeaderProved && sentence.text.contains("in continuous time") && said.verdict != "proved" {
        return Err(Wrong::False(format!(
            "the header says proved, and the verdict of the design is `{}`",
            said.verdict
        )));
    }
    let Theorem::DeployedObserver(theorem) = file.theorem() else { return Ok(Held::Computed) };
    match claim {
        Claim::HeaderStored => stored(theorem),
        Claim::HeaderSame => same(theorem),
        Claim::HeaderBound => bounded(theorem, sentence),
        _ => Ok(Held::Computed),
    }
}

fn matrix(m: &luenberger_proof::Matrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(m.rows(), m.cols(), |i, j| m[(i, j)])
}

/// The error of a plant with the stored matrices tends to 0: the stored A - LC is Schur, exactly.
fn stored(theorem: &DeployedObserver) -> Verdict {
    let kept = &theorem.stored;
    match linear::contracts(&matrix(&kept.a), &matrix(&kept.l), &matrix(&kept.c), 1.0) {
        Some(true) => Ok(Held::Computed),
        Some(false) => Err(Wrong::False("the stored A - LC is not Schur, exactly".to_owned())),
        None => Ok(Held::Unchecked),
    }
}

/// The stored matrices are those of the plant.
fn same(theorem: &DeployedObserver) -> Verdict {
    let (plant, kept) = (&theorem.plant, &theorem.stored);
    let pairs = [(&plant.a, &kept.a), (&plant.b, &kept.b), (&plant.c, &kept.c)];
    if pairs.iter().all(|(plant, kept)| matrix(plant) == matrix(kept)) {
        return Ok(Held::Computed);
    }
    Err(Wrong::False("a stored matrix is not that of the plant".to_owned()))
}

/// The printed hypotheses are within those of the certificate, and the printed bounds above its own.
fn bounded(theorem: &DeployedObserver, sentence: &Sentence) -> Verdict {
    let given = |what: &str| -> Vec<f64> {
        let found = sentence.hole(0).split_once(&format!("{what} ("));
        listed(found.and_then(|(_, rest)| rest.split_once(')')).map_or("", |(list, _)| list))
    };
    let operation = &theorem.operation;
    let all = [
        ("states", &operation.state),
        ("inputs", &operation.input),
        ("measurement noise", &operation.noise),
        ("first error", &operation.error),
    ];
    for (what, certified) in all {
        for (printed, certified) in given(what).iter().zip(certified) {
            if printed > certified {
                return Err(Wrong::Rounded(format!(
                    "the bound of the {what} is printed as {printed}, and certified for {certified}"
                )));
            }
        }
    }
    let Some(ball) = &theorem.ball else { return Err(Wrong::False("no bound is certified".to_owned())) };
    let printed = listed(sentence.hole(1));
    for (printed, certified) in printed.iter().zip(&ball.entries) {
        if printed < certified {
            return Err(Wrong::Rounded(format!("the error is printed as {printed}, and certified below {certified}")));
        }
    }
    // The noise alone.
    if theorem.stored.cubic.is_none() {
        let (a, c, l) = (matrix(&theorem.stored.a), matrix(&theorem.stored.c), matrix(&theorem.stored.l));
        let g = DMatrix::from_fn(l.nrows(), l.ncols(), |i, k| l[(i, k)] * operation.noise[k]);
        if let Some(peaks) = linear::peak_gains(&(&a - &l * &c), &g, true) {
            for (i, printed) in printed.iter().enumerate().take(peaks.nrows()) {
                let found: f64 = peaks.row(i).iter().sum();
                if found > printed * (1.0 + 1e-6) {
                    return Err(Wrong::False(format!(
                        "noise within its bound drives entry {} of the error to {found:e}, above {printed:e}",
                        i + 1
                    )));
                }
            }
        }
    }
    Ok(Held::Computed)
}
