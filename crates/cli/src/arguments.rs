//! Command-line arguments and their help texts.

use crate::examples;
use crate::exit::WRONG;
use crate::input::Source;
use crate::input::given::{
    Data, LoopProblem, Lyapunov, NoiseModel, Pair, PolePlacement, Problem, RiccatiProblem, Square, StateSpace,
    Sylvester,
};
use crate::limit::{Limit, time};
use crate::output;
use clap::error::ErrorKind;
use clap::{Args, Parser, Subcommand, ValueEnum};
use luenberger_export::{FixedPointFormat, Layout};
use luenberger_lmi::Solver;
use luenberger_study::advise::Criteria;
use luenberger_study::deployment::Precision;
use luenberger_study::execute::Shard;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Design, certify, simulate and compare state observers.
#[derive(Parser)]
#[command(
    name = "luenberger",
    version,
    arg_required_else_help = true,
    after_help = "Exit code: 0 success; 1 negative result (no solution, not proved) or full disk; 2 invalid input (usage, files, data); 130 ended by Ctrl-C.\n\
                  Conventions: continuous time unless the name says discrete; L is the observer gain (A - L C), K the feedback gain (A - B K)."
)]
pub(crate) struct Arguments {
    /// Print one JSON object on standard output; an error is {"error": {"kind", "message", ..}}
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Results and errors only: no notes, estimates and progress
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// A line for each part that is done, and the estimate of time and memory, on standard error
    #[arg(short, long, global = true)]
    pub(crate) verbose: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Write a commented study file to start from
    ///
    /// Output {"study", "files"}: the files written.
    #[command(after_help = examples::NEW)]
    New(NewInput),
    /// Design, certify, simulate and compare the observers of a study, and write a folder with the report
    ///
    /// The folder contains report.html (offline), figures (SVG, PNG), trajectories (CSV, npz), study.json with all
    /// numbers, and the certificates. Results are reproducible: the same study gives identical bytes. Ctrl-C keeps the
    /// finished files. The exit code is 1 if an observer is not applicable to the plant, a condition is not verified,
    /// or a simulation fails; all other parts are still computed.
    #[command(after_help = examples::RUN)]
    Run(RunInput),
    /// Observability: rank, margin of each mode, unobservable directions
    ///
    /// Nonlinear plants are linearized at points along the trajectory; the rank of the Lie derivatives and the
    /// empirical Gramian are computed too.
    #[command(after_help = examples::OBSERVE)]
    Observe(StudyInput),
    /// Design the observers of a study: gains, poles, verified properties
    ///
    /// For an observer that is not applicable to the plant, the violated hypothesis is reported, with
    /// alternatives that were designed on this plant, and hints; the exit code is then 1.
    #[command(after_help = examples::DESIGN)]
    Design(StudyInput),
    /// Design the observers and write their certificates as files for `luenberger verify`
    #[command(after_help = examples::CERTIFY)]
    Certify(StudyInput),
    /// Simulate the plant and its observers; write trajectories and figures
    #[command(after_help = examples::SIMULATE)]
    Simulate(StudyInput),
    /// Compare the observers: settling time, peak, root mean square of the error
    #[command(after_help = examples::COMPARE)]
    Compare(StudyInput),
    /// Which observer should I use? Try every kind that applies, tuned from the same information, and rank them
    ///
    /// Every kind of observer whose hypotheses hold for the plant is tuned by its rule from the same information (noise
    /// level, region, settling time), which the study gives in [advise] or which is derived, and run on the same
    /// noises, or on the log of the study, where they are judged by their predictions of the last part. The kinds that
    /// do not apply are listed with the hypothesis that fails. The study needs a [simulation] with noise, or a [log].
    /// With -o: figures of error against cost and peak, the scores of all runs, and the study with the
    /// recommended observers. The exit code is 1 if no observer is ranked.
    #[command(after_help = examples::ADVISE)]
    Advise(AdviseInput),
    /// Fit to a log what a filter assumes (noise covariances, parameters, biases, delays), or the gains of an observer
    ///
    /// The likelihood of the innovations is the largest for the fitted values, or the errors of predictions or
    /// estimates are the least. The table [tune] of the study names the observer and what is fitted. Each value comes
    /// with its standard error and 95 % interval; what the log does not determine is said. The observer is judged on
    /// the last part of the log, which is not fitted. The tuned study is written beside the study, as tuned.toml. With
    /// -o: a page with the profile likelihoods.
    #[command(after_help = examples::TUNE)]
    Tune(TuneInput),
    /// Parameter sweep over gamma, poles, noise or initial errors, with ensembles, in parallel
    ///
    /// Runs are computed in blocks, files in the folder `blocks` of the results folder. A sweep that was interrupted or
    /// killed is resumed: blocks that are there are not computed again. Several processes compute one sweep with
    /// --shard; `sweep status` tells how far it is, `sweep reduce` forms the results, and `sweep script` submits it to
    /// SLURM. The results are the same bytes in all cases, on one kind of processor.
    #[command(after_help = examples::SWEEP, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
    Sweep(SweepInput),
    /// Write an observer for the target, as C99 or Rust source or as an FMU, bit for bit what was designed
    ///
    /// All kinds, functional for plants in discrete time; what has no export is refused with the reason and a hint. A
    /// linear observer in continuous time is designed for the plant sampled at --period. The folder contains the
    /// source, a test with golden vectors, a build file, a README and the certificate. An observer without a
    /// certificate needs --unproved. Output {"observer", "folder", "files", "period", "operations", "bytes", "proved",
    /// "statement", "digest"}.
    #[command(after_help = examples::EXPORT)]
    Export(ExportInput),
    /// An observer on rows from standard input, as they arrive: a line with the estimate for each
    ///
    /// The rows are CSV with a line that names the columns, or JSON objects, one a line; the answers have the same
    /// form. The columns are those of [log] in the study, or the names of the plant's inputs and outputs and the time
    /// t. Each row is one sample of the step that `luenberger export` writes. A row that cannot be used is reported
    /// with its line and passed over; --strict ends at it. Ends with the input, with exit code 0, or 2 if no row of it
    /// could be used. With --json an error is an object on standard output as well.
    #[command(after_help = examples::STREAM)]
    Stream(StreamInput),
    /// Lyapunov equation A X + X A' + Q = 0
    ///
    /// Input {"a": n x n, "q": n x n symmetric}; output {"x", "residual", "condition"}.
    /// As `lyap(A, Q)` of python-control and MATLAB; --transposed solves the observer's form A'X + X A + Q = 0.
    /// A unique X exists iff no two eigenvalues of A add to zero.
    #[command(after_help = examples::LYAP)]
    Lyap(LyapunovInput),
    /// Discrete Lyapunov (Stein) equation A X A' - X + Q = 0
    ///
    /// Input {"a": n x n, "q": n x n symmetric}; output {"x", "residual", "condition"}.
    /// As `dlyap(A, Q)` of python-control and MATLAB; --transposed solves the observer's form A'X A - X + Q = 0.
    /// A unique X exists iff no two eigenvalues of A multiply to one.
    #[command(after_help = examples::DLYAP)]
    Dlyap(LyapunovInput),
    /// Sylvester equation A X + X B + Q = 0
    ///
    /// Input {"a": n x n, "b": m x m, "q": n x m}; output {"x", "residual", "condition"}. The sign is that of
    /// `lyap(A, B, Q)` of python-control and MATLAB; scipy's `solve_sylvester(A, B, Q)` has A X + X B = Q. A unique X
    /// exists iff no eigenvalue of A is the negative of one of B.
    #[command(after_help = examples::SYLV)]
    Sylv(MatrixInput<Sylvester>),
    /// Riccati equation A'X + X A - X B R^-1 B'X + Q = 0, and the regulator K = R^-1 B'X
    ///
    /// Input {"a": n x n, "b": n x m, "q": n x n symmetric, "r": m x m symmetric, regular}; output
    /// {"x", "k", "poles", "residual", "condition", "forward_error"}. X is the stabilizing solution, poles are the
    /// eigenvalues of A - B K. As `care(A, B, Q, R)` of python-control, which returns (X, poles, K). Optional keys:
    /// "s", n x m, the weight 2 x'S u, and "e", n x n regular, of E x' = A x + B u. Q and R may be
    /// indefinite, as in H-infinity equations; X is then not positive semidefinite in general.
    ///
    /// Kalman filter: input {"a": n x n, "c": p x n, "w": n x n, "v": p x p}, the intensities of process and
    /// measurement noise; output {"p", "l", "poles", "residual", "condition", "forward_error"} with A P + P A' - P
    /// C'V^-1 C P + W = 0, L = P C'V^-1. P is the covariance of the error, poles are the eigenvalues of A - L C.
    /// Optional keys: "g", n x q, of x' = A x + B u + G w, with "w" q x q; and "s", n x p (with "g" q x p), the
    /// cross-intensity of w and v.
    #[command(after_help = examples::CARE)]
    Care(MatrixInput<RiccatiProblem>),
    /// Discrete Riccati equation A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0, and K = (R + B'X B)^-1 B'X A
    ///
    /// Input {"a": n x n, "b": n x m, "q": n x n symmetric, "r": m x m symmetric, regular, or singular with
    /// R + B'X B definite}; output {"x", "k", "poles", "residual", "condition", "forward_error"}. X is
    /// the stabilizing solution, poles are the eigenvalues of A - B K. As `dare(A, B, Q, R)` of python-control, which
    /// returns (X, poles, K). Optional keys: "s", n x m, the weight 2 x'S u, and "e", n x n regular, of E x+ = A x + B
    /// u. Q and R may be indefinite, as in H-infinity equations; X is then not positive semidefinite in
    /// general.
    ///
    /// Kalman predictor and filter: input {"a": n x n, "c": p x n, "w": n x n, "v": p x p}, the covariances of process
    /// and measurement noise (v may be singular); output {"p", "l", "filter_gain", "filter_covariance", "poles",
    /// "residual", "condition", "forward_error"} with L = A P C'(V + C P C')^-1. P is the covariance of the one-step
    /// prediction error, poles are the eigenvalues of A - L C. filter_gain is M = P C'(V + C P C')^-1 of the
    /// measurement update, filter_covariance P - M C P. Optional keys: "g", n x q, of x+ = A x + B u + G w, with "w" q
    /// x q; and "s", n x p (with "g" q x p), the cross-covariance of w and v.
    #[command(after_help = examples::DARE)]
    Dare(MatrixInput<RiccatiProblem>),
    /// Pole placement: K such that A - B K, or L such that A - L C, has the specified eigenvalues
    ///
    /// Input {"a": n x n, "b": n x m, "poles": n numbers, complex ones as [re, im] with their conjugates}; output {"k",
    /// "poles", "relative_errors", "condition"}. As `place(A, B, poles)` of python-control and MATLAB: u = -K x.
    ///
    /// Observer: input {"a": n x n, "c": p x n, "poles"}; output {"l", "poles", "relative_errors", "condition"}. This
    /// L is `place(A', C', poles)'` of python-control and MATLAB.
    ///
    /// Optional key "pattern", of the size of the gain, with 0 where the gain must be 0 and 1 elsewhere. The output has
    /// "free" and "rank" in addition: the number of free entries, and how many poles they move independently.
    ///
    /// The poles in the output are recomputed from this gain, in the order of the input, relative_errors are their
    /// distances from the desired ones, relative to these; condition is the condition number of the eigenvector matrix,
    /// null for a defective closed loop. If a pole is missed by more than a tenth, or the closed loop is unstable and
    /// the desired one is not, there is a warning, and the exit code is 1. The multiplicity of a pole is at most
    /// rank(B) or rank(C); with one input or output it is not limited.
    #[command(after_help = examples::PLACE)]
    Place(PlacementInput),
    /// Observability of (A, C): rank, margin of each mode, unobservable directions
    ///
    /// Input {"a": n x n, "c": p x n}; output {"rank", "unobservable", "margins"}, and "tolerance" if one is given.
    /// rank is that of `obsv(A, C)` of python-control and MATLAB, computed without forming that matrix. margins has for
    /// each eigenvalue of A the smallest singular value of [A - lambda I; C] relative to the norm of the scaled pair: 0
    /// for an unobservable mode. unobservable has eigenvalue and direction of each unobservable mode: A v = lambda v, C
    /// v = 0. The exit code is 0 for an unobservable pair too.
    #[command(after_help = examples::OBSV)]
    Obsv(ObservabilityInput),
    /// Eigenvalues of a square matrix
    ///
    /// Input {"a": n x n}; output {"eigenvalues": [[re, im], ..]}. Complex pairs are adjacent, the one with positive
    /// imaginary part first.
    #[command(after_help = examples::EIG)]
    Eig(MatrixInput<Square>),
    /// Frequency response of a plant, of its observer or of the loop u = -K xhat, with margins
    ///
    /// Input {"a": n x n, "b": n x m, "c": p x n, "d": p x m}; without d D is 0. With "l", n x p, the responses from y
    /// and u to the estimate of xhat' = A xhat + B u + L (y - C xhat - D u). With "k", m x n, the loop K (s I - A)^-1 B
    /// of state feedback; with both the loop of the estimate, opened at the inputs and at the outputs of the plant.
    /// Output {"frequencies", "responses": [{"name", "magnitude", "phase", "singular_values"}, ..], "loops": [{"name",
    /// "stable", "poles", "channels": [{"gain_margins", "phase_margins"}, ..], "sensitivity",
    /// "complementary_sensitivity"}, ..]}: for each output and input a list over the frequencies, phases in degrees,
    /// margins of each channel with the others closed. Frequencies are in radians per unit of time.
    #[command(after_help = examples::BODE)]
    Bode(BodeInput),
    /// Continuous to discrete time: zoh, foh, tustin, impulse, matched
    ///
    /// Input {"a": n x n, "b": n x m, "c": p x n, "d": p x m}; without c the output is the state, without d D is 0.
    /// Output {"a", "b", "c", "d", "period"}, and for matched {"transfer": {"zeros", "poles", "gain"}}. The methods are
    /// those of MATLAB's c2d; the state of tustin is scaled as in scipy and python-control. matched needs one input and
    /// one output, and gives the companion form. --delay delays the inputs, --output-delay the outputs: past inputs and
    /// outputs become states.
    #[command(after_help = examples::C2D)]
    C2d(SamplingInput),
    /// Discrete to continuous time: zoh, foh, tustin, impulse
    ///
    /// Input and output as those of c2d. A pole at zero or on the negative real axis has no continuous-time model of
    /// the same order, except by tustin.
    #[command(after_help = examples::D2C)]
    D2c(ConversionInput),
    /// Noise: standard deviations of samples and intensities; process noise in continuous and discrete time
    ///
    /// A Kalman filter in continuous time takes intensities: V = R h for the covariance R of a sample, or sigma^2 h.
    /// Input {"r": p x p} or {"v": p x p}, and {"a", "w"} or {"a", "qd"}: process noise of intensity w in x' = A x + w,
    /// its covariance qd in one period. Whichever is given is converted into the other. Output {"period", "r", "v",
    /// "sigma", "w", "qd"}.
    #[command(after_help = examples::NOISE)]
    Noise(NoiseInput),
    /// Observer poles from a settling time: dominant pair, Bessel, Butterworth, ITAE
    ///
    /// Output {"poles": [[re, im], ..], "settling_time", "band", "damping", "discrete"}. The step response of a system
    /// with these poles, without zeros, stays within the band from the settling time on.
    #[command(after_help = examples::POLES)]
    Poles(PolesInput),
    /// Create a study file from a state-space model of MATLAB and Octave (.mat), numpy (.npz) or python-control (JSON)
    ///
    /// The file has matrices A and C, and optionally B, D, a regular E, a sampling time dt and names of the columns
    /// (StateName or state_labels, likewise inputs and outputs); upper or lower case. They are variables of the file or
    /// fields of one structure: save('model.mat', 'A', 'B', 'C', '-v7'); np.savez('model.npz', A=sys.A, B=sys.B,
    /// C=sys.C); json.dump({'A': sys.A.tolist(), ..}, file). Output {"study", "states", "inputs", "outputs",
    /// "ignored"}.
    #[command(after_help = examples::IMPORT)]
    Import(ImportInput),
    /// Verify certificate files: every claim is rederived in exact or interval arithmetic
    ///
    /// Same as the program luenberger-verify, which depends only on the checker. Output {"files": [{"file", "outcome",
    /// "title", "statement", "facts"}, ..]}. The exit code is 0 if every file is verified, 1 if one is rejected, 2 if
    /// one is not a certificate.
    ///
    /// With --coq the certificate is written as a file that the proof assistant Coq checks with the theory in proofs/
    /// of the repository: a theorem for each claim, up to the decay of the error along all trajectories. Of a
    /// certificate that is false, the theorems say so. Output {"file", "outcome", "coq", "theorems"}.
    #[command(after_help = examples::VERIFY)]
    Verify(VerifyInput),
    /// Rigorous bounds on the optimum of a semidefinite program in SDPA's sparse format
    ///
    /// Minimise c'x subject to x_1 F_1 + ... + x_m F_m - F_0 >= 0. The solver computes an approximate solution; the
    /// printed bounds are verified independently of it. The exit code is 0 if both bounds, or infeasibility, are
    /// verified, 1 otherwise.
    #[command(after_help = examples::SDP)]
    Sdp(SdpInput),
    /// Write the studio: all of this in one page, which opens in a browser without an installation
    ///
    /// One HTML file that loads nothing and sends nothing: studies as text and as a form, run while they are written,
    /// with reports, verified certificates and exported code. Output {"page", "bytes"}.
    #[command(after_help = examples::STUDIO)]
    Studio(StudioInput),
    /// Print a script with which a shell completes the arguments
    ///
    /// Output {"shell", "script"}. Bash reads it from ~/.local/share/bash-completion/completions/luenberger, zsh from a
    /// folder of $fpath under the name _luenberger, fish from ~/.config/fish/completions/luenberger.fish.
    #[command(after_help = examples::COMPLETIONS)]
    Completions(CompletionsInput),
    /// Write the manual pages, one for each command
    ///
    /// Output {"folder", "files"}. `man` finds those in ~/.local/share/man/man1: man luenberger-run.
    #[command(after_help = examples::MAN)]
    Man(ManInput),
}

