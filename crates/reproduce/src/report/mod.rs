//! The report of all claims as one HTML file, with the report type of `luenberger-figures`.

use crate::claim::{Class, Record};
use crate::evidence::{Standing, Verdict};
use crate::paper::{Finding, Kind, Paper};
use crate::summary::{Drawn, Live, Summary};
use crate::terminal::counts;
use crate::value::{Value, beside, short};
use luenberger_figures::report::ReportError;
use luenberger_figures::{Report, Section, escape};
use luenberger_live::page::{MODULE, SCRIPT, STYLE};
use luenberger_proof::wording::counted;
use std::fmt::Write;

/// The page.
pub(crate) fn html(papers: &[Paper], summary: &Summary, drawn: &[Drawn], live: &[Live]) -> Result<String, ReportError> {
    let datasets = papers.iter().flat_map(|paper| &paper.datasets);
    let datasets = datasets.map(|dataset| (format!("data/{}.csv", dataset.id), String::new()));
    let files = [("claims.json".to_owned(), "every claim".to_owned())].into_iter().chain(datasets);
    let mut report = Report::new("The papers and their claims")
        .lead("Every claim below is computed anew; the verdict follows from what is printed, what is computed and the tolerance.")
        .head(head(papers, summary))
        .with(include_str!("page.css"), include_str!("page.js"))
        .compressed("details", details(&summary.records).to_string().as_bytes());
    if papers.iter().any(|paper| !paper.findings.is_empty()) {
        report = report.section(Section::new("At a glance").html(glance(papers)));
        report = report.section(Section::new("Findings").html(findings(papers, &summary.records)));
    }
    if !live.is_empty() {
        let style = [include_str!("page.css"), STYLE].concat();
        let script = [include_str!("page.js"), SCRIPT].concat();
        report = report.with(style, script).packed("live-module", MODULE).section(examples(live));
    }
    report = report.section(Section::new("Claims").html(claims(papers, &summary.records)));
    for paper in papers {
        let section = Section::new(format!("Figures of {}", paper.short));
        let of_paper = drawn.iter().filter(|drawn| drawn.paper == paper.key);
        report =
            report.section(of_paper.fold(section, |section, drawn| section.figure(drawn.id, drawn.figure.clone())));
    }
    report.section(Section::new("Data").links(files)).html()
}

/// The examples that the page runs itself.
fn examples(live: &[Live]) -> Section {
    let section = Section::new("Live").prose(
        "These examples run in this page: the simulation, the observers and the verification of the certificates, \
         compiled to WebAssembly. Each slider is a factor of the value in the paper. With other gains the inequalities \
         are evaluated again, with the same P: not certified means that this P proves no convergence.",
    );
    live.iter().fold(section, |section, live| {
        section.heading(live.example.title).prose(live.example.about).html(live.html.as_str())
    })
}

// Writing into a String cannot fail, hence `let _ =` below.

