//! Names of states, inputs and outputs in messages: `x2` or `speed`.
//!
//! Messages are created in many places, from indices of states counted from 0, with the user's names. [`Names::with`]
//! sets the names on this thread while messages are created.

use std::cell::RefCell;

/// What the states, inputs and outputs of a plant are called. Where a list has no entry there is `x1`, `u1`, `y1`,
/// counted from 1.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Names {
    /// Of the states.
    pub states: Vec<String>,
    /// Of the inputs.
    pub inputs: Vec<String>,
    /// Of the outputs.
    pub outputs: Vec<String>,
}

thread_local! {
    static NAMES: RefCell<Names> = RefCell::default();
}

/// Puts the previous names back when it is dropped.
struct Restore(Names);

impl Drop for Restore {
    fn drop(&mut self) {
        let previous = std::mem::take(&mut self.0);
        NAMES.with(|names| names.replace(previous));
    }
}

impl Names {
    /// The result of `f`, with these names in all messages of this crate that it creates.
    ///
    /// ```
    /// use luenberger_design::{Names, Region};
    /// let names = Names { states: vec!["angle".to_owned()], ..Names::default() };
    /// let region = Region::new(&[(-1.0, 1.0), (0.0, 2.0)]);
    /// assert_eq!(names.with(|| region.to_string()), "angle in [-1, 1], x2 in [0, 2]");
    /// assert_eq!(region.to_string(), "x1 in [-1, 1], x2 in [0, 2]");
    /// ```
    pub fn with<R>(&self, f: impl FnOnce() -> R) -> R {
        let _restore = Restore(NAMES.with(|names| names.replace(self.clone())));
        f()
    }
}

/// The name of the state, from 0.
pub(crate) fn state(k: usize) -> String {
    name(|names| &names.states, 'x', k)
}

/// The name of the input, from 0.
pub(crate) fn input(k: usize) -> String {
    name(|names| &names.inputs, 'u', k)
}

/// The name of the output, from 0.
pub(crate) fn output(k: usize) -> String {
    name(|names| &names.outputs, 'y', k)
}

fn name(list: impl Fn(&Names) -> &Vec<String>, letter: char, k: usize) -> String {
    NAMES.with(|names| list(&names.borrow()).get(k).cloned()).unwrap_or_else(|| format!("{letter}{}", k + 1))
}

/// The derivative of a row of f, or of an output, by a state: `df1/dx2`, or `d(angle')/d(speed)` where states or
/// outputs have names.
pub(crate) fn derivative(of_output: bool, row: usize, column: usize) -> String {
    let letter = if of_output { 'h' } else { 'f' };
    let above = if of_output { output(row) } else { state(row) };
    let numbered = |name: &str, letter: char, k: usize| name == format!("{letter}{}", k + 1);
    let below = state(column);
    if numbered(&below, 'x', column) && numbered(&above, if of_output { 'y' } else { 'x' }, row) {
        return format!("d{letter}{}/dx{}", row + 1, column + 1);
    }
    let rate = if of_output { "" } else { "'" };
    format!("d({above}{rate})/d({below})")
}
