//! Functional mock-up units: co-simulation by FMI 2.0 and 3.0, from the emitted C and a thin wrapper.
//!
//! An FMU is a zip archive of `modelDescription.xml`, `sources/` (the emitted C, unchanged, and the wrapper) and shared
//! libraries for the platforms whose compilers are present. Inputs are u and y, outputs xhat and the innovation; with
//! [feedback](Export::with_feedback) the inputs are r and y, and u is an output. The first estimate is a parameter. All
//! variables are scalars of the type Real or Float64; the observer computes in its own format. The archive is the same
//! for the same export: no time of day is in it.
//!
//! | file | subject |
//! |---|---|
//! | `description` | `modelDescription.xml` and `buildDescription.xml` |
//! | `model` | `model.h` and `model.c`: the observer under the names that the wrapper uses |
//! | `instance.h`, `fmi2.c`, `fmi3.c` | the wrapper |
//! | `build` | shared libraries |
//! | `golden` | golden vectors for fmpy |

mod build;
mod description;
mod golden;
mod model;

pub use build::{Compiler, compilers};

use std::io::{Cursor, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::error::ExportError;
use crate::{Export, File};

/// A version of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// `2.0` or `3.0`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Two => "2.0",
            Self::Three => "3.0",
        }
    }

    /// The source of the wrapper.
    fn source(self) -> File {
        let (name, text) = match self {
            Self::Two => ("fmi2.c", include_str!("fmi2.c")),
            Self::Three => ("fmi3.c", include_str!("fmi3.c")),
        };
        File { name: name.to_owned(), text: text.to_owned() }
    }
}

/// An FMU: the files of its archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fmu {
    identifier: String,
    version: Version,
    files: Vec<(String, Vec<u8>)>,
    /// The names of the sources to compile.
    sources: Vec<String>,
}

impl Export {
    /// The observer as an FMU with sources and without binaries; [`Fmu::compile`] adds those.
    ///
    /// # Errors
    /// As [`c`](Self::c); [`ExportError::Duplicate`] for two columns of one name, [`ExportError::TimeUnit`] for a time
    /// unit that is not a known multiple of the second; [`ExportError::VaryingPeriods`].
    pub fn fmu(&self, version: Version) -> Result<Fmu, ExportError> {
        if self.observer.takes_time() {
            return Err(ExportError::VaryingPeriods { what: "as an FMU, whose step has a fixed period" });
        }
        let period = self.period_in_seconds()?;
        let name = &self.identifier;
        let sources = vec![version.source().name, "model.c".to_owned(), format!("{name}.c")];
        let observer =
            self.c()?.into_iter().filter(|file| [format!("{name}.h"), format!("{name}.c")].contains(&file.name));
        let token = description::token(self, version)?;
        let mut sources_folder: Vec<File> = observer.collect();
        sources_folder.extend(model::files(self, &token, period)?);
        sources_folder.push(File { name: "instance.h".to_owned(), text: include_str!("instance.h").to_owned() });
        sources_folder.push(version.source());
        let mut files = vec![("modelDescription.xml".to_owned(), description::model(self, version, &sources, &token)?)];
        if version == Version::Three {
            sources_folder
                .push(File { name: "buildDescription.xml".to_owned(), text: description::build(name, &sources) });
        }
        files.extend(sources_folder.into_iter().map(|file| (format!("sources/{}", file.name), file.text)));
        files.push(("documentation/index.html".to_owned(), description::documentation(self)));
        let files = files.into_iter().map(|(name, text)| (name, text.into_bytes())).collect();
        Ok(Fmu { identifier: name.clone(), version, files, sources })
    }

    /// A test with golden vectors: a table of inputs and expected estimates, and a Python script that simulates the FMU
    /// with fmpy and compares every bit.
    ///
    /// # Errors
    /// As [`fmu`](Self::fmu).
    pub fn fmu_test(&self) -> Result<Vec<File>, ExportError> {
        golden::files(self, self.period_in_seconds()?)
    }

    /// The sampling period in seconds, the unit of time of an FMU.
    pub(crate) fn period_in_seconds(&self) -> Result<f64, ExportError> {
        Ok(self.observer.period() * self.time_unit_in_seconds()?)
    }

    /// The unit of time of the observer in seconds.
    pub(crate) fn time_unit_in_seconds(&self) -> Result<f64, ExportError> {
        Ok(match self.names.time_unit.as_str() {
            "" | "s" | "sec" | "second" | "seconds" => 1.0,
            "ms" => 1e-3,
            "us" | "\u{b5}s" | "\u{3bc}s" => 1e-6,
            "ns" => 1e-9,
            "min" | "minute" | "minutes" => 60.0,
            "h" | "hour" | "hours" => 3600.0,
            "d" | "day" | "days" => 86400.0,
            unit => return Err(ExportError::TimeUnit { unit: unit.to_owned() }),
        })
    }
}

impl Fmu {
    /// The name of the archive, `NAME.fmu`.
    pub fn file_name(&self) -> String {
        format!("{}.fmu", self.identifier)
    }

    /// Adds a file, such as a certificate under `documentation/`.
    pub fn add(&mut self, path: &str, bytes: Vec<u8>) {
        self.files.push((path.to_owned(), bytes));
    }

    /// The paths in the archive.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|(name, _)| name.as_str())
    }

    /// Writes the sources into a folder.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_sources(&self, folder: &Path) -> std::io::Result<()> {
        for (name, bytes) in &self.files {
            if let Some(name) = name.strip_prefix("sources/") {
                std::fs::write(folder.join(name), bytes)?;
            }
        }
        Ok(())
    }

    /// The archive. The order of the files, their times and their compression are fixed.
    ///
    /// # Errors
    /// [`ExportError::Archive`] if it cannot be written, as for a file of two times the same name.
    pub fn archive(&self) -> Result<Vec<u8>, ExportError> {
        let failed = |error: zip::result::ZipError| ExportError::Archive { why: error.to_string() };
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default());
        for (name, bytes) in &self.files {
            let mode = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
            archive.start_file(name.as_str(), options.unix_permissions(mode)).map_err(failed)?;
            archive.write_all(bytes).map_err(|error| failed(error.into()))?;
        }
        archive.finish().map(Cursor::into_inner).map_err(failed)
    }
}
