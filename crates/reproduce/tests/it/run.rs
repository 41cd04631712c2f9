//! End-to-end run on a paper with one claim: files written, and the effect of a failure.

// A check returns a Result by its type, also where it cannot fail.
#![allow(clippy::unnecessary_wraps)]

use luenberger_reproduce::{
    CheckError, Claim, Class, Context, Dataset, Drawing, Evidence, Figure, Finding, Hypothesis, KernelRefutation, Kind,
    Outcome, Panel, Paper, Plate, Printed, Quote, ReproduceError, Series, Standing, Summary, Table, Tolerance, Value,
    Verdict, run_papers, terminal,
};
use serde_json::{Value as Json, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use terminal::Filter;

fn right(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Outcome::new(Evidence::value(1.0 / 3.0)).note("One third."))
}

fn wrong(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Evidence::value(nalgebra::DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 4.06])).into())
}

fn infinite(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Evidence::value(f64::INFINITY).into())
}

fn fails(_: &Context) -> Result<Outcome, CheckError> {
    Err("the pair <A, C> is not observable".into())
}

fn holds(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Evidence::holds(true).into())
}

const fn claim(id: &'static str, printed: &'static str, check: fn(&Context) -> Result<Outcome, CheckError>) -> Claim {
    Claim {
        id,
        class: Class::Example,
        place: "Example 1",
        statement: "a number < its bound",
        printed: Printed::Decimals(printed),
        tolerance: Tolerance::AsPrinted,
        assumptions: &["x(0) = 0"],
        quote: Some(Quote { text: "e < 5", reading: "in metres" }),
        proof: None,
        check,
    }
}

fn decay(_: &Context) -> Result<Plate, CheckError> {
    let t: Vec<f64> = (0..=100).map(|k| f64::from(k) / 25.0).collect();
    let e: Vec<f64> = t.iter().map(|t| (-t).exp()).collect();
    let panel = Panel::new("time t (s)", "error e (m)").series(Series::line("e </script>", &t, &e));
    Ok(Plate { figure: Figure::new("Decay").panel(panel), data: Table::new().column("t", t).column("e", e) })
}

fn nothing(_: &Context) -> Result<Plate, CheckError> {
    let panel = Panel::new("time t (s)", "error e (m)").series(Series::line("e", &[0.0], &[f64::NAN]));
    Ok(Plate { figure: Figure::new("").panel(panel), data: Table::new().column("t", [0.0]) })
}

fn paper(claims: Vec<Claim>, figures: Vec<Drawing>, findings: Vec<Finding>) -> Paper {
    let (key, title, short, citation) = ("demo", "A paper", "a demo", "Nobody, 2000");
    Paper { key, title, short, citation, claims, figures, datasets: vec![], live: vec![], kernel: vec![], findings }
}

/// Runs in a folder of its own, which is removed by the next run.
fn run(name: &str, paper: Paper) -> (Result<Summary, ReproduceError>, PathBuf) {
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&out);
    (run_papers(&[paper], &out), out)
}

#[test]
fn a_run_writes_the_ledger_the_data_the_figures_and_the_report() {
    let holds = Claim { printed: Printed::Holds(true), ..claim("demo.holds", "", holds) };
    let claims = vec![
        claim("demo.right", "0.33", right),
        claim("demo.wrong", "1 2.00; 3.0 4.0", wrong),
        claim("demo.infinite", "7", infinite),
        holds,
    ];
    let figures = vec![Drawing { id: "demo-fig1", draw: decay }];
    let (title, statement) = ("The entry is wrong", "It is 4.06.");
    let finding = Finding { kind: Kind::Wrong, title, statement, claims: &["demo.wrong"] };
    let (summary, out) = run("complete", paper(claims, figures, vec![finding]));
    let summary = summary.unwrap();
    assert!(summary.is_complete(), "{:?}", summary.failures);
    assert_eq!((summary.count(Verdict::Reproduced), summary.count(Verdict::Refuted)), (2, 2));

    let ledger: Json = serde_json::from_slice(&fs::read(out.join("claims.json")).unwrap()).unwrap();
    assert_eq!(
        ledger[0],
        json!({
            "id": "demo.right", "paper": "demo", "class": "example", "where": "Example 1",
            "statement": "a number < its bound", "quote": {"text": "e < 5", "reading": "in metres"}, "hypotheses": [],
            "printed": 0.33, "computed": 1.0 / 3.0, "tolerance": 0.005, "as_printed": "0.33", "verdict": "reproduced",
            "assumptions": ["x(0) = 0"], "note": "One third.",
        })
    );
    assert_eq!(ledger[1]["computed"], json!([[1.0, 2.0], [3.0, 4.06]]));
    assert_eq!(ledger[1]["tolerance"], json!([[0.5, 0.005], [0.05, 0.05]]));
    assert_eq!(ledger[1]["verdict"], json!("refuted"));
    assert_eq!((&ledger[2]["computed"], &ledger[2]["verdict"]), (&Json::Null, &json!("refuted")));
    assert!(ledger[2]["note"].as_str().unwrap().contains("inf"));
    assert_eq!((&ledger[3]["printed"], &ledger[3]["tolerance"]), (&json!(true), &Json::Null));

    let csv = fs::read_to_string(out.join("data/demo-fig1.csv")).unwrap();
    assert!(csv.starts_with("t,e\n0.0,1.0\n0.04,0.9607894391523232\n"), "{}", &csv[..60]);
    assert!(fs::read_to_string(out.join("figures/demo-fig1.svg")).unwrap().starts_with("<svg"));
    assert!(fs::read(out.join("figures/demo-fig1.png")).unwrap().starts_with(b"\x89PNG"));

    let table = terminal::table(&summary, &Filter::default(), false);
    assert!(!table.contains('\u{1b}'), "no colour off the terminal");
    let counted = "the papers' own claims: 4 (0 theorem, 4 example)\n\
        theorems: 0 proved, 0 consistent with every instance tried, 0 neither (0 refuted, 0 underspecified)\n\
        examples: 2 reproduced, 2 refuted, 0 underspecified\n";
    assert!(table.contains(counted) && table.contains("\n4 claims checked, 0 failed ("), "{table}");
}

