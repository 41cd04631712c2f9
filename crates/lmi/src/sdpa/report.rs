//! A result as text and as JSON.

use super::{Outcome, Status};
use luenberger_proof::wording::{counted, shortest};

impl Status {
    /// `proved-optimal-bounds`, `proved-primal-infeasible`, `proved-dual-infeasible` or `undecided`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Bounds => "proved-optimal-bounds",
            Self::PrimalInfeasible => "proved-primal-infeasible",
            Self::DualInfeasible => "proved-dual-infeasible",
            Self::Undecided => "undecided",
        }
    }
}

impl Outcome {
    /// Two lines of text, and a third with the reason if undecided. `seconds` is the total time, including reading the
    /// file.
    pub fn sentence(&self, seconds: f64) -> String {
        let why = self.why.map_or(String::new(), |why| format!("{why}\n"));
        format!(
            "{} after {seconds:.3} s ({} of the solver, which said: {})\n{why}{} <= optimum <= {}\n",
            self.status.word(),
            counted(self.runs, "run"),
            self.word,
            shortest(self.lower),
            shortest(self.upper)
        )
    }

    /// One JSON object on one line, with `seconds` as in [`sentence`](Self::sentence): `status`, `lower`, `upper`,
    /// `primal_margin`, `seconds`, `solve_seconds`, `verify_seconds`, `runs`, `reason`. An infinite bound is null, and
    /// so is `reason` if the program is decided.
    ///
    /// ```
    /// use luenberger_lmi::sdpa;
    /// let program = sdpa::read("1\n1\n2\n1.0\n0 1 1 2 -1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n".as_bytes())?;
    /// let found = sdpa::solve(&program, &Default::default());
    /// assert!(found.json(0.1).starts_with("{ \"status\": \"proved-optimal-bounds\", \"lower\": 9.99"));
    /// # Ok::<(), sdpa::ReadError>(())
    /// ```
    pub fn json(&self, seconds: f64) -> String {
        let number = |x: f64| if x.is_finite() { format!("{x:e}") } else { "null".to_owned() };
        format!(
            "{{ \"status\": \"{}\", \"lower\": {}, \"upper\": {}, \"primal_margin\": {}, \"seconds\": {seconds}, \"solve_seconds\": {}, \"verify_seconds\": {}, \"runs\": {}, \"reason\": {} }}",
            self.status.word(),
            number(self.lower),
            number(self.upper),
            self.primal_margin.map_or("null".to_owned(), number),
            self.solving.as_secs_f64(),
            self.verifying.as_secs_f64(),
            self.runs,
            self.why.map_or("null".to_owned(), |why| format!("\"{why}\""))
        )
    }
}
