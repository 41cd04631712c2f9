//! Examples at the end of helps: those of the pages in docs/commands, which the tests run. A line `[..]` stands for the
//! rest of an output.

pub(crate) const NEW: &str = r"Example:
  $ luenberger new --plant double-integrator -o cart.toml
  $ luenberger run cart.toml";

pub(crate) const RUN: &str = r"Example:
  $ luenberger new -o cart.toml
  $ luenberger run cart.toml";

pub(crate) const OBSERVE: &str = r"Example:
  $ luenberger new -o cart.toml
  $ luenberger observe cart.toml";

pub(crate) const DESIGN: &str = r"Example:
  $ luenberger new -o cart.toml
  $ luenberger design cart.toml";

pub(crate) const CERTIFY: &str = r"Example:
  $ luenberger new -o cart.toml
  $ luenberger certify cart.toml -o results";

pub(crate) const SIMULATE: &str = r"Example:
  $ luenberger new -o cart.toml
  $ luenberger simulate cart.toml -o results";

pub(crate) const COMPARE: &str = r"Example:
  $ luenberger new -o cart.toml
  $ luenberger compare cart.toml";

pub(crate) const ADVISE: &str = r"Example, for a study with a plant and its noise:
  $ luenberger advise pendulum.toml --budget 10min -o advice
  $ luenberger run advice/study.toml -o results";

pub(crate) const TUNE: &str = r"Example, for a study with a log and a table [tune]:
  $ luenberger tune motor.toml -o fit
  $ luenberger run tuned.toml -o results";

pub(crate) const SWEEP: &str = r"Examples:
  $ luenberger new -o cart.toml
  $ luenberger sweep cart.toml -o results
On several machines with one file system, for a study with a sweep:
  $ luenberger sweep mass.toml -o shared --block-size 10 --shard 1/2
  $ luenberger sweep mass.toml -o shared --shard 2/2
  $ luenberger sweep status shared
  $ luenberger sweep reduce shared";

pub(crate) const SWEEP_STATUS: &str = r"Example, for a sweep of which half is computed:
  $ luenberger sweep status shared
  mass.toml: 3 of 6 blocks in shared/blocks (30 of 60 runs)
  missing: 3 (1, 3, 5)
  [..]";

pub(crate) const SWEEP_REDUCE: &str = r"Example, for a sweep of which all blocks are computed:
  $ luenberger sweep reduce shared
  [..]
  7 files in shared";

pub(crate) const SWEEP_SCRIPT: &str = r"Example:
  $ luenberger sweep script mass.toml --slurm -o shared --shards 2 --cpus 4 --time 1:00:00 > submit.sh";

pub(crate) const EXPORT: &str = r"Example:
  $ luenberger new -o cart.toml
  $ luenberger export cart.toml --observer sampled --to c --format f32 -o firmware";

pub(crate) const STREAM: &str = r"Examples:
  $ luenberger new -o cart.toml
  $ printf 't,force,measured\n0,0.1,3\n0.02,0.1,2.99\n' | luenberger stream cart.toml --observer sampled
  t,position_hat,velocity_hat
  [..]";

pub(crate) const LYAP: &str = r#"Examples:
  $ echo '{"a": [[0, 1], [-2, -3]], "q": [[1, 0], [0, 1]]}' | luenberger lyap -
  A X + X A' + Q = 0
  X =
     1    -0.5
    -0.5   0.5
  [..]
  $ echo '{"a": [[0, 1], [-2, -3]], "q": [[1, 0], [0, 1]]}' | luenberger lyap - --transposed
  A'X + X A + Q = 0
  X =
    1.25  0.25
    0.25  0.25
  [..]"#;

pub(crate) const DLYAP: &str = r#"Example:
  $ echo '{"a": [[0.5, 1], [0, -0.5]], "q": [[1, 0], [0, 1]]}' | luenberger dlyap -
  A X A' - X + Q = 0
  X =
     2.4       -0.533333
    -0.533333   1.33333
  [..]"#;

pub(crate) const SYLV: &str = r#"Example:
  $ echo '{"a": [[0, 1], [-2, -3]], "b": [[-4]], "q": [[1], [2]]}' | luenberger sylv -
  A X + X B + Q = 0
  X =
    0.3
    0.2
  [..]"#;

pub(crate) const CARE: &str = r#"Examples:
  $ echo '{"a": [[0, 1], [0, 0]], "b": [[0], [1]], "q": [[1, 0], [0, 1]], "r": [[1]]}' | luenberger care -
  A'X + X A - X B R^-1 B'X + Q = 0, K = R^-1 B'X
  X =
    1.73205        1
          1  1.73205
  K =
    1  1.73205
  [..]
  $ echo '{"a": [[0, 1], [0, 0]], "c": [[1, 0]], "w": [[0, 0], [0, 1]], "v": [[1]]}' | luenberger care -
  A P + P A' - P C'V^-1 C P + W = 0, L = P C'V^-1
  [..]"#;