fn refuted(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Outcome::new(Evidence::holds(false)).given(vec![Hypothesis::computed("η ≥ 1", true, "η = 1")]))
}

fn refuted_outside(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Outcome::new(Evidence::holds(false)).given(vec![Hypothesis::computed("η ≥ 1", false, "η = 0")]))
}

fn bare(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Evidence::holds(false).into())
}

/// The headline counts the paper's own claims; misprints, readings and what is ours stand apart, and each can be asked
/// for.
#[test]
fn claims_are_counted_and_shown_by_class() {
    let truth = |class, id, check| {
        Claim::holds(class, id, "Theorem 1", "it converges", &[], check).quoting("e → 0", "as t → ∞")
    };
    let claims = vec![
        truth(Class::Theorem, "demo.theorem", refuted),
        truth(Class::Theorem, "demo.outside", refuted_outside),
        claim("demo.example", "0.33", right),
        truth(Class::Misprint, "demo.misprint", bare),
        truth(Class::Reading, "demo.reading", bare),
        truth(Class::Ours, "demo.ours", holds),
    ];
    let (summary, out) = run("classes", paper(claims, vec![], vec![]));
    let summary = summary.unwrap();
    assert!(summary.is_complete(), "{:?}", summary.failures);
    let own = Verdict::Refuted;
    assert_eq!((summary.of(&Class::OWN), summary.count_of(&Class::OWN, own), summary.count(own)), (3, 1, 3));
    let counts = terminal::counts(&summary);
    for said in [
        "the papers' own claims: 3 (2 theorem, 1 example)",
        "theorems: 0 proved, 0 consistent with every instance tried, 2 neither (1 refuted, 1 underspecified)",
        "examples: 1 reproduced, 0 refuted, 0 underspecified",
        "apart: 1 misprint (0 reproduced, 1 refuted, 0 underspecified), 1 reading (0 reproduced, 1 refuted, 0 underspecified), 1 ours (1 reproduced, 0 refuted, 0 underspecified)",
        "6 claims checked, 0 failed (",
    ] {
        assert!(counts.contains(said), "{counts}");
    }
    let shown = |classes: &[Class], verdicts: &[Verdict]| {
        let filter = Filter { classes: classes.to_vec(), verdicts: verdicts.to_vec() };
        let table = terminal::table(&summary, &filter, false);
        summary
            .records
            .iter()
            .filter(|record| table.contains(&record.id))
            .map(|record| record.id.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(shown(&[Class::Misprint, Class::Ours], &[]), ["demo.misprint", "demo.ours"]);
    assert_eq!(shown(&Class::OWN, &[Verdict::Underspecified]), ["demo.outside"]);

    let ledger: Json = serde_json::from_slice(&fs::read(out.join("claims.json")).unwrap()).unwrap();
    assert_eq!(ledger[0]["hypotheses"], json!([{"case": "", "hypothesis": "η ≥ 1", "holds": true, "how": "η = 1"}]));
    assert!(
        ledger[1]["note"]
            .as_str()
            .unwrap()
            .contains("Not refuted, because the hypothesis \"η ≥ 1\" fails here (η = 0).")
    );
    let page = read_page(&out);
    for part in [
        "data-class=\"misprint\"",
        "<option>reading</option>",
        "<q>e → 0</q>",
        "<dt>Read as<dd>as t → ∞",
        "<td>η ≥ 1<td>holds<td>η = 1",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

/// The page with what its script unpacks into it.
fn read_page(out: &Path) -> String {
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let details: Json = serde_json::from_slice(&luenberger_figures::unpacked(&page, "details").unwrap()).unwrap();
    let texts = details.as_object().unwrap().values().flat_map(|of| [&of["rows"], &of["note"]]);
    texts.fold(page, |page, text| page + text.as_str().unwrap())
}

fn many(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Evidence::cases([Some(true); 12]).into())
}

fn either(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Evidence::Readings(vec![("one", Value::Truth(true)), ("the other", Value::Truth(false))]).into())
}

/// A claim with a refutation for Coq is marked with the theorems of the file that was written; one that is not refuted
/// cannot have any.
#[test]
fn a_refutation_for_coq_is_written_and_marked() {
    let refutation =
        |claim| KernelRefutation { claim, file: |said| Ok(luenberger_proof::coq::cubic_paper::never_strict(said)) };
    let misprint = |id, check| Claim { class: Class::Misprint, ..claim(id, "1 2; 3 5", check) };
    let with = |kernel| Paper {
        kernel,
        ..paper(vec![misprint("demo.not-so", wrong), claim("demo.third", "0.33", right)], vec![], vec![])
    };
    let (summary, out) = run("kernel", with(vec![refutation("demo.not-so")]));
    let summary = summary.unwrap();
    assert!(summary.is_complete(), "{:?}", summary.failures);
    let ledger: Json = serde_json::from_slice(&fs::read(out.join("claims.json")).unwrap()).unwrap();
    let expected = json!({ "file": "coq/demo_not_so.v", "theorems": ["inequality_13_is_never_strict"] });
    assert_eq!((&ledger[0]["kernel"], &ledger[1]["kernel"]), (&expected, &Json::Null));
    let written = fs::read_to_string(out.join("coq/demo_not_so.v")).unwrap();
    assert!(written.starts_with("(** demo.not-so is false: a number < its bound (Example 1)\n"), "{written}");
    assert!(written.contains("\nTheorem inequality_13_is_never_strict :\n"));
    let page = read_page(&out);
    for part in ["<dt>Refuted in Coq", "<code>inequality_13_is_never_strict</code> of <a href=\"coq/demo_not_so.v\">"] {
        assert!(page.contains(part), "{part}");
    }
    for (claim, error) in [
        ("demo.third", "it has a refutation for Coq and is not refuted"),
        ("demo.other", "a refutation for Coq belongs to no claim"),
    ] {
        let (summary, _) = run("kernel", with(vec![refutation(claim)]));
        let failures: Vec<String> = summary.unwrap().failures.into_iter().map(|failure| failure.error).collect();
        assert_eq!(failures, [error]);
    }
}

/// A theorem whose check agrees is proved if its row names a proof, and else consistent with the instances tried.
#[test]
fn a_theorem_is_proved_or_consistent_or_neither() {
    let theorem = |id, check| Claim::holds(Class::Theorem, id, "Theorem 1", "it converges", &[], check);
    let claims = vec![
        theorem("demo.proved", many).proved_in("theory.md", "Theorem A", "tests/it/run.rs", "it_is_proved"),
        theorem("demo.consistent", many),
        theorem("demo.one-run", holds),
        theorem("demo.open", either).quoting("e → 0", "as t → ∞"),
        claim("demo.example", "0.33", right),
    ];
    let (summary, out) = run("standing", paper(claims, vec![], vec![]));
    let summary = summary.unwrap();
    assert!(summary.is_complete(), "{:?}", summary.failures);
    let words: Vec<&str> = summary.records.iter().map(luenberger_reproduce::Record::word).collect();
    assert_eq!(words, ["proved", "consistent", "consistent", "underspecified", "reproduced"]);
    assert_eq!((summary.theorems(Standing::Proved), summary.theorems(Standing::Consistent)), (1, 2));
    let said = "theorems: 1 proved, 2 consistent with every instance tried, 1 neither (0 refuted, 1 underspecified)\n";
    assert!(terminal::headline(&summary).contains(said), "{}", terminal::headline(&summary));
    let ledger: Json = serde_json::from_slice(&fs::read(out.join("claims.json")).unwrap()).unwrap();
    assert_eq!((&ledger[0]["standing"], &ledger[0]["instances"]), (&json!("proved"), &json!(12)));
    assert_eq!((&ledger[1]["standing"], &ledger[2]["instances"]), (&json!("consistent"), &json!(1)));
    assert_eq!((&ledger[3]["standing"], &ledger[4]["standing"]), (&Json::Null, &Json::Null));
    let page = read_page(&out);
    for part in
        ["consistent <small>× 12</small>", "data-verdict=\"consistent\"", "proved in <code>docs/theory.md</code>"]
    {
        assert!(page.contains(part), "{part}");
    }
}

/// The proof of each row stands on its page, and the test of it in its file.
#[test]
fn every_proof_is_where_its_row_says() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let read = |path: PathBuf| fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut proofs = 0;
    for claim in luenberger_reproduce::papers().iter().flat_map(|paper| &paper.claims) {
        let Some(proof) = claim.proof else { continue };
        proofs += 1;
        assert_eq!(claim.class, Class::Theorem, "{}", claim.id);
        assert!(read(root.join("docs").join(proof.page)).contains(proof.at), "{}: {}", claim.id, proof.at);
        let test = format!("fn {}(", proof.property);
        assert!(read(root.join(proof.tests)).contains(&test), "{}: {}", claim.id, proof.property);
    }
    assert!(proofs >= 10, "{proofs}");
}

/// What is printed stands in the report letter by letter, and what is computed with the digits that are compared; a
/// claim that is not reproduced shows the paper's words in its row.
#[test]
fn the_report_shows_the_digits_and_the_sentence() {
    let claims = vec![claim("demo.digits", "3702.5756", near), claim("demo.wrong", "3702.58", wrong_number)];
    let (summary, out) = run("digits", paper(claims, vec![], vec![]));
    assert!(summary.unwrap().is_complete());
    let page = read_page(&out);
    for part in
        ["<td class=\"number\">3702.5756<td class=\"number\">3702.57564", "<div class=\"deciding\"><q>e &lt; 5</q>"]
    {
        assert!(page.contains(part), "{part}");
    }
    assert_eq!(page.matches("class=\"deciding\"").count(), 1);
}

fn near(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Evidence::value(3_702.575_643_486).into())
}