fn head(papers: &[Paper], summary: &Summary) -> String {
    let mut page = String::new();
    for paper in papers {
        let _ = write!(page, "<p class=\"citation\"><b>{}</b><br>{}</p>", escape(paper.title), escape(paper.citation));
    }
    let mut counts_of = |title: &str, class: Class, words: &[(&str, usize)]| {
        let _ = write!(page, "<p>{title}:</p><div class=\"counts\">");
        for (word, count) in words {
            let _ = write!(
                page,
                "<button type=\"button\" class=\"count {word}\" data-verdict=\"{word}\" data-class=\"{class}\"><b>{count}</b> {word}</button>",
            );
        }
        let _ = write!(page, "</div>");
    };
    let of = |class, verdict: Verdict| (verdict.word(), summary.count_of(&[class], verdict));
    let known = |standing: Standing| (standing.word(), summary.theorems(standing));
    counts_of(
        "The papers' theorems and other general statements",
        Class::Theorem,
        &[
            known(Standing::Proved),
            known(Standing::Consistent),
            of(Class::Theorem, Verdict::Refuted),
            of(Class::Theorem, Verdict::Underspecified),
        ],
    );
    counts_of(
        "Their examples",
        Class::Example,
        &[Verdict::Reproduced, Verdict::Refuted, Verdict::Underspecified].map(|verdict| of(Class::Example, verdict)),
    );
    let _ = write!(page, "<p>Apart from them:</p><div class=\"counts\">");
    for class in Class::ALL.into_iter().filter(|class| !Class::OWN.contains(class)) {
        let _ = write!(
            page,
            "<button type=\"button\" class=\"count\" data-verdict=\"\" data-class=\"{class}\"><b>{}</b> {class}</button>",
            summary.of(&[class])
        );
    }
    let counts = escape(&counts(summary)).replace('\n', "<br>");
    let _ = write!(page, "</div><p class=\"small\">{counts}</p>");
    if !summary.failures.is_empty() {
        let _ = write!(page, "<div class=\"failures\"><b>Failed</b><ul>");
        for failure in &summary.failures {
            let _ = write!(page, "<li><code>{}</code>: {}</li>", escape(&failure.id), escape(&failure.error));
        }
        let _ = write!(page, "</ul></div>");
    }
    page
}

/// What each paper comes to, on one screen: a list for each kind of finding, its lines linked to the details.
fn glance(papers: &[Paper]) -> String {
    let mut page = String::new();
    for paper in papers.iter().filter(|paper| !paper.findings.is_empty()) {
        let _ = write!(page, "<article class=\"glance\"><h3>{}</h3><div class=\"kinds\">", escape(paper.title));
        for kind in Kind::ALL {
            let mut of_kind = findings_of(paper).filter(|(_, finding)| finding.kind == kind).peekable();
            if of_kind.peek().is_none() {
                continue;
            }
            let _ = write!(page, "<section class=\"kind-{}\"><h4>{}</h4><ul>", style(kind), kind.heading());
            for (id, finding) in of_kind {
                let _ = write!(page, "<li><a href=\"#{id}\">{}</a></li>", escape(finding.title));
            }
            let _ = write!(page, "</ul></section>");
        }
        let _ = write!(page, "</div></article>");
    }
    page
}

/// The findings of a paper with their anchors.
fn findings_of(paper: &Paper) -> impl Iterator<Item = (String, &Finding)> {
    paper.findings.iter().enumerate().map(|(k, finding)| (format!("finding-{}-{k}", paper.key), finding))
}

/// The colour of a kind of finding, by the verdict that has it.
fn style(kind: Kind) -> &'static str {
    match kind {
        Kind::Holds | Kind::Beyond => "reproduced",
        Kind::Slip => "slip",
        Kind::Wrong => "refuted",
        Kind::Open => "underspecified",
    }
}

fn findings(papers: &[Paper], records: &[Record]) -> String {
    let mut page = "<div class=\"findings\">".to_owned();
    for (id, finding) in papers.iter().flat_map(findings_of) {
        let _ = write!(
            page,
            "<article id=\"{id}\" class=\"kind-{}\"><h3>{}</h3><p class=\"kind\">{}</p><p>{}</p><ul class=\"evidence\">",
            style(finding.kind),
            escape(finding.title),
            finding.kind.heading(),
            escape(finding.statement)
        );
        for record in finding.claims.iter().filter_map(|id| records.iter().find(|record| record.id == *id)) {
            let _ = write!(
                page,
                "<li>{} <a href=\"#{id}\"><code>{id}</code></a>{}<div class=\"note\"></div></li>",
                badge(record),
                numbers(record),
                id = escape(&record.id)
            );
        }
        let _ = write!(page, "</ul></article>");
    }
    page + "</div>"
}

/// `printed 1.18, computed 1.1694`, where both are short.
fn numbers(record: &Record) -> String {
    match (&record.printed, &record.computed) {
        (Some(Value::Number(_)), Some(Value::Number(_))) => {
            format!(": printed {}, computed {}", printed(record), computed(record))
        }
        _ => String::new(),
    }
}

