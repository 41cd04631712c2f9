//! FMUs: the description, the archive, and the wrapper, driven by a small importer in C.

use std::io::{Cursor, Read};
use std::path::Path;
use std::process::Command;

use luenberger_export::fmu::{Version, compilers as libraries};
use luenberger_export::{Export, ExportableObserver, Names, Scalar, golden};
use luenberger_observers::SampledNonlinearObserver;
use nalgebra::dmatrix;

use crate::compiled::{self, SANITISERS, can_sanitise, export, folder, program, with_feedback};
use crate::fuzz;

const VERSIONS: [Version; 2] = [Version::Two, Version::Three];

/// An importer: instantiates, sets, steps, gets; compares with the golden vectors; saves, serializes and restores
/// states.
const IMPORTER_2: &str = include_str!("importer2.c");
const IMPORTER_3: &str = include_str!("importer3.c");

/// The golden vectors as a header of the importer.
fn vectors(export: &Export, token: &str) -> String {
    let steps = golden::steps(export, golden::STEPS).unwrap();
    let table = |name: &str, of: fn(&golden::Step) -> &Vec<f64>| {
        let rows: Vec<String> = steps
            .iter()
            .map(|step| {
                let row: Vec<String> = of(step).iter().map(|x| format!("{x:e}")).collect();
                format!("{{ {} }}", if row.is_empty() { "0".to_owned() } else { row.join(", ") })
            })
            .collect();
        let width = of(&steps[0]).len().max(1);
        format!("static const double {name}[{}][{width}] = {{\n{}\n}};\n", steps.len(), rows.join(",\n"))
    };
    format!(
        "#define STEPS {}\n#define TOKEN \"{token}\"\n#define PERIOD {:e}\n#define LINEAR {}\n#define TIMED {}\n#define COPY {}\nenum {{ N = {}, M = {}, P = {}, FED = {} }};\n{}{}{}{}",
        steps.len(),
        export.observer().period(),
        i32::from(matches!(export.observer(), ExportableObserver::Linear(_) | ExportableObserver::Cubic(_))),
        i32::from(export.c().unwrap()[0].text.contains("uint64_t sample;")),
        i32::from(matches!(
            export.observer(),
            ExportableObserver::SampledNonlinear(_) | ExportableObserver::Discrete(_)
        )),
        steps[0].estimate.len(),
        steps[0].u.len(),
        steps[0].y.len(),
        i32::from(!steps[0].applied.is_empty()),
        table("golden_u", |step| &step.u),
        table("golden_y", |step| &step.y),
        table("golden_xhat", |step| &step.estimate),
        table("golden_applied", |step| &step.applied),
    )
}

fn token(description: &str) -> String {
    let start = description.find("=\"{").unwrap() + 2;
    description[start..start + 38].to_owned()
}

fn read(archive: &[u8], name: &str) -> String {
    let mut archive = zip::ZipArchive::new(Cursor::new(archive)).unwrap();
    let mut text = String::new();
    archive.by_name(name).unwrap().read_to_string(&mut text).unwrap();
    text
}

/// Compiles the sources of the FMU with the importer and runs it.
#[track_caller]
fn runs(export: &Export, version: Version, folder: &Path, compiler: &str, flags: &[&str]) {
    let fmu = export.fmu(version).unwrap();
    fmu.write_sources(folder).unwrap();
    let description = read(&fmu.archive().unwrap(), "modelDescription.xml");
    std::fs::write(folder.join("vectors.h"), vectors(export, &token(&description))).unwrap();
    let (wrapper, importer) = match version {
        Version::Two => ("fmi2.c", IMPORTER_2),
        Version::Three => ("fmi3.c", IMPORTER_3),
    };
    std::fs::write(folder.join("importer.c"), importer).unwrap();
    let built = Command::new(compiler)
        .current_dir(folder)
        .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror"])
        .args(flags)
        .args(["plant.c", "model.c", wrapper, "importer.c", "-o", "importer", "-lm"])
        .output()
        .unwrap();
    assert!(built.status.success(), "{compiler} {flags:?}: {}", String::from_utf8_lossy(&built.stderr));
    let ran = Command::new(folder.join("importer")).output().unwrap();
    let text = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.success(), "{version:?} {flags:?}: {text}{}", String::from_utf8_lossy(&ran.stderr));
    assert!(text.contains("64 of 64 steps agree"), "{text}");
}

