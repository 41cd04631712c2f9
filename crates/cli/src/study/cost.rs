//! Estimated computing time of a study, reported before it starts. There is no prompt; Ctrl-C aborts.

use luenberger_study::{Estimate, Step, Study, estimate};
use std::io::Write;
use std::thread::available_parallelism;

/// Estimates below this many seconds are not reported.
const WORTH_SAYING: f64 = 10.0;

/// Reports the estimated time of the step on standard error, if it is long.
pub(super) fn announce(study: &Study, step: Step, threads: Option<usize>) {
    let cost = estimate(study, step);
    if cost.seconds >= WORTH_SAYING {
        let threads = threads.unwrap_or_else(|| available_parallelism().map_or(1, usize::from));
        _ = writeln!(std::io::stderr(), "{}", sentence(&cost, threads));
    }
}

fn sentence(cost: &Estimate, threads: usize) -> String {
    let Estimate { runs, seconds, mostly } = cost;
    let share = if threads > 1 { format!(", shared by {threads} threads where it can be") } else { String::new() };
    format!(
        "this takes about {} on one thread{share} ({runs} runs; the {mostly} take most of it); Ctrl-C leaves what is finished on disk",
        rounded(*seconds)
    )
}

/// Order of magnitude: one digit, in the largest unit of which there is at least one.
fn rounded(seconds: f64) -> String {
    const UNITS: [(f64, &str); 4] = [(86400.0, "day"), (3600.0, "hour"), (60.0, "minute"), (1.0, "second")];
    let (unit, name) = UNITS.into_iter().find(|(unit, _)| seconds >= *unit).unwrap_or((1.0, "second"));
    let count = (seconds / unit).max(1.0);
    let digit = 10f64.powf(count.log10().floor());
    let count = (count / digit).round() * digit;
    format!("{count} {name}{}", if count == 1.0 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_of_magnitude_in_words() {
        let words = [(0.2, "1 second"), (12.3, "10 seconds"), (61.0, "1 minute"), (3500.0, "60 minutes")];
        let more = [(7300.0, "2 hours"), (86400.0 * 365.0, "400 days"), (86400.0, "1 day")];
        for (seconds, expected) in words.into_iter().chain(more) {
            assert_eq!(rounded(seconds), expected);
        }
        let cost = Estimate { runs: 12000, seconds: 9000.0, mostly: "runs".to_owned() };
        assert_eq!(
            sentence(&cost, 1),
            "this takes about 3 hours on one thread (12000 runs; the runs take most of it); Ctrl-C leaves what is finished on disk"
        );
        assert!(sentence(&cost, 8).contains("on one thread, shared by 8 threads where it can be (12000 runs;"));
    }
}
