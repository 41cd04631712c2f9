//! Tests of the HTML report.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::GzDecoder;
use luenberger_figures::report::ReportError;
use luenberger_figures::{Cell, Figure, Formula, Grid, Panel, Report, Section, Series, Tone, unpacked};
use sha2::{Digest, Sha256};

fn errors(name: &str) -> Figure {
    let panel = Panel::new("time t (s)", "error e (m)").series(Series::line(name, &[0.0, 1.0], &[1.0, 0.1]));
    Figure::new("Errors").caption("From e(0) = 1.").panel(panel)
}

fn report() -> Report {
    Report::new("Study of <plant>")
        .lead("First.\n\nSecond: `x < y`, and a lone ` stays.")
        .numbers_as(&["csv", "npz"])
        .section(
            Section::new("What is seen")
                .facts([("rank", Cell::from(3usize)), ("margin", Cell::number("-2.5e-9")), ("by", Cell::from("y & z"))])
                .grid(
                    Grid::new(&["observer", "rms (m)", "verdict"])
                        .caption("Over 8 s")
                        .row([Cell::from("</script>"), Cell::number("0.125"), Cell::badge("proved", Tone::Good)])
                        .row([Cell::from("cubic"), Cell::number("–"), Cell::badge("undecided", Tone::Open)]),
                ),
        )
        .section(
            Section::new("What is seen")
                .heading("Files")
                .list(["one", "two"])
                .verbatim("a <\n  b")
                .figure("errors", errors("e </script>"))
                .links([("study.json", "all numbers")]),
        )
}

/// Tags that are opened and closed, in their order; the script of plotly is left out.
fn balanced(html: &str) {
    let body = &html[html.find("<body>").unwrap()..html.find("<script type=\"text/plain\"").unwrap()];
    let mut open: Vec<&str> = Vec::new();
    for tag in body.split('<').skip(1) {
        let name = tag.split([' ', '>']).next().unwrap();
        match name.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "in {tag}"),
            None if name == "img" => {}
            None => open.push(name),
        }
    }
    assert_eq!(open, ["body"]);
}

#[test]
fn text_is_text_and_every_element_is_closed() {
    let html = report().html().unwrap();
    balanced(&html);
    for part in [
        "<title>Study of &lt;plant&gt;</title>",
        "<p class=\"lead\">First.</p><p class=\"lead\">Second: <code>x &lt; y</code>, and a lone ` stays.</p>",
        "<a href=\"#what-is-seen\">What is seen</a> <a href=\"#what-is-seen-2\">",
        "<dt>margin</dt><dd>−2.5e−9</dd>",
        "<dd>y &amp; z</dd>",
        "<td>&lt;/script&gt;</td><td class=\"number\">0.125</td><td><span class=\"badge good\">proved</span></td>",
        "<th>observer</th><th class=\"number\">rms (m)</th>",
        "<pre><code>a &lt;\n  b</code></pre>",
        "<a href=\"data/errors.csv\">CSV</a> <a href=\"data/errors.npz\">NPZ</a>",
        "<a href=\"study.json\"><code>study.json</code></a> all numbers",
    ] {
        assert!(html.contains(part), "{part}");
    }
}

#[test]
fn the_page_is_the_same_every_time_and_loads_nothing() {
    let html = report().html().unwrap();
    assert_eq!(html, report().html().unwrap());
    // Everything except the plotting library, which contains addresses in its text but loads none of them.
    let library = html.rfind("</script>\n<script>\n").unwrap();
    let own = [&html[..html.find("</script>").unwrap()], &html[library..]].concat();
    for address in ["http:", "https:", "//cdn", "@import", "url("] {
        assert!(!own.contains(address), "{address}");
    }
    let pictures: serde_json::Value = serde_json::from_slice(&unpacked(&html, "pictures").unwrap()).unwrap();
    assert_eq!(pictures["errors"]["data"][0]["name"], "e </script>");
}

#[test]
fn a_report_that_makes_no_sense_is_refused() {
    let with = |section| Report::new("").section(section).html().unwrap_err();
    assert!(matches!(
        with(Section::new("").figure("a", errors("e")).figure("a", errors("e"))),
        ReportError::Duplicate { id } if id == "a"
    ));
    assert!(matches!(
        with(Section::new("").figure("a", Figure::new(""))),
        ReportError::Figure { id, .. } if id == "a"
    ));
    let grid = Grid::new(&["a", "b"]).row(["1", "2"]).row(["3"]);
    assert!(matches!(with(Section::new("").grid(grid)), ReportError::Ragged { row: 2, expected: 2, found: 1, .. }));
}

