//! A report with title, sections, prose, facts, tables and figures, as one HTML file. Each section can be written as
//! plain text and as Markdown too.
//!
//! Text is escaped: a name such as `<b>` appears literally. Prose has two kinds of markup: an empty line separates
//! paragraphs, and text between backticks is code.
//!
//! The page is self-contained; it links to `figures/ID.svg`, `figures/ID.png` and `data/ID.csv` beside it, which the
//! caller writes with [`static_figure`](crate::figure::static_figure) and [`Table`](crate::Table).
//! ```
//! use luenberger_figures::{Cell, Figure, Grid, Panel, Report, Section, Series, Tone};
//!
//! let panel = Panel::new("time t (s)", "error e (m)").series(Series::line("cubic", &[0.0, 1.0], &[1.0, 0.1]));
//! let merits = Grid::new(&["observer", "rms (m)", "verdict"])
//!     .row([Cell::from("linear"), Cell::number("0.31"), Cell::badge("proved", Tone::Good)])
//!     .row([Cell::from("cubic"), Cell::number("0.12"), Cell::badge("undecided", Tone::Open)]);
//! let html = Report::new("Two observers")
//!     .lead("What each of them sees.")
//!     .section(
//!         Section::new("Comparison")
//!             .prose("Both start from `xhat = 0`.")
//!             .facts([("plant", "double integrator"), ("seed", "7")])
//!             .grid(merits)
//!             .figure("errors", Figure::new("Errors").panel(panel)),
//!     )
//!     .html()?;
//! assert!(html.contains("<td class=\"number\">0.31</td>"));
//! # Ok::<(), luenberger_figures::report::ReportError>(())
//! ```

mod text;

use crate::figure::{Figure, FigureError};
use crate::formula::Formula;
use crate::page::{Pictures, compressed, in_base85, page};
use luenberger_wording::escape;
use std::collections::HashSet;
use std::fmt::Write;

const OWN_STYLE: &str = include_str!("report.css");

/// A page with a title and sections.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    title: String,
    lead: String,
    head: String,
    style: String,
    script: String,
    packed: Vec<(String, String)>,
    numbers: Vec<String>,
    sections: Vec<Section>,
}

/// A part of the report under a heading; the page's contents link to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    title: String,
    blocks: Vec<Block>,
}

#[derive(Debug, Clone, PartialEq)]
enum Block {
    Heading(String, Option<Cell>),
    Prose(String),
    Note(String),
    Verbatim(String),
    Html(String),
    List(Vec<String>),
    Facts(Vec<(String, Cell)>),
    Grid(Grid),
    Figure { id: String, figure: Figure },
    Links(Vec<(String, String)>),
    Formulas(Vec<Formula>),
    Matrices(Vec<(String, Vec<Vec<String>>)>),
    Folded { summary: String, inside: Vec<Block> },
}

/// A table of text: a head and rows with as many cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    caption: String,
    head: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

/// Content of a cell, or of the value of a fact.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    text: String,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Text,
    Number,
    Best,
    Badge(Tone),
}

/// Tone (colour) of a badge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// The condition holds.
    Good,
    /// The condition does not hold.
    Bad,
    /// Undecided.
    Open,
    /// Not computed, because of an error.
    Failed,
}

/// Error of writing a report.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A figure that cannot be drawn.
    #[error("figure {id:?}: {source}")]
    Figure {
        /// Its id.
        id: String,
        /// The error.
        source: FigureError,
    },
    /// Two figures of one id.
    #[error("two figures have the id {id:?}")]
    Duplicate {
        /// The id.
        id: String,
    },
    /// A row of a table has more or fewer cells than its head.
    #[error("row {row} of the table with the head {head:?} has {found} cells, and the head has {expected}")]
    Ragged {
        /// The head.
        head: Vec<String>,
        /// The row, counted from 1 below the head.
        row: usize,
        /// Cells of the head.
        expected: usize,
        /// Cells of the row.
        found: usize,
    },
}

impl Report {
    /// A report without sections.
    pub fn new(title: impl Into<String>) -> Self {
        let [lead, head, style, script] = [const { String::new() }; 4];
        let numbers = vec!["csv".to_owned()];
        let (packed, sections) = (Vec::new(), Vec::new());
        Self { title: title.into(), lead, head, style, script, packed, numbers, sections }
    }

    /// HTML below the lead, before the links to the sections; user text in it must be [`escape`]d.
    #[must_use]
    pub fn head(mut self, html: impl Into<String>) -> Self {
        self.head = html.into();
        self
    }

    /// A user-supplied style sheet and script, placed after those of the page.
    #[must_use]
    pub fn with(mut self, style: impl Into<String>, script: impl Into<String>) -> Self {
        (self.style, self.script) = (style.into(), script.into());
        self
    }

