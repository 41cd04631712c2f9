//! Every kind of file gives the plant that was written into it; every damaged one gives an error.

mod writer;

use luenberger_study::import::{ImportError, Model, read};
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;
use writer::{Mat, npy, npy_of, npz};

/// Small numbers in two bytes, large and small doubles, zeros for the sparse.
fn plant() -> (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>) {
    let a = dmatrix![0.0, 1.0, 0.0; -2.5, 0.0, 1e-300; 0.0, 0.1, -3e12];
    (a, dmatrix![0.0, 1.0; 1.0, 0.0; 0.0, -7.0], dmatrix![1.0, 0.0, 0.0])
}

#[track_caller]
fn assert_is_plant(bytes: &[u8], ignored: &[&str]) {
    let (a, b, c) = plant();
    assert_eq!(
        read(bytes),
        Ok(Model {
            a,
            b,
            c,
            d: None,
            descriptor: None,
            dt: None,
            states: None,
            inputs: None,
            outputs: None,
            ignored: ignored.iter().map(|name| (*name).to_owned()).collect()
        })
    );
}

fn kinds() -> impl Iterator<Item = Mat> {
    [(true, false), (true, true), (false, false), (false, true)]
        .into_iter()
        .map(|(is_little, is_compressed)| Mat { is_little, is_compressed })
}

#[test]
fn matlab_files_of_either_order_compressed_or_not() {
    let (a, b, c) = plant();
    for mat in kinds() {
        let other = mat.full("hsv", &dmatrix![1.0, 2.0]);
        assert_is_plant(&mat.file(&[mat.full("A", &a), other.clone(), mat.full("B", &b), mat.full("C", &c)]), &["hsv"]);
        assert_is_plant(&mat.file(&[mat.sparse("a", &a), mat.sparse("b", &b), mat.sparse("c", &c)]), &[]);
        let fields = [("A", mat.full("", &a)), ("B", mat.sparse("", &b)), ("C", mat.full("", &c))];
        let text = mat.array(4, &[1, 2], "note", &[mat.element(16, b"hi")]);
        assert_is_plant(&mat.file(&[text, other, mat.structure("sys", &fields)]), &["hsv", "note"]);
    }
}

#[test]
fn archives_of_numpy_in_either_order_compressed_or_not() {
    let (a, b, c) = plant();
    for is_compressed in [false, true] {
        for (is_fortran, kind) in [(false, "<f8"), (true, "<f8"), (false, ">f8"), (true, ">f8")] {
            let array = |m| npy(m, is_fortran, kind);
            let arrays = [("A", array(&a)), ("B", array(&b)), ("C", array(&c)), ("w", array(&a))];
            assert_is_plant(&npz(&arrays, is_compressed), &["w"]);
        }
    }
}

#[test]
fn small_integers_and_scalars_of_numpy() {
    let header = |kind, shape| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let arrays = [
        ("A", npy_of(&header("|i1", "(1, 1)"), &[0xfe])),
        ("B", npy_of(&header("<i8", "()"), &3_i64.to_le_bytes())),
        ("C", npy_of(&header(">f4", "(1,)"), &0.5_f32.to_be_bytes())),
        ("dt", npy_of(&header("<f8", "()"), &0.0_f64.to_le_bytes())),
    ];
    let model = read(&npz(&arrays, true)).unwrap();
    assert_eq!((model.a, model.b, model.c), (dmatrix![-2.0], dmatrix![3.0], dmatrix![0.5]));
}

#[test]
fn json_as_python_dumps_it() {
    let text = "{\"A\": [[0.0, 1.0, 0.0], [-2.5, 0.0, 1e-300], [0.0, 0.1, -3e12]], \"B\": [[0, 1], [1, 0], [0, -7]], \"C\": [[1, 0, 0]], \"D\": [[0, 0]], \"dt\": null}";
    assert_is_plant(text.as_bytes(), &[]);
    let mut marked = "\u{feff}\n ".as_bytes().to_vec();
    marked.extend(
        text.replace("\"dt\": null", "\"dt\": 0, \"E\": [[1,0,0],[0,1,0],[0,0,1]], \"names\": [\"q\", [1]]").as_bytes(),
    );
    assert_is_plant(&marked, &["names"]);
    let nested = format!("{{\"about\": \"an arm\", \"sys\": {}}}", text.replace("\"D\"", "\"d\""));
    assert_is_plant(nested.as_bytes(), &["about"]);
}