#[derive(Args)]
pub(crate) struct CompletionsInput {
    /// The shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Args)]
pub(crate) struct ManInput {
    /// Folder for the pages
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: PathBuf,
}

#[derive(Args)]
pub(crate) struct NewInput {
    /// Name of the plant; --list shows all
    #[arg(long, default_value = "double-integrator")]
    pub(crate) plant: String,
    /// The study file to write, or - for standard output
    #[arg(short, long, value_name = "STUDY", default_value = "study.toml")]
    pub(crate) output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    pub(crate) force: bool,
    /// List the plants and the kinds of observers, and exit
    #[arg(long)]
    pub(crate) list: bool,
}

#[derive(Args)]
pub(crate) struct StudyInput {
    /// Study file, TOML or JSON (.json), a folder with one, or - for standard input; file names in it are relative to
    /// its folder
    #[arg(value_name = "STUDY")]
    pub(crate) study: Source,
    /// Results folder [default: STUDY-results for run, certify, simulate and sweep; none for the others]
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
    /// Write into a results folder that has files and no manifest; other files are kept
    #[arg(long)]
    pub(crate) force: bool,
    /// Limit on the estimated memory or the time: memory=SIZE, time=TIME [default: memory=4GiB,time=24h]
    #[arg(long, value_name = "LIMIT", value_delimiter = ',')]
    pub(crate) limit: Vec<Limit>,
    /// Number of threads; it does not affect the results [default: number of processors]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<usize>,
    /// Print the results as Markdown, for an issue or a notebook
    #[arg(long, conflicts_with = "json")]
    pub(crate) markdown: bool,
}

#[derive(Args)]
pub(crate) struct RunInput {
    #[command(flatten)]
    pub(crate) study: StudyInput,
    /// Open the report
    #[arg(long)]
    pub(crate) open: bool,
    /// Run again whenever the study, or a file that it names, is saved; until Ctrl-C
    #[arg(long, conflicts_with = "json")]
    pub(crate) watch: bool,
}

/// What a command that compares or fits has beside a study.
#[derive(Args)]
pub(crate) struct FolderInput {
    /// Results folder [default: none]
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
    /// Write into a results folder that has files and no manifest; other files are kept
    #[arg(long)]
    pub(crate) force: bool,
    /// Number of threads [default: number of processors]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<usize>,
    /// Print the results as Markdown, for an issue or a notebook
    #[arg(long, conflicts_with = "json")]
    pub(crate) markdown: bool,
}

#[derive(Args)]
pub(crate) struct AdviseInput {
    /// Study file, TOML or JSON (.json), a folder with one, or - for standard input; file names in it are relative to
    /// its folder
    #[arg(value_name = "STUDY")]
    pub(crate) study: Source,
    /// Criterion, or several with weights: error, noise, peak, settling, cost, proved, on a log innovations and
    /// likelihood; error=2,cost=1 [default: error, on a log innovations]
    #[arg(long, value_name = "CRITERIA")]
    pub(crate) by: Option<Criteria>,
    /// Time budget, such as 30s or 5min; what it does not reach is listed
    #[arg(long, value_name = "TIME", value_parser = time, default_value = "1min", allow_hyphen_values = true)]
    pub(crate) budget: f64,
    #[command(flatten)]
    pub(crate) folder: FolderInput,
}

#[derive(Args)]
#[command(mut_arg("force", |force| force.help(
    "Write over a tuned study, and into a results folder that has files and no manifest; other files are kept"
)))]
pub(crate) struct TuneInput {
    /// Study file, TOML or JSON (.json), a folder with one, or - for standard input; file names in it are relative to
    /// its folder
    #[arg(value_name = "STUDY")]
    pub(crate) study: Source,
    #[command(flatten)]
    pub(crate) folder: FolderInput,
}