    /// Data that a script of [`with`](Self::with) reads: `await unpack(id)` is a response with them. They are given as
    /// gzip in base64, and `id` is an attribute of the page's HTML.
    #[must_use]
    pub fn packed(mut self, id: &str, gzip_in_base64: &str) -> Self {
        self.packed.push((escape(id), in_base85(gzip_in_base64)));
        self
    }

    /// The same for `bytes` that are not compressed yet.
    #[must_use]
    pub fn compressed(mut self, id: &str, bytes: &[u8]) -> Self {
        self.packed.push((escape(id), compressed(bytes)));
        self
    }

    /// Prose under the title.
    #[must_use]
    pub fn lead(mut self, prose: impl Into<String>) -> Self {
        self.lead = prose.into();
        self
    }

    /// The file formats of the data of the figures (default `data/ID.csv`): extensions such as `csv`, `npz`.
    #[must_use]
    pub fn numbers_as(mut self, extensions: &[&str]) -> Self {
        self.numbers = extensions.iter().map(|&extension| extension.to_owned()).collect();
        self
    }

    /// The same report with one more section.
    #[must_use]
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// The figures with their ids, in the order of the report.
    pub fn figures(&self) -> impl Iterator<Item = (&str, &Figure)> {
        self.sections.iter().flat_map(|section| &section.blocks).filter_map(|block| match block {
            Block::Figure { id, figure } => Some((id.as_str(), figure)),
            _ => None,
        })
    }

    /// The page.
    /// # Errors
    /// [`ReportError`]: a figure that cannot be drawn, two of one id, a row that does not fit its head.
    pub fn html(&self) -> Result<String, ReportError> {
        let extensions: Vec<&str> = self.numbers.iter().map(String::as_str).collect();
        let mut pictures = Pictures::with_numbers_as(&extensions);
        let mut taken: HashSet<String> = HashSet::from(["pictures".to_owned()]);
        for (id, _) in self.figures() {
            if !taken.insert(id.to_owned()) {
                return Err(ReportError::Duplicate { id: id.to_owned() });
            }
        }
        let anchors: Vec<String> = self.sections.iter().map(|section| anchor(&section.title, &mut taken)).collect();
        let mut body = format!("<header><h1>{}</h1>", escape(&self.title));
        paragraphs(&mut body, &self.lead, " class=\"lead\"");
        body.push_str(&self.head);
        body.push_str("</header><nav aria-label=\"Contents\">");
        for (section, anchor) in self.sections.iter().zip(&anchors) {
            // Writing into a String cannot fail, hence `let _ =` here and below.
            let _ = write!(body, "<a href=\"#{anchor}\">{}</a> ", escape(&section.title));
        }
        body.push_str("</nav>");
        for (section, anchor) in self.sections.iter().zip(&anchors) {
            let link = permalink(anchor, &section.title);
            let _ = write!(body, "<section id=\"{anchor}\"><h2>{}{link}</h2>", escape(&section.title));
            for block in &section.blocks {
                block.write(&mut body, &mut pictures, &mut taken)?;
            }
            body.push_str("</section>");
        }
        for (id, letters) in &self.packed {
            let _ = write!(body, "<script type=\"text/plain\" id=\"{id}\">{letters}</script>");
        }
        let style = [OWN_STYLE, &self.style].concat();
        Ok(page(&self.title, &body, &pictures, &style, &self.script))
    }
}

