//! `modelDescription.xml` and `buildDescription.xml`.

use std::collections::BTreeSet;
use std::fmt::Write;

use luenberger_wording::escape;

use super::Version;
use crate::Export;
use crate::error::ExportError;

/// A variable, in the order of its value reference; that of the time is 0.
struct Variable {
    name: String,
    description: String,
    unit: String,
    role: Role,
}

#[derive(Clone, Copy, PartialEq)]
enum Role {
    Input,
    /// An output of the value 0 until the first step.
    Output,
    /// An output that follows from parameters and inputs before the first step.
    Derived,
    Parameter(f64),
}

/// Text inside an attribute, on one line.
fn attribute(text: &str) -> String {
    escape(&text.replace(char::is_control, " "))
}

fn is_identifier(name: &str) -> bool {
    name.starts_with(|letter: char| letter.is_ascii_alphabetic() || letter == '_')
        && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

fn variables(export: &Export) -> Vec<Variable> {
    let names = &export.names;
    let mut all = Vec::new();
    let mut group = |prefix: &str, columns: &[String], units: &[String], about: &str, role: &dyn Fn(usize) -> Role| {
        for (i, name) in columns.iter().enumerate() {
            all.push(Variable {
                name: format!("{prefix}.{name}"),
                description: format!("{about} {name}"),
                unit: units.get(i).cloned().unwrap_or_default(),
                role: role(i),
            });
        }
    };
    let fed = export.feedback.is_some();
    let (u, role) = if fed {
        ("input to apply until the next sample:", Role::Derived)
    } else {
        ("input held until the next sample:", Role::Input)
    };
    group("u", &names.inputs, &names.input_units, u, &|_| role);
    group("y", &names.outputs, &names.output_units, "measured output:", &|_| Role::Input);
    group("xhat", &names.states, &names.units, "estimate of the state", &|_| Role::Derived);
    let innovation = "innovation of the last step, measured minus expected output:";
    group("innovation", &names.outputs, &names.output_units, innovation, &|_| Role::Output);
    group("initial", &names.states, &names.units, "first estimate of the state", &|i| {
        Role::Parameter(export.initial[i])
    });
    if fed {
        group("r", &names.inputs, &names.input_units, "reference, added to -K xhat:", &|_| Role::Input);
    }
    all
}

/// A number that is read back to the same bits.
fn number(x: f64) -> String {
    format!("{x:?}")
}

/// The GUID: 128 bits of the digest of all that the description says.
pub(super) fn token(export: &Export, version: Version) -> Result<String, ExportError> {
    let digits = crate::sha256(model(export, version, &[], &export.digest())?.as_bytes());
    Ok(format!("{{{}-{}-{}-{}-{}}}", &digits[..8], &digits[8..12], &digits[12..16], &digits[16..20], &digits[20..32]))
}

pub(super) fn model(export: &Export, version: Version, sources: &[String], token: &str) -> Result<String, ExportError> {
    let name = &export.identifier;
    let variables = variables(export);
    let mut known = BTreeSet::new();
    for variable in &variables {
        if !known.insert(&variable.name) {
            return Err(ExportError::Duplicate { name: variable.name.clone() });
        }
    }
    let step = number(export.period_in_seconds()?);
    let columns = [&export.names.states, &export.names.inputs, &export.names.outputs];
    let structured = columns.into_iter().flatten().all(|name| is_identifier(name));
    let token_key = if version == Version::Two { "guid" } else { "instantiationToken" };
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<fmiModelDescription
  fmiVersion=\"{}\"
  modelName=\"{name}\"
  {token_key}=\"{token}\"
  description=\"{}\"
  generationTool=\"luenberger {}\"
  variableNamingConvention=\"{}\">
",
        version.name(),
        attribute(&format!(
            "{}, one step every {step} s, computed in {}. {}",
            export.kind(),
            export.scalar.name(),
            export.statement.join(" ")
        )),
        env!("CARGO_PKG_VERSION"),
        if structured { "structured" } else { "flat" },
    );
    match version {
        // In 2.0 a step of any size would be promised by canHandleVariableCommunicationStepSize.
        Version::Two => {
            _ = writeln!(
                text,
                "  <CoSimulation
    modelIdentifier=\"{name}\"
    canHandleVariableCommunicationStepSize=\"false\"
    canNotUseMemoryManagementFunctions=\"true\"
    canGetAndSetFMUstate=\"true\"
    canSerializeFMUstate=\"true\">
    <SourceFiles>"
            );
            for source in sources {
                _ = writeln!(text, "      <File name=\"{source}\"/>");
            }
            text.push_str("    </SourceFiles>\n  </CoSimulation>\n");
        }
        Version::Three => {
            _ = writeln!(
                text,
                "  <CoSimulation
    modelIdentifier=\"{name}\"
    canHandleVariableCommunicationStepSize=\"true\"
    fixedInternalStepSize=\"{step}\"
    canGetAndSetFMUState=\"true\"
    canSerializeFMUState=\"true\"/>"
            );
        }
    }
    units(&mut text, &variables);
    text.push_str(
        "  <LogCategories>
    <Category name=\"logStatusWarning\" description=\"The estimate is not finite.\"/>
    <Category name=\"logStatusError\" description=\"A function was called wrongly.\"/>
  </LogCategories>
",
    );
    _ = writeln!(text, "  <DefaultExperiment startTime=\"0.0\" stepSize=\"{step}\"/>");
    text.push_str("  <ModelVariables>\n");
    if version == Version::Three {
        text.push_str(
            "    <Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\"/>\n",
        );
    }
    for (k, variable) in variables.iter().enumerate() {
        one(&mut text, version, k + 1, variable);
    }
    text.push_str("  </ModelVariables>\n");
    structure(&mut text, version, export, &variables);
    text.push_str("</fmiModelDescription>\n");
    Ok(text)
}

