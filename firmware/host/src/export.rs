//! The exports that are compiled for the boards.

use luenberger_export::{Export, ExportableObserver, File, Names, Scalar};
use luenberger_golden::linear::{Cubic, Linear};
use luenberger_golden::{Number, STEPS};
use luenberger_observers::{DiscreteLinearObserver, SampledCubicGains, SampledCubicObserver, SampledObserver};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, SMatrix};
use std::fs;
use std::path::Path;

/// An observer with sizes known at compile time, as one that is exported.
pub trait Exported {
    /// The same observer.
    fn exportable(&self) -> ExportableObserver;
}

/// The matrix with sizes known at run time.
fn dynamic<T: Number, const R: usize, const C: usize>(m: &SMatrix<T, R, C>) -> DMatrix<f64> {
    DMatrix::from_fn(R, C, |i, j| m[(i, j)].value())
}

impl<T: Number, const N: usize, const M: usize, const P: usize> Exported for Linear<T, N, M, P> {
    fn exportable(&self) -> ExportableObserver {
        let plant = self.plant();
        let plant = StateSpace::new(dynamic(&plant.a), dynamic(&plant.b), dynamic(&plant.c)).expect("finite");
        let observer = DiscreteLinearObserver::new(plant, dynamic(self.l()), self.period().value());
        ExportableObserver::Linear(observer.expect("the same numbers"))
    }
}

impl<T: Number, const N: usize, const M: usize, const P: usize> Exported for Cubic<T, N, M, P> {
    fn exportable(&self) -> ExportableObserver {
        let observer = SampledCubicObserver::new(SampledCubicGains {
            ad: dynamic(self.ad()),
            bd: dynamic(self.bd()),
            c: dynamic(self.c()),
            ld: dynamic(self.ld()),
            n: dynamic(self.n()),
            theta: dynamic(self.theta()),
            w: self.w().value(),
            period: self.period().value(),
        });
        ExportableObserver::Cubic(observer.expect("the same numbers"))
    }
}

/// Writes the C files of the observer, and `case.h` for `main.c`, to a folder of its own.
pub fn write(observer: &impl Exported, folder: &Path, name: &str, number: &str, amplitude: f64) {
    let scalar = if number == "f32" { Scalar::Binary32 } else { Scalar::Binary64 };
    let number = if number == "f32" { "float" } else { "double" };
    // As in `luenberger_golden::Run::sample`.
    let (small, large) = if amplitude > 1.0 { (1.0, 1e3) } else { (amplitude, amplitude) };
    files(folder, name, export(observer, name, scalar).c().expect("an export"));
    let leaves_out = u8::from(observer.exportable().leaves_out_missing());
    let numbers = format!("#define NUMBER {number}\n#define SMALL {small:?}\n#define LARGE {large:?}\n");
    case(folder, name, &format!("{numbers}#define LEAVES_OUT {leaves_out}\n"));
}

/// The observer as designed, with the first estimate of the golden programs.
pub fn export(observer: &impl Exported, name: &str, scalar: Scalar) -> Export {
    let exportable = observer.exportable();
    let size = exportable.dimensions();
    let initial: Vec<f64> = (0..size.state).map(|i| 0.1 * i as f64 - 0.3).collect();
    let names = Names::numbered(size.state, size.inputs, size.outputs);
    Export::new(name, exportable, scalar, &initial, names).expect("an export")
}

/// Writes the files of an export to a folder of its own.
pub fn files(folder: &Path, name: &str, files: Vec<File>) {
    let folder = folder.join(name);
    fs::create_dir_all(&folder).expect("the folder of the exports");
    for file in files {
        fs::write(folder.join(file.name), file.text).expect("the folder of the exports");
    }
}

/// Writes `case.h`.
pub fn case(folder: &Path, name: &str, numbers: &str) {
    let upper = name.to_uppercase();
    let case = format!(
        "#include \"{name}.h\"
#define NAME \"{name}\"
#define STATE {name}_state
#define RESET {name}_reset
#define STEP {name}_step
#define STATES {upper}_STATES
#define INPUTS {upper}_INPUTS
#define OUTPUTS {upper}_OUTPUTS
#define STEPS {STEPS}
{numbers}"
    );
    fs::write(folder.join(name).join("case.h"), case).expect("the folder of the exports");
}