fn claims(papers: &[Paper], records: &[Record]) -> String {
    let mut page = "<form class=\"filter\" id=\"filter\">\
         <input type=\"search\" id=\"text\" placeholder=\"Filter by text\" aria-label=\"Filter by text\">\
         <select id=\"verdict\" aria-label=\"Verdict\"><option value=\"\">every verdict</option>"
        .to_owned();
    for choice in ["proved", "consistent", "reproduced", "refuted", "underspecified", "failed"] {
        let _ = write!(page, "<option>{choice}</option>");
    }
    let _ = write!(
        page,
        "</select><select id=\"class\" aria-label=\"Class\"><option value=\"\">every class</option>\
         <option value=\"own\">the paper's own</option>"
    );
    for class in Class::ALL {
        let _ = write!(page, "<option>{class}</option>");
    }
    let _ = write!(page, "</select><select id=\"paper\" aria-label=\"Paper\"><option value=\"\">every paper</option>");
    for paper in papers {
        let _ = write!(page, "<option>{}</option>", escape(paper.key));
    }
    let _ = write!(
        page,
        "</select><output id=\"shown\"></output></form><table class=\"claims\"><thead><tr><th>verdict</th>\
         <th>claim</th><th>class</th><th>printed</th><th>computed</th></tr></thead>"
    );
    for paper in papers {
        let _ = write!(
            page,
            "<tbody class=\"paper\" data-paper=\"{}\"><tr><th colspan=\"5\" scope=\"rowgroup\">{}</th></tr></tbody>",
            escape(paper.key),
            escape(paper.title)
        );
        for record in records.iter().filter(|record| record.paper == paper.key) {
            claim(&mut page, record);
        }
    }
    short_tags(&page) + "</table>"
}

/// HTML lets these end tags out; they would be a tenth of the table.
fn short_tags(page: &str) -> String {
    ["</td>", "</th>", "</tr>", "</dt>", "</dd>", "</li>"]
        .iter()
        .fold(page.to_owned(), |page, tag| page.replace(tag, ""))
}

fn claim(page: &mut String, record: &Record) {
    let id = escape(&record.id);
    let _ = write!(
        page,
        "<tbody class=\"claim\" id=\"{id}\" data-verdict=\"{}\" data-class=\"{class}\" data-own=\"{}\" data-paper=\"{}\">\
         <tr class=\"row\"><td>{}</td>\
         <td><button class=\"more\"><code>{id}</code></button>\
         <div class=\"statement\">{}</div>{}</td><td>{class}</td><td class=\"number\">{}</td><td class=\"number\">{}</td></tr></tbody>",
        record.word(),
        Class::OWN.contains(&record.class),
        escape(&record.paper),
        badge(record),
        escape(&record.statement),
        deciding(record),
        printed(record),
        outcome(record).unwrap_or_else(|| computed(record)),
        class = record.class
    );
}

/// What a row of the table opens, and its note, which the findings show too: by the ids of the claims, as the JSON that
/// the script of the page reads.
fn details(records: &[Record]) -> serde_json::Value {
    let of = |record: &Record| {
        let note = if record.note.is_empty() { String::new() } else { short_tags(&note(record)) };
        let details = serde_json::json!({ "rows": short_tags(&rows(record)), "note": note });
        (record.id.clone(), details)
    };
    records.iter().map(of).collect::<serde_json::Map<_, _>>().into()
}

