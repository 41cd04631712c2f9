//! Where a stream is: the state of its step, the time of the last row, and what is held. Its saved form is a JSON
//! object with all bits of each number and a digest of its content.

use serde::{Deserialize, Serialize};

use super::ResumeError;
use crate::digest::sha256;

/// The name of the saved form.
const FORM: &str = "luenberger stream 1";

/// Where a stream is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Position {
    /// Number of samples so far.
    pub(super) samples: u64,
    /// The state of the step.
    pub(super) state: Vec<f64>,
    /// The time of the last row.
    pub(super) time: Option<f64>,
    /// The inputs that are held.
    pub(super) inputs: Vec<f64>,
    /// The last value of each output.
    pub(super) outputs: Vec<f64>,
    /// Whether something was missing so far.
    pub(super) has_missed: bool,
    /// From what the times of the rows are counted.
    pub(super) times: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    form: String,
    observer: String,
    subject: String,
    samples: u64,
    state: Vec<String>,
    time: Option<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    has_missed: bool,
    times: String,
    digest: String,
}

impl Saved {
    /// The digest of all but itself.
    fn digest(&self) -> String {
        let Self { form, observer, subject, samples, state, time, inputs, outputs, has_missed, times, digest: _ } =
            self;
        let numbers = [state, inputs, outputs].map(|numbers| numbers.join(" "));
        let content = format!("{form}\n{observer}\n{subject}\n{samples}\n{numbers:?}\n{time:?}\n{has_missed}\n{times}");
        sha256(content.as_bytes())
    }
}

fn digits(x: f64) -> String {
    format!("{:016x}", x.to_bits())
}

fn number(digits: &String) -> Option<f64> {
    let bits = Some(digits).filter(|digits| digits.len() == 16).map(|digits| u64::from_str_radix(digits, 16));
    bits?.ok().map(f64::from_bits).filter(|x| x.is_finite())
}

impl Position {
    pub(super) fn saved(&self, subject: &str, observer: &str) -> String {
        let all = |numbers: &[f64]| numbers.iter().copied().map(digits).collect();
        let mut saved = Saved {
            form: FORM.to_owned(),
            observer: observer.to_owned(),
            subject: subject.to_owned(),
            samples: self.samples,
            state: all(&self.state),
            time: self.time.map(digits),
            inputs: all(&self.inputs),
            outputs: all(&self.outputs),
            has_missed: self.has_missed,
            times: self.times.clone(),
            digest: String::new(),
        };
        saved.digest = saved.digest();
        // Texts and counts only: it can be written.
        serde_json::to_string(&saved).unwrap_or_default() + "\n"
    }

    /// The position in a saved text, with the sizes of `like`.
    pub(super) fn of_saved(text: &str, subject: &str, like: &Self) -> Result<Self, ResumeError> {
        let saved: Saved = serde_json::from_str(text).map_err(|_| ResumeError::NotSaved)?;
        if saved.form != FORM {
            return Err(ResumeError::NotSaved);
        }
        if saved.digest != saved.digest() {
            return Err(ResumeError::Damaged);
        }
        if saved.subject != subject {
            return Err(ResumeError::Other);
        }
        let all = |digits: &[String], count: usize| {
            let numbers = digits.iter().map(number).collect::<Option<Vec<f64>>>();
            numbers.filter(|numbers| numbers.len() == count).ok_or(ResumeError::Damaged)
        };
        Ok(Self {
            samples: saved.samples,
            state: all(&saved.state, like.state.len())?,
            time: saved.time.as_ref().map(|time| number(time).ok_or(ResumeError::Damaged)).transpose()?,
            inputs: all(&saved.inputs, like.inputs.len())?,
            outputs: all(&saved.outputs, like.outputs.len())?,
            has_missed: saved.has_missed,
            times: saved.times,
        })
    }
}
