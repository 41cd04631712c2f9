//! `luenberger stream`: an observer on the rows of standard input.

use super::file::read;
use super::interrupt;
use crate::answer::Answer;
use crate::arguments::{RowFormat, StreamInput};
use crate::failure::Failure;
use crate::input::Source;
use crate::output;
use luenberger_proof::wording::counted;
use luenberger_study::StudyError;
use luenberger_study::stream::{Stream, StreamError, StreamOptions};
use luenberger_study::table::Form;
use std::io::{self, BufRead, Read};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

/// The longest line, in bytes.
const LONGEST: usize = 1 << 20;

/// After so many rows the state is saved.
const SAVED: u64 = 1000;

/// So many rows that cannot be used are reported one by one.
const REPORTED: u64 = 20;

/// How often Ctrl-C is looked for while no row arrives.
const LOOK: Duration = Duration::from_millis(50);

/// A line of standard input, without its end; none for one that is too long.
type Line = io::Result<Option<Vec<u8>>>;

pub(crate) fn stream(input: &StreamInput) -> Result<Answer, Failure> {
    if input.study == Source::Standard {
        return Err(Failure::Usage("the study is read from a file: standard input has the rows"));
    }
    let study = read(&input.study)?;
    let options = StreamOptions {
        form: input.format.map(|format| match format {
            RowFormat::Csv => Form::Csv,
            RowFormat::Json => Form::Json,
        }),
        timed: !input.untimed,
        predicted: input.predicted.then_some(true),
        period: input.period,
        substeps: input.substeps.map(usize::from),
    };
    let mut stream = Stream::new(&study, input.observer.as_deref(), &options)?;
    let state = input.state.as_deref();
    if let Some(path) = state {
        resume(&mut stream, path)?;
        // What cannot be written is found before the first row.
        save(&stream, path)?;
    }
    let ended = rows(&mut stream, input);
    if let Some(path) = state {
        save(&stream, path)?;
    }
    ended
}

/// The rows until the input ends, the output is closed, Ctrl-C, or a row that ends the stream.
fn rows(stream: &mut Stream, input: &StreamInput) -> Result<Answer, Failure> {
    let interrupted = interrupt::flag();
    let lines = lines();
    let (mut line, mut answers, mut refused) = (0, 0, 0);
    // The names of the columns are an answer of no row.
    let mut is_used = false;
    loop {
        if interrupted.load(Ordering::Relaxed) {
            return Err(StudyError::Interrupted.into());
        }
        let bytes = match lines.recv_timeout(LOOK) {
            Ok(bytes) => bytes.map_err(|error| Failure::Read { origin: Source::Standard.to_string(), error })?,
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => break,
        };
        line += 1;
        let before = stream.samples();
        let answered = match bytes {
            Some(bytes) => stream.line(line, &bytes).map_err(Failure::from),
            None => Err(Failure::Line { line, limit: LONGEST }),
        };
        match answered {
            Ok(None) => {}
            Ok(Some(text)) => {
                if let Err(error) = output::text(&text) {
                    return Ok(Answer::delivered(output::failed(&error, ExitCode::SUCCESS)));
                }
                stream.deliver();
                answers += 1;
                is_used |= stream.samples() > before;
                if let Some(path) = input.state.as_deref().filter(|_| answers % SAVED == 0) {
                    save(stream, path)?;
                }
            }
            Err(failure) if input.strict || ends(&failure) => return Err(failure),
            Err(failure) => {
                refused += 1;
                if refused <= REPORTED {
                    output::say(&format!("passed over: {failure}"));
                }
                if refused == REPORTED {
                    output::say("further rows that cannot be used are only counted");
                }
            }
        }
    }
    if refused > 0 && !is_used {
        return Err(Failure::NoRow { refused });
    }
    if refused > 0 {
        output::say(&format!("note: {} of {} passed over", refused, counted(line as usize, "line")));
    }
    for name in stream.unseen() {
        output::say(&format!("note: `{name}` did not occur in any row"));
    }
    Ok(Answer::delivered(ExitCode::SUCCESS))
}

/// Whether no later row has an answer.
fn ends(failure: &Failure) -> bool {
    matches!(failure, Failure::Row(error) if StreamError::ends_stream(error))
}

/// The lines of standard input, read by a thread of its own: reading cannot be interrupted.
fn lines() -> Receiver<Line> {
    let (sender, receiver) = sync_channel(64);
    std::thread::spawn(move || {
        let mut input = io::stdin().lock();
        while let Some(line) = next(&mut input) {
            let is_last = line.is_err();
            if sender.send(line).is_err() || is_last {
                return;
            }
        }
    });
    receiver
}

/// The next line; none at the end of the input.
fn next(input: &mut impl BufRead) -> Option<Line> {
    let mut bytes = Vec::new();
    match input.by_ref().take(LONGEST as u64 + 1).read_until(b'\n', &mut bytes) {
        Err(error) => return Some(Err(error)),
        Ok(0) => return None,
        Ok(_) => {}
    }
    if bytes.ends_with(b"\n") {
        bytes.pop();
        if bytes.ends_with(b"\r") {
            bytes.pop();
        }
    } else if bytes.len() > LONGEST {
        // The rest of it.
        return Some(input.skip_until(b'\n').map(|_| None));
    }
    Some(Ok(Some(bytes)))
}

/// Goes on from a saved state, if there is one.
fn resume(stream: &mut Stream, path: &Path) -> Result<(), Failure> {
    let origin = || path.display().to_string();
    match std::fs::read(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(Failure::Read { origin: origin(), error }),
        Ok(bytes) => {
            stream
                .resume(&String::from_utf8_lossy(&bytes))
                .map_err(|error| Failure::State { path: origin(), error })?;
            output::say(&format!(
                "note: goes on from {} after {}",
                origin(),
                counted(stream.samples() as usize, "sample")
            ));
            Ok(())
        }
    }
}

fn save(stream: &Stream, path: &Path) -> Result<(), Failure> {
    output::replace(path, &stream.saved()).map_err(|error| Failure::Write { path: path.display().to_string(), error })
}