/// All of a claim but its note, as a list of terms.
fn rows(record: &Record) -> String {
    let mut page = String::new();
    let _ = write!(page, "<dt>Where</dt><dd>{}</dd>", escape(&record.place));
    if let Some(quote) = &record.quote {
        let _ = write!(page, "<dt>Printed there</dt><dd><q>{}</q></dd>", escape(quote.text));
        let _ = write!(page, "<dt>Read as</dt><dd>{}</dd>", escape(quote.reading));
    }
    hypotheses(&mut page, record);
    if !record.assumptions.is_empty() {
        let _ = write!(page, "<dt>Assumptions</dt><dd><ul>");
        for assumption in &record.assumptions {
            let _ = write!(page, "<li>{}</li>", escape(assumption));
        }
        let _ = write!(page, "</ul></dd>");
    }
    if let Some(known) = known(record) {
        let _ = write!(page, "<dt>Known</dt><dd>{known}</dd>");
    }
    if let Some(kernel) = &record.kernel {
        let theorems: Vec<String> =
            kernel.theorems.iter().map(|name| format!("<code>{}</code>", escape(name))).collect();
        let _ = write!(
            page,
            "<dt>Refuted in Coq</dt><dd>{} of <a href=\"{file}\"><code>{file}</code></a>, which <code>cargo xtask kernel</code> has Coq's kernel check</dd>",
            theorems.join(", "),
            file = escape(&kernel.file)
        );
    }
    for (name, value) in
        [("Printed", &record.printed), ("Computed", &record.computed), ("Tolerance", &record.tolerance)]
    {
        if let Some(value) = value {
            let _ = write!(page, "<dt>{name}</dt><dd>{}</dd>", full(value));
        }
    }
    page
}

/// The note, as a paragraph or a list of its parts, with its table behind a line that opens it.
fn note(record: &Record) -> String {
    let mut page = match record.parts.as_slice() {
        [one] => escape(one),
        parts => {
            let items: Vec<String> = parts.iter().map(|part| format!("<li>{}</li>", escape(part))).collect();
            format!("<ul class=\"parts\">{}</ul>", items.concat())
        }
    };
    if let Some(table) = &record.table {
        let row = |cells: &[String], tag: &str| {
            let cells: Vec<String> = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect();
            format!("<tr>{}</tr>", cells.concat())
        };
        let rows: String = table.rows.iter().map(|cells| row(cells, "td")).collect();
        let _ = write!(
            page,
            "<details class=\"numbers\"><summary>{}</summary><div class=\"wide\"><table class=\"rows\"><thead>{}</thead><tbody>{rows}</tbody></table></div></details>",
            counted(table.rows.len(), "row"),
            row(&table.head, "th")
        );
    }
    page
}

/// The hypotheses as evaluated, a row each.
fn hypotheses(page: &mut String, record: &Record) {
    if record.hypotheses.is_empty() {
        return;
    }
    let _ = write!(page, "<dt>Hypotheses</dt><dd><table class=\"hypotheses\">");
    for found in &record.hypotheses {
        let _ = write!(
            page,
            "<tr class=\"{word}\"><td>{}</td><td>{}</td><td>{word}</td><td>{}</td></tr>",
            escape(&found.case),
            escape(&found.hypothesis),
            escape(&found.how),
            word = found.word()
        );
    }
    let _ = write!(page, "</table></dd>");
}

/// Of a claim that is not reproduced, the words of the paper that decide, in the row itself.
fn deciding(record: &Record) -> String {
    match (&record.quote, record.verdict) {
        (Some(quote), Some(Verdict::Refuted | Verdict::Underspecified)) => {
            format!("<div class=\"deciding\"><q>{}</q></div>", escape(quote.text))
        }
        _ => String::new(),
    }
}

/// What is known of a theorem that is reproduced.
fn known(record: &Record) -> Option<String> {
    let tried = counted(record.instances?, "instance");
    Some(match (record.standing?, &record.proof) {
        (Standing::Proved, Some(proof)) => format!(
            "proved in <code>docs/{}</code> (“{}”), tested by <code>{}</code> of <code>{}</code>; {tried} here",
            escape(proof.page),
            escape(proof.at),
            escape(proof.property),
            escape(proof.tests)
        ),
        _ => format!("consistent: {tried} tried, none contradicts it; there is no proof here"),
    })
}