fn wrong_number(_: &Context) -> Result<Outcome, CheckError> {
    Ok(Evidence::value(3_702.57).into())
}

/// A refutation or two readings without the paper's sentence, a refutation of a theorem without its hypotheses, and
/// of a claim of ours, are failures of the run.
#[test]
fn a_refutation_must_show_its_ground() {
    let truth = |class, id, check| Claim::holds(class, id, "Theorem 1", "it converges", &[], check);
    let claims = vec![
        truth(Class::Example, "demo.unquoted", bare),
        truth(Class::Theorem, "demo.bare", bare).quoting("e → 0", "as t → ∞"),
        truth(Class::Ours, "demo.ours", bare).quoting("e → 0", "as t → ∞"),
        truth(Class::Reading, "demo.open", either),
        truth(Class::Theorem, "demo.grounded", refuted).quoting("e → 0", "as t → ∞"),
    ];
    let (summary, _) = run("ground", paper(claims, vec![], vec![]));
    let failed: Vec<String> = summary.unwrap().failures.into_iter().map(|failure| failure.id).collect();
    assert_eq!(failed, ["demo.unquoted", "demo.bare", "demo.ours", "demo.open"]);
}

#[test]
fn the_report_loads_nothing_and_survives_hostile_words() {
    let (summary, out) = run(
        "report",
        paper(vec![claim("demo.right", "0.33", right)], vec![Drawing { id: "demo-fig1", draw: decay }], vec![]),
    );
    summary.unwrap();
    let html = read_page(&out);
    // The plotting library and the figures are compressed: no letter of theirs is read by the browser's parser.
    let between = |start: &str| html.split_once(start).unwrap().1.split_once("</script>").unwrap().0;
    let packed = |text: &str| !text.contains(['<', '&']) && luenberger_figures::base85::decode(text).is_some();
    let (library, pictures) = (between("id=\"plotting-library\">"), between("id=\"pictures\">"));
    assert!(library.len() > 400_000 && packed(library), "the library is in the page");
    assert!(packed(pictures));
    let page = html.replace(library, "");
    for loads in ["http://", "https://", "src=\"//", "@import", "url("] {
        assert!(!page.contains(loads), "{loads}");
    }
    assert!(page.contains("a number &lt; its bound"));
    assert!(!page.contains("e </script>"));
}

