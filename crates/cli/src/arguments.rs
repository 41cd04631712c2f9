//! What can be said on the command line.

use crate::exit::WRONG;
use crate::input::Source;
use crate::output;
use clap::error::ErrorKind;
use clap::{Args, Parser, Subcommand, ValueEnum};
use luenberger_lmi::Solver;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Design, certify, simulate and compare state observers.
#[derive(Parser)]
#[command(
    name = "luenberger",
    version,
    arg_required_else_help = true,
    after_help = "Exit code: 0 for success, 1 for a negative answer (no solution, not proved), 2 for a wrong question (usage, files, data).\n\
                  Conventions: continuous time unless the name says discrete; L is the observer gain (A - L C), K the feedback gain (A - B K)."
)]
pub(crate) struct Arguments {
    /// One JSON object on standard output, for machines; an error is {"error": {"kind", "message", ..}}
    #[arg(long, global = true)]
    pub(crate) json: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Write a commented study file to start from
    ///
    /// Output {"study", "files"}: what was written.
    #[command(after_help = NEW)]
    New(NewInput),
    /// Design, certify, simulate and compare the observers of a study, and write a folder with the report
    ///
    /// The folder has report.html (offline), figures (SVG, PNG), trajectories (CSV, npz), study.json with every number,
    /// and the certificates. The same study gives the same bytes. Ctrl-C leaves what is finished on disk. The exit code
    /// is 1 if an observer does not fit, a fact is not proved, or a run ends early; the rest is done all the same.
    #[command(after_help = RUN)]
    Run(StudyInput),
    /// What the outputs see: ranks with margins for each mode, hidden directions
    ///
    /// For nonlinear plants at points along the trajectory, with the rank of Lie derivatives and the empirical Gramian.
    #[command(after_help = OBSERVE)]
    Observe(StudyInput),
    /// The observers of a study: gains, poles, and what is proved of them
    ///
    /// An observer that does not fit the plant is reported with the hypothesis that fails and the observer that would
    /// fit; the exit code is 1 then.
    #[command(after_help = DESIGN)]
    Design(StudyInput),
    /// The observers with their certificates, written to files that `luenberger verify` accepts
    #[command(after_help = CERTIFY)]
    Certify(StudyInput),
    /// Run the plant and its observers, and write trajectories and figures
    #[command(after_help = SIMULATE)]
    Simulate(StudyInput),
    /// The observers side by side: settling time, peak, root mean square of the error
    #[command(after_help = COMPARE)]
    Compare(StudyInput),
    /// Vary gamma, poles, noise or initial errors, with ensembles, in parallel
    #[command(after_help = SWEEP)]
    Sweep(StudyInput),
    /// Lyapunov equation A X + X A' + Q = 0
    ///
    /// Input {"a": n x n, "q": n x n symmetric}; output {"x", "residual", "condition"}.
    /// As `lyap(A, Q)` of python-control and MATLAB. For the observer's form A'P + P A + Q = 0 give A'.
    /// A unique X exists iff no two eigenvalues of A add to zero.
    #[command(after_help = LYAP)]
    Lyap(MatrixInput),
    /// Discrete Lyapunov (Stein) equation A X A' - X + Q = 0
    ///
    /// Input {"a": n x n, "q": n x n symmetric}; output {"x", "residual", "condition"}.
    /// As `dlyap(A, Q)` of python-control and MATLAB. A unique X exists iff no two eigenvalues of A multiply to one.
    #[command(after_help = DLYAP)]
    Dlyap(MatrixInput),
    /// Sylvester equation A X + X B + Q = 0
    ///
    /// Input {"a": n x n, "b": m x m, "q": n x m}; output {"x", "residual", "condition"}. The sign is that of
    /// `lyap(A, B, Q)` of python-control and MATLAB; scipy's `solve_sylvester(A, B, Q)` has A X + X B = Q. A unique X
    /// exists iff no eigenvalue of A is the negative of one of B.
    #[command(after_help = SYLV)]
    Sylv(MatrixInput),
    /// Riccati equation A'X + X A - X B R^-1 B'X + Q = 0, and the regulator K = R^-1 B'X
    ///
    /// Input {"a": n x n, "b": n x m, "q": n x n symmetric, semidefinite, "r": m x m symmetric, definite}; output {"x",
    /// "k", "poles", "residual"}. X is the stabilizing solution, poles are the eigenvalues of A - B K. As
    /// `care(A, B, Q, R)` of python-control, which returns (X, poles, K). For a Kalman gain give A', C', the two noise
    /// intensities, and transpose K.
    #[command(after_help = CARE)]
    Care(MatrixInput),
    /// Discrete Riccati equation A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0, and K = (R + B'X B)^-1 B'X A
    ///
    /// Input {"a": n x n, "b": n x m, "q": n x n symmetric, semidefinite, "r": m x m symmetric, definite}; output {"x",
    /// "k", "poles", "residual"}. X is the stabilizing solution, poles are the eigenvalues of A - B K. As
    /// `dare(A, B, Q, R)` of python-control, which returns (X, poles, K).
    #[command(after_help = DARE)]
    Dare(MatrixInput),
    /// Pole placement: K with the eigenvalues of A - B K where they are wished
    ///
    /// Input {"a": n x n, "b": n x m, "poles": n numbers, complex ones as [re, im] with their conjugates}; output {"k",
    /// "poles", "condition"}. As `place(A, B, poles)` of python-control and MATLAB: u = -K x. For an observer give A'
    /// and C' and transpose K: L = K'. The poles of the answer are computed afresh from this K, in the order of the
    /// input; condition is that of the eigenvectors, null for a defective closed loop. A pole may be repeated rank(B)
    /// times, with one input as often as one likes.
    #[command(after_help = PLACE)]
    Place(MatrixInput),
    /// Observability of (A, C): the rank, the margin of each mode, what no output sees
    ///
    /// Input {"a": n x n, "c": p x n}; output {"rank", "unobservable", "margins"}. rank is that of `obsv(A, C)` of
    /// python-control and MATLAB, decided without forming that matrix. margins has for each eigenvalue of A the
    /// smallest singular value of [A - lambda I; C] relative to the pair, in units that suit it: 0 if no output sees
    /// the mode. unobservable has eigenvalue and direction of each hidden mode: A v = lambda v, C v = 0. The exit code
    /// is 0 for an unobservable pair too: the question is what is seen.
    #[command(after_help = OBSV)]
    Obsv(MatrixInput),
    /// Eigenvalues of a square matrix
    ///
    /// Input {"a": n x n}; output {"eigenvalues": [[re, im], ..]}, complex pairs adjacent, the one above the real axis
    /// first.
    #[command(after_help = EIG)]
    Eig(MatrixInput),
    /// A study file from a state-space model of MATLAB (.mat), numpy (.npz) or python-control (JSON)
    ///
    /// The file holds A and C, and B if there are inputs, under these names in either case, by themselves or as fields
    /// of one structure: save('model.mat', 'A', 'B', 'C', '-v7'); np.savez('model.npz', A=sys.A, B=sys.B, C=sys.C);
    /// json.dump({'A': sys.A.tolist(), ..}, file). D has to be zero and the model in continuous time. Output {"study",
    /// "states", "inputs", "outputs", "ignored"}.
    #[command(after_help = IMPORT)]
    Import(ImportInput),
    /// Check certificate files: everything they claim is derived again, outside floating point
    ///
    /// As the program luenberger-verify, which depends on nothing but the checker. Output {"files": [{"file",
    /// "outcome", "title", "statement", "facts"}, ..]}. The exit code is 0 if every file is proved, 1 if one is
    /// rejected, 2 if one is no certificate.
    #[command(after_help = VERIFY)]
    Verify(VerifyInput),
    /// Proved bounds of a semidefinite program in SDPA's sparse format
    ///
    /// Minimise c'x subject to x_1 F_1 + ... + x_m F_m - F_0 >= 0. The solver proposes; what is printed is proved
    /// outside it. The exit code is 0 if both bounds, or infeasibility, are proved, 1 if nothing is.
    #[command(after_help = SDP)]
    Sdp(SdpInput),
}

