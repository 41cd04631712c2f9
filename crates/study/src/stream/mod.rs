//! An observer on rows that arrive one after the other: an estimate for each, by the step that would run on the target.
//!
//! | file | subject |
//! |---|---|
//! | `step` | the step of an export, with its estimates and bands |
//! | `written` | results as lines of CSV and JSON |
//! | `position` | where a stream is, and its saved form |
//! | `error` | why a row is passed over, or a stream ends |
//!
//! A row is one sample. With the times of the rows the number of periods since the row before is known, to the nearest:
//! samples in between are missed, as a row that is refused is. Without them each row is the next sample.
//!
//! At a missed sample, and for a missing value, a filter with a covariance only predicts, and observers with a constant
//! gain leave the output out of their correction, as the exported code does; otherwise the predicted output takes the
//! place of the missing one. A step that has no predicted output keeps the last value. An input that is missing keeps
//! its value.

mod error;
mod position;
mod step;
mod written;

pub use error::{ResumeError, StreamError};

use luenberger_clock::stop_flag;

use luenberger_sim::Estimates;
use luenberger_wording::setters;

use crate::deployment::{ExportOptions, ExportRefusal, Prepared, chosen, prepared};
use crate::design::design;
use crate::digest::sha256;
use crate::execute::with_variances;
use crate::study::Study;
use crate::table::{Form, LogColumns, LogRow, LogRows};
use position::Position;
use step::{Shown, StepOfStream};

/// Samples that may be missed in a row; more are a clock that jumped.
const MOST_MISSED: f64 = 1e6;

/// Options of a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamOptions {
    /// How the rows are written (default: by the first of them).
    pub form: Option<Form>,
    /// Whether the rows have times (default true).
    pub timed: bool,
    /// Whether filters, too, give the estimate for the next sample, as other observers and the exported step do, and
    /// not that with the measurement of the sample (default: as `estimates` of the log says, which is false by
    /// default).
    pub predicted: Option<bool>,
    /// Sampling period (default: that of a sampled observer, or the hold of the simulation).
    pub period: Option<f64>,
    /// Runge-Kutta steps per period, as of an export.
    pub substeps: Option<usize>,
}

impl Default for StreamOptions {
    fn default() -> Self {
        Self { form: None, timed: true, predicted: None, period: None, substeps: None }
    }
}

impl StreamOptions {
    setters! {
        form: Form,
        timed: bool,
        predicted: bool,
        period: f64,
        substeps: usize,
    }
}

/// An observer of a study on rows that arrive.
///
/// ```
/// use luenberger_study::{Format, Study};
/// use luenberger_study::stream::{Stream, StreamOptions};
/// let text = "
/// [plant]
/// states = [\"level\"]
/// outputs = [\"gauge\"]
/// a = [[1]]
/// c = [[1]]
/// dt = 0.5
/// [[observer]]
/// kind = \"luenberger\"
/// poles = [0.5]
/// ";
/// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
/// let mut stream = Stream::new(&study, None, &StreamOptions::default())?;
/// assert_eq!(stream.line(1, b"t,gauge")?.as_deref(), Some("t,level_hat\n"));
/// // From 0 half of the way to the measurement, for the next sample.
/// assert_eq!(stream.line(2, b"0,2")?.as_deref(), Some("0.5,1\n"));
/// let refused = stream.line(3, b"0.5,2 V").unwrap_err();
/// assert_eq!(refused.to_string(), "line 3, column 2 (gauge): expected a number, found `2 V`");
/// assert!(!refused.ends_stream());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Stream {
    step: StepOfStream,
    rows: LogRows,
    columns: LogColumns,
    names: Vec<String>,
    estimates: Estimates,
    is_timed: bool,
    /// What a saved state belongs to.
    subject: String,
    position: Position,
    /// The position after the last row whose estimates were delivered.
    delivered: Position,
}