#[test]
fn an_importer_gets_the_golden_vectors() {
    let compilers = compiled::compilers();
    if compilers.is_empty() {
        eprintln!("SKIPPED: no C compiler");
    }
    let folder = folder("fmu");
    for (k, compiler) in compilers.into_iter().enumerate() {
        // Another compiler sees one of the observers: the step is tested with each elsewhere.
        let kinds = [((3, 2, 2), true, true), ((2, 1, 1), false, false), ((2, 0, 1), true, false)];
        let (kinds, seeds) = match (k, compiled::is_complete()) {
            (0, true) => (&kinds[..], 4),
            (0, false) => (&kinds[..2], 1),
            _ => (&kinds[..1], 0),
        };
        for version in VERSIONS {
            for &(sizes, is_cubic, fed) in kinds {
                for scalar in [Scalar::Binary32, Scalar::Binary64] {
                    let export = export(program(11, sizes, is_cubic, fed), scalar);
                    let block = (sizes.1 > 0).then(|| with_feedback(export.clone()));
                    for export in [Some(export), block].into_iter().flatten() {
                        runs(&export, version, &folder, compiler, &[compiled::optimisation()]);
                        let is_sanitised = scalar == Scalar::Binary32 && compiled::is_complete();
                        if is_sanitised && can_sanitise(compiler) {
                            runs(&export, version, &folder, compiler, &SANITISERS);
                        }
                    }
                }
            }
            for seed in 0..seeds {
                let export =
                    fuzz::export("plant", fuzz::nonlinear(&mut luenberger_random::Random(seed)), Scalar::Binary64);
                let block = (export.observer().dimensions().inputs > 0).then(|| with_feedback(export.clone()));
                for export in [Some(export), block].into_iter().flatten() {
                    runs(&export, version, &folder, compiler, &[compiled::optimisation()]);
                }
            }
        }
    }
}

/// The samples of a plant that depends on time are numbered from the start of the simulation, which is a multiple of
/// the period: by the standard the start time is the first value of the independent variable.
#[test]
fn the_samples_of_an_fmu_are_those_of_its_start_time() {
    let Some(compiler) = compiled::compilers().first().copied() else { return };
    let plant = crate::moving_horizon::plant(&["x2", "-x1 - 0.5*x2 + 3*sin(4*t) + u1"], &["x1"], 1);
    let observer = SampledNonlinearObserver::new(plant, dmatrix![1.0; 0.5], 0.1, 2).unwrap();
    let program = ExportableObserver::SampledNonlinear(observer);
    let folder = folder("fmu-start");
    for version in VERSIONS {
        for scalar in [Scalar::Binary32, Scalar::Binary64] {
            runs(&export(program.clone(), scalar), version, &folder, compiler, &[compiled::optimisation()]);
        }
    }
}

#[test]
fn archives_are_complete_and_the_same_each_time() {
    let export = export(program(3, (2, 1, 1), false, false), Scalar::Binary32);
    for version in VERSIONS {
        let mut fmu = export.fmu(version).unwrap();
        let archive = fmu.archive().unwrap();
        assert_eq!(archive, export.fmu(version).unwrap().archive().unwrap());
        let mut expected: Vec<&str> =
            vec!["modelDescription.xml", "sources/plant.h", "sources/plant.c", "sources/model.h"];
        expected.extend(["sources/model.c", "sources/instance.h"]);
        match version {
            Version::Two => expected.push("sources/fmi2.c"),
            Version::Three => expected.extend(["sources/fmi3.c", "sources/buildDescription.xml"]),
        }
        expected.push("documentation/index.html");
        assert_eq!(fmu.paths().collect::<Vec<_>>(), expected);
        let Some(compiler) = libraries().into_iter().next() else {
            eprintln!("SKIPPED: no C compiler");
            continue;
        };
        let path = fmu.compile(&compiler, &folder("library")).unwrap();
        assert!(path.starts_with("binaries/") && fmu.paths().any(|name| name == path), "{path}");
    }
}

