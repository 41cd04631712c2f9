//! A section as plain text, for a terminal, and as Markdown.
//!
//! Notes, HTML and figures belong to a page, and are left out of plain text.

use super::{Block, Cell, Grid, Kind, Report, Section, Tone};
use std::fmt::Write;

/// How the word of a badge is written.
type Paint = fn(&str, Tone) -> String;

/// A word in the colour of its tone, by the sequences of ECMA-48 that terminals read: green, red, yellow, magenta.
fn coloured(word: &str, tone: Tone) -> String {
    let colour = match tone {
        Tone::Good => 32,
        Tone::Bad => 31,
        Tone::Open => 33,
        Tone::Failed => 35,
    };
    format!("\x1b[{colour}m{word}\x1b[0m")
}

/// Maximal number of entries of a matrix that is written in one line.
const IN_ONE_LINE: usize = 36;

impl Report {
    /// Title, lead and sections as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n", escaped(&self.title));
        if !self.lead.trim().is_empty() {
            text.extend(["\n", &escaped(self.lead.trim()), "\n"]);
        }
        self.sections.iter().fold(text, |text, section| text + "\n" + &section.markdown())
    }
}

impl Section {
    /// The section as lines of text, an empty line before it. Best values have an asterisk. A title that a heading
    /// follows at once is left out.
    ///
    /// ```
    /// use luenberger_figures::{Cell, Grid, Section};
    /// let grid = Grid::new(&["observer", "rms"]).row([Cell::from("linear"), Cell::best("0.31")]);
    /// let section = Section::new("Comparison").prose("Two of `them`.").grid(grid).note("Why.");
    /// assert_eq!(section.text(), "\nComparison\n  Two of `them`.\n  observer  rms\n  linear    0.31*\n");
    /// ```
    pub fn text(&self) -> String {
        self.painted(|word, _| word.to_owned())
    }

    /// The same with badges in colours, for a terminal.
    pub fn coloured_text(&self) -> String {
        self.painted(coloured)
    }

    fn painted(&self, paint: Paint) -> String {
        let mut text = String::new();
        if !matches!(self.blocks.first(), Some(Block::Heading(..))) {
            text.extend(["\n", &self.title, "\n"]);
        }
        blocks(&mut text, &self.blocks, paint);
        text
    }

    /// The section as Markdown, with a title of the second level.
    ///
    /// ```
    /// use luenberger_figures::{Cell, Grid, Section};
    /// let grid = Grid::new(&["observer", "rms"]).row([Cell::from("a|b"), Cell::best("0.31")]);
    /// let section = Section::new("Comparison").prose("Of *all*.").grid(grid).note("Why.");
    /// let table = "| observer | rms |\n|---|---:|\n| a\\|b | **0.31** |\n";
    /// assert_eq!(section.markdown(), format!("## Comparison\n\nOf \\*all\\*.\n\n{table}\nWhy.\n"));
    /// ```
    pub fn markdown(&self) -> String {
        let mut text = format!("## {}\n", escaped(&self.title));
        for block in &self.blocks {
            markdown(&mut text, block);
        }
        text
    }
}

fn blocks(text: &mut String, blocks: &[Block], paint: Paint) {
    let mut after_grid = false;
    for block in blocks {
        // A line between a table and the title of the next one.
        if after_grid && matches!(block, Block::Grid(grid) if !grid.caption.is_empty()) {
            text.push('\n');
        }
        after_grid = matches!(block, Block::Grid(_)) || (after_grid && matches!(block, Block::Note(_)));
        match block {
            Block::Heading(heading, mark) => {
                let mark = mark.as_ref().map(|mark| format!(": {}", value(mark, paint).shown)).unwrap_or_default();
                text.extend(["\n", heading, &mark, "\n"]);
            }
            Block::Prose(prose) => {
                for line in prose.lines().map(str::trim).filter(|line| !line.is_empty()) {
                    text.extend(["  ", line, "\n"]);
                }
            }
            Block::Verbatim(lines) => indented(text, lines.lines()),
            Block::List(items) => indented(text, items.iter().map(String::as_str)),
            Block::Facts(facts) => {
                let rows = facts.iter().map(|(name, cell)| vec![Word::plain(name), value(cell, paint)]);
                table(text, &rows.collect::<Vec<_>>());
            }
            Block::Grid(grid) => {
                if !grid.caption.is_empty() {
                    text.extend(["  ", &grid.caption, "\n"]);
                }
                let head = grid.head.iter().map(|name| Word::plain(name)).collect();
                let rows = grid.rows.iter().map(|row| row.iter().map(|cell| value(cell, paint)).collect());
                table(text, &std::iter::once(head).chain(rows).collect::<Vec<_>>());
            }
            Block::Matrices(matrices) => {
                for (name, rows) in matrices {
                    matrix(text, name, rows);
                }
            }
            Block::Folded { inside, .. } => self::blocks(text, inside, paint),
            Block::Links(links) => {
                for (path, what) in links {
                    text.extend(["  ", format!("{path} {what}").trim_end(), "\n"]);
                }
            }
            Block::Formulas(formulas) => indented(text, formulas.iter().map(|formula| formula.latex.as_str())),
            Block::Note(_) | Block::Html(_) | Block::Figure { .. } => {}
        }
    }
}

/// The content of a cell as it is written, and its width.
struct Word {
    shown: String,
    width: usize,
}

impl Word {
    fn plain(text: &str) -> Self {
        Self { shown: text.to_owned(), width: text.chars().count() }
    }
}

fn value(cell: &Cell, paint: Paint) -> Word {
    match cell.kind {
        Kind::Best => Word::plain(&format!("{}*", cell.text)),
        Kind::Badge(tone) => Word { shown: paint(&cell.text, tone), ..Word::plain(&cell.text) },
        Kind::Text | Kind::Number => Word::plain(&cell.text),
    }
}