#[test]
fn a_failure_is_listed_and_does_not_stop_the_others() {
    let finding = |title, claims| Finding { kind: Kind::Wrong, title, statement: "", claims };
    let (summary, out) = run(
        "failing",
        paper(
            vec![
                claim("demo.fails", "1.0", fails),
                claim("demo.right", "0.33", right),
                claim("demo.typo", "0.3.3", right),
            ],
            vec![Drawing { id: "demo-nothing", draw: nothing }, Drawing { id: "demo-fig1", draw: decay }],
            vec![finding("unsupported", &["demo.right"]), finding("dangling", &["demo.absent"])],
        ),
    );
    let summary = summary.unwrap();
    let failed: Vec<&str> = summary.failures.iter().map(|failure| failure.id.as_str()).collect();
    assert_eq!(failed, ["demo.fails", "demo.typo", "demo-nothing", "unsupported", "dangling"]);
    assert_eq!(summary.count(Verdict::Reproduced), 1);
    assert!(out.join("figures/demo-fig1.svg").exists() && !out.join("figures/demo-nothing.svg").exists());
    let ledger: Json = serde_json::from_slice(&fs::read(out.join("claims.json")).unwrap()).unwrap();
    assert_eq!((&ledger[0]["verdict"], &ledger[0]["printed"]), (&Json::Null, &json!(1.0)));
    assert_eq!(ledger[0]["note"], json!("The check failed: the pair <A, C> is not observable."));
}

