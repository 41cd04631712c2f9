//! The samples of observers at varying periods: what a run drew or a log has, and whether convergence is proved for it.

use luenberger_design::Periods;
use luenberger_proof::wording::{counted, significant};
use luenberger_sim::{SampleTime, Samples};

use crate::results::{LogSampling, SamplingReport};
use crate::study::{Simulation, Study};
use crate::trajectory::Member;

/// Periods are differences of times, with their rounding.
const ROUNDING: f64 = 1e-9;

/// A sample outside of the periods and misses for which convergence is proved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outside {
    pub(super) t: f64,
    /// The quantity, with its value and the bounds.
    pub(super) name: &'static str,
    pub(super) value: f64,
    pub(super) bounds: (f64, f64),
}

/// The period before each sample, and how many were missed in a row up to it and with it.
fn drawn(samples: &[SampleTime]) -> impl Iterator<Item = (f64, f64, usize)> {
    samples.iter().scan((0.0, 0), |(before, missed), sample| {
        let period = sample.time - *before;
        *before = sample.time;
        *missed = if sample.arrives { 0 } else { *missed + 1 };
        Some((sample.time, period, *missed))
    })
}

/// The samples of a run from t = 0 that are outside.
pub(super) fn outside(samples: &[SampleTime], periods: &Periods) -> Vec<Outside> {
    let Periods { shortest, longest, misses } = *periods;
    let slack = ROUNDING * longest;
    let of = |(t, period, missed): (f64, f64, usize)| {
        if period < shortest - slack || period > longest + slack {
            return Some(Outside { t, name: "the sampling period", value: period, bounds: (shortest, longest) });
        }
        let (name, value) = ("the number of samples missed in a row", missed as f64);
        (missed > misses).then_some(Outside { t, name, value, bounds: (0.0, misses as f64) })
    };
    let partly = samples.iter().filter(|sample| sample.arrives && sample.absent > 0).map(|sample| Outside {
        t: sample.time,
        name: "the number of outputs missing from a sample",
        value: sample.absent as f64,
        bounds: (0.0, 0.0),
    });
    let mut all: Vec<Outside> = drawn(samples).filter_map(of).chain(partly).collect();
    all.sort_by(|a, b| a.t.total_cmp(&b.t));
    all
}

/// What the rows of a log are as samples; none for other observers, and with fewer than two corrections.
///
/// A sample that is missed leaves no trace but a longer time between two corrections: g is within the design if
/// `(m + 1) shortest <= g <= (m + 1) longest` for some number m of misses that is allowed.
pub(super) fn on_log(study: &Study, member: &Member<'_>, outputs: &Samples) -> Option<LogSampling> {
    let periods = member.requested.kind.varying_periods()?;
    let Periods { shortest, longest, misses } = *periods;
    let measured = |k: usize| (0..outputs.values().ncols()).filter(|&j| outputs.value(k, j).is_some()).count();
    let corrections: Vec<(f64, usize)> =
        outputs.times().iter().enumerate().map(|(k, t)| (*t, measured(k))).filter(|(_, count)| *count > 0).collect();
    let all: Vec<(f64, f64, usize)> = corrections
        .windows(2)
        .map(|pair| {
            let g = pair[1].0 - pair[0].0;
            (pair[1].0, g, ((g / longest - ROUNDING).ceil() - 1.0).max(0.0) as usize)
        })
        .collect();
    let lengths = || all.iter().map(|(_, g, _)| *g);
    let (least, most) = (lengths().fold(f64::INFINITY, f64::min), lengths().fold(0.0, f64::max));
    let in_a_row = all.iter().map(|(.., m)| *m).max()?;
    let missed: usize = all.iter().map(|(.., m)| *m).sum();
    let unit = study.plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
    let width = outputs.values().ncols();
    let too_far = all.iter().filter_map(|&(t, g, m)| {
        let is_within = m <= misses && (m + 1) as f64 * shortest <= g + ROUNDING * longest;
        let why = || format!("the last correction is {}{unit} ago", significant(g, 4));
        (!is_within).then(|| (t, why()))
    });
    let partly = corrections.iter().filter(|(_, count)| *count < width);
    let partly = partly.map(|(t, count)| (*t, format!("{} missing", counted(width - count, "output"))));
    let mut outside: Vec<(f64, String)> = too_far.chain(partly).collect();
    outside.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_proved = member.designed.report.verdict.is_proved();
    let verdict = match (outside.first(), is_proved) {
        (None, true) => format!("Convergence is proved for them: {periods}."),
        (None, false) => format!("They are within those of the design, {periods}, for which nothing is proved."),
        (Some((t, why)), _) => {
            let more = match outside.len() - 1 {
                0 => String::new(),
                more => format!("; the same holds for {more} more"),
            };
            let of = if is_proved { "those for which convergence is proved" } else { "those of the design" };
            format!("Not all are within {of}, {periods}: at t = {}{unit} {why}{more}.", significant(*t, 6))
        }
    };
    let words = format!(
        "{}: {} at the rows of the log, {} to {}{unit} apart: at least {missed} missed, at most {in_a_row} in a row. {verdict}",
        member.requested.name,
        counted(corrections.len(), "correction"),
        significant(least, 4),
        significant(most, 4),
    );
    Some(LogSampling {
        corrections: corrections.len(),
        shortest: least,
        longest: most,
        missed,
        missed_in_a_row: in_a_row,
        outside: outside.len(),
        words,
    })
}

/// The samples of a run in numbers and words; none for other observers, and without a sample.
pub(super) fn report(
    study: &Study,
    simulation: &Simulation,
    member: &Member<'_>,
    samples: &[SampleTime],
) -> Option<SamplingReport> {
    let periods = member.requested.kind.varying_periods()?;
    let all: Vec<_> = drawn(samples).collect();
    let lengths = || all.iter().map(|(_, period, _)| *period);
    let (shortest, longest) = (lengths().fold(f64::INFINITY, f64::min), lengths().fold(0.0, f64::max));
    let missed = samples.iter().filter(|sample| !sample.arrives).count();
    let in_a_row = all.iter().map(|(_, _, missed)| *missed).max()?;
    let seed = simulation.sampling.seed;
    let is_within = outside(samples, periods).is_empty();
    let unit = study.plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
    let verdict = match (is_within, member.designed.report.verdict.is_proved()) {
        (true, true) => format!("Convergence is proved for them: {periods}."),
        (true, false) => format!("They are within those of the design, {periods}, for which nothing is proved."),
        (false, true) => format!("They are not within those for which convergence is proved: {periods}."),
        (false, false) => format!("They are not within those of the design, {periods}, for which nothing is proved."),
    };
    let words = format!(
        "{}: {} at periods from {} to {}{unit}, {missed} missed, at most {in_a_row} in a row (seed {seed}). {verdict}",
        member.requested.name,
        counted(samples.len(), "sample"),
        significant(shortest, 4),
        significant(longest, 4),
    );
    Some(SamplingReport {
        observer: member.requested.name.clone(),
        samples: samples.len(),
        missed,
        missed_in_a_row: in_a_row,
        shortest,
        longest,
        seed,
        within_design: is_within,
        words,
    })
}