fn indented<'a>(text: &mut String, lines: impl Iterator<Item = &'a str>) {
    for line in lines {
        text.extend(["  ", line, "\n"]);
    }
}

/// Maximal width of the first column of a table.
const FIRST: usize = 60;

/// Rows of cells, left-aligned in columns; one below the other where the first column would leave no room for others.
fn table(text: &mut String, rows: &[Vec<Word>]) {
    let columns = rows.iter().map(Vec::len).max().unwrap_or_default();
    let width = |column| rows.iter().filter_map(|row| row.get(column)).map(|cell: &Word| cell.width).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or_default()).collect();
    let is_wide = widths.first().is_some_and(|width| *width > FIRST);
    for row in rows {
        if let (true, [first, others @ ..]) = (is_wide, row.as_slice()) {
            let others: Vec<&str> = others.iter().map(|cell| cell.shown.as_str()).collect();
            text.extend(["  ", &first.shown, ": ", &others.join("; "), "\n"]);
            continue;
        }
        let padded = |(cell, width): (&Word, &usize)| cell.shown.clone() + &" ".repeat(width - cell.width);
        let cells: Vec<String> = row.iter().zip(&widths).map(padded).collect();
        text.extend(["  ", cells.join("  ").trim_end(), "\n"]);
    }
}

/// `L = [7; 10]`, or for a large matrix its rows in aligned lines.
fn matrix(text: &mut String, name: &str, rows: &[Vec<String>]) {
    if rows.iter().map(Vec::len).sum::<usize>() <= IN_ONE_LINE {
        let rows: Vec<String> = rows.iter().map(|row| row.join(" ")).collect();
        let _ = writeln!(text, "  {name} = [{}]", rows.join("; "));
    } else {
        let _ = writeln!(text, "  {name} =");
        let row =
            |row: &Vec<String>| std::iter::once("").chain(row.iter().map(String::as_str)).map(Word::plain).collect();
        table(text, &rows.iter().map(row).collect::<Vec<_>>());
    }
}

fn markdown(text: &mut String, block: &Block) {
    text.push('\n');
    match block {
        Block::Heading(heading, mark) => {
            let mark = mark.as_ref().map(|mark| format!(": {}", escaped(&mark.text))).unwrap_or_default();
            text.extend(["### ", &escaped(heading), &mark, "\n"]);
        }
        Block::Prose(prose) | Block::Note(prose) => text.extend([&escaped(prose.trim()), "\n"]),
        Block::Verbatim(lines) => text.extend(["```\n", lines.trim_end(), "\n```\n"]),
        Block::List(items) => text.extend(items.iter().map(|item| format!("- {}\n", escaped(item)))),
        Block::Facts(facts) => {
            text.extend(facts.iter().map(|(name, cell)| format!("- {}: {}\n", escaped(name), marked(cell))));
        }
        Block::Grid(grid) => grid_markdown(text, grid),
        Block::Matrices(matrices) => {
            let matrices = matrices.iter().map(|(name, rows)| super::Formula::matrix(name, rows));
            text.push_str(&displayed(matrices.map(|formula| formula.latex)));
        }
        Block::Formulas(formulas) => text.push_str(&displayed(formulas.iter().map(|formula| formula.latex.clone()))),
        Block::Folded { summary, inside } => {
            text.extend([&escaped(summary), ":\n"]);
            for block in inside {
                markdown(text, block);
            }
        }
        Block::Links(links) => {
            let line = |(path, what): &(String, String)| format!("- [{path}]({path}) {}", escaped(what));
            text.extend(links.iter().map(|link| line(link).trim_end().to_owned() + "\n"));
        }
        Block::Figure { id, figure } => text.extend(["![", &escaped(&figure.title), "](figures/", id, ".svg)\n"]),
        Block::Html(_) => _ = text.pop(),
    }
}

/// Formulas by themselves, an empty line between them.
fn displayed(formulas: impl Iterator<Item = String>) -> String {
    formulas.map(|latex| format!("$${latex}$$\n")).collect::<Vec<_>>().join("\n")
}

fn grid_markdown(text: &mut String, grid: &Grid) {
    if !grid.caption.is_empty() {
        text.extend([&escaped(&grid.caption), "\n\n"]);
    }
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let is_number = |column: usize| grid.rows.iter().any(|row| matches!(row[column].kind, Kind::Number | Kind::Best));
    let rules = (0..grid.head.len()).map(|column| if is_number(column) { "---:" } else { "---" });
    text.push_str(&line(grid.head.iter().map(|name| escaped(name)).collect()));
    text.extend(["|", &rules.collect::<Vec<_>>().join("|"), "|\n"]);
    text.extend(grid.rows.iter().map(|row| line(row.iter().map(marked).collect())));
}

fn marked(cell: &Cell) -> String {
    match cell.kind {
        Kind::Best => format!("**{}**", escaped(&cell.text)),
        _ => escaped(&cell.text),
    }
}

/// Text in which a backslash stands before what Markdown would read as its own, but for code between backticks.
fn escaped(text: &str) -> String {
    let pieces: Vec<&str> = text.split('`').collect();
    let mut shown = String::new();
    for (part, piece) in pieces.iter().enumerate() {
        // A backtick without another one is literal.
        let is_code = part % 2 == 1 && part + 1 < pieces.len();
        if part > 0 {
            shown.push_str(if part % 2 == 1 && !is_code { "\\`" } else { "`" });
        }
        for c in piece.chars() {
            if (!is_code && "\\*_[]<>#~$".contains(c)) || c == '|' {
                shown.push('\\');
            }
            shown.push(c);
        }
    }
    shown
}