#[test]
fn an_id_that_occurs_twice_is_refused() {
    let (twice, _) =
        run("twice", paper(vec![claim("demo.a", "1", right), claim("demo.a", "2", right)], vec![], vec![]));
    assert!(matches!(twice, Err(ReproduceError::Duplicate { id }) if id == "demo.a"));
}

fn numbers(_: &Context, id: &str) -> Result<Table, CheckError> {
    if id == "demo-broken" { Err("no numbers".into()) } else { Ok(Table::new().column("t", [0.0, 0.5])) }
}

/// Datasets are written and linked; one that fails is listed; a figure and a dataset of one name would overwrite each
/// other.
#[test]
fn numbers_without_a_picture_are_written_too() {
    let with = |ids: &[&'static str]| Paper {
        datasets: ids.iter().map(|&id| Dataset { id, tabulate: numbers }).collect(),
        ..paper(vec![], vec![Drawing { id: "demo-fig1", draw: decay }], vec![])
    };
    let (summary, out) = run("numbers", with(&["demo-run", "demo-broken"]));
    let failures = summary.unwrap().failures;
    assert_eq!(failures.iter().map(|failure| failure.id.as_str()).collect::<Vec<_>>(), ["demo-broken"]);
    assert_eq!(fs::read_to_string(out.join("data/demo-run.csv")).unwrap(), "t\n0.0\n0.5\n");
    assert!(fs::read_to_string(out.join("report.html")).unwrap().contains("href=\"data/demo-run.csv\""));
    let (twice, _) = run("numbers-twice", with(&["demo-fig1"]));
    assert!(matches!(twice, Err(ReproduceError::Duplicate { id }) if id == "demo-fig1"));
}

/// The pages in docs/ name claims in code; each must be in the ledger.
#[test]
fn every_claim_that_the_docs_name_exists() {
    let papers = luenberger_reproduce::papers();
    let known: Vec<&str> = papers.iter().flat_map(|paper| paper.claims.iter().map(|claim| claim.id)).collect();
    for (page, name, prefix) in [
        (include_str!("../../../../docs/theory-cubic.md"), "theory-cubic.md", "cubic."),
        (include_str!("../../../../docs/theory-mvt.md"), "theory-mvt.md", "mvt."),
        (include_str!("../../../../docs/theory-kkl.md"), "theory-kkl.md", "kkl."),
    ] {
        let named: Vec<&str> = page.split('`').filter(|word| word.starts_with(prefix) && !word.contains(' ')).collect();
        assert!(named.len() > 10, "{name}: {named:?}");
        for id in named {
            assert!(known.contains(&id), "{id} is in docs/{name} and not in the ledger");
        }
    }
}

/// The data of the converter's two runs: columns and times by which others find their way in them.
#[test]
fn the_data_of_the_converter_have_their_columns_and_times() {
    let papers = luenberger_reproduce::papers();
    let drawings: Vec<&Drawing> = papers.iter().flat_map(|paper| &paper.figures).collect();
    let context = Context::new(env!("CARGO_TARGET_TMPDIR"));
    let observers = ["kklo", "pebo", "kkl_peb", "iandi", "hgo_varying", "hgo_linear", "hgo_exact"];
    let estimates = observers.iter().flat_map(|name| [format!("i1_{name}"), format!("v4_{name}")]);
    let wanted: Vec<String> =
        ["t", "u", "i1", "v2", "i3", "v4"].map(str::to_owned).into_iter().chain(estimates).collect();
    for id in ["kkl-cuk-noise-free", "kkl-cuk-noise"] {
        let drawing = drawings.iter().find(|drawing| drawing.id == id).unwrap();
        let plate = (drawing.draw)(&context).unwrap();
        plate.figure.check().unwrap();
        let found: Vec<&str> = plate.data.columns().iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(found, wanted);
        let t = &plate.data.columns()[0].1;
        for time in [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.19, 0.205, 0.21, 0.25, 0.39, 1.2] {
            assert!(t.contains(&time), "{id} lacks t = {time}");
        }
    }
}

