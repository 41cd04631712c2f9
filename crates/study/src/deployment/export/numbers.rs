//! The numbers of an export: floating or fixed point.

use luenberger_export::{Export, ExportError, File, FixedPointFormats, Layout, Scalar, golden};
use luenberger_proof::statement::{Format, Formats};

use super::{ExportOptions, ExportRefusal, Language, Libm, Precision};

/// The numbers on the target.
#[derive(Clone, Copy)]
pub(super) enum Numbers {
    Floating(Scalar),
    Fixed(FixedPointFormats),
}

impl Numbers {
    /// What `format`, `gains` and `to` ask for.
    pub(super) fn of(options: &ExportOptions<'_>) -> Result<Self, ExportRefusal> {
        if options.fmi.is_some() && options.to != Language::Fmu {
            return Err(ExportRefusal::Options("--fmi is for --to fmu"));
        }
        if options.libm == Libm::Target {
            if options.to != Language::C {
                return Err(ExportRefusal::Options(
                    "--libm target is for --to c: a no_std crate has no C library, and an FMU runs on a computer",
                ));
            }
            if matches!(options.format, Precision::Fixed(_)) {
                return Err(ExportRefusal::Options(
                    "--libm target is for floating point: fixed point calls no function",
                ));
            }
        }
        if options.layout.is_some() && options.to != Language::C {
            return Err(ExportRefusal::Options("--layout is for --to c"));
        }
        match (options.format, options.gains) {
            (Precision::Fixed(_), _) if options.layout == Some(Layout::Ros2) => Err(ExportRefusal::Options(
                "the messages of --layout ros2 are floating-point numbers: --format f64 or f32",
            )),
            (Precision::Fixed(_), _) if options.feedback => Err(ExportRefusal::Options(
                "--feedback is for floating point: in fixed point no certificate counts the rounding of u; export the observer alone, and form u = r - K xhat from its integers",
            )),
            (Precision::Fixed(_), _) if options.to == Language::Fmu => Err(ExportRefusal::Options(
                "fixed point is for --to c: an FMU exchanges floating-point numbers; --to fmu --format f32 has the same observer in f32",
            )),
            (Precision::Fixed(_), _) if options.to != Language::C => Err(ExportRefusal::Options(
                "fixed point is for --to c; in Rust, FixedPointObserver of luenberger-observers computes the same integers",
            )),
            (Precision::Fixed(signals), gains) => {
                Ok(Self::Fixed(FixedPointFormats { gains: gains.unwrap_or(signals), signals }))
            }
            (_, Some(_)) => Err(ExportRefusal::Options("--gains is for fixed point, as with --format q16.16")),
            (Precision::Binary32, None) => Ok(Self::Floating(Scalar::Binary32)),
            (Precision::Binary64, None) => Ok(Self::Floating(Scalar::Binary64)),
        }
    }

    /// Of the export from which the one in fixed point is made, too.
    pub(super) fn scalar(self) -> Scalar {
        match self {
            Self::Floating(scalar) => scalar,
            Self::Fixed(_) => Scalar::Binary64,
        }
    }

    /// As the certificate names them.
    pub(super) fn formats(self) -> Formats {
        match self {
            Self::Floating(Scalar::Binary32) => Format::Binary32.into(),
            Self::Floating(Scalar::Binary64) => Format::Binary64.into(),
            Self::Fixed(FixedPointFormats { gains, signals }) => {
                let [stored, running] = [gains, signals].map(|format| Format::Fixed {
                    integer_bits: format.integer_bits(),
                    fraction_bits: format.fraction_bits(),
                });
                Formats { stored, running }
            }
        }
    }

    /// `f32`, `Q16.16`.
    pub(super) fn name(self) -> String {
        match self {
            Self::Floating(scalar) => scalar.name().to_owned(),
            Self::Fixed(_) => self.formats().running.to_string(),
        }
    }

    /// Why nothing is proved.
    pub(super) fn unproved(self) -> String {
        match self {
            Self::Floating(_) => "it has no stability certificate".to_owned(),
            Self::Fixed(_) => {
                format!("with its gains stored in {} it has no stability certificate", self.formats().stored)
            }
        }
    }

    /// Whether the format holds the numbers of the observer.
    pub(super) fn check(self, export: &Export) -> Result<(), ExportError> {
        self.cost(export).map(|_| ())
    }

    /// The files in C.
    pub(super) fn c(self, export: &Export, layout: Option<Layout>) -> Result<Vec<File>, ExportError> {
        match (self, layout) {
            (Self::Floating(_), None) => export.c(),
            (Self::Floating(_), Some(layout)) => export.c_in(layout),
            (Self::Fixed(formats), None) => Ok(export.fixed_point(formats)?.c()),
            (Self::Fixed(formats), Some(layout)) => export.fixed_point(formats)?.c_in(layout),
        }
    }

    /// The estimates of the exported observer for given inputs and outputs, one pair for each sample.
    pub(super) fn replay(
        self,
        export: &Export,
        samples: &[(Vec<f64>, Vec<f64>)],
    ) -> Result<Vec<Vec<f64>>, ExportError> {
        match self {
            Self::Floating(_) => golden::replay(export, samples),
            Self::Fixed(formats) => Ok(export.fixed_point(formats)?.replay(samples)),
        }
    }

    /// In how many of the samples a value is cut off at an end of the range.
    pub(super) fn saturated(self, export: &Export, samples: &[(Vec<f64>, Vec<f64>)]) -> Result<usize, ExportError> {
        match self {
            Self::Floating(_) => Ok(0),
            Self::Fixed(formats) => Ok(export.fixed_point(formats)?.saturated(samples)),
        }
    }

    pub(super) fn cost(self, export: &Export) -> Result<Cost, ExportError> {
        Ok(match self {
            Self::Floating(_) => Cost {
                operations: export.operations(),
                of: "floating-point operations",
                bytes: export.bytes(),
                digest: export.digest(),
            },
            Self::Fixed(formats) => {
                let fixed = export.fixed_point(formats)?;
                Cost {
                    operations: fixed.products(),
                    of: "products of integers",
                    bytes: fixed.bytes(),
                    digest: fixed.digest(),
                }
            }
        })
    }
}

/// What a step costs, and the digest of the exported numbers.
pub(super) struct Cost {
    pub(super) operations: usize,
    /// What the operations are.
    pub(super) of: &'static str,
    pub(super) bytes: usize,
    pub(super) digest: String,
}
