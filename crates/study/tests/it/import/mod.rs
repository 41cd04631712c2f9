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
    assert_eq!(
        with(", \"TS\": true"),
        "the sampling time TS is true, and must be positive, or 0 for a model in continuous time"
    );
    assert!(with(", \"dt\": -1").starts_with("the sampling time dt is -1, and must be positive"));
    assert!(with(", \"E\": [[1, 0], [0, 2]]").starts_with("E(2, 2) is 2, and the plant of a study is x' = A x + B u"));
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
    let model = Model { a, b, c, d: None, dt: None, states: None, inputs: None, outputs: None, ignored: vec![] };
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
        let expected = Model { a: a.clone(), b: b.clone(), c: c.clone(), d: None, dt: None, states: None, inputs: None, outputs: None, ignored: vec![] };
        let mat = Mat { is_little, is_compressed };
        let write = |name, m| if is_sparse { mat.sparse(name, m) } else { mat.full(name, m) };
        let file = mat.file(&[write("A", &a), write("B", &b), write("C", &c)]);
        prop_assert_eq!(read(&file), Ok(expected.clone()));
        let array = |m| npy(m, is_fortran, if is_little { "<f8" } else { ">f8" });
        let file = npz(&[("A", array(&a)), ("B", array(&b)), ("C", array(&c))], is_compressed);
        prop_assert_eq!(read(&file), Ok(expected));
    }
}