#[test]
fn a_plant_without_inputs_has_none() {
    let model = read(br#"{"A": [[-1]], "C": [[1]]}"#).unwrap();
    assert_eq!(model.b.shape(), (1, 0));
    assert!(!model.study("t").contains("\nb = "));
}

#[test]
fn a_feedthrough_is_taken_and_a_zero_one_is_none() {
    let with = |d: &str| {
        read(format!("{{\"A\": [[-1]], \"B\": [[1, 2]], \"C\": [[1], [3]], \"D\": {d}}}").as_bytes()).unwrap()
    };
    let model = with("[[0, 2.5], [-1, 0]]");
    assert_eq!(model.d, Some(dmatrix![0.0, 2.5; -1.0, 0.0]));
    assert!(model.study("t").contains("\nd = [\n  [0.0, 2.5],\n  [-1.0, 0.0],\n]\n"), "{}", model.study("t"));
    // In python-control a scalar zero stands for a zero matrix.
    for zero in ["[[0, 0], [0, 0]]", "[[0]]", "[]"] {
        assert_eq!(with(zero).d, None, "{zero}");
        assert!(!with(zero).study("t").contains("\nd = "));
    }
}

#[test]
fn a_model_in_discrete_time_keeps_its_period() {
    let model = read(br#"{"A": [[0.5, 1], [0, 0]], "C": [[1, 0]], "Ts": 0.25}"#).unwrap();
    assert_eq!(model.dt, Some(0.25));
    let study = model.study("t");
    assert!(study.contains("# In discrete time, x+ = A x + B u.\ndt = 0.25\n"), "{study}");
    assert!(study.contains("# Covariances per sample of the noise"), "{study}");
    // The slowest time constant is 0.25/ln 2.
    assert!(study.contains("duration = 10.0\n"), "{study}");
}

/// MATLAB's names, python-control's labels and those of a study are kept where they fit.
#[test]
fn names_of_columns_are_kept() {
    let json = r#"{"A": [[0, 1], [-1, -1]], "B": [[0], [1]], "C": [[1, 0]],
        "state_labels": ["angle", "speed"], "InputName": ["torque"], "outputs": ["encoder"]}"#;
    let model = read(json.as_bytes()).unwrap();
    let list = |names: &[&str]| Some(names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>());
    assert_eq!(model.states, list(&["angle", "speed"]));
    assert_eq!((model.inputs.clone(), model.outputs.clone()), (list(&["torque"]), list(&["encoder"])));
    assert!(model.ignored.is_empty());
    assert!(
        model.study("t").contains("states = [\"angle\", \"speed\"]\ninputs = [\"torque\"]\noutputs = [\"encoder\"]\n")
    );
    // Empty names, as MATLAB's defaults, too few and equal ones are no names; they are listed.
    for names in ["[\"\", \"\"]", "[\"angle\"]", "[\"a\", \"a\"]", "[1, 2]", "3"] {
        let model = read(json.replace("[\"angle\", \"speed\"]", names).as_bytes()).unwrap();
        assert_eq!((model.states, model.ignored), (None, vec!["state_labels".to_owned()]), "{names}");
    }
    let (a, b, c) = plant();
    for kind in kinds() {
        let texts = ["q", "v\u{e4}", "z"];
        let cells: Vec<Vec<u8>> = texts.iter().map(|text| kind.text(text)).collect();
        let state_names = kind.array(1, &[3, 1], "", &cells);
        let unnamed = |m: &DMatrix<f64>| kind.full("", m);
        let fields = [("A", unnamed(&a)), ("B", unnamed(&b)), ("C", unnamed(&c)), ("StateName", state_names)];
        let model = read(&kind.file(&[kind.structure("sys", &fields)])).unwrap();
        assert_eq!(model.states, list(&texts), "{kind:?}");
    }
    let letters: Vec<u8> = ["on", "off"]
        .iter()
        .flat_map(|name| {
            name.chars().chain(['\0'; 3]).take(3).flat_map(|letter| (letter as u32).to_le_bytes()).collect::<Vec<_>>()
        })
        .collect();
    let header = "{'descr': '<U3', 'fortran_order': False, 'shape': (2,), }";
    let one = |m: &DMatrix<f64>| writer::npy(m, false, "<f8");
    let arrays = [
        ("A", one(&dmatrix![0.0, 1.0; -1.0, -1.0])),
        ("C", one(&dmatrix![1.0, 0.0])),
        ("states", npy_of(header, &letters)),
    ];
    assert_eq!(read(&npz(&arrays, false)).unwrap().states, list(&["on", "off"]));
}

/// A file by hand, in the form of `ls-oct-text.cc` and `ov-*.cc` of Octave 8, with every kind of matrix.
const OCTAVE: &str = r"# Created by Octave 8.4.0, Fri Jan 05 10:00:00 2024 UTC <user@host>
# name: note
# type: cell
# rows: 1
# columns: 2
# name: <cell-element>
# type: string
# elements: 1
# length: 9
# name: A


# name: <cell-element>
# type: scalar struct
# ndims: 2
 1 1
# length: 1
# name: A
# type: scalar
7




# name: sys
# type: scalar struct
# ndims: 2
 1 1
# length: 7
# name: A
# type: complex matrix
# rows: 2
# columns: 2
 (0,0) (1,0)
 (-2.5,0) (-1e-3,0)


# name: B
# type: sparse matrix
# nnz: 2
# rows: 2
# columns: 2
2 1 1
1 2 0.5


# name: C
# type: diagonal matrix
# rows: 2
# columns: 2
1
1


# name: D
# type: int32 matrix
# ndims: 2
 2 2
  0
  3
  0
  0


# name: E
# type: null_matrix
# rows: 0
# columns: 0


# name: StateName
# type: cell
# rows: 2
# columns: 1
# name: <cell-element>
# type: sq_string
# elements: 1
# length: 5
angle


# name: <cell-element>
# type: string
# elements: 1
# length: 5
speed




# name: OutputName
# type: string
# elements: 2
# length: 2
q 
# length: 2
dq


# name: dt
# type: bool
1


";

#[test]
fn octave_s_text() {
    let expected = Model {
        a: dmatrix![0.0, 1.0; -2.5, -1e-3],
        b: dmatrix![0.0, 0.5; 1.0, 0.0],
        c: dmatrix![1.0, 0.0; 0.0, 1.0],
        d: Some(dmatrix![0.0, 0.0; 3.0, 0.0]),
        descriptor: None,
        dt: None,
        states: Some(vec!["angle".to_owned(), "speed".to_owned()]),
        inputs: None,
        outputs: Some(vec!["q".to_owned(), "dq".to_owned()]),
        ignored: vec!["dt".to_owned(), "note".to_owned()],
    };
    assert_eq!(read(OCTAVE.as_bytes()), Ok(expected.clone()));
    assert_eq!(read(OCTAVE.replace('\n', "\r\n").as_bytes()), Ok(expected));
    // Of another program, without its first line, and with the variables themselves.
    let plain = "# name: A\n# type: matrix\n# rows: 2\n# columns: 2\n 0 1\n -Inf -3\n\n\n# name: C\n# type: matrix\n";
    assert_eq!(refused(plain.as_bytes()), "line 10: \"# rows: ..\" is expected");
    let scalar = "# name: A\n# type: scalar\n-2\n\n\n# name: C\n# type: complex scalar\n(1,0)\n# name: dt\n# type: scalar\n0.5\n";
    let model = read(scalar.as_bytes()).unwrap();
    assert_eq!((model.a, model.c, model.dt), (dmatrix![-2.0], dmatrix![1.0], Some(0.5)));
    assert_eq!(
        refused(scalar.replace("(1,0)", "(1,2)").as_bytes()),
        "C is complex, and must be a matrix of real numbers"
    );
    assert_eq!(refused(scalar.replace("-2", "two").as_bytes()), "line 3: \"two\" is not a number");
    assert_eq!(refused(scalar.replace("-2", "-2 1").as_bytes()), "line 3: 1 numbers are expected, and 2 found");
    let huge = "# name: A\n# type: matrix\n# rows: 70000\n# columns: 70000\n";
    assert!(refused(huge.as_bytes()).contains("matrices of at most"));
    let nested = "# name: s\n# type: scalar struct\n# length: 1\n".repeat(100_000);
    assert_eq!(refused(nested.as_bytes()), "line 100: structures and cell arrays are nested deeper than 32");
}

/// A matrix of version 4, full or sparse.
fn version_4(m: &DMatrix<f64>, name: &str, is_sparse: bool) -> Vec<u8> {
    let stored = m.iter().filter(|x| **x != 0.0).count();
    let columns: Vec<f64> = if is_sparse {
        let places = (0..m.ncols()).flat_map(|j| (0..m.nrows()).map(move |i| (i, j))).filter(|at| m[*at] != 0.0);
        let places: Vec<(usize, usize)> = places.collect();
        let rows = places.iter().map(|at| at.0 as f64 + 1.0).chain([m.nrows() as f64]);
        let of = places.iter().map(|at| at.1 as f64 + 1.0).chain([m.ncols() as f64]);
        rows.chain(of).chain(places.iter().map(|at| m[*at])).chain([0.0]).collect()
    } else {
        m.iter().copied().collect()
    };
    let (rows, width) = if is_sparse { (stored + 1, 3) } else { m.shape() };
    let kind = if is_sparse { 2 } else { 0 };
    let head = [kind, rows as u32, width as u32, 0, name.len() as u32 + 1];
    let head = head.iter().flat_map(|word| word.to_le_bytes());
    head.chain(name.bytes()).chain([0]).chain(columns.iter().flat_map(|x| x.to_le_bytes())).collect()
}

/// The bytes are those of scipy 1.17.1, `savemat(.., format='4')`: A = [0 1; -2 -3], C complex with imaginary part
/// zero, B sparse, StateName, dt and an array of bytes.
#[test]
fn matlab_files_of_version_4() {
    let words = |words: [u32; 5], name: &[u8]| -> Vec<u8> {
        words.iter().flat_map(|word| word.to_le_bytes()).chain(name.iter().copied()).collect()
    };
    let doubles = |numbers: &[f64]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let parts = [
        words([0, 2, 2, 0, 2], b"A\0"),
        doubles(&[0.0, -2.0, 1.0, -3.0]),
        words([0, 1, 2, 1, 2], b"C\0"),
        doubles(&[1.0, 2.0, 0.0, 0.0]),
        words([2, 3, 3, 0, 2], b"B\0"),
        doubles(&[2.0, 1.0, 2.0, 1.0, 2.0, 2.0, 2.0, 1.5, 0.0]),
        words([51, 2, 2, 0, 10], b"StateName\0"),
        b"acb ".to_vec(),
        words([0, 1, 1, 0, 3], b"dt\0"),
        doubles(&[1.0]),
        words([50, 1, 2, 0, 3], b"n8\0"),
        vec![1, 2],
    ];
    let file = parts.concat();
    let model = read(&file).unwrap();
    assert_eq!(model.a, dmatrix![0.0, 1.0; -2.0, -3.0]);
    assert_eq!((model.b, model.c), (dmatrix![0.0, 1.5; 2.0, 0.0], dmatrix![1.0, 2.0]));
    assert_eq!((model.states, model.dt), (Some(vec!["ab".to_owned(), "c".to_owned()]), Some(1.0)));
    assert_eq!(model.ignored, ["n8"]);
    // A big-endian one.
    let big = |words: [u32; 5], name: &[u8], numbers: &[f64]| -> Vec<u8> {
        let words = words.iter().flat_map(|word| word.to_be_bytes());
        words.chain(name.iter().copied()).chain(numbers.iter().flat_map(|x| x.to_be_bytes())).collect()
    };
    let file = [big([1000, 1, 1, 0, 2], b"A\0", &[-2.0]), big([1000, 1, 1, 0, 2], b"C\0", &[4.0])].concat();
    let model = read(&file).unwrap();
    assert_eq!((model.a, model.c), (dmatrix![-2.0], dmatrix![4.0]));
    assert_eq!(
        refused(&file[..55]),
        "the file is damaged: a matrix that is longer than what is left of the file at byte 30"
    );
}

/// None is continuous time, and true, a period left open, counts samples, in JSON, numpy's archives and MATLAB's files.
#[test]
fn sampling_times_of_python_control() {
    let json = |dt: &str| read(format!("{{\"A\": [[0.5]], \"C\": [[1]], \"dt\": {dt}}}").as_bytes()).unwrap().dt;
    assert_eq!(
        [json("true"), json("false"), json("null"), json("0"), json("0.5")],
        [Some(1.0), None, None, None, Some(0.5)]
    );
    let header = |kind| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (), }}");
    let archive = |kind, data: &[u8]| {
        let one = |m: &DMatrix<f64>| npy(m, false, "<f8");
        npz(&[("A", one(&dmatrix![0.5])), ("C", one(&dmatrix![1.0])), ("dt", npy_of(&header(kind), data))], true)
    };
    // numpy 2.4, `np.savez(.., dt=None)`, protocol 4, and the end of the same of protocol 2.
    let none = b"\x80\x04\x95\x87\0\0\0\0\0\0\0\x8c\x16numpy._core.multiarray\x94\x8c\x0c_reconstruct\x94\x93\x94\x8c\x05numpy\x94\x8c\x07ndarray\x94\x93\x94K\0\x85\x94C\x01b\x94\x87\x94R\x94(K\x01)h\x03\x8c\x05dtype\x94\x93\x94\x8c\x02O8\x94\x89\x88\x87\x94R\x94(K\x03\x8c\x01|\x94NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK?t\x94b\x89]\x94Nat\x94b.";
    assert_eq!(read(&archive("|O", none)).unwrap().dt, None);
    assert_eq!(read(&archive("|O", b"\x89]q\x0cNatq\rb.")).unwrap().dt, None);
    // The integer 78.
    assert!(read(&archive("|O", b"\x89]\x94KNat\x94b.")).unwrap_err().to_string().contains("of the type \"|O\""));
    assert_eq!(read(&archive("|b1", &[1])).unwrap().dt, Some(1.0));
    assert_eq!(read(&archive("|b1", &[0])).unwrap().dt, None);
    let mat = Mat { is_little: true, is_compressed: false };
    // scipy 1.17.1, `savemat(.., dict(dt=True))`: bytes with the flag of logical arrays.
    let dt = mat.array(9 | 2 << 8, &[1, 1], "dt", &[mat.element(2, &[1])]);
    let file = mat.file(&[mat.full("A", &dmatrix![0.5]), mat.full("C", &dmatrix![1.0]), dt]);
    assert_eq!(read(&file).unwrap().dt, Some(1.0));
}