/// A badge with the verdict; of a consistent theorem with the number of its instances.
fn badge(record: &Record) -> String {
    let tried = match (record.standing, record.instances) {
        (Some(Standing::Consistent), Some(count)) => format!(" <small>× {count}</small>"),
        _ => String::new(),
    };
    format!("<span class=\"badge {0}\">{0}{tried}</span>", record.word())
}

/// The entries of the printed value letter by letter, in rows.
fn letters(text: &str) -> Vec<Vec<&str>> {
    text.split(';').map(|row| row.split_whitespace().collect()).collect()
}

/// What is printed, letter by letter.
fn printed(record: &Record) -> String {
    match (&record.as_printed, &record.printed) {
        (Some(text), _) => cells(
            &letters(text).iter().map(|row| row.iter().map(|x| escape(x)).collect()).collect::<Vec<_>>(),
            text.contains(';'),
        ),
        (None, Some(value)) => brief(value),
        (None, None) => "–".to_owned(),
    }
}

/// What is computed, with the digits that are compared.
fn computed(record: &Record) -> String {
    let Some(value) = &record.computed else { return "–".to_owned() };
    let Some(text) = &record.as_printed else { return brief(value) };
    let rows = letters(text);
    let entries = value.entries();
    if rows.iter().map(Vec::len).sum::<usize>() != entries.len() {
        return brief(value);
    }
    let mut entries = entries.into_iter();
    let shown: Vec<Vec<String>> = rows
        .iter()
        .map(|row| row.iter().zip(entries.by_ref()).map(|(printed, x)| escape(&beside(x, printed))).collect())
        .collect();
    cells(&shown, text.contains(';'))
}

/// Entries in a list, or in a matrix.
fn cells(rows: &[Vec<String>], is_matrix: bool) -> String {
    if !is_matrix {
        return rows.concat().join(", ");
    }
    let row = |row: &Vec<String>| {
        let cells: Vec<String> = row.iter().map(|x| format!("<td>{}</td>", x.replace('-', "−"))).collect();
        format!("<tr>{}</tr>", cells.concat())
    };
    format!("<table class=\"matrix\">{}</table>", rows.iter().map(row).collect::<String>())
}

/// What fits a cell of the table.
fn brief(value: &Value) -> String {
    match value {
        Value::Truth(true) => "holds".to_owned(),
        Value::Truth(false) => "does not hold".to_owned(),
        Value::Number(x) => escape(&short(*x)),
        Value::Vector(v) if v.len() > 6 => format!("{} numbers", v.len()),
        Value::Vector(_) => escape(&value.to_string()),
        Value::Matrix(_) => grid(value, short),
    }
}

/// The outcome of a claim that is true or false, with the quantity that decided.
fn outcome(record: &Record) -> Option<String> {
    let (Some(Value::Truth(printed)), Some(computed)) = (&record.printed, &record.computed) else { return None };
    if matches!(computed, Value::Truth(_)) {
        return None;
    }
    let holds = match record.verdict? {
        Verdict::Reproduced => *printed,
        Verdict::Refuted => !printed,
        Verdict::Underspecified => return None,
    };
    Some(format!("{}<div class=\"by\">decided by {}</div>", brief(&Value::Truth(holds)), brief(computed)))
}

/// Every digit.
fn full(value: &Value) -> String {
    match value {
        Value::Matrix(_) => grid(value, |x| x.to_string()),
        Value::Vector(v) => v.iter().map(f64::to_string).collect::<Vec<_>>().join(", "),
        Value::Number(x) => x.to_string(),
        Value::Truth(_) => brief(value),
    }
}

fn grid(value: &Value, show: fn(f64) -> String) -> String {
    let Value::Matrix(rows) = value else { return escape(&value.to_string()) };
    let mut table = "<table class=\"matrix\">".to_owned();
    for row in rows {
        table.push_str("<tr>");
        for &x in row {
            let _ = write!(table, "<td>{}</td>", show(x).replace('-', "−"));
        }
        table.push_str("</tr>");
    }
    table + "</table>"
}