#[test]
fn the_description_has_names_units_and_start_values() {
    let mut names = Names::numbered(2, 1, 1);
    names.states = vec!["position".to_owned(), "a < \"b\" & \u{3c9}".to_owned()];
    names.units = vec!["m".to_owned(), "m/s".to_owned()];
    names.input_units = vec!["N".to_owned()];
    names.output_units = vec!["V".to_owned()];
    names.time_unit = "ms".to_owned();
    let program = program(3, (2, 1, 1), false, false);
    let export = Export::new("plant", program.clone(), Scalar::Binary64, &[0.1, -0.5], names.clone()).unwrap();
    for version in VERSIONS {
        let text = read(&export.fmu(version).unwrap().archive().unwrap(), "modelDescription.xml");
        for part in [
            "name=\"xhat.position\"",
            "name=\"initial.a &lt; &quot;b&quot; &amp; \u{3c9}\"",
            "unit=\"m/s\" start=\"-0.5\"",
            "<Unit name=\"m\"/>",
            "<Unit name=\"N\"/>",
            "variableNamingConvention=\"flat\"",
            // 0.05 ms.
            "stepSize=\"5e-5\"",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        for (name, unit) in [("u.u1", "N"), ("y.y1", "V"), ("innovation.y1", "V")] {
            let line = text.lines().find(|line| line.contains(&format!("name=\"{name}\""))).unwrap();
            assert!(line.contains(&format!("unit=\"{unit}\"")), "{line}");
        }
        let other = Export::new("plant", program.clone(), Scalar::Binary64, &[0.2, -0.5], names.clone()).unwrap();
        let other = read(&other.fmu(version).unwrap().archive().unwrap(), "modelDescription.xml");
        assert_ne!(token(&text), token(&other));
    }
}

/// FMI 3.0, section 2.5: the sources to build are named in `buildDescription.xml`, which FMI 2.0 does not have.
#[test]
fn the_sources_of_an_fmu_are_described() {
    let export = export(program(3, (2, 1, 1), false, false), Scalar::Binary64);
    let fmu = export.fmu(Version::Three).unwrap();
    assert_eq!(fmu.file_name(), "plant.fmu");
    let text = read(&fmu.archive().unwrap(), "sources/buildDescription.xml");
    assert!(
        text.starts_with("<?xml version=\"1.0\"") && text.contains("<fmiBuildDescription fmiVersion=\"3.0\""),
        "{text}"
    );
    for source in fmu.paths().filter(|path| path.strip_suffix(".c").is_some()) {
        let name = source.strip_prefix("sources/").unwrap();
        assert!(text.contains(&format!("name=\"{name}\"")), "{name} is not in\n{text}");
    }
    assert!(text.contains("modelIdentifier=\"plant\""), "{text}");
}

/// The table for fmpy has the names and numbers of the golden vectors, and the script the name of the archive.
#[test]
fn the_test_of_an_fmu_has_the_golden_vectors() {
    let export = export(program(3, (2, 1, 1), false, false), Scalar::Binary64);
    let files = export.fmu_test().unwrap();
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(names, ["plant_golden.csv", "test_plant.py"]);
    let mut lines = files[0].text.lines();
    assert_eq!(lines.next(), Some("\"u.u1\",\"y.y1\",\"xhat.x1\",\"xhat.x2\""));
    let steps = golden::steps(&export, golden::STEPS).unwrap();
    assert_eq!(lines.clone().count(), steps.len());
    for (line, step) in lines.zip(&steps) {
        let numbers: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(numbers, [&step.u[..], &step.y, &step.estimate].concat());
    }
    assert!(files[1].text.contains("plant.fmu") && files[1].text.contains("plant_golden.csv"), "{}", files[1].text);
}

/// XML 1.0 has no control characters but the three of white space, and in attributes these become spaces.
#[test]
fn the_description_has_no_control_characters() {
    let mut names = Names::numbered(2, 1, 1);
    names.states[0] = "a\u{1}b".to_owned();
    names.inputs[0] = "c\nd".to_owned();
    names.outputs[0] = "e\u{7f}\tf".to_owned();
    names.units = vec!["m\u{8}".to_owned(), String::new()];
    let program = program(3, (2, 1, 1), false, false);
    let export = Export::new("plant", program, Scalar::Binary64, &[0.0, 0.0], names).unwrap();
    for version in VERSIONS {
        let text = read(&export.fmu(version).unwrap().archive().unwrap(), "modelDescription.xml");
        assert!(text.chars().all(|c| c == '\n' || !c.is_control()), "{version:?} {text:?}");
        for name in ["\"xhat.a b\"", "\"u.c d\"", "\"y.e  f\"", "\"initial.a b\""] {
            let line = text.lines().find(|line| line.contains(&format!("name={name}")));
            assert!(line.is_some(), "{name} is not in a line of\n{text}");
        }
    }
}

#[test]
fn what_cannot_be_an_fmu_is_an_error() {
    let program = program(3, (2, 1, 1), false, false);
    let mut names = Names::numbered(2, 1, 1);
    names.time_unit = "fortnight".to_owned();
    let export = Export::new("plant", program.clone(), Scalar::Binary64, &[0.0, 0.0], names.clone()).unwrap();
    let error = export.fmu(Version::Three).unwrap_err().to_string();
    assert_eq!(error, "the time unit \"fortnight\" cannot be converted to seconds; s, ms, us, ns, min, h and d can");
    names.time_unit = "s".to_owned();
    names.states[1] = "x1".to_owned();
    let export = Export::new("plant", program, Scalar::Binary64, &[0.0, 0.0], names).unwrap();
    assert_eq!(export.fmu(Version::Two).unwrap_err().to_string(), "two columns are named \"xhat.x1\"");
}