#[test]
fn sections_and_figures_never_share_an_anchor() {
    let html = Report::new("")
        .section(Section::new("Errors").figure("errors", errors("e")))
        .section(Section::new("Δ"))
        .section(Section::new("Pictures"))
        .html()
        .unwrap();
    for id in ["errors", "errors-2", "section", "pictures", "pictures-2"] {
        assert_eq!(html.matches(&format!(" id=\"{id}\"")).count(), 1, "{id}");
    }
}

/// User-supplied HTML, style sheet and script are unchanged in the page, after the default ones.
#[test]
fn a_report_takes_html_of_ones_own() {
    let report = Report::new("").head("<p id=\"head\"></p>").with("b { x: y }", "own();");
    let html = report.section(Section::new("Own").html("<b>1 &lt; 2</b>")).html().unwrap();
    balanced(&html);
    assert!(html.contains("<p id=\"head\"></p></header><nav") && html.contains("</h2><b>1 &lt; 2</b></section>"));
    assert!(html.contains("b { x: y }</style>") && html.contains("own();</script>"));
}

/// Formulas are MathML with LaTeX beside it; folded contents and headings can be linked.
#[test]
fn formulas_folded_contents_and_links() {
    let matrix = Formula::matrix("L", &[vec!["-2".to_owned(), "1".to_owned()]]);
    let section = Section::new("Gain <L>").heading("The gain").formulas([matrix]);
    let html = Report::new("").section(section.folded("More & more", Section::new("").prose("inside"))).html().unwrap();
    balanced(&html);
    assert!(html.contains("<math display=\"block\" alttext=\"L = \\begin{bmatrix} -2 &amp; 1 \\end{bmatrix}\">"));
    assert!(html.contains("<mn>−2</mn>") && html.contains("<annotation encoding=\"application/x-tex\">L = "));
    assert!(html.contains("<details><summary>More &amp; more</summary><p>inside</p></details>"));
    assert!(html.contains("<h3 id=\"the-gain\">") && html.contains("href=\"#the-gain\""));
    assert!(html.contains("aria-label=\"Link to Gain &lt;L&gt;\""));
}

/// The embedded library is the file named in its README, and what a report gives its script comes back as it was.
#[test]
fn the_plotting_library_is_the_one_that_is_named() {
    let module = include_str!("../../assets/plotly-basic-3.7.0.min.js.gz.base64");
    let html = report().packed("module", module).html().unwrap();
    let script = unpacked(&html, "plotting-library").unwrap();
    let digits = format!("{:x}", Sha256::digest(&script));
    assert!(include_str!("../../assets/README.md").contains(&digits), "{digits}");
    let mut bytes = Vec::new();
    let packed = STANDARD.decode(module.split_whitespace().collect::<String>()).unwrap();
    GzDecoder::new(packed.as_slice()).read_to_end(&mut bytes).unwrap();
    assert_eq!(bytes, script);
    assert_eq!(unpacked(&html, "module"), Some(bytes));
    assert_eq!(unpacked(&html, "absent"), None);
}

/// On a terminal a verdict has its colour, and columns are as wide as without.
#[test]
fn badges_are_coloured_where_that_is_asked_for() {
    let grid = Grid::new(&["observer", "verdict", "rms"])
        .row([Cell::from("a"), Cell::badge("proved", Tone::Good), Cell::number("1")])
        .row([Cell::from("b"), Cell::badge("none", Tone::Open), Cell::best("2")]);
    let section = Section::new("All").marked_heading("a", Cell::badge("refuted", Tone::Bad)).grid(grid);
    let plain = "\na: refuted\n  observer  verdict  rms\n  a         proved   1\n  b         none     2*\n";
    assert_eq!(section.text(), plain);
    let coloured = plain
        .replace("refuted", "\x1b[31mrefuted\x1b[0m")
        .replace("proved", "\x1b[32mproved\x1b[0m")
        .replace("none", "\x1b[33mnone\x1b[0m");
    assert_eq!(section.coloured_text(), coloured);
}