impl Section {
    /// A section without contents.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), blocks: Vec::new() }
    }

    fn with(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    /// A smaller heading.
    #[must_use]
    pub fn heading(self, text: impl Into<String>) -> Self {
        self.with(Block::Heading(text.into(), None))
    }

    /// A smaller heading with a word beside it, such as a verdict.
    #[must_use]
    pub fn marked_heading(self, text: impl Into<String>, mark: Cell) -> Self {
        self.with(Block::Heading(text.into(), Some(mark)))
    }

    /// Paragraphs, with an empty line between them and code between backticks.
    #[must_use]
    pub fn prose(self, text: impl Into<String>) -> Self {
        self.with(Block::Prose(text.into()))
    }

    /// Prose that explains what stands before it; not in [`text`](Self::text).
    #[must_use]
    pub fn note(self, text: impl Into<String>) -> Self {
        self.with(Block::Note(text.into()))
    }

    /// Preformatted text in a monospaced font, such as the output of a `Display`.
    #[must_use]
    pub fn verbatim(self, text: impl Into<String>) -> Self {
        self.with(Block::Verbatim(text.into()))
    }

    /// HTML, in which user text must be [`escape`]d.
    #[must_use]
    pub fn html(self, html: impl Into<String>) -> Self {
        self.with(Block::Html(html.into()))
    }

    /// A list; code between backticks.
    #[must_use]
    pub fn list<T: Into<String>>(self, items: impl IntoIterator<Item = T>) -> Self {
        self.with(Block::List(items.into_iter().map(Into::into).collect()))
    }

    /// Names and their values.
    #[must_use]
    pub fn facts<N: Into<String>, C: Into<Cell>>(self, facts: impl IntoIterator<Item = (N, C)>) -> Self {
        self.with(Block::Facts(facts.into_iter().map(|(name, cell)| (name.into(), cell.into())).collect()))
    }

    /// A table.
    #[must_use]
    pub fn grid(self, grid: Grid) -> Self {
        self.with(Block::Grid(grid))
    }

    /// A figure; the id names its files.
    #[must_use]
    pub fn figure(self, id: impl Into<String>, figure: Figure) -> Self {
        self.with(Block::Figure { id: id.into(), figure })
    }

    /// Formulas, one below the other.
    #[must_use]
    pub fn formulas(self, formulas: impl IntoIterator<Item = Formula>) -> Self {
        self.with(Block::Formulas(formulas.into_iter().collect()))
    }

    /// Matrices by name, with their entries as they are written, row by row.
    #[must_use]
    pub fn matrices(self, matrices: impl IntoIterator<Item = (String, Vec<Vec<String>>)>) -> Self {
        self.with(Block::Matrices(matrices.into_iter().collect()))
    }

    /// The contents of a section behind a line that opens them.
    #[must_use]
    pub fn folded(self, summary: impl Into<String>, inside: Self) -> Self {
        self.with(Block::Folded { summary: summary.into(), inside: inside.blocks })
    }

    /// Links to files beside the page: the path, and what is in it.
    #[must_use]
    pub fn links<P: Into<String>, T: Into<String>>(self, links: impl IntoIterator<Item = (P, T)>) -> Self {
        self.with(Block::Links(links.into_iter().map(|(path, text)| (path.into(), text.into())).collect()))
    }
}

impl Grid {
    /// A table with this head and no rows.
    pub fn new(head: &[&str]) -> Self {
        Self { caption: String::new(), head: head.iter().map(|&text| text.to_owned()).collect(), rows: Vec::new() }
    }

    /// Caption of the table.
    #[must_use]
    pub fn caption(mut self, text: impl Into<String>) -> Self {
        self.caption = text.into();
        self
    }

    /// The same table with one more row.
    #[must_use]
    pub fn row<C: Into<Cell>>(mut self, cells: impl IntoIterator<Item = C>) -> Self {
        self.rows.push(cells.into_iter().map(Into::into).collect());
        self
    }

    fn write(&self, page: &mut String) -> Result<(), ReportError> {
        let expected = self.head.len();
        if let Some(row) = self.rows.iter().position(|row| row.len() != expected) {
            let (head, found) = (self.head.clone(), self.rows[row].len());
            return Err(ReportError::Ragged { head, row: row + 1, expected, found });
        }
        page.push_str("<div class=\"wide\"><table class=\"rows\">");
        if !self.caption.is_empty() {
            let _ = write!(page, "<caption>{}</caption>", inline(&self.caption));
        }
        page.push_str("<thead><tr>");
        for (column, text) in self.head.iter().enumerate() {
            // Numbers and their headings are right-aligned.
            let numbers = self.rows.iter().any(|row| matches!(row[column].kind, Kind::Number | Kind::Best));
            let _ = write!(page, "<th{}>{}</th>", if numbers { " class=\"number\"" } else { "" }, inline(text));
        }
        page.push_str("</tr></thead><tbody>");
        for row in &self.rows {
            page.push_str("<tr>");
            for cell in row {
                let _ = match cell.kind {
                    Kind::Number | Kind::Best => write!(page, "<td class=\"number\">{}</td>", cell.html()),
                    Kind::Text | Kind::Badge(_) => write!(page, "<td>{}</td>", cell.html()),
                };
            }
            page.push_str("</tr>");
        }
        page.push_str("</tbody></table></div>");
        Ok(())
    }
}

impl Cell {
    /// A word in a coloured frame.
    pub fn badge(text: impl Into<String>, tone: Tone) -> Self {
        Self { text: text.into(), kind: Kind::Badge(tone) }
    }

    /// A number as it is written, such as `0.31`, `1.2 ± 0.1` or `–`.
    pub fn number(text: impl Into<String>) -> Self {
        Self { text: text.into(), kind: Kind::Number }
    }