pub(crate) const DARE: &str = r#"Examples:
  $ echo '{"a": [[1]], "b": [[1]], "q": [[1]], "r": [[1]]}' | luenberger dare -
  A'X A - X - A'X B (R + B'X B)^-1 B'X A + Q = 0, K = (R + B'X B)^-1 B'X A
  X =
    1.61803
  K =
    0.618034
  [..]
  $ echo '{"a": [[1]], "c": [[1]], "w": [[1]], "v": [[1]]}' | luenberger dare -
  A P A' - P - A P C'(V + C P C')^-1 C P A' + W = 0, L = A P C'(V + C P C')^-1
  [..]"#;

pub(crate) const PLACE: &str = r#"Examples:
  $ luenberger place "0 1; 0 0" --c "1 0" --poles -2,-5
  A - L C has the poles below: L (y - C xhat) corrects the estimate
  [..]
  $ echo '{"a": [[0, 1], [3, 2]], "b": [[0], [1]], "poles": [[-1, 2], [-1, -2]]}' | luenberger place -
  A - B K has the poles below: u = -K x
  K =
    8  4
  [..]
  $ echo '{"a": [[0, 1], [0, 0]], "c": [[1, 0]], "poles": [-2, -5]}' | luenberger place -
  A - L C has the poles below: L (y - C xhat) corrects the estimate
  L =
     7
    10
  [..]"#;

pub(crate) const OBSV: &str = r#"Example:
  $ echo '{"a": [[-1, 0], [0, -2]], "c": [[1, 0]]}' | luenberger obsv -
  rank 1 of 2: not observable
    mode -1: margin 0.33
    mode -2: margin 0
  unobservable: -2 along [0, 1]"#;

pub(crate) const EIG: &str = r#"Example:
  $ echo '{"a": [[0, 1], [-5, -2]]}' | luenberger eig -
  eigenvalues =
    -1 + 2i
    -1 - 2i"#;

pub(crate) const BODE: &str = r#"Example:
  $ luenberger bode "0 1; -3 -4" --b "0; 1" --c "2 1" --l "30; -50" --k "50 10" --from 1 --to 100 --points 3
  loop at the inputs: closed, it is stable
    gain may fall to 0.804671 (-1.88763 dB) at 4.57278
    phase margin 14.8132 degrees at 12.604
  [..]"#;

pub(crate) const C2D: &str = r#"Example:
  $ echo '{"a": [[0, 1], [-2, -3]], "b": [[0], [1]], "c": [[1, 0]]}' | luenberger c2d - --period 0.1
  x+ = A x + B u, y = C x + D u, period 0.1
  A =
     0.990944  0.0861067
    -0.172213  0.732624
  [..]"#;

pub(crate) const D2C: &str = r#"Example:
  $ echo '{"a": [[0.5]], "b": [[1]]}' | luenberger d2c - --period 1
  x' = A x + B u, y = C x + D u
  A =
    -0.693147
  B =
    1.38629
  [..]"#;

pub(crate) const NOISE: &str = r#"Examples:
  $ luenberger noise --period 0.01 --sigma 0.005
  period 0.01
  V = R h, intensity of the measurement noise =
    2.5e-7
  [..]
  $ echo '{"a": [[0, 1], [0, 0]], "w": [[0, 0], [0, 2]]}' | luenberger noise - --period 0.5
  period 0.5
  Qd, covariance of the process noise in one period =
    0.0833333  0.25
    0.25       1
  [..]"#;

pub(crate) const POLES: &str = r"Examples:
  $ luenberger poles --order 3 --settling 1.5 --overshoot 0.05
  settling time 1.5 (to 2 %)
  damping ratio 0.690107
  poles =
    -2.82359 + 2.96107i
    -2.82359 - 2.96107i
    -14.118
  $ luenberger poles --order 4 --settling 1.5 --pattern bessel --period 0.01";

pub(crate) const IMPORT: &str = r#"Example:
  $ echo '{"A": [[0, 1], [-2, -3]], "B": [[0], [1]], "C": [[1, 0]], "D": [[0]], "dt": 0}' > model.json
  $ luenberger import model.json -o pendulum.toml
  pendulum.toml: 2 states, 1 input, 1 output"#;

pub(crate) const VERIFY: &str = r"Example:
  $ luenberger new -o cart.toml
  $ luenberger certify cart.toml -o results
  $ luenberger verify results/certificates/linear.json
  results/certificates/linear.json: Proved
  [..]";

pub(crate) const STUDIO: &str = r"Example:
  $ luenberger studio -o studio.html
  studio.html: the studio, one page of [..]";

pub(crate) const SDP: &str = r"Example:
  $ printf '1\n1\n2\n1.0\n0 1 1 2 -1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n' > one.dat-s
  $ luenberger sdp one.dat-s
  proved-optimal-bounds after [..]
  1 <= optimum <= 1";

pub(crate) const COMPLETIONS: &str = r"Example:
  $ luenberger completions bash > luenberger.bash";

pub(crate) const MAN: &str = r"Example:
  $ luenberger man -o man1";