#[derive(Args)]
pub(crate) struct NewInput {
    /// The plant: --list shows all
    #[arg(long, default_value = "double-integrator")]
    pub(crate) plant: String,
    /// The study file to write, or - for standard output
    #[arg(short, long, value_name = "STUDY", default_value = "study.toml")]
    pub(crate) output: PathBuf,
    /// Write over a file that is there
    #[arg(long)]
    pub(crate) force: bool,
    /// List the plants instead
    #[arg(long)]
    pub(crate) list: bool,
}

#[derive(Args)]
pub(crate) struct StudyInput {
    /// A study: TOML, or JSON by the same keys (.json)
    #[arg(value_name = "STUDY")]
    pub(crate) study: PathBuf,
    /// The folder of the results [default: STUDY-results for run, certify, simulate and sweep; none for the others]
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
    /// Threads; the results do not depend on it [default: as many as there are processors]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<usize>,
}

/// At least one thread, and not so many that the machine refuses.
fn threads(word: &str) -> Result<usize, String> {
    match word.parse() {
        Ok(count @ 1..=1024) => Ok(count),
        _ => Err("a number from 1 to 1024 is expected".to_owned()),
    }
}

#[derive(Args)]
pub(crate) struct MatrixInput {
    /// A JSON file, or - for standard input; a matrix is a list of its rows
    #[arg(value_name = "FILE")]
    pub(crate) file: Source,
}