/// The numbers that the README gives.
#[test]
fn the_readme_counts_right() {
    let papers = luenberger_reproduce::papers();
    let figures: usize = papers.iter().map(|paper| paper.figures.len()).sum();
    let page = include_str!("../../../../README.md");
    let of = |class: Class, paper: &Paper| paper.claims.iter().filter(|claim| claim.class == class).count();
    for class in Class::ALL {
        let each: Vec<String> = papers.iter().map(|paper| of(class, paper).to_string()).collect();
        let all: usize = papers.iter().map(|paper| of(class, paper)).sum();
        let row = format!("| {class} | {} | {all} |", each.join(" | "));
        assert!(page.contains(&row), "{row}");
    }
    let own: usize =
        papers.iter().flat_map(|paper| &paper.claims).filter(|claim| Class::OWN.contains(&claim.class)).count();
    assert!(page.contains(&format!("{own} claims of the papers:")), "{own}");
    assert!(page.contains(&format!("{figures} figures")), "{figures}");
}

/// What others refer to keeps its name.
#[test]
fn the_claims_of_the_mean_value_theorem_paper_keep_their_names() {
    let papers = luenberger_reproduce::papers();
    let paper = papers.iter().find(|paper| paper.key == "mvt").unwrap();
    for id in [
        "mvt.ex1.e0-is-identity",
        "mvt.ex1.e01-converges",
        "mvt.ex1.beta-in-unit-interval",
        "mvt.ex1.beta-unique",
        "mvt.ex2.e0",
        "mvt.ex2.e01",
        "mvt.ex2.classical-e0",
        "mvt.ex2.classical-e01",
        "mvt.ex2.printed-e01",
        "mvt.ex2.beta-in-unit-interval",
        "mvt.ex2.gain-of-16",
        "mvt.ex2.unstructured-lipschitz",
        "mvt.ex2.polytopic",
        "mvt.thm1.as-stated",
        "mvt.thm1.internal-decrease",
        "mvt.thm1.eta-half",
        "mvt.raising-eta",
        "mvt.repair.ex1",
        "mvt.repair.ex2-classical",
        "mvt.repair.ex2-printed",
    ] {
        assert!(paper.claims.iter().any(|claim| claim.id == id), "{id}");
    }
    assert_eq!(paper.datasets.len(), 16);
}

/// The pages on the third paper name claims too.
#[test]
fn every_claim_that_the_docs_name_of_the_third_paper_exists() {
    let papers = luenberger_reproduce::papers();
    let known: Vec<&str> = papers.iter().flat_map(|paper| paper.claims.iter().map(|claim| claim.id)).collect();
    for (page, text) in [
        ("theory-kkl.md", include_str!("../../../../docs/theory-kkl.md")),
        ("numerical-kkl.md", include_str!("../../../../docs/numerical-kkl.md")),
    ] {
        let named: Vec<&str> =
            text.split('`').filter(|word| word.starts_with("kkl.") && !word.contains([' ', '\n'])).collect();
        assert!(!named.is_empty(), "{page} names no claim");
        for id in named {
            assert!(known.contains(&id), "{id} is in docs/{page} and not in the ledger");
        }
    }
}

/// The claims of the third paper beside its converter keep their names, and come out as the pages in docs/ say. (The
/// numerical observer, whose fit takes a while, is tested in `tests/tests/it/numerical_kkl.rs`.)
#[test]
fn the_examples_of_the_third_paper_come_out_as_the_docs_say() {
    use Verdict::{Refuted, Reproduced, Underspecified};
    let papers = luenberger_reproduce::papers();
    let claims: Vec<&Claim> = papers.iter().flat_map(|paper| &paper.claims).collect();
    let find = |id| claims.iter().find(|claim| claim.id == id).unwrap_or_else(|| panic!("{id}"));
    let context = Context::new(".");
    for (id, verdict) in [
        ("kkl.prop5.as-printed", Refuted),
        ("kkl.prop5.repaired", Reproduced),
        ("kkl.set-relation", Underspecified),
        ("kkl.a1.dimension", Refuted),
        ("kkl.r1", Reproduced),
        ("kkl.r5.imaginary", Reproduced),
        ("kkl.r7", Underspecified),
        ("kkl.r8", Reproduced),
        ("kkl.r9.pebo", Refuted),
        ("kkl.r10", Refuted),
        ("kkl.prop4.shape-of-q", Refuted),
        ("kkl.prop6.pde-residual", Reproduced),
        ("kkl.prop6.boundedness", Underspecified),
        ("kkl.prop6.x2-converges", Reproduced),
        ("kkl.prop6.x3-converges", Reproduced),
        ("kkl.prop6.theta-positive", Underspecified),
        ("kkl.prop6.psi-start", Reproduced),
        ("kkl.prop6.psi-zero", Reproduced),
        ("kkl.prop6.f3", Reproduced),
        ("kkl.prop6.kklo-varying", Reproduced),
        ("kkl.prop7.gradient", Refuted),
        ("kkl.prop7.filtered", Reproduced),
        ("kkl.prop7.error-equation", Refuted),
        ("kkl.prop7.drem", Underspecified),
        ("kkl.prop7.not-exciting", Reproduced),
        ("kkl.cuk.controller", Underspecified),
        ("kkl.cuk.iandi-nonlinear", Refuted),
        ("kkl.cuk.not-square-integrable", Reproduced),
    ] {
        let record = find(id).examine("kkl", &context);
        assert_eq!(record.verdict, Some(verdict), "{id}: {}", record.note);
    }
    for id in ["kkl.duffing.numerical", "kkl.duffing.pde-residual"] {
        find(id);
    }
}