#[derive(Args)]
pub(crate) struct SweepInput {
    #[command(subcommand)]
    pub(crate) action: Option<SweepAction>,
    #[command(flatten)]
    pub(crate) study: Option<StudyInput>,
    /// Compute shard I of N only, and leave the results to `sweep reduce`
    #[arg(long, value_name = "I/N", allow_hyphen_values = true)]
    pub(crate) shard: Option<Shard>,
    /// Runs of a block [default: those of the folder, or a sixteenth of the ensemble, from 32 to 1000]
    #[arg(long, value_name = "RUNS")]
    pub(crate) block_size: Option<u64>,
    /// Delete the blocks in the folder, of this or another study, and compute all of them
    #[arg(long)]
    pub(crate) restart: bool,
    /// Where the scores of each run are written as comma-separated values
    #[arg(long, value_enum, default_value_t = Csv::One)]
    pub(crate) csv: Csv,
}

#[derive(Subcommand)]
pub(crate) enum SweepAction {
    /// How many blocks of a sweep are done, the rate and the remaining time
    ///
    /// Output {"study", "blocks", "runs", "block_size", "done", "done_runs", "missing", "running", "faults", "rate",
    /// "remaining"}: runs per second over the latest hundred blocks, and seconds. The exit code is 1 if --verify finds
    /// a faulty block.
    #[command(after_help = examples::SWEEP_STATUS)]
    Status(StatusInput),
    /// Form the results of a sweep from its blocks: tables, figures, study.json
    #[command(after_help = examples::SWEEP_REDUCE)]
    Reduce(ReduceInput),
    /// Print a shell script that submits a sweep to SLURM: an array of shards, and the reduction after them
    #[command(after_help = examples::SWEEP_SCRIPT)]
    Script(ScriptInput),
}