    /// A number that is the best of those it is compared with.
    pub fn best(text: impl Into<String>) -> Self {
        Self { text: text.into(), kind: Kind::Best }
    }

    fn html(&self) -> String {
        match self.kind {
            Kind::Text => inline(&self.text),
            Kind::Number => escape(&self.text.replace('-', "−")),
            Kind::Best => format!("<strong>{}</strong>", escape(&self.text.replace('-', "−"))),
            Kind::Badge(tone) => format!("<span class=\"badge {}\">{}</span>", tone.class(), escape(&self.text)),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self { text, kind: Kind::Text }
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::number(count.to_string())
    }
}

impl Tone {
    fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Bad => "bad",
            Self::Open => "open",
            Self::Failed => "failed",
        }
    }
}

impl Block {
    fn write(
        &self,
        page: &mut String,
        pictures: &mut Pictures,
        taken: &mut HashSet<String>,
    ) -> Result<(), ReportError> {
        match self {
            Self::Heading(text, mark) => {
                let anchor = anchor(text, taken);
                let mark = mark.as_ref().map(|mark| format!(" {}", mark.html())).unwrap_or_default();
                let _ = write!(page, "<h3 id=\"{anchor}\">{}{mark}{}</h3>", inline(text), permalink(&anchor, text));
            }
            Self::Formulas(formulas) => formulas_html(page, formulas.iter().map(Formula::html)),
            Self::Matrices(matrices) => {
                formulas_html(page, matrices.iter().map(|(name, rows)| Formula::matrix(name, rows).html()));
            }
            Self::Folded { summary, inside } => {
                let _ = write!(page, "<details><summary>{}</summary>", inline(summary));
                for block in inside {
                    block.write(page, pictures, taken)?;
                }
                page.push_str("</details>");
            }
            Self::Prose(text) | Self::Note(text) => paragraphs(page, text, ""),
            Self::Verbatim(text) => {
                let _ = write!(page, "<pre><code>{}</code></pre>", escape(text));
            }
            Self::Html(html) => page.push_str(html),
            Self::List(items) => {
                page.push_str("<ul>");
                for item in items {
                    let _ = write!(page, "<li>{}</li>", inline(item));
                }
                page.push_str("</ul>");
            }
            Self::Facts(facts) => {
                page.push_str("<dl class=\"facts\">");
                for (name, cell) in facts {
                    let _ = write!(page, "<dt>{}</dt><dd>{}</dd>", inline(name), cell.html());
                }
                page.push_str("</dl>");
            }
            Self::Grid(grid) => grid.write(page)?,
            Self::Figure { id, figure } => match pictures.add(id, figure) {
                Ok(element) => page.push_str(&element),
                Err(source) => return Err(ReportError::Figure { id: id.clone(), source }),
            },
            Self::Links(links) => {
                page.push_str("<ul>");
                for (path, text) in links {
                    let path = escape(path);
                    let _ = write!(page, "<li><a href=\"{path}\"><code>{path}</code></a> {}</li>", inline(text));
                }
                page.push_str("</ul>");
            }
        }
        Ok(())
    }
}

fn formulas_html(page: &mut String, formulas: impl Iterator<Item = String>) {
    page.push_str("<div class=\"formulas\">");
    page.extend(formulas);
    page.push_str("</div>");
}

/// A link of a heading to itself.
fn permalink(anchor: &str, title: &str) -> String {
    format!("<a class=\"anchor\" href=\"#{anchor}\" aria-label=\"Link to {}\">#</a>", escape(title))
}

fn paragraphs(page: &mut String, text: &str, attribute: &str) {
    for paragraph in text.split("\n\n").map(str::trim).filter(|paragraph| !paragraph.is_empty()) {
        let _ = write!(page, "<p{attribute}>{}</p>", inline(paragraph));
    }
}

/// Escaped text, with code between backticks; an unpaired backtick is literal.
fn inline(text: &str) -> String {
    let mut html = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('`') {
        let Some((code, beyond)) = after.split_once('`') else { break };
        let _ = write!(html, "{}<code>{}</code>", escape(before), escape(code));
        rest = beyond;
    }
    html + &escape(rest)
}

/// An anchor of letters, digits and hyphens, unique on the page.
fn anchor(title: &str, taken: &mut HashSet<String>) -> String {
    let letters = title.to_lowercase().replace(|c: char| !c.is_ascii_alphanumeric(), " ");
    let words = letters.split_whitespace().collect::<Vec<_>>().join("-");
    let stem = if words.is_empty() { "section".to_owned() } else { words };
    let mut name = stem.clone();
    let mut count = 1;
    while !taken.insert(name.clone()) {
        count += 1;
        name = format!("{stem}-{count}");
    }
    name
}