/// How the papers are read decides these; each verdict is computed, and each refutation shows its ground.
#[test]
fn the_readings_of_the_papers_come_out_as_the_docs_say() {
    use Class::{Example, Misprint, Ours, Reading, Theorem};
    use Verdict::{Refuted, Reproduced, Underspecified};
    let papers = luenberger_reproduce::papers();
    let context = Context::new(".");
    for (id, class, verdict) in [
        // The plant of Example 2 is a44 = 0 with the printed C; the variants are no claims of the paper.
        ("mvt.ex2.a44", Misprint, Refuted),
        ("mvt.ex2.e0", Example, Reproduced),
        ("mvt.ex2.e01", Example, Underspecified),
        ("mvt.ex2.classical-e01", Reading, Refuted),
        ("mvt.ex2.printed-e01", Reading, Refuted),
        // Equality in (23): a singular theta is within the hypotheses, an unobservable pair is not.
        ("cubic.thm5.equality", Misprint, Refuted),
        ("cubic.thm5.equality-observable", Ours, Reproduced),
        ("cubic.eq9", Theorem, Reproduced),
        ("cubic.cor1", Theorem, Reproduced),
        ("cubic.thm3.faster", Theorem, Underspecified),
        ("cubic.ex1.faster-from-every-direction", Ours, Reproduced),
        ("cubic.ex1.peak-cubic", Reading, Reproduced),
        ("cubic.ex1.peak-linear", Reading, Reproduced),
        ("cubic.ex1.settling-first-crossing", Reading, Reproduced),
        ("cubic.ex2.epsilon-bound-holds", Ours, Reproduced),
        ("cubic.thm2.strict", Theorem, Refuted),
        ("cubic.thm2.arrow", Misprint, Refuted),
        ("cubic.thm3.larger", Theorem, Reproduced),
        ("cubic.remark3.step", Theorem, Underspecified),
        ("cubic.thm4.margin", Theorem, Underspecified),
        ("cubic.thm5.linear", Theorem, Reproduced),
        ("cubic.lemma1", Misprint, Refuted),
        ("cubic.fig6", Example, Underspecified),
        ("cubic.ex3.sign-of-n", Misprint, Refuted),
        ("mvt.thm1.as-stated", Theorem, Refuted),
        ("mvt.eq7", Theorem, Refuted),
        ("mvt.necessary", Theorem, Refuted),
        ("mvt.ex1.e01-converges", Example, Underspecified),
        ("mvt.ex2.both-as-printed", Reading, Reproduced),
        ("mvt.eq18", Misprint, Refuted),
        ("mvt.linear-term", Misprint, Refuted),
        ("mvt.unknown-inputs", Misprint, Refuted),
        ("mvt.figure-numbers", Misprint, Refuted),
        ("mvt.ex2.beta-continuous", Theorem, Refuted),
        ("mvt.thm1.eta-half", Ours, Reproduced),
        ("mvt.lsqnonlin-finds-beta", Ours, Reproduced),
        ("cubic.thm4", Theorem, Underspecified),
        ("cubic.thm5", Theorem, Underspecified),
        // What the papers say in passing.
        ("cubic.near-zero", Theorem, Reproduced),
        ("cubic.remark2.zubov", Theorem, Reproduced),
        ("cubic.thm5.footnote", Theorem, Reproduced),
        ("cubic.thm6.lmi", Theorem, Reproduced),
        ("cubic.noise.bound", Ours, Reproduced),
        ("cubic.noise.example1", Ours, Reproduced),
        ("mvt.fig5", Example, Underspecified),
        ("kkl.prop1", Theorem, Reproduced),
        ("kkl.prop2", Theorem, Reproduced),
        ("kkl.prop3", Theorem, Reproduced),
        ("kkl.prop4", Theorem, Underspecified),
        ("kkl.r5", Theorem, Reproduced),
        ("kkl.r6", Theorem, Reproduced),
        ("kkl.r9", Theorem, Refuted),
        ("kkl.r2", Ours, Reproduced),
        ("kkl.prop7.blocks", Theorem, Reproduced),
        ("kkl.prop7.rows", Theorem, Reproduced),
        ("kkl.prop7.monotonic", Theorem, Reproduced),
        ("kkl.phi-of-the-input", Ours, Reproduced),
        ("kkl.cuk.output-feedback", Ours, Reproduced),
    ] {
        let (paper, claim) = papers
            .iter()
            .find_map(|paper| paper.claims.iter().find(|claim| claim.id == id).map(|claim| (paper, claim)))
            .unwrap_or_else(|| panic!("{id}"));
        let record = claim.examine(paper.key, &context);
        assert_eq!(
            (record.class, record.verdict),
            (class, Some(verdict)),
            "{id}: {} {:?}",
            record.note,
            record.computed
        );
        assert_eq!(record.owes(), None, "{id}");
        if verdict == Refuted {
            assert!(record.hypotheses.iter().all(|found| found.holds == Some(true)), "{id}: {:?}", record.hypotheses);
        }
    }
}

