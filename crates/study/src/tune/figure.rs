//! The profile likelihoods as a figure.

use luenberger_figures::{Dash, Figure, Hue, Mark, Marker, Panel, Series};

use super::profile::DROP;
use super::report::TuneReport;
use crate::results::with_unit;

const CAPTION: &str = "Profile log-likelihoods: the largest log-likelihood for each value of a parameter, less that of all. Where it is above the line lies the 95 % interval. Dashed: the parabola of the standard error; where the two differ, the interval of the profile is the better one.";

/// None without profiles.
pub(super) fn profiles(report: &TuneReport) -> Option<Figure> {
    let panel = |profile: &super::Profile| {
        let unit = report.parameters.iter().find(|one| one.name == profile.name).and_then(|one| one.unit.as_ref());
        let mut panel = Panel::new(with_unit(&profile.name, unit), "log-likelihood - largest")
            .series(
                Series::line("profile", &profile.values, &profile.log_likelihood)
                    .hue(Hue::Palette(0))
                    .marker(Marker::Circle),
            )
            .mark(Mark::horizontal(-DROP).label("95 %"));
        if !profile.parabola.is_empty() {
            let parabola = Series::line("standard error", &profile.values, &profile.parabola);
            panel = panel.series(parabola.hue(Hue::Grey).dash(Dash::Dashed));
        }
        if profile.is_log { panel.log_x() } else { panel }
    };
    if report.profiles.is_empty() {
        return None;
    }
    let figure = Figure::new("Profile likelihoods").caption(CAPTION).columns(2);
    Some(report.profiles.iter().map(panel).fold(figure, Figure::panel))
}
