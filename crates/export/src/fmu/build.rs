//! Shared libraries from the sources of an FMU.

use std::path::Path;
use std::process::{Command, Stdio};

use super::{Fmu, Version};
use crate::error::ExportError;

/// A C compiler and the platform that it compiles for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Compiler {
    command: String,
    /// The platform by the name of FMI 3.0, `x86_64-linux`.
    pub platform: String,
}

/// The compilers that are present: one for this machine (`$CC`, `cc`, `gcc` or `clang`), and mingw for 64-bit Windows.
pub fn compilers() -> Vec<Compiler> {
    let runs = |command: &str| {
        let mut version = Command::new(command);
        version.arg("--version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        version.status().is_ok_and(|status| status.success())
    };
    let own = std::env::var("CC").ok();
    let host = own.iter().map(String::as_str).chain(["cc", "gcc", "clang"]).find(|command| runs(command));
    let system = match std::env::consts::OS {
        "macos" => "darwin",
        other => other,
    };
    let platform = format!("{}-{system}", std::env::consts::ARCH);
    let mingw = "x86_64-w64-mingw32-gcc";
    let windows = "x86_64-windows";
    let mut all: Vec<Compiler> =
        host.map(|command| Compiler { command: command.to_owned(), platform: platform.clone() }).into_iter().collect();
    if platform != windows && runs(mingw) {
        all.push(Compiler { command: mingw.to_owned(), platform: windows.to_owned() });
    }
    all
}

impl Compiler {
    /// The folder of its binaries in an FMU. FMI 2.0 has names of its own for the common platforms.
    fn folder(&self, version: Version) -> &str {
        match (version, self.platform.as_str()) {
            (Version::Two, "x86_64-linux") => "linux64",
            (Version::Two, "x86_64-windows") => "win64",
            (Version::Two, "x86_64-darwin") => "darwin64",
            (_, platform) => platform,
        }
    }

    fn extension(&self) -> &'static str {
        match self.platform.rsplit('-').next() {
            Some("windows") => "dll",
            Some("darwin") => "dylib",
            _ => "so",
        }
    }
}

impl Fmu {
    /// Compiles the sources in the folder `scratch`, which exists, and adds the shared library. Returns its path in the
    /// archive.
    ///
    /// # Errors
    /// [`ExportError::Compiler`] with what the compiler says.
    pub fn compile(&mut self, compiler: &Compiler, scratch: &Path) -> Result<String, ExportError> {
        let failed = |why: String| ExportError::Compiler { compiler: compiler.command.clone(), why };
        self.write_sources(scratch).map_err(|error| failed(error.to_string()))?;
        let library = format!("{}.{}", self.identifier, compiler.extension());
        let mut command = Command::new(&compiler.command);
        command.current_dir(scratch).args(["-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared"]);
        if compiler.extension() == "dll" {
            command.arg("-static-libgcc");
        } else {
            command.arg("-fPIC");
        }
        command.args(&self.sources).args(["-o", &library, "-lm"]).stdin(Stdio::null());
        let output = command.output().map_err(|error| failed(error.to_string()))?;
        if !output.status.success() {
            return Err(failed(String::from_utf8_lossy(&output.stderr).into_owned()));
        }
        let bytes = std::fs::read(scratch.join(&library)).map_err(|error| failed(error.to_string()))?;
        let path = format!("binaries/{}/{library}", compiler.folder(self.version));
        self.add(&path, bytes);
        Ok(path)
    }
}