/// Theorem 1 of the mean-value-theorem paper: five cases, each with (4) proved, everywhere where the plant is linear
/// and along the run elsewhere. x' = u, y = x, where (4) reads 0 < 0, is none of them.
#[test]
fn every_counterexample_to_theorem_1_fulfils_condition_4() {
    let papers = luenberger_reproduce::papers();
    let claim = papers.iter().flat_map(|paper| &paper.claims).find(|claim| claim.id == "mvt.thm1.as-stated").unwrap();
    let record = claim.examine("mvt", &Context::new("."));
    let fourth: Vec<_> = record.hypotheses.iter().filter(|found| found.hypothesis.starts_with("(4)")).collect();
    let everywhere = fourth.iter().filter(|found| found.how.ends_with("everywhere")).count();
    let along = fourth.iter().filter(|found| found.how.contains("along the run only")).count();
    assert_eq!((fourth.len(), everywhere, along), (5, 3, 2), "{fourth:?}");
    assert!(fourth.iter().all(|found| found.holds == Some(true) && found.how.starts_with("proved")), "{fourth:?}");
    assert_eq!(record.note.matches("Counterexample, ").count(), 5, "{}", record.note);
}

/// Theorems 4 and 5 are tested where their hypotheses hold, and the ledger shows them.
#[test]
fn the_robust_theorems_show_their_hypotheses() {
    let papers = luenberger_reproduce::papers();
    for id in ["cubic.thm4", "cubic.thm5"] {
        let claim = papers.iter().flat_map(|paper| &paper.claims).find(|claim| claim.id == id).unwrap();
        let record = claim.examine("cubic", &Context::new("."));
        let proved = |found: &Hypothesis| found.holds == Some(true) && found.how.contains("proved");
        assert!(record.hypotheses.len() >= 6 && record.hypotheses.iter().all(proved), "{id}: {:?}", record.hypotheses);
    }
}

/// Progress is a line for each step where standard error is no terminal. This test starts itself in a process of its
/// own, whose standard error it can read.
#[test]
fn there_is_no_bar_off_the_terminal() {
    let inner = "LUENBERGER_REPRODUCE_TEST_OF_PROGRESS";
    if std::env::var_os(inner).is_some() {
        let claims = vec![claim("demo.right", "0.33", right), claim("demo.fails", "1.0", fails)];
        run("progress", paper(claims, vec![Drawing { id: "demo-fig1", draw: decay }], vec![])).0.unwrap();
        return;
    }
    let run = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "run::there_is_no_bar_off_the_terminal", "--nocapture"])
        .env(inner, "1")
        .output()
        .unwrap();
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.success() && !said.contains('\u{1b}') && !said.contains('\r'), "{said:?}");
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 3, "{said}");
    for (line, (step, word)) in lines.into_iter().zip([
        ("[  1/3] demo.right ", " reproduced "),
        ("[  2/3] demo.fails ", " failed "),
        ("[  3/3] demo-fig1 ", " drawn "),
    ]) {
        assert!(line.starts_with(step) && line.contains(word) && line.ends_with(" s"), "{line}");
    }
}

#[test]
fn the_template_of_the_progress_bar_is_well_formed() {
    assert!(indicatif::ProgressStyle::with_template(terminal::PROGRESS).is_ok());
}