#[derive(Args)]
pub(crate) struct SdpInput {
    /// A program in SDPA's sparse format
    #[arg(value_name = "FILE.dat-s")]
    pub(crate) file: PathBuf,
    /// Who proposes the points that are proved
    #[arg(long, value_enum, default_value_t = Proposer::Interior)]
    pub(crate) solver: Proposer,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Proposer {
    /// The interior-point method of this project
    Interior,
    /// Clarabel
    Clarabel,
}

impl From<Proposer> for Solver {
    fn from(proposer: Proposer) -> Self {
        match proposer {
            Proposer::Interior => Self::Interior,
            Proposer::Clarabel => Self::Clarabel,
        }
    }
}

#[derive(Args)]
pub(crate) struct VerifyInput {
    /// Certificate files, or - for standard input
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<Source>,
}

#[derive(Args)]
pub(crate) struct ImportInput {
    /// The model: its kind is told by its first bytes
    #[arg(value_name = "MODEL")]
    pub(crate) model: PathBuf,
    /// The study file to write, or - for standard output
    #[arg(short, long, value_name = "STUDY", default_value = "study.toml")]
    pub(crate) output: PathBuf,
    /// Write over a file that is there
    #[arg(long)]
    pub(crate) force: bool,
}

const NEW: &str = "Example:\n  $ luenberger new --plant double-integrator\n  $ luenberger run study.toml";
const RUN: &str = "Example:\n  $ luenberger new\n  $ luenberger run study.toml -o results";
const OBSERVE: &str = "Example:\n  $ luenberger new\n  $ luenberger observe study.toml";
const DESIGN: &str = "Example:\n  $ luenberger new\n  $ luenberger design study.toml";
const CERTIFY: &str = "Example:\n  $ luenberger new\n  $ luenberger certify study.toml -o results";
const SIMULATE: &str = "Example:\n  $ luenberger new\n  $ luenberger simulate study.toml -o results";
const COMPARE: &str = "Example:\n  $ luenberger new\n  $ luenberger compare study.toml";
const SWEEP: &str = "Example:\n  $ luenberger new\n  $ luenberger sweep study.toml -o results";

const LYAP: &str = r#"Example:
  $ echo '{"a": [[0, 1], [-2, -3]], "q": [[1, 0], [0, 1]]}' | luenberger lyap - --json
  {"x":[[1.0,-0.5],[-0.5,0.5]],"residual":..,"condition":..}"#;

const DLYAP: &str = r#"Example:
  $ echo '{"a": [[0.5]], "q": [[3]]}' | luenberger dlyap - --json
  {"x":[[4.0]],"residual":0.0,"condition":..}"#;

const SYLV: &str = r#"Example:
  $ echo '{"a": [[1]], "b": [[2]], "q": [[6]]}' | luenberger sylv - --json
  {"x":[[-2.0]],"residual":0.0,"condition":1.0}"#;

const CARE: &str = r#"Example:
  $ echo '{"a": [[0, 1], [0, 0]], "b": [[0], [1]], "q": [[1, 0], [0, 1]], "r": [[1]]}' | luenberger care -
  (X = [2 1; 1 2], K = [1 2], both poles at -1)"#;

const DARE: &str = r#"Example:
  $ echo '{"a": [[1]], "b": [[1]], "q": [[1]], "r": [[1]]}' | luenberger dare -
  (X = 1.61803, K = 0.618034, the pole at 0.381966)"#;

const PLACE: &str = r#"Example:
  $ echo '{"a": [[0, 1], [3, 2]], "b": [[0], [1]], "poles": [[-1, 2], [-1, -2]]}' | luenberger place -
  (K = [8 4])"#;

const OBSV: &str = r#"Example:
  $ echo '{"a": [[-1, 0], [0, -2]], "c": [[1, 0]]}' | luenberger obsv -
  (rank 1 of 2, the mode at -2 is hidden)"#;

const EIG: &str = r#"Example:
  $ echo '{"a": [[0, 1], [-5, -2]]}' | luenberger eig - --json
  {"eigenvalues":[[-1.0,2.0],[-1.0,-2.0]]}"#;

const IMPORT: &str = "Example:\n  $ luenberger import building.mat -o building.toml\n  $ luenberger run building.toml";

const VERIFY: &str = "Example:\n  $ luenberger new\n  $ luenberger certify study.toml -o results\n  $ luenberger verify results/certificates/*";

const SDP: &str = "Example:\n  $ luenberger sdp theta1.dat-s --json";

/// Prints what clap has to say: help and version with exit code 0, an error of usage with 2.
pub(crate) fn refused(error: &clap::Error) -> ExitCode {
    let is_answer = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
    if !is_answer && std::env::args_os().any(|argument| argument == "--json") {
        let message = error.to_string();
        let message = message.strip_prefix("error: ").unwrap_or(&message);
        let object = json!({ "error": { "kind": "usage", "message": message.trim_end() } });
        output::line(&object.to_string());
    }
    // Help that nobody reads to its end is no failure.
    _ = error.print();
    if is_answer { ExitCode::SUCCESS } else { ExitCode::from(WRONG) }
}
