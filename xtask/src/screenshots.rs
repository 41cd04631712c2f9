//! The pictures of README, from the reports that the commands write.

use std::fs;
use std::path::Path;

use crate::live::{browser, chromium, of_template};
use crate::step::{Failure, build_command, reproduction, root, target};

/// The study whose report is photographed.
const TEMPLATE: &str = "double-integrator";

/// The section of the report that the picture shows, by its anchor.
const SECTION: &str = "live-simulation";

/// The size of the picture in pixels.
const SIZE: &str = "--window-size=1000,880";

/// The most bytes of a picture: they are in every clone of the repository.
const LARGEST: u64 = 200_000;

/// Writes `docs/images/cubic-fig4.png`, a figure of the papers' report, and `docs/images/report-live.png`, the section
/// of a study's report that the page simulates.
pub(crate) fn run() -> Result<(), Failure> {
    let papers = target().join("screenshots/papers");
    reproduction(&papers)?.quiet_output("papers")?;
    let figure = images("cubic-fig4.png");
    fs::copy(papers.join("figures/cubic-fig4.png"), &figure).map_err(|source| Failure::io(&figure, source))?;
    small(&figure)?;
    let Some(browser) = browser("the picture of a report") else { return Ok(()) };
    build_command()?;
    let report = of_template(TEMPLATE)?;
    let html = fs::read_to_string(&report).map_err(|source| Failure::io(&report, source))?;
    // Only the section, without the time that its simulation took. The plotting library measures text in an element of
    // its own, which has to be displayed.
    let style = format!(
        "<style>header, nav, section:not(#{SECTION}), .live-note, .anchor {{ display: none; }} \
         h2 {{ margin-top: 0; }} body {{ padding: 1.2rem; }}</style></head>"
    );
    let page = report.with_file_name("screenshot.html");
    fs::write(&page, html.replacen("</head>", &style, 1)).map_err(|source| Failure::io(&page, source))?;
    let picture = images("report-live.png");
    let to = format!("--screenshot={}", picture.display());
    chromium(browser, &[&to, SIZE, "--hide-scrollbars", "--blink-settings=preferredColorScheme=1"], &page)?;
    small(&picture)
}

fn images(name: &str) -> std::path::PathBuf {
    root().join("docs/images").join(name)
}

/// Says what was written; a picture that is missing or too large is a failure.
fn small(picture: &Path) -> Result<(), Failure> {
    let bytes = fs::metadata(picture).map_err(|source| Failure::io(picture, source))?.len();
    if bytes > LARGEST {
        return Err(Failure::Live(format!("{} has {bytes} bytes, more than {LARGEST}", picture.display())));
    }
    eprintln!("── {}: {bytes} bytes", picture.display());
    Ok(())
}