/// Why a log with variances is not streamed.
const OTHER_VARIANCES: &str = "`variances` in [log] are those of its rows, and the exported step has one V for all: expected a study without them, in which `v` covers what the sensor does";

impl Stream {
    /// The stream of the observer of that name; without a name, of the only observer.
    ///
    /// The columns are those of `[log]`, or the names of the plant's inputs and outputs, with the time `t`.
    ///
    /// # Errors
    /// [`ExportRefusal`] of an observer without a step.
    pub fn new(study: &Study, name: Option<&str>, options: &StreamOptions) -> Result<Self, ExportRefusal> {
        let observer = chosen(study, name)?;
        let designed = design(study, observer, &stop_flag().unwrap_or_default());
        let designed = designed.map_err(|why| ExportRefusal::design(observer, why))?;
        if study.log.as_ref().is_some_and(|log| with_variances(&designed.runnable, log.variances.as_ref()).is_some()) {
            return Err(ExportRefusal::Options(OTHER_VARIANCES));
        }
        let of_export = ExportOptions {
            period: options.period,
            substeps: options.substeps,
            designed: Some(&designed),
            ..ExportOptions::default()
        };
        let Prepared { sampled, export, .. } = prepared((study, observer), &of_export, None, None)?;
        let step = StepOfStream::of((study, observer, &designed), &sampled.design, &export)?;
        let default = || {
            let (inputs, outputs) = (study.plant.inputs.clone(), study.plant.outputs.clone());
            LogColumns { time: "t".to_owned(), inputs, outputs }
        };
        let columns = study.log.as_ref().map_or_else(default, |log| log.columns.clone());
        let of_log = study.log.as_ref().map_or(Estimates::Filtered, |log| log.estimates);
        let estimates = match options.predicted {
            Some(true) => Estimates::Predicted,
            Some(false) => Estimates::Filtered,
            None => of_log,
        };
        let identity = format!(
            "{}\n{}\n{}\n{:?}\n{}\n{}",
            sha256(study.source.text().as_bytes()),
            observer.name,
            export.digest(),
            columns,
            export.observer().period().to_bits(),
            options.timed
        );
        let position = step.start();
        Ok(Self {
            rows: LogRows::new(options.form, columns.clone(), options.timed),
            names: step.names(estimates),
            columns,
            estimates,
            is_timed: options.timed,
            subject: sha256(identity.as_bytes()),
            delivered: position.clone(),
            position,
            step,
        })
    }

    /// The names of the results: the time `t` for which an estimate holds, the estimates `NAME_hat`, of a filter two
    /// standard deviations `NAME_2sigma`, of an interval observer the bounds `NAME_lower` and `NAME_upper`.
    pub fn columns(&self) -> &[String] {
        &self.names
    }

    /// The columns of inputs and outputs that have not occurred so far, which in JSON is no mistake.
    pub fn unseen(&self) -> Vec<&str> {
        self.rows.unseen()
    }