#[test]
fn complex_arrays_of_numpy_with_imaginary_parts_of_zero() {
    let header = |kind| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (1, 2), }}");
    let c = |kind, data: Vec<u8>| {
        read(&npz(
            &[("A", npy(&dmatrix![0.0, 1.0; 2.0, 3.0], false, "<f8")), ("C", npy_of(&header(kind), &data))],
            false,
        ))
    };
    let doubles = |numbers: [f64; 4]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let singles = [1.0_f32, 0.0, -2.5, 0.0].iter().flat_map(|x| x.to_be_bytes()).collect();
    assert_eq!(c("<c16", doubles([1.0, 0.0, -2.5, 0.0])).unwrap().c, dmatrix![1.0, -2.5]);
    assert_eq!(c(">c8", singles).unwrap().c, dmatrix![1.0, -2.5]);
    let refused = c("<c16", doubles([1.0, 0.0, -2.5, 1e-9])).unwrap_err();
    assert_eq!(refused.to_string(), "C is complex, and must be a matrix of real numbers");
}

/// `E x' = A x + B u` with E = [1 0; 1 2e-6]: by hand, A = [0 1; -2e6 -2e6], B = [0; 5e5].
#[test]
fn a_regular_e_is_multiplied_into_a_and_b() {
    let text = br#"{"A": [[0, 1], [-4, -3]], "B": [[0], [1]], "C": [[1, 0]], "E": [[1, 0], [1, 2e-6]]}"#;
    let model = read(text).unwrap();
    let expected = dmatrix![0.0, 1.0; -2e6, -2e6];
    assert!(
        (&model.a - &expected).amax() < 1e-9 && (model.b[1] - 5e5).abs() < 1e-9 && model.b[0] == 0.0,
        "{}",
        model.a
    );
    assert!(model.descriptor.unwrap() < 10.0);
    assert!(model.study("t").contains("# E^-1 A and E^-1 B of the file; condition number of E, balanced: "));
    let plain = read(br#"{"A": [[0, 1], [-4, -3]], "C": [[1, 0]], "E": [[1, 0], [0, 1]]}"#).unwrap();
    assert_eq!(plain.descriptor, None);
}

#[track_caller]
fn refused(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

#[test]
fn what_is_no_plant_is_refused_in_words() {
    let with = |more: &str| {
        refused(format!("{{\"A\": [[0, 1], [2, 3]], \"B\": [[0], [1]], \"C\": [[1, 0]]{more}}}").as_bytes())
    };
    assert_eq!(with(", \"D\": [[0, 0]]"), "D must be 1 x 1 (C is 1 x n, B is n x 1), found 1 x 2");
    assert!(with(", \"dt\": -1").starts_with("the sampling time dt is -1, and must be positive"));
    let singular = with(", \"E\": [[1, 2], [2, 4]]");
    assert!(singular.contains("E x' = A x + B u becomes one if E is regular"), "{singular}");
    assert_eq!(with(", \"E\": [[1, 2]]"), "E must be 2 x 2, found 1 x 2");
    assert_eq!(with(", \"a\": [[1]]"), "A and a could both be meant: leave one of them in the file");
    assert_eq!(with(", \"D\": \"none\""), "D is text, and must be a matrix of real numbers");
    assert_eq!(refused(b"{\"A\": [[1]], \"Q\": 1}"), "there is no C in the file; it holds A, Q");
    assert_eq!(refused(b"{}"), "there is no A in the file; it holds nothing");
    assert_eq!(refused(br#"{"A": [[1, 2]], "C": [[1]]}"#), "A must be square, of order 1 at least, found 1 x 2");
    assert_eq!(refused(br#"{"A": [], "C": [[1]]}"#), "A must be square, of order 1 at least, found 0 x 0");
    assert_eq!(refused(br#"{"A": [[1]], "C": [[1, 2]]}"#), "C must be p x 1 (A is 1 x 1), found 1 x 2");
    assert_eq!(refused(br#"{"A": [[1]], "B": [[1], [2]], "C": [[1]]}"#), "B must be 1 x m (A is 1 x 1), found 2 x 1");
    assert_eq!(
        refused(br#"{"s": {"A": [[1]]}, "t": {"A": [[1]]}}"#),
        "s and t could both be meant: leave one of them in the file"
    );
    assert_eq!(refused(b"{\"A\": [[1, 2],\n [3]]}"), "line 2, column 5: row 2 has length 1, and row 1 has length 2");
    let null = refused(br#"{"A": [[1, null]]}"#);
    assert!(null.starts_with("line 1, column 15: ") && null.contains("null"), "{null}");
    assert!(
        refused(b"[[1]]").starts_with("line 1, column 1: invalid type: sequence, expected an object with the matrices")
    );
}

#[test]
fn files_of_other_kinds_are_told_apart() {
    assert_eq!(
        refused(b"\x89HDF\r\n\x1a\n and more"),
        "the file is of MATLAB's version 7.3 (HDF5), which is not read: save it with save('model.mat', 'A', 'B', 'C', '-v7')"
    );
    assert_eq!(read(b"MATLAB 7.3 MAT-file, Platform: GLNXA64"), Err(ImportError::Hdf5));
    assert_eq!(read(&npy(&dmatrix![1.0], false, "<f8")), Err(ImportError::OneArray));
    let unknown = refused(b"\x80\x04\x95pickle");
    assert!(unknown.starts_with("the file is of no known kind (9 bytes, the first are [80, 04, 95, 70"), "{unknown}");
    assert_eq!(refused(b""), "the file is empty");
}

#[test]
fn what_matlab_saves_besides_numbers_is_named() {
    let mat = Mat { is_little: true, is_compressed: true };
    let c = mat.full("C", &dmatrix![1.0]);
    let text = mat.array(4, &[1, 1], "A", &[mat.element(16, b"x")]);
    assert_eq!(refused(&mat.file(&[text, c.clone()])), "A is text, and must be a matrix of real numbers");
    let cube = mat.array(6, &[1, 1, 2], "A", &[]);
    assert_eq!(
        refused(&mat.file(&[cube, c.clone()])),
        "A is an array of the shape [1, 1, 2], and must be a matrix of real numbers"
    );
    let parts = [mat.element(1, &[1]), mat.element(1, &[1])];
    let complex = mat.array(6 | 1 << 11, &[1, 1], "A", &parts);
    assert_eq!(refused(&mat.file(&[complex, c.clone()])), "A is complex, and must be a matrix of real numbers");
    let real = mat.array(6 | 1 << 11, &[1, 1], "A", &[mat.element(1, &[1]), mat.element(1, &[0])]);
    assert_eq!(read(&mat.file(&[real, c.clone()])).unwrap().a, dmatrix![1.0]);
    let not_finite = mat.full("A", &dmatrix![f64::NAN]);
    assert_eq!(refused(&mat.file(&[not_finite, c.clone()])), "A(1, 1) is NaN");
    // Today's `ss` is an object: MATLAB says how to take its matrices out.
    let mut object = mat.element(6, &[mat.u32(17), mat.u32(0)].concat());
    for word in ["sys", "MCOS", "ss"] {
        object.extend(mat.element(1, word.as_bytes()));
    }
    let object = mat.element(14, &object);
    let words = refused(&mat.file(&[object]));
    assert_eq!(words, "there is no A in the file; it holds sys (an object of the class ss)");
}

#[test]
fn sizes_are_judged_before_memory_is_taken() {
    let mat = Mat { is_little: true, is_compressed: true };
    for name in ["A", "B"] {
        let huge = mat.array(6, &[70_000, 70_000], name, &[]);
        assert_eq!(
            refused(&mat.file(&[huge])),
            format!("{name} is 70000 x 70000; matrices of at most 16777216 entries are read")
        );
    }
    let sparse = mat.array(5, &[i32::MAX as u32, 0], "A", &[]);
    assert!(refused(&mat.file(&[sparse])).contains("matrices of at most"));
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (18446744073709551615, 2), }";
    assert!(refused(&npz(&[("A", npy_of(header, &[]))], true)).starts_with("A is 18446744073709551615 x 2; "));
}

#[test]
fn damage_is_located() {
    let mat = Mat { is_little: true, is_compressed: false };
    let (a, ..) = plant();
    let whole = mat.file(&[mat.full("A", &a)]);
    assert_eq!(
        refused(&whole[..140]),
        "the file is damaged: an element that is longer than what is left of the file at byte 128"
    );
    assert_eq!(refused(&whole[..131]), "the file is damaged: the end of the file within a tag at byte 128");
    let compressed = Mat { is_compressed: true, ..mat }.file(&[mat.full("A", &a)]);
    let mut broken = compressed.clone();
    let last = broken.len() - 1;
    broken[last] ^= 1;
    assert_eq!(refused(&broken), "the file is damaged: compressed data that cannot be inflated at byte 128");
    let archive = npz(&[("A", npy(&a, false, "<f8"))], true);
    assert!(refused(&archive[..archive.len() / 2]).starts_with("the archive is damaged: "));
    let short = npz(&[("A", npy_of("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }", &[0; 31]))], true);
    assert!(refused(&short).contains("whose numbers are not as many as its shape says"));
    let odd = npz(&[("A", npy_of("{'shape': (2, 2)}", &[]))], true);
    assert!(refused(&odd).contains("whose header is not numpy's"));
}

#[test]
fn a_study_has_every_digit() {
    let (a, b, c) = plant();
    let model = Model {
        a,
        b,
        c,
        d: None,
        descriptor: None,
        dt: None,
        states: None,
        inputs: None,
        outputs: None,
        ignored: vec![],
    };
    let study = model.study("a \"quoted\" \\ title\n");
    let parts = [
        "title = \"a \\\"quoted\\\" \\\\ title\\u000A\"\n\n[plant]\n",
        "a = [\n  [0.0, 1.0, 0.0],\n  [-2.5, 0.0, 1e-300],\n  [0.0, 0.1, -3000000000000.0],\n]\n",
        "b = [\n  [0.0, 1.0],\n  [1.0, 0.0],\n  [0.0, -7.0],\n]\nc = [\n  [1.0, 0.0, 0.0],\n]\n",
        "x0 = [1.0, 1.0, 1.0]\n",
        "duration = 1e-11\n",
    ];
    for part in parts {
        assert!(study.contains(part), "{part}\nin\n{study}");
    }
}

/// A valid file of any kind, small enough that a mutation often meets what matters.
fn valid() -> impl Strategy<Value = Vec<u8>> {
    let (a, b, c) = plant();
    let mut files = Vec::new();
    for mat in kinds() {
        let fields = [("A", mat.sparse("", &a)), ("B", mat.full("", &b)), ("C", mat.full("", &c))];
        files.push(mat.file(&[mat.sparse("A", &a), mat.full("B", &b), mat.full("C", &c)]));
        files.push(mat.file(&[mat.structure("sys", &fields)]));
    }
    for is_compressed in [false, true] {
        let array = |m| npy(m, is_compressed, "<f8");
        files.push(npz(&[("A", array(&a)), ("B", array(&b)), ("C", array(&c))], is_compressed));
    }
    files.push([version_4(&a, "A", false), version_4(&c, "C", true), version_4(&b, "B", false)].concat());
    files.push(OCTAVE.as_bytes().to_vec());
    files.push(br#"{"A": [[0, 1], [-2, -3]], "s": {"B": [[0], [1]]}, "C": [[1, 0]], "dt": null}"#.to_vec());
    prop::sample::select(files)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Bytes changed, cut out, repeated: an answer or an error, and never a panic. What is an answer is a plant:
    /// finite, with shapes that fit.
    #[test]
    fn damaged_files_do_not_panic(
        file in valid(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut file = file;
        for (place, byte, how) in changes {
            let at = place.index(file.len());
            match how {
                0 => file[at] = byte,
                1 => file[at] ^= 1 << (byte % 8),
                2 => { file.remove(at); }
                _ => file.insert(at, byte),
            }
        }
        if let Some(cut) = cut {
            file.truncate(cut.index(file.len()));
        }
        if let Ok(model) = read(&file) {
            let n = model.a.nrows();
            prop_assert!(n > 0 && model.a.ncols() == n && model.b.nrows() == n && model.c.ncols() == n);
            prop_assert!(model.a.iter().chain(model.b.iter()).chain(model.c.iter()).all(|x| x.is_finite()));
        }
    }

    /// Whatever is written is read back, to the last bit.
    #[test]
    fn what_is_written_is_read(
        (n, m, entries) in (1..6_usize, 0..3_usize).prop_flat_map(|(n, m)| (
            Just(n), Just(m), prop::collection::vec(prop_oneof![Just(0.0), -1e9..1e9_f64, -9.0..9.0_f64], n * n + n * m + n),
        )),
        (is_little, is_compressed, is_sparse, is_fortran) in any::<(bool, bool, bool, bool)>(),
    ) {
        let a = DMatrix::from_column_slice(n, n, &entries[..n * n]);
        let b = DMatrix::from_column_slice(n, m, &entries[n * n..n * n + n * m]);
        let c = DMatrix::from_column_slice(1, n, &entries[n * n + n * m..]);
        let expected = Model { a: a.clone(), b: b.clone(), c: c.clone(), d: None, descriptor: None, dt: None, states: None, inputs: None, outputs: None, ignored: vec![] };
        let mat = Mat { is_little, is_compressed };
        let write = |name, m| if is_sparse { mat.sparse(name, m) } else { mat.full(name, m) };
        let file = mat.file(&[write("A", &a), write("B", &b), write("C", &c)]);
        prop_assert_eq!(read(&file), Ok(expected.clone()));
        let array = |m| npy(m, is_fortran, if is_little { "<f8" } else { ">f8" });
        let file = npz(&[("A", array(&a)), ("B", array(&b)), ("C", array(&c))], is_compressed);
        prop_assert_eq!(read(&file), Ok(expected));
    }
}
