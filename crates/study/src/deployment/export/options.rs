//! What is asked of an export: the options of `luenberger export`, under the same names.

use luenberger_export::fmu::Version;
use luenberger_export::golden;
use luenberger_export::{FixedPointFormat, Layout};
use luenberger_wording::setters;

use super::ExportRefusal;
use super::numbers::Numbers;
use crate::designed::Designed;

/// Options of an export.
#[derive(Debug, Clone)]
pub struct ExportOptions<'a> {
    /// What is written (default C).
    pub to: Language,
    /// Version of the standard of an FMU (default 2).
    pub fmi: Option<Version>,
    /// The build system that the files in C are for (default CMake).
    pub layout: Option<Layout>,
    /// Whether the step has the feedback `u = r - K xhat` of the study, and returns u as well.
    pub feedback: bool,
    /// Numbers on the target (default binary64).
    pub format: Precision,
    /// Fixed-point format of the gains (default: that of `format`).
    pub gains: Option<FixedPointFormat>,
    /// Whose elementary functions C calls (default: those of the design).
    pub libm: Libm,
    /// Sampling period (default: that of a sampled observer, or the hold of the simulation).
    pub period: Option<f64>,
    /// Runge-Kutta steps per period of a nonlinear observer (default: a quarter of the fastest time constant of the
    /// error each; those of an extended Kalman filter in the study).
    pub substeps: Option<usize>,
    /// Steps of the golden test (default 64).
    pub test_steps: usize,
    /// Whether an observer without a stability certificate is exported.
    pub unproved: bool,
    /// The design of the observer in its study, if it is there already.
    pub designed: Option<&'a Designed>,
}

impl Default for ExportOptions<'_> {
    fn default() -> Self {
        Self {
            to: Language::C,
            fmi: None,
            layout: None,
            feedback: false,
            format: Precision::Binary64,
            gains: None,
            libm: Libm::Own,
            period: None,
            substeps: None,
            test_steps: golden::STEPS,
            unproved: false,
            designed: None,
        }
    }
}

impl<'a> ExportOptions<'a> {
    setters! {
        to: Language,
        fmi: Version,
        layout: Layout,
        feedback: bool,
        format: Precision,
        gains: FixedPointFormat,
        libm: Libm,
        period: f64,
        substeps: usize,
        test_steps: usize,
        unproved: bool,
        designed: &'a Designed,
    }

    /// Whether the options go together.
    ///
    /// # Errors
    /// [`ExportRefusal::Options`].
    pub fn check(&self) -> Result<(), ExportRefusal> {
        Numbers::of(self).map(|_| ())
    }

    pub(super) fn version(&self) -> Version {
        self.fmi.unwrap_or(Version::Two)
    }
}

/// What an export writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// C99.
    C,
    /// A `no_std` crate on `luenberger-observers`.
    Rust,
    /// A functional mock-up unit for co-simulation.
    Fmu,
}

impl std::str::FromStr for Language {
    type Err = String;

    /// `c`, `rust`, `fmu`.
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "c" => Ok(Self::C),
            "rust" => Ok(Self::Rust),
            "fmu" => Ok(Self::Fmu),
            _ => Err("c, rust or fmu is expected".to_owned()),
        }
    }
}

/// Whose elementary functions emitted C calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Libm {
    /// Those of the design, written out: the same bits.
    Own,
    /// Those of the target's C library.
    Target,
}

/// The format of the numbers on the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// IEEE 754 binary32.
    Binary32,
    /// IEEE 754 binary64.
    Binary64,
    /// Fixed point.
    Fixed(FixedPointFormat),
}

impl Precision {
    /// The fixed-point format `q16.16` (2 to 32 bits, the sign among those before the point).
    ///
    /// # Errors
    /// What is expected instead of the word.
    pub fn fixed_point(word: &str) -> Result<FixedPointFormat, String> {
        let bits = word.strip_prefix(['q', 'Q']).and_then(|bits| bits.split_once('.'));
        let is_number = |digits: &&str| digits.bytes().all(|byte| byte.is_ascii_digit());
        let number = |digits: &str| Some(digits).filter(is_number).and_then(|digits| digits.parse::<u32>().ok());
        let found = bits.and_then(|(integer, fraction)| Some((number(integer)?, number(fraction)?)));
        let (integer, fraction) = found.ok_or("a fixed-point format such as q16.16 is expected")?;
        FixedPointFormat::new(integer, fraction).map_err(|error| error.to_string())
    }
}

impl std::str::FromStr for Precision {
    type Err = String;

    /// `f32`, `f64`, `q16.16`.
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "f32" => Ok(Self::Binary32),
            "f64" => Ok(Self::Binary64),
            _ if word.starts_with(['q', 'Q']) => Self::fixed_point(word).map(Self::Fixed),
            _ => Err("f32, f64 or a fixed-point format such as q16.16 is expected".to_owned()),
        }
    }
}