    /// The text that answers a line, which has no end: the results of a row in the form of the rows, with an empty cell
    /// or null where a band is not known; for the names of the columns those of the results. None for a comment and a
    /// blank line.
    ///
    /// # Errors
    /// [`StreamError`]. Unless it [ends the stream](StreamError::ends_stream), the row is passed over and its sample
    /// missed.
    pub fn line(&mut self, line: u64, bytes: &[u8]) -> Result<Option<String>, StreamError> {
        let begins = !self.rows.knows_columns();
        let row = match self.rows.line(line, bytes) {
            Ok(Some(row)) => row,
            Ok(None) if begins && self.rows.knows_columns() => return Ok(Some(written::header(&self.names))),
            Ok(None) => return Ok(None),
            Err(error) if !self.rows.knows_columns() => return Err(StreamError::Columns(error)),
            Err(error) => {
                // Without times it is the only trace of its sample.
                if !self.is_timed && self.position.samples > 0 {
                    self.step.miss(&mut self.position);
                }
                return Err(error.into());
            }
        };
        let missed = self.missed(line, &row)?;
        let mut next = self.position.clone();
        for (j, value) in row.inputs.iter().enumerate() {
            match value {
                Some(value) => next.inputs[j] = *value,
                None if next.samples == 0 => {
                    return Err(StreamError::NoInput { line, name: self.columns.inputs[j].clone() });
                }
                None => {}
            }
        }
        if self.step.takes_time() && row.outputs.iter().all(Option::is_none) {
            return Err(StreamError::NoOutput { line });
        }
        // Inputs are held until the row that has others.
        let applied = std::mem::replace(&mut next.inputs, self.position.inputs.clone());
        for _ in 0..missed {
            self.step.miss(&mut next);
        }
        let elapsed = row.time.zip(self.position.time).map_or(0.0, |(now, before)| now - before);
        // A step at varying periods takes the inputs that were held until its sample.
        if !self.step.takes_time() || next.samples == 0 {
            next.inputs.clone_from(&applied);
        }
        let shown = self.step.take(&mut next, &row.outputs, elapsed, self.estimates);
        next.inputs = applied;
        next.time = row.time;
        if !shown.values.iter().chain(&next.state).all(|x| x.is_finite()) {
            return Err(StreamError::Diverged { line, observer: self.step.observer().to_owned() });
        }
        self.rows.accept(&row);
        self.position = next;
        let results = self.results(&shown);
        Ok(Some(match self.rows.form() {
            Some(Form::Json) => written::object(&self.names, &results),
            _ => written::row(&results),
        }))
    }

    /// How many samples have passed since the last row without one.
    fn missed(&self, line: u64, row: &LogRow) -> Result<u64, StreamError> {
        let (Some(now), Some(before)) = (row.time, self.position.time) else { return Ok(0) };
        let (elapsed, period) = (now - before, self.step.period());
        if now <= before {
            return Err(StreamError::Backwards { line, now, before });
        }
        if self.step.takes_time() {
            return Ok(0);
        }
        let periods = (elapsed / period).round();
        if periods < 1.0 {
            return Err(StreamError::TooEarly { line, now, elapsed, period });
        }
        if periods > MOST_MISSED {
            return Err(StreamError::Jump { line, now, elapsed, periods });
        }
        Ok(periods as u64 - 1)
    }

    fn results(&self, shown: &Shown) -> Vec<Option<f64>> {
        let period = self.step.period();
        let at = self.position.time.unwrap_or((self.position.samples - 1) as f64 * period);
        let t = if shown.is_of_sample { at } else { at + period };
        let band = |band: &Vec<f64>| {
            band.iter().copied().map(|x| (shown.has_bands && x.is_finite()).then_some(x)).collect::<Vec<_>>()
        };
        let values = shown.values.iter().copied().map(Some);
        std::iter::once(Some(t)).chain(values).chain(shown.bands.iter().flat_map(band)).collect()
    }

    /// Says that the results so far have been delivered.
    pub fn deliver(&mut self) {
        self.delivered.clone_from(&self.position);
        self.delivered.times = self.rows.words_of_times();
    }

    /// Number of samples so far, missed ones included.
    pub fn samples(&self) -> u64 {
        self.position.samples
    }

    /// The state after the last row that was delivered, as a text from which [`resume`](Self::resume) goes on with the
    /// same bits.
    pub fn saved(&self) -> String {
        self.delivered.saved(&self.subject, self.step.observer())
    }

    /// Goes on from a saved state.
    ///
    /// # Errors
    /// [`ResumeError`] for a text that is not one, is damaged, or is of another study or observer; nothing has changed
    /// then.
    pub fn resume(&mut self, text: &str) -> Result<(), ResumeError> {
        let position = Position::of_saved(text, &self.subject, &self.delivered)?;
        if !self.rows.resume_times(&position.times) {
            return Err(ResumeError::Damaged);
        }
        self.delivered = position.clone();
        self.position = position;
        Ok(())
    }
}