#[derive(Args)]
pub(crate) struct StatusInput {
    /// Results folder of the sweep
    #[arg(value_name = "FOLDER")]
    pub(crate) folder: PathBuf,
    /// Read every block and check it
    #[arg(long)]
    pub(crate) verify: bool,
}

#[derive(Args)]
pub(crate) struct ReduceInput {
    /// Results folder of the sweep
    #[arg(value_name = "FOLDER")]
    pub(crate) folder: PathBuf,
    /// Where the scores of each run are written as comma-separated values
    #[arg(long, value_enum, default_value_t = Csv::One)]
    pub(crate) csv: Csv,
    /// Write into a folder that has files and no manifest; other files are kept
    #[arg(long)]
    pub(crate) force: bool,
    /// Limit on the estimated memory or the time: memory=SIZE, time=TIME [default: memory=4GiB,time=24h]
    #[arg(long, value_name = "LIMIT", value_delimiter = ',')]
    pub(crate) limit: Vec<Limit>,
    /// Number of threads; it does not affect the results [default: number of processors]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Csv {
    /// All in sweep.csv
    One,
    /// Those of each block beside it
    Blocks,
    /// Nowhere
    None,
}

#[derive(Args)]
pub(crate) struct ScriptInput {
    /// Study file
    #[arg(value_name = "STUDY")]
    pub(crate) study: Source,
    /// For SLURM, the only scheduler with a script
    #[arg(long, required = true)]
    pub(crate) slurm: bool,
    /// Results folder [default: STUDY-results]
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
    /// Number of shards [default: number of blocks, at most 100]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) shards: Option<u32>,
    /// Runs of a block [default: a sixteenth of the ensemble, from 32 to 1000]
    #[arg(long, value_name = "RUNS")]
    pub(crate) block_size: Option<u64>,
    /// Processors of each shard
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) cpus: u32,
    /// Partition [default: that of SLURM]
    #[arg(long, value_name = "NAME", value_parser = word)]
    pub(crate) partition: Option<String>,
    /// Account [default: that of SLURM]
    #[arg(long, value_name = "NAME", value_parser = word)]
    pub(crate) account: Option<String>,
    /// Time limit of each shard, as for sbatch [default: that of SLURM]
    #[arg(long, value_name = "TIME", value_parser = word)]
    pub(crate) time: Option<String>,
    /// Memory of each shard, as for sbatch [default: that of SLURM]
    #[arg(long, value_name = "SIZE", value_parser = word)]
    pub(crate) mem: Option<String>,
}

