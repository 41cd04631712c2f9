//! Every line of text that an export writes beside its numbers, in one reviewed file, `texts.txt`: comments,
//! directives, headers, build files, descriptions of FMUs, READMEs. Numbers are compiled and compared by other tests,
//! and are `#` here.
//!
//! Run with `UPDATE=1` in the environment after an intended change, and read the difference.

use std::collections::BTreeSet;
use std::io::{Cursor, Read};
use std::path::Path;

use luenberger_export::fmu::Version;
use luenberger_export::{Export, ExportableObserver, FixedPointFormat, FixedPointFormats, Names, Scalar};
use luenberger_random::Random;
use nalgebra::DMatrix;

use crate::compiled::{program, semi_implicit, varying, with_feedback};
use crate::fuzz;

/// The lines with `#` for numbers and digests; of sources the comments and directives.
fn note(lines: &mut BTreeSet<String>, file: &str, text: &str) {
    let is_source = Path::new(file).extension().is_some_and(|end| end == "c" || end == "rs" || end == "csv");
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let begin = line.trim_start();
        if is_source && !["/", "*", "#"].iter().any(|sign| begin.starts_with(sign)) {
            continue;
        }
        let (mut words, mut rest) = (String::new(), line);
        while let Some(letter) = rest.chars().next() {
            let digest = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_hexdigit() || c == '-').len();
            let number = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '.').len();
            let is_inside = words.ends_with(|before: char| before.is_alphanumeric() || before == '_');
            let length = match (digest >= 32, letter.is_ascii_digit() && !is_inside) {
                (true, _) => digest,
                (false, true) => number,
                (false, false) => 0,
            };
            words.push(if length > 0 { '#' } else { letter });
            rest = &rest[length.max(letter.len_utf8())..];
        }
        lines.insert(words);
    }
}

fn all_files(lines: &mut BTreeSet<String>, export: &Export) {
    for files in [export.c().unwrap(), export.rust().unwrap()] {
        for file in &files {
            note(lines, &file.name, &file.text);
        }
    }
    for version in [Version::Two, Version::Three] {
        let Ok(fmu) = export.fmu(version) else { continue };
        let mut archive = zip::ZipArchive::new(Cursor::new(fmu.archive().unwrap())).unwrap();
        for name in
            fmu.paths().filter(|name| Path::new(name).extension().is_some_and(|end| end == "xml" || end == "html"))
        {
            let mut text = String::new();
            archive.by_name(name).unwrap().read_to_string(&mut text).unwrap();
            note(lines, name, &text);
        }
    }
    for file in export.fmu_test().into_iter().flatten() {
        note(lines, &file.name, &file.text);
    }
}

/// Columns with units, of some a name that would end a comment, and the unit of the time.
fn named(observer: ExportableObserver, scalar: Scalar) -> Export {
    let size = observer.dimensions();
    let mut names = Names::numbered(size.estimate, observer.plant_inputs(), size.outputs);
    names.time_unit.push_str("ms");
    names.units = (0..size.estimate).map(|i| if i == 0 { "m".to_owned() } else { String::new() }).collect();
    names.output_units = vec!["m/s*/".to_owned(); size.outputs];
    let sentence = "The error decays at least like exp(-2 t), which is shown for every state of the region by an \
                    inequality that was verified, with all of its numbers as they are stored.";
    let export = Export::new("plant", observer, scalar, &vec![0.25; size.estimate], names).unwrap();
    export.statement(&[sentence.to_owned()]).source("the study", &"5".repeat(64))
}

#[test]
fn every_line_of_text_is_reviewed() {
    let mut lines = BTreeSet::new();
    let mut random = Random(7);
    for k in 0..60 {
        let scalar = if k % 3 == 0 { Scalar::Binary32 } else { Scalar::Binary64 };
        all_files(&mut lines, &fuzz::export("plant", fuzz::nonlinear(&mut random), scalar));
        if k % 4 == 0 {
            let estimator = ExportableObserver::MovingHorizon(fuzz::moving_horizon(&mut random));
            all_files(&mut lines, &fuzz::export("plant", estimator, scalar));
        }
    }
    for sizes in [(2, 1, 1), (3, 0, 2)] {
        for is_cubic in [false, true] {
            let observer = || program(3, sizes, is_cubic, sizes.1 > 0);
            if is_cubic {
                all_files(&mut lines, &named(varying(&observer()), Scalar::Binary64));
            }
            all_files(&mut lines, &named(observer(), Scalar::Binary64));
            if sizes.1 > 0 {
                all_files(&mut lines, &with_feedback(named(observer(), Scalar::Binary32)));
            }
            if !is_cubic {
                let update = DMatrix::from_element(sizes.0, sizes.2, 0.125);
                all_files(&mut lines, &named(observer(), Scalar::Binary64).with_update(&update).unwrap());
            }
        }
    }
    all_files(&mut lines, &named(semi_implicit(5, (4, 1, 2), false), Scalar::Binary64));
    all_files(
        &mut lines,
        &named(program(3, (2, 1, 1), false, false), Scalar::Binary64).titled("Reduced-order observer"),
    );
    let fixed = named(program(3, (2, 1, 1), false, false), Scalar::Binary64);
    let formats = FixedPointFormats::from(FixedPointFormat::new(6, 26).unwrap());
    for file in fixed.fixed_point(formats).unwrap().c() {
        note(&mut lines, &file.name, &file.text);
    }
    let text: String = lines.into_iter().map(|line| line + "\n").collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/texts.txt");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let expected = std::fs::read_to_string(path).unwrap_or_default();
    for (found, expected) in text.lines().zip(expected.lines()) {
        assert_eq!(found, expected, "UPDATE=1 writes the file anew");
    }
    assert_eq!(text.lines().count(), expected.lines().count());
}

/// With the units, and without what would end a comment; sentences in lines of at most 100 characters.
#[test]
fn names_of_columns_stand_with_their_units() {
    let export = named(program(3, (2, 1, 1), false, false), Scalar::Binary64);
    let files = export.c().unwrap();
    let header = &files.iter().find(|file| file.name == "plant.h").unwrap().text;
    for line in [" * Period:  0.05 ms", " * States:  x1 (m), x2", " * Inputs:  u1", " * Outputs: y1 (m/s* /)"] {
        assert!(header.lines().any(|found| found == line), "{line}: {header}");
    }
    let sentence: Vec<&str> =
        header.lines().skip_while(|line| !line.starts_with(" * The error")).take_while(|line| *line != " *").collect();
    let text = sentence.iter().map(|line| line.trim_start_matches(" * ")).collect::<Vec<_>>();
    assert!(text.iter().all(|line| line.len() <= 100) && text.len() == 2, "{text:?}");
    // The first word of the second line would not have fitted into the first.
    assert!(text[0].len() + 1 + text[1].split(' ').next().unwrap().len() > 100, "{text:?}");
}
