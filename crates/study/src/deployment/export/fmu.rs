//! An observer as an FMU: the archive with the binaries that can be built here, and a test for fmpy.

use std::sync::atomic::{AtomicUsize, Ordering};

use luenberger_export::fmu::{Version, compilers};
use luenberger_export::{Export, ExportError, File};

/// `NAME.fmu`, and beside it a test and a README.
pub(super) struct FmuFiles {
    pub(super) archive: (String, Vec<u8>),
    pub(super) texts: Vec<File>,
    /// The paths of the binaries in the archive.
    pub(super) binaries: Vec<String>,
    /// Why the archive lacks binaries.
    pub(super) notes: Vec<String>,
}

/// Exports of this process, each of which compiles in a folder of its own.
static COUNT: AtomicUsize = AtomicUsize::new(0);

pub(super) fn files(
    export: &Export,
    version: Version,
    certificates: &[(String, Vec<u8>)],
) -> Result<FmuFiles, ExportError> {
    let mut fmu = export.fmu(version)?;
    for (name, bytes) in certificates {
        fmu.add(&format!("documentation/{name}"), bytes.clone());
    }
    let (mut binaries, mut notes) = (Vec::new(), Vec::new());
    let compilers = compilers();
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    for compiler in &compilers {
        let name = format!("luenberger-{}-{count}-{}", std::process::id(), compiler.platform);
        let scratch = std::env::temp_dir().join(name);
        let built = std::fs::create_dir_all(&scratch)
            .map_err(|error| ExportError::Archive { why: error.to_string() })
            .and_then(|()| fmu.compile(compiler, &scratch));
        _ = std::fs::remove_dir_all(&scratch);
        match built {
            Ok(path) => binaries.push(path),
            Err(error) => notes.push(format!("no binary for {}: {error}", compiler.platform)),
        }
    }
    let name = fmu.file_name();
    if compilers.is_empty() {
        notes.push(format!(
            "no C compiler (cc, gcc, clang or $CC): {name} has no binary, and tools that do not compile sources refuse it"
        ));
    }
    let mut texts = export.fmu_test()?;
    texts.push(readme(export, version));
    Ok(FmuFiles { archive: (name, fmu.archive()?), texts, binaries, notes })
}

fn readme(export: &Export, version: Version) -> File {
    let text = format!(
        "# {0}.fmu

Co-simulation by FMI {1}, one step every {2}. The communication step has to be a multiple of the period.

| variable | meaning |
|---|---|
| `y.NAME` | measured outputs, inputs of the FMU |
{known}
| `xhat.NAME` | the estimate {estimate} |
| `innovation.NAME` | measured minus expected output of the last step |
| `initial.NAME` | parameters: the first estimate |

`sources/` is complete; compilers must not contract operations (`-ffp-contract=off`). The test simulates the FMU with fmpy
and compares each estimate with that of the design, bit by bit:

```console
$ python3 -m pip install fmpy
$ python3 test_{0}.py
```
",
        export.identifier(),
        version.name(),
        export.period_text(),
        estimate = if export.is_of_sample() { "at the last sample, with its measurement" } else { "for the end of the step" },
        known = if export.has_feedback() {
            "| `r.NAME` | references, inputs of the FMU |\n| `u.NAME` | inputs to apply until the next sample, `u = r - K xhat` |"
        } else {
            "| `u.NAME` | inputs of the plant, held until the next sample |"
        },
    );
    File { name: "README.md".to_owned(), text }
}