/// The value of an option of sbatch.
fn word(word: &str) -> Result<String, String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-.,:+".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return Ok(word.to_owned());
    }
    Err("letters, digits and any of _-.,:+ are expected".to_owned())
}

/// Number of threads, from 1 to 1024.
fn threads(word: &str) -> Result<usize, String> {
    match word.parse() {
        Ok(count @ 1..=1024) => Ok(count),
        _ => Err("a number from 1 to 1024 is expected".to_owned()),
    }
}

#[derive(Args)]
pub(crate) struct ExportInput {
    /// Study file: TOML, or JSON with the same keys (.json); - for standard input
    #[arg(value_name = "STUDY")]
    pub(crate) study: Source,
    /// Name of the observer [default: the only one of the study]
    #[arg(long, value_name = "NAME")]
    pub(crate) observer: Option<String>,
    /// What is written
    #[arg(long, value_enum, value_name = "c|rust|fmu")]
    pub(crate) to: Language,
    /// Version of the standard, with --to fmu [default: 2]
    #[arg(long, value_enum, value_name = "VERSION")]
    pub(crate) fmi: Option<FmiVersion>,
    /// The build system that the files in C are for, with a program to be filled in: arduino (and PlatformIO), zephyr,
    /// esp-idf or ros2 [default: CMake]
    #[arg(long, value_name = "SYSTEM")]
    pub(crate) layout: Option<Layout>,
    /// With the feedback u = r - K xhat of the study: the step takes r and y, and returns u as well
    #[arg(long)]
    pub(crate) feedback: bool,
    /// Format of the numbers on the target: f32, f64, or fixed point such as q16.16 (2 to 32 bits, the sign among those
    /// before the point)
    #[arg(long, value_name = "FORMAT", default_value = "f64")]
    pub(crate) format: Precision,
    /// Fixed-point format of the gains [default: that of --format]
    #[arg(long, value_name = "FORMAT", value_parser = Precision::fixed_point)]
    pub(crate) gains: Option<FixedPointFormat>,
    /// Elementary functions (sin, exp) of the C: those of the design, which give its bits, or the target's own
    #[arg(long, value_enum, value_name = "WHOSE", default_value = "own")]
    pub(crate) libm: Libm,
    /// Sampling period, in the time unit of the study [default: that of a sampled observer, or simulation.hold]
    #[arg(long, value_name = "PERIOD", value_parser = period, allow_negative_numbers = true)]
    pub(crate) period: Option<f64>,
    /// Runge-Kutta steps per period of a nonlinear observer [default: a quarter of the fastest time constant of the
    /// error each; those of an extended Kalman filter in the study]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) substeps: Option<u16>,
    /// Steps of the golden test
    #[arg(long, value_name = "COUNT", default_value = "64", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) test_steps: u16,
    /// Folder for the files [default: STUDY-NAME-c, STUDY-NAME-rust or STUDY-NAME-fmu]
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: Option<PathBuf>,
    /// Export an observer without a stability certificate
    #[arg(long)]
    pub(crate) unproved: bool,
    /// Use a folder that has other files; they are kept
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args)]
pub(crate) struct StreamInput {
    /// Study file: TOML, or JSON with the same keys (.json)
    #[arg(value_name = "STUDY")]
    pub(crate) study: Source,
    /// Name of the observer [default: the only one of the study]
    #[arg(long, value_name = "NAME")]
    pub(crate) observer: Option<String>,
    /// Form of the rows, and of the answers [default: by the first row, an object begins with a brace]
    #[arg(long, value_enum, value_name = "FORM")]
    pub(crate) format: Option<RowFormat>,
    /// Sampling period, in the time unit of the study [default: that of a sampled observer, or simulation.hold]
    #[arg(long, value_name = "PERIOD", value_parser = period, allow_negative_numbers = true)]
    pub(crate) period: Option<f64>,
    /// Runge-Kutta steps per period of a nonlinear observer [default: as `luenberger export`]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) substeps: Option<u16>,
    /// Rows without a time: each is the next sample
    #[arg(long)]
    pub(crate) untimed: bool,
    /// Of filters, too, the estimate for the next sample, which the step on the target returns
    #[arg(long)]
    pub(crate) predicted: bool,
    /// Go on from the state in this file, if it is there, and save the state to it at the end and every 1000 rows
    #[arg(long, value_name = "FILE")]
    pub(crate) state: Option<PathBuf>,
    /// End at the first row that cannot be used
    #[arg(long)]
    pub(crate) strict: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum RowFormat {
    /// Comma-separated values, with a line that names the columns
    Csv,
    /// JSON objects, one a line
    Json,
}

/// A positive finite number.
fn period(word: &str) -> Result<f64, String> {
    match word.parse() {
        Ok(period) if period > 0.0 && f64::is_finite(period) => Ok(period),
        _ => Err("a positive finite number is expected".to_owned()),
    }
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Language {
    /// C99
    C,
    /// A no_std crate on luenberger-observers
    Rust,
    /// A functional mock-up unit for co-simulation
    Fmu,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Libm {
    /// Those of the design, written out
    Own,
    /// Those of the target's C library: the results are not those of the design to the last bit
    Target,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum FmiVersion {
    /// FMI 2.0
    #[value(name = "2")]
    Two,
    /// FMI 3.0
    #[value(name = "3")]
    Three,
}

#[derive(Args)]
pub(crate) struct MatrixInput<P: Problem> {
    #[command(flatten)]
    pub(crate) data: Data<P>,
}

#[derive(Args)]
pub(crate) struct ObservabilityInput {
    #[command(flatten)]
    pub(crate) data: Data<Pair>,
    /// Relative size below which a part of the pair counts as zero, for data of few digits [default: rounding]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) tolerance: Option<f64>,
}

#[derive(Args)]
pub(crate) struct BodeInput {
    #[command(flatten)]
    pub(crate) data: Data<LoopProblem>,
    /// Sampling period of a plant in discrete time, x+ = A x + B u [default: continuous time]
    #[arg(short, long, value_name = "H", allow_negative_numbers = true)]
    pub(crate) period: Option<f64>,
    /// First frequency, in radians per unit of time [default: a decade below the slowest pole]
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) from: Option<f64>,
    /// Last frequency [default: a decade above the fastest pole, or pi/period]
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) to: Option<f64>,
    /// Number of frequencies, equally spaced in their logarithm; those of lightly damped poles are added
    #[arg(long, value_name = "N", default_value_t = 13)]
    pub(crate) points: usize,
}

#[derive(Args)]
pub(crate) struct PlacementInput {
    #[command(flatten)]
    pub(crate) data: Data<PolePlacement>,
    /// Exit with 0 also where the poles are missed
    #[arg(long)]
    pub(crate) accept_inexact: bool,
}

#[derive(Args)]
pub(crate) struct LyapunovInput {
    #[command(flatten)]
    pub(crate) data: Data<Lyapunov>,
    /// Transpose A, and E: the observer's form, in which V = e'X e decreases by e'Q e
    #[arg(long)]
    pub(crate) transposed: bool,
}

#[derive(Args)]
pub(crate) struct ConversionInput {
    #[command(flatten)]
    pub(crate) data: Data<StateSpace>,
    /// Sampling period
    #[arg(short, long, value_name = "H", allow_negative_numbers = true)]
    pub(crate) period: f64,
    /// Method, by its name in MATLAB's c2d
    #[arg(short, long, value_enum, default_value_t = Method::Zoh)]
    pub(crate) method: Method,
    /// With tustin: frequency in radians per unit of time at which the frequency response is exact
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub(crate) prewarp: Option<f64>,
}

#[derive(Args)]
pub(crate) struct SamplingInput {
    #[command(flatten)]
    pub(crate) conversion: ConversionInput,
    /// With zoh: delay of the input, or of each input, in the unit of time of A; whole periods or not
    #[arg(long, value_name = "DELAY", value_delimiter = ',', allow_negative_numbers = true)]
    pub(crate) delay: Vec<f64>,
    /// With zoh: delay of the output, or of each output, likewise
    #[arg(long, value_name = "DELAY", value_delimiter = ',', allow_negative_numbers = true)]
    pub(crate) output_delay: Vec<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Zero-order hold: exact for an input that is held over each period
    Zoh,
    /// First-order hold: exact for an input that is linear between samples
    Foh,
    /// Trapezoidal rule, s = (2/h) (z - 1)/(z + 1)
    Tustin,
    /// The impulse response is sampled, and multiplied by the period
    Impulse,
    /// Matched poles and zeros, for one input and one output
    Matched,
}

#[derive(Args)]
pub(crate) struct NoiseInput {
    #[command(flatten)]
    pub(crate) data: Data<NoiseModel>,
    /// Sampling period
    #[arg(short, long, value_name = "H", allow_negative_numbers = true)]
    pub(crate) period: f64,
    /// Standard deviations of the samples of the sensors, in place of r
    #[arg(short, long, value_name = "S", value_delimiter = ',', allow_negative_numbers = true)]
    pub(crate) sigma: Option<Vec<f64>>,
}

#[derive(Args)]
pub(crate) struct PolesInput {
    /// Number of poles
    #[arg(short = 'n', long, value_name = "N")]
    pub(crate) order: usize,
    /// Settling time
    #[arg(short, long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) settling: f64,
    /// Band of the settling time
    #[arg(long, value_name = "FRACTION", default_value_t = 0.02, allow_negative_numbers = true)]
    pub(crate) band: f64,
    /// Pattern of the poles
    #[arg(long, value_enum, default_value_t = Pattern::Dominant)]
    pub(crate) pattern: Pattern,
    /// Damping ratio of the dominant pair [default: 1]
    #[arg(long, value_name = "ZETA", conflicts_with = "overshoot", allow_negative_numbers = true)]
    pub(crate) damping: Option<f64>,
    /// Overshoot of the dominant pair as a fraction, in place of its damping
    #[arg(long, value_name = "FRACTION", allow_negative_numbers = true)]
    pub(crate) overshoot: Option<f64>,
    /// Real part of the other poles relative to that of the dominant pair
    #[arg(long, value_name = "RATIO", default_value_t = 5.0, allow_negative_numbers = true)]
    pub(crate) ratio: f64,
    /// Sampling period: print the poles e^{p h} in discrete time, too
    #[arg(short, long, value_name = "H", allow_negative_numbers = true)]
    pub(crate) period: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Pattern {
    /// A pair with the damping ratio, the other poles real and further left
    Dominant,
    /// Bessel filter: hardly any overshoot
    Bessel,
    /// Butterworth filter
    Butterworth,
    /// Least integral of time-weighted absolute error, up to order 6
    Itae,
}

#[derive(Args)]
pub(crate) struct SdpInput {
    /// Semidefinite program in SDPA's sparse format, or - for standard input
    #[arg(value_name = "FILE.dat-s")]
    pub(crate) file: Source,
    /// Solver that computes the approximate solution
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
    /// Write the certificate as a file for Coq, with a theorem for each claim (one certificate)
    #[arg(long, requires = "output")]
    pub(crate) coq: bool,
    /// The file for Coq, or - for standard output
    #[arg(short, long, value_name = "FILE.v", requires = "coq")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite the file for Coq
    #[arg(long, requires = "coq")]
    pub(crate) force: bool,
}

#[derive(Args)]
pub(crate) struct ImportInput {
    /// Model file; its format is recognized from its first bytes
    #[arg(value_name = "MODEL")]
    pub(crate) model: PathBuf,
    /// The study file to write, or - for standard output
    #[arg(short, long, value_name = "STUDY", default_value = "study.toml")]
    pub(crate) output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args)]
pub(crate) struct StudioInput {
    /// The page to write
    #[arg(short, long, value_name = "PAGE", default_value = "studio.html")]
    pub(crate) output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    pub(crate) force: bool,
    /// Open it in the program that shows pages
    #[arg(long)]
    pub(crate) open: bool,
}

/// Prints clap's message: help and version with exit code 0, a usage error with 2.
pub(crate) fn refused(error: &clap::Error) -> ExitCode {
    let is_answer = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
    if !is_answer && std::env::args_os().any(|argument| argument == "--json") {
        let message = error.to_string();
        let message = message.strip_prefix("error: ").unwrap_or(&message);
        let object = json!({ "error": { "kind": "usage", "message": message.trim_end() } });
        // The exit code says that there is an error, even if its object cannot be written.
        _ = output::line(&object.to_string());
    }
    let printed = error.print();
    if !is_answer {
        return ExitCode::from(WRONG);
    }
    printed.map_or_else(|error| output::failed(&error, ExitCode::SUCCESS), |()| ExitCode::SUCCESS)
}
