//! Comparisons that are undecided on a box: all branches are evaluated.
//!
//! A right-hand side that branches (`if d < 1 { .. } else { .. }`) takes one branch at some points of a box and the
//! other at others. The comparison of overlapping intervals therefore returns an answer from a script, and the
//! right-hand side is evaluated again until all answers have been used: for each point of the box, one of the
//! evaluations takes the branches of that point. An operation that is undefined somewhere on the box is recorded in the
//! same place, so that its result is never used.
//!
//! The script is thread-local because a comparison has no other access to it; a nested exploration restores the outer
//! one when it ends, also by a panic. A comparison on a thread without a script (a right-hand side that starts threads)
//! is counted, and no exploration that ran at the same time has a result.

use core::cell::RefCell;
use core::sync::atomic::{AtomicUsize, Ordering};

/// How many runs one evaluation may take: six open comparisons in a row.
pub(super) const MAX_RUNS: usize = 64;

/// The longest script. A loop that ends on a comparison gets alternating answers beyond it, so that it ends.
const MAX_DECISIONS: usize = 256;

/// Why an evaluation over a box has no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Undefined {
    /// This operation is not defined, or jumps, or is not bounded, at some point of the box.
    Operation(&'static str),
    /// The right-hand side has too many branches that the box leaves open.
    TooManyBranches,
}

/// The longest recorded script. A path with more comparisons cannot be repeated at another point.
const MAX_TRACE: usize = 4096;

#[derive(Default)]
struct Script {
    answers: Vec<bool>,
    next: usize,
    undefined: Option<Undefined>,
    steered: bool,
    /// The answers to all comparisons of this run, also to those that the operands decide.
    trace: Vec<bool>,
    /// The answers to all comparisons, whatever the operands are.
    forced: Option<Vec<bool>>,
}

impl Script {
    /// The next answer; `decided` is that of the operands, if they have one.
    fn answer(&mut self, decided: Option<bool>) -> bool {
        let answer = match (&self.forced, decided) {
            (Some(forced), _) => forced.get(self.trace.len()).copied(),
            (None, Some(answer)) => Some(answer),
            (None, None) => Some(self.open()),
        };
        // More questions than on the way that is followed: it is another way.
        let answer = answer.unwrap_or_else(|| {
            self.undefined = Some(Undefined::TooManyBranches);
            self.trace.len().is_multiple_of(2)
        });
        if self.trace.len() <= MAX_TRACE {
            self.trace.push(answer);
        }
        answer
    }

    fn open(&mut self) -> bool {
        let at = self.next;
        self.next += 1;
        if at >= MAX_DECISIONS {
            self.undefined = Some(Undefined::TooManyBranches);
            return at.is_multiple_of(2);
        }
        if at == self.answers.len() {
            self.answers.push(true);
        }
        self.answers[at]
    }
}

thread_local! {
    static SCRIPT: RefCell<Option<Script>> = const { RefCell::new(None) };
}

/// How many questions came from threads without a script.
static STRAYS: AtomicUsize = AtomicUsize::new(0);

/// Puts the previous script back when it is dropped.
struct Restore(Option<Script>);

impl Drop for Restore {
    fn drop(&mut self) {
        SCRIPT.with(|cell| cell.replace(self.0.take()));
    }
}

/// The answer to a comparison; `decided` is that of the operands, none if they leave it open.
pub fn comparison(decided: Option<bool>) -> bool {
    SCRIPT.with(|cell| match cell.borrow_mut().as_mut() {
        Some(script) => script.answer(decided),
        None => decided.unwrap_or_else(|| {
            STRAYS.fetch_add(1, Ordering::SeqCst);
            false
        }),
    })
}

/// Notes that an open comparison has operands that vary along the direction of the evaluation.
pub(super) fn note_steered() {
    SCRIPT.with(|cell| {
        if let Some(script) = cell.borrow_mut().as_mut() {
            script.steered = true;
        }
    });
}

/// Whether the way that this run takes may depend on the coordinate along which it is evaluated. Where it does not, a
/// result with the slope 0 does not depend on it either.
pub(crate) fn steered() -> bool {
    SCRIPT.with(|cell| cell.borrow().as_ref().is_none_or(|script| script.steered))
}

/// Notes that an operation has no result on this box.
pub fn note_undefined(operation: &'static str) {
    SCRIPT.with(|cell| match cell.borrow_mut().as_mut() {
        Some(script) => {
            script.undefined.get_or_insert(Undefined::Operation(operation));
        }
        None => {
            STRAYS.fetch_add(1, Ordering::SeqCst);
        }
    });
}

/// The results of all runs of `f`.
///
/// # Errors
/// The first operation without a result on the box, or too many runs.
pub fn explore<R>(f: impl FnMut() -> R) -> Result<Vec<R>, Undefined> {
    Ok(explore_ways(f)?.into_iter().map(|(result, _)| result).collect())
}

/// A way through the comparisons of a right-hand side: the answers to all of them.
pub struct Way(Vec<bool>);

/// As [`explore`], each result with its way.
///
/// # Errors
/// As [`explore`].
pub fn explore_ways<R>(mut f: impl FnMut() -> R) -> Result<Vec<(R, Way)>, Undefined> {
    let mut results = Vec::new();
    let ways = all_ways(&mut || results.push(f()))?;
    Ok(results.into_iter().zip(ways).collect())
}

/// Runs `f` on every way.
fn all_ways(f: &mut dyn FnMut()) -> Result<Vec<Way>, Undefined> {
    let mut answers = Vec::new();
    let mut ways = Vec::new();
    loop {
        let script = run(Script { answers, ..Script::default() }, f)?;
        ways.push(Way(script.trace));
        answers = script.answers;
        // A run that asked fewer questions than its script has answers did not depend on the rest.
        answers.truncate(script.next);
        while answers.last() == Some(&false) {
            answers.pop();
        }
        match answers.last_mut() {
            None => return Ok(ways),
            Some(_) if ways.len() >= MAX_RUNS => return Err(Undefined::TooManyBranches),
            Some(last) => *last = false,
        }
    }
}

/// The result of `f` on this way, at whatever point: the formula of one branch, on either side. `None` where it has no
/// value there, or where the way is not known to its end.
pub fn follow<R>(way: &Way, mut f: impl FnMut() -> R) -> Option<R> {
    if way.0.len() > MAX_TRACE {
        return None;
    }
    let script = Script { forced: Some(way.0.clone()), ..Script::default() };
    let mut result = None;
    run(script, &mut || result = Some(f())).ok()?;
    result
}

/// One run with a script; the script after it.
fn run(script: Script, f: &mut dyn FnMut()) -> Result<Script, Undefined> {
    let restore = Restore(SCRIPT.with(|cell| cell.replace(Some(script))));
    let strays = STRAYS.load(Ordering::SeqCst);
    f();
    let script = SCRIPT.with(|cell| cell.borrow_mut().take()).unwrap_or_default();
    drop(restore);
    if let Some(undefined) = script.undefined {
        return Err(undefined);
    }
    if STRAYS.load(Ordering::SeqCst) != strays {
        return Err(Undefined::Operation("a comparison in another thread"));
    }
    Ok(script)
}