fn units(text: &mut String, variables: &[Variable]) {
    let units: BTreeSet<&String> =
        variables.iter().map(|variable| &variable.unit).filter(|unit| !unit.is_empty()).collect();
    if units.is_empty() {
        return;
    }
    text.push_str("  <UnitDefinitions>\n");
    for unit in units {
        _ = writeln!(text, "    <Unit name=\"{}\"/>", attribute(unit));
    }
    text.push_str("  </UnitDefinitions>\n");
}

fn one(text: &mut String, version: Version, reference: usize, variable: &Variable) {
    let unit =
        if variable.unit.is_empty() { String::new() } else { format!(" unit=\"{}\"", attribute(&variable.unit)) };
    // Inputs are continuous so that tools connect them to any signal; the wrapper reads them at the samples.
    let (role, start) = match variable.role {
        Role::Input => ("causality=\"input\" variability=\"continuous\"", Some(0.0)),
        Role::Output => ("causality=\"output\" variability=\"discrete\" initial=\"exact\"", Some(0.0)),
        Role::Derived => ("causality=\"output\" variability=\"discrete\" initial=\"calculated\"", None),
        Role::Parameter(x) => ("causality=\"parameter\" variability=\"fixed\" initial=\"exact\"", Some(x)),
    };
    let start = start.map(|x| format!(" start=\"{}\"", number(x))).unwrap_or_default();
    let head = format!(
        "name=\"{}\" valueReference=\"{reference}\" {role} description=\"{}\"",
        attribute(&variable.name),
        attribute(&variable.description)
    );
    _ = match version {
        Version::Two => writeln!(text, "    <ScalarVariable {head}><Real{unit}{start}/></ScalarVariable>"),
        Version::Three => writeln!(text, "    <Float64 {head}{unit}{start}/>"),
    };
}

/// Outputs change at the steps: at one instant only u depends on other variables, on r and on the estimate.
fn structure(text: &mut String, version: Version, export: &Export, variables: &[Variable]) {
    let list =
        |references: &mut dyn Iterator<Item = usize>| references.map(|k| k.to_string()).collect::<Vec<_>>().join(" ");
    let with = |prefix: &str| -> Vec<usize> {
        let one = |(k, variable): (usize, &Variable)| variable.name.starts_with(prefix).then_some(k + 1);
        variables.iter().enumerate().filter_map(one).collect()
    };
    let (references, initial) = (with("r."), with("initial."));
    let states = export.names.states.len();
    text.push_str("  <ModelStructure>\n");
    if version == Version::Two {
        text.push_str("    <Outputs>\n");
    }
    let (first_xhat, first_u) = (with("xhat.")[0], 1);
    let outputs = |k: usize| matches!(variables[k - 1].role, Role::Output | Role::Derived);
    for k in (1..=variables.len()).filter(|k| outputs(*k)) {
        // u = r - K xhat.
        let fed = variables[k - 1].name.starts_with("u.");
        let dependencies = if fed { list(&mut std::iter::once(references[k - first_u])) } else { String::new() };
        _ = match version {
            Version::Two => writeln!(text, "      <Unknown index=\"{k}\" dependencies=\"{dependencies}\"/>"),
            Version::Three => writeln!(text, "    <Output valueReference=\"{k}\" dependencies=\"{dependencies}\"/>"),
        };
    }
    if version == Version::Two {
        text.push_str("    </Outputs>\n    <InitialUnknowns>\n");
    }
    for k in (1..=variables.len()).filter(|k| variables[k - 1].role == Role::Derived) {
        let dependencies = if (first_xhat..first_xhat + states).contains(&k) {
            list(&mut std::iter::once(initial[k - first_xhat]))
        } else {
            list(&mut initial.iter().copied().chain(std::iter::once(references[k - first_u])))
        };
        _ = match version {
            Version::Two => writeln!(text, "      <Unknown index=\"{k}\" dependencies=\"{dependencies}\"/>"),
            Version::Three => {
                writeln!(text, "    <InitialUnknown valueReference=\"{k}\" dependencies=\"{dependencies}\"/>")
            }
        };
    }
    if version == Version::Two {
        text.push_str("    </InitialUnknowns>\n");
    }
    text.push_str("  </ModelStructure>\n");
}

/// How the sources of an FMU 3.0 are compiled.
pub(super) fn build(name: &str, sources: &[String]) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<fmiBuildDescription fmiVersion=\"3.0\">
  <BuildConfiguration modelIdentifier=\"{name}\" description=\"Operations are rounded one by one: no contraction.\">
    <SourceFileSet language=\"C99\" compilerOptions=\"-ffp-contract=off\">
"
    );
    for source in sources {
        _ = writeln!(text, "      <SourceFile name=\"{source}\"/>");
    }
    text.push_str("    </SourceFileSet>\n  </BuildConfiguration>\n</fmiBuildDescription>\n");
    text
}

/// The page that tools show.
pub(super) fn documentation(export: &Export) -> String {
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>{0}</title></head>\n<body>\n<h1>{0}</h1>\n",
        export.identifier
    );
    _ = writeln!(text, "<p>{}, one step per sample.</p>", export.kind());
    for sentence in &export.statement {
        _ = writeln!(text, "<p>{}</p>", attribute(sentence));
    }
    _ = writeln!(
        text,
        "<p>The communication step has to be a multiple of the sampling period; the inputs are held over it. The estimate\nis that {}.</p>\n<p>{}</p>\n</body>\n</html>",
        if export.is_of_sample() { "at the last sample, with its measurement" } else { "for the end of the step" },
        attribute(&export.digests().join(". "))
    );
    text
}
