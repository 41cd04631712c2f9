//! The section in which the page runs the experiment itself.

use luenberger_figures::{Section, colours};
use luenberger_live::{Experiment, page};

use crate::error::StudyError;
use crate::results::ObserverReport;

/// Sliders, figures, scores and verdicts, and which observers are not among them. `observers` are those of the study,
/// in whose order the figures of the report have their colours.
pub(super) fn section(
    experiment: &Experiment,
    omitted: &[String],
    observers: &[ObserverReport],
) -> Result<Section, StudyError> {
    let palette = colours();
    let place = |name: &str| observers.iter().position(|of| of.name == name).unwrap_or_default();
    let own = experiment.observers.iter().map(|of| palette[place(&of.name) % palette.len()].clone());
    let block = page::html_block("live", experiment, &own.collect::<Vec<_>>())
        .map_err(|why| StudyError::Output { what: "report.html".to_owned(), why: why.to_string() })?;
    let section = Section::new("Live simulation").prose(
        "This page contains the simulation, the observers and the verification of their certificates, compiled to \
         WebAssembly. Each slider is a factor of the value in the study. With other gains the inequalities of the \
         certificate are evaluated again, with the same P: not certified means that this P does not prove \
         convergence, not that the observer diverges.",
    );
    let section = if experiment.observers.iter().any(|observer| observer.hypotheses.is_some()) {
        section.prose(
            "The certificate of an interval observer is for bounded noise and first errors. Where a slider goes beyond \
             them, or the noise is Gaussian, it is not certified.",
        )
    } else {
        section
    };
    let section = match &experiment.truth {
        Some(_) => section.prose(
            "The simulated plant is that of `[truth]`. The certificates are about the plant that the observers are \
             designed for.",
        ),
        None => section,
    };
    let section = section.html(block);
    if omitted.is_empty() {
        return Ok(section);
    }
    Ok(section.prose(format!("Not simulated in this page, which has no code for them: {}.", omitted.join(", "))))
}

/// Why there is nothing to try.
pub(super) fn absent(why: &str) -> Section {
    Section::new("Live simulation").prose(format!("The page of this report does not simulate this study: {why}."))
}
