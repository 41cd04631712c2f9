//! CSV tables: valid input, errors with positions, and suspicious data of a log.

use luenberger_sim::{SampleInterpolation, SimError};
use luenberger_study::table::{Suspicion, Table, TableError};
use proptest::prelude::*;

/// The mistake of a table in which every column is used.
fn error(text: &str) -> String {
    match Table::parse(text) {
        Err(error) => error.to_string(),
        Ok(table) => table.names().iter().find_map(|name| table.column(name).err()).unwrap().to_string(),
    }
}

#[test]
fn tables_of_several_dialects_are_read() {
    let expected = Table::parse("t,u1,y1\n0,1,2\n0.5,-1e-3,.25\n").unwrap();
    for text in [
        "t;u1;y1\n0;1;2\n0.5;-1e-3;.25\n",
        "t\tu1\ty1\r\n0\t1\t2\r\n0.5\t-1e-3\t.25",
        "\u{feff}# bench 3\n t , u1 ,y1\n\n0, 1, 2\n# a remark\n0.5,-0.001,0.25\n\n",
        "\"t\",\"u1\",\"y1\"\n0,1,2\n0.5,-1E-3,+0.25\n",
    ] {
        let table = Table::parse(text).unwrap();
        assert_eq!((table.names(), table.rows()), (expected.names(), 2), "{text:?}");
        for name in ["t", "u1", "y1"] {
            assert_eq!(table.column(name).unwrap(), expected.column(name).unwrap(), "{text:?}");
        }
    }
    let log = expected.recording("t", &["u1"], &["y1", "u1"]).unwrap();
    assert_eq!(log.outputs().values().ncols(), 2);
    let held = expected.samples("t", &["u1"], SampleInterpolation::ZeroOrderHold).unwrap();
    let mut value = [0.0];
    held.at(0.49, &mut value);
    assert_eq!(value, [1.0]);
    // A table without inputs is valid.
    assert_eq!(expected.recording::<&str>("t", &[], &["y1"]).unwrap().inputs().values().ncols(), 0);
}

#[test]
fn what_is_wrong_has_its_line_and_column() {
    assert_eq!(error(""), "the table is empty: expected a line that names the columns");
    assert_eq!(error("# only a remark\n\n"), "the table is empty: expected a line that names the columns");
    assert!(error("0,1\n1,2\n").starts_with("line 1, column 1: expected the name of a column, found `0`"));
    assert!(error("t,,u\n1,2,3\n").starts_with("line 1, column 2: expected the name of a column, found ``"));
    assert_eq!(error("t,u,t\n"), "columns 1 and 3 are both named `t`");
    assert_eq!(error("t,u\n0,1\n1\n"), "line 3 has 1 cell where the table has 2 columns");
    assert_eq!(
        error("t,u\n0,1\n\n# x\n1,2,3\n"),
        "line 5 has 3 cells where the table has 2 columns; a decimal comma needs semicolons or tabs between the cells"
    );
    assert!(error("t,u\n0,1\n1,1,5\n").starts_with("line 3 has 3 cells where the table has 2 columns; a decimal"));
    assert_eq!(error("t,u\n0,1e400\n"), "line 2, column 2 (u): inf is not a finite number");

    let table = Table::parse("t,u1,y1\n0,0,1\n").unwrap();
    let few = table.recording("t", &["u1"], &["y1"]).unwrap_err();
    assert_eq!(few.to_string(), "the table has 1 row; at least 2 are needed");
    let missing = table.column("time").unwrap_err();
    assert_eq!(missing.to_string(), "there is no column `time`; the columns are t, u1, y1");
    let table = Table::parse("t,y\n0,1\n0.2,1\n\n0.1,1\n").unwrap();
    let unsorted = table.recording::<&str>("t", &[], &["y"]).unwrap_err();
    assert_eq!(
        unsorted.to_string(),
        "line 5: the time 0.1 comes before 0.2, the time of the row above; where the logger started again begins another log"
    );
    let none = Table::read(std::path::Path::new("no/such/file.csv")).unwrap_err();
    assert!(matches!(none, TableError::File { .. }) && none.to_string().contains("no/such/file.csv"));
    // No second check: the samples have been checked.
    assert!(!matches!(unsorted, TableError::Samples(SimError::TimesUnsorted { .. })));
}

/// What loggers and spreadsheets write.
#[test]
fn dialects_of_loggers_are_read() {
    let same = Table::parse("t,u,y\n0,1,2\n0.5,-1e-3,.25\n").unwrap();
    for text in [
        // A decimal comma, with semicolons and with tabs.
        "t;u;y\n0;1;2\n0,5;-1e-3;,25\n",
        "t\tu\ty\n0\t1\t2\n0,5\t-1e-3\t,25\n",
        // Units in the header, with a comma in one of them.
        "t [s];u (V, rms);y\n0;1;2\n0.5;-1e-3;.25\n",
        "\u{feff}\"t [s]\",\"u [V]\",y [m/s]\r\n0,1,2\r\n\"0.5\",\"-0.001\",\"0.25\"\r\n",
        // A separator at the end of each line, of all and of the header alone.
        "t,u,y,\n0,1,2,\n0.5,-1e-3,.25,\n",
        "t,u,y,\n0,1,2\n0.5,-1e-3,.25\n",
        // Text in a column that nobody asks for.
        "date,t,u,y,remark\n2024-05-01 12:00:00,0,1,2,start\n2024-05-01 12:00:01,0.5,-1e-3,.25,\"1,5 V?\"\n",
    ] {
        let table = Table::parse(text).unwrap_or_else(|error| panic!("{text:?}: {error}"));
        for name in ["t", "u", "y"] {
            assert_eq!(table.column(name).unwrap(), same.column(name).unwrap(), "{text:?}");
        }
    }
    // A name with its unit is one, too; two columns that differ in the unit have no common name.
    let units = Table::parse("t,u [V],u [mV]\n0,1,2\n").unwrap();
    assert_eq!(units.column("u [mV]").unwrap(), [2.0]);
    assert!(matches!(units.column("u"), Err(TableError::MissingColumn { .. })));
}

#[test]
fn what_is_not_a_number_has_advice() {
    let time = "dates and times of day are for the column of times, all in one form, such as 2024-05-01T12:00:00.5 or 12:00:00.5";
    for cell in ["2024-05-01T12:00:00Z", "2024-05-01", "12:00:01.5", "01.05.2024 12:00", "5/1/2024"] {
        assert_eq!(
            error(&format!("t,u\n{cell},1\n")),
            format!("line 2, column 1 (t): expected a number, found `{cell}`; {time}")
        );
    }
    assert_eq!(
        error("t;u\n0;1.5\n1;1,5\n"),
        "line 3, column 2 (u): expected a number, found `1,5`; other cells have a decimal point, so that a comma is ambiguous"
    );
    assert!(error("t;u\n0;1,5\n1;1.5\n").ends_with("so that a point is ambiguous"));
    assert!(error("t,u\n0,\"1,500\"\n").ends_with("there is no sign for thousands"));
    assert!(error("t;u\n0;1.500,0\n").ends_with("there is no sign for thousands"));
    assert_eq!(error("t,u\n0,1.5V\n"), "line 2, column 2 (u): expected a number, found `1.5V`");
    assert_eq!(
        Table::from_bytes(b"t,T [\xb0C]\n0,1\n").unwrap_err().to_string(),
        "line 1: the byte 0xb0 is not UTF-8; save the file as UTF-8 (a spreadsheet: \"CSV UTF-8\")"
    );
    assert!(matches!(Table::from_bytes(b"\xff\xfet\0,\0"), Err(TableError::Encoding { line: 1, byte: 0xff })));
    let input = Table::parse("t,u\n0,1\n1,1\n1,2\n").unwrap();
    let twice = input.samples("t", &["u"], SampleInterpolation::ZeroOrderHold).unwrap_err();
    assert_eq!(twice.to_string(), "line 4: the time 1 is that of the row before; each row needs a time of its own");
}

/// A blank cell, NaN, NA and null are missing values; where every value is needed they are an error.
#[test]
fn a_missing_value_is_no_number() {
    let table = Table::parse("t,u,y\n0,1,\n1,,2\n2,NaN,na\n3,N/A,null\n4,2, \n").unwrap();
    assert_eq!(table.values("u").unwrap(), [Some(1.0), None, None, None, Some(2.0)]);
    assert_eq!(table.values("y").unwrap(), [None, Some(2.0), None, None, None]);
    assert_eq!(table.column("u").unwrap_err().to_string(), "line 3, column 2 (u): the value is missing");
    let missing = |result: Result<luenberger_sim::Samples, TableError>| result.unwrap_err().to_string();
    assert_eq!(
        missing(table.samples("t", &["y"], SampleInterpolation::ZeroOrderHold)),
        "line 2, column 3 (y): the value is missing"
    );
    let log = table.recording("t", &["u"], &["y"]).unwrap();
    assert_eq!((log.outputs().value(0, 0), log.outputs().count(0), log.inputs().values()[(3, 0)]), (None, 1, 1.0));
    let held: Vec<String> = table.suspicions("t", &["u"], &[]).unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(held, ["3 values of the input `u` missing: the value before is held"]);
    let first = table.recording("t", &["y"], &["u"]).unwrap_err();
    assert_eq!(first.to_string(), "line 2, column 3 (y): the value is missing");
    let time = Table::parse("t,y\n0,1\n,2\n2,3\n").unwrap().recording("t", &[], &["y"]).unwrap_err();
    assert_eq!(time.to_string(), "line 3, column 1 (t): the value is missing");
    let empty = Table::parse("t,y\n0,\n1,\n").unwrap().suspicions("t", &[], &["y"]).unwrap();
    assert_eq!(empty, [Suspicion::Empty { column: "y".to_owned() }]);
}

/// A log of 400 samples of a sine, with faults built in.
fn log(fault: impl Fn(usize, f64) -> f64, time: impl Fn(usize) -> f64) -> Table {
    let rows: Vec<String> = (0..400).map(|k| format!("{},{}", time(k), fault(k, (0.031 * k as f64).sin()))).collect();
    Table::parse(&format!("t,y\n{}\n", rows.join("\n"))).unwrap()
}

fn suspicions(table: &Table) -> Vec<Suspicion> {
    table.suspicions("t", &[], &["y"]).unwrap()
}

/// Two sensors that write into one column in turn are seen; an oscillation of two rows that grows is none.
#[test]
fn two_sensors_in_one_column_are_seen() {
    let even = |k: usize| 0.01 * k as f64;
    let both = suspicions(&log(|k, y| if k.is_multiple_of(2) { y } else { 25.0 + 0.1 * y }, even));
    let [Suspicion::Alternating { step, over_two, .. }] = &both[..] else { panic!("{both:?}") };
    assert!((*step - 25.0).abs() < 1.0 && *over_two < 0.07, "{both:?}");
    let words = both[0].to_string();
    assert!(
        words.starts_with("`y` jumps to and fro by 25") && words.ends_with("two sensors in one column?"),
        "{words}"
    );
    // Ten times as far over one row as over two, however small: 3 against 0.2, and 1.9 against 0.2.
    let saw = |jump: f64| log(|k, _| 0.1 * k as f64 + if k.is_multiple_of(2) { 0.0 } else { jump }, even);
    assert_eq!((suspicions(&saw(3.0)).len(), suspicions(&saw(1.9)).len()), (1, 0));
    // Of twenty values it can be said, of nineteen it cannot.
    let first = |count: usize| {
        let rows: Vec<String> = (0..count).map(|k| format!("{k},{}", if k % 2 == 0 { k } else { 50 + k })).collect();
        suspicions(&Table::parse(&format!("t,y\n{}\n", rows.join("\n"))).unwrap()).len()
    };
    assert_eq!((first(19), first(20)), (0, 1));
    // Noise jumps over two rows as far as over one.
    let mut random = luenberger_random::Random(4);
    let noise: Vec<f64> = (0..400).map(|_| random.normal_pair()[0]).collect();
    assert_eq!(suspicions(&log(|k, _| noise[k], even)), []);
    let short: Vec<String> = (0..18).map(|k| format!("{k},{}", k % 2)).collect();
    assert_eq!(suspicions(&Table::parse(&format!("t,y\n{}\n", short.join("\n"))).unwrap()), []);
}

#[test]
fn gaps_saturation_and_dropouts_are_seen() {
    let even = |k: usize| 0.01 * k as f64;
    assert_eq!(suspicions(&log(|_, y| y, even)), []);
    let gap = suspicions(&log(|_, y| y, |k| if k < 200 { even(k) } else { even(k) + 0.3 }));
    assert!(matches!(gap[..], [Suspicion::Gap { from, to, .. }] if from == 1.99 && to == 2.3), "{gap:?}");
    assert_eq!(gap[0].in_words(Some("s")), "Gap 1.99-2.3 s (median Ts 0.01 s)");
    let saturated = suspicions(&log(|_, y| y.clamp(-2.0, 0.9), even));
    assert!(
        matches!(&saturated[..], [Suspicion::Saturated { value, samples, .. }] if *value == 0.9 && *samples > 20),
        "{saturated:?}"
    );
    let frozen = suspicions(&log(|k, y| if (100..130).contains(&k) { 0.125 } else { y }, even));
    let [Suspicion::Frozen { value, samples, during, .. }] = &frozen[..] else { panic!("{frozen:?}") };
    assert_eq!((*value, *samples, *during), (0.125, 30, (1.0, 1.29)));
    assert!(frozen[0].to_string().contains("dropout"));
    assert!(matches!(suspicions(&log(|_, _| 4.0, even))[..], [Suspicion::Constant { value, .. }] if value == 4.0));
    // A coarsely quantized sensor and a switch repeat their values without a fault.
    assert_eq!(suspicions(&log(|_, y| (8.0 * y).round() / 8.0, even)), []);
    assert_eq!(suspicions(&log(|_, y| y.signum(), even)), []);
}

/// A sentence has the ordinal of a number as English has it.
#[test]
fn the_rows_of_a_repetition_are_counted_in_words() {
    for (each, ordinal) in [
        (2, "2nd"),
        (3, "3rd"),
        (4, "4th"),
        (10, "10th"),
        (11, "11th"),
        (12, "12th"),
        (13, "13th"),
        (14, "14th"),
        (21, "21st"),
        (22, "22nd"),
        (23, "23rd"),
        (24, "24th"),
        (101, "101st"),
        (111, "111th"),
        (112, "112th"),
        (113, "113th"),
    ] {
        let words = Suspicion::Repeated { column: "y".to_owned(), each, measurements: 5 }.to_string();
        assert!(words.starts_with(&format!("`y` changes in about every {ordinal} row: taken for 5 ")), "{words}");
    }
}

/// More than three gaps, or values that stay, of one column are one sentence with their number; those of two columns
/// are not counted together.
#[test]
fn many_of_one_kind_are_one_sentence() {
    let gaps = |count: usize| {
        suspicions(&log(|_, y| y, |k| 0.01 * k as f64 + 0.3 * ((k / 50).min(count) as f64)))
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
    };
    assert_eq!(gaps(3).len(), 3);
    assert_eq!(gaps(4), ["Gap 0.49-0.8 (median Ts 0.01); the first of 4"]);
    // Two columns that stay at three values each, within their range.
    let stays = |k: usize| {
        [(60, 0.125), (170, 0.25), (290, 0.375)].iter().find(|(from, _)| (*from..from + 12).contains(&k)).map(|of| of.1)
    };
    let row = |k: usize| {
        let (x, y) = ((0.031 * k as f64).sin(), (0.037 * k as f64).cos());
        format!("{k},{},{}", stays(k).unwrap_or(x), stays(k).unwrap_or(y))
    };
    let rows: Vec<String> = (0..400).map(row).collect();
    let found =
        Table::parse(&format!("t,x,y\n{}\n", rows.join("\n"))).unwrap().suspicions("t", &[], &["x", "y"]).unwrap();
    let of = |name: &str| {
        let frozen = |one: &&Suspicion| matches!(one, Suspicion::Frozen { column, samples: 12, .. } if column == name);
        found.iter().filter(frozen).count()
    };
    assert_eq!((found.len(), of("x"), of("y")), (6, 3, 3), "{found:?}");
}

/// Four samples at the limit are a saturation and ten in a row within the range a dropout; one sample less is neither.
#[test]
fn a_few_equal_samples_are_no_fault() {
    let even = |k: usize| 0.01 * k as f64;
    let limit = |count: usize| suspicions(&log(|k, y| if (48..48 + count).contains(&k) { 1.5 } else { y }, even));
    assert_eq!((limit(2), limit(3)), (vec![], vec![]));
    let [Suspicion::Saturated { value: 1.5, samples: 4, longest: (0.48, 0.51), .. }] = limit(4)[..] else {
        panic!("{:?}", limit(4))
    };
    let within = |count: usize| suspicions(&log(|k, y| if (100..100 + count).contains(&k) { 0.125 } else { y }, even));
    assert_eq!(within(9), []);
    assert!(matches!(within(10)[..], [Suspicion::Frozen { samples: 10, .. }]), "{:?}", within(10));
}

proptest! {
    /// Any text gives a table or an error.
    #[test]
    fn no_text_panics(text in "[t,u;0-9.e+\\-#\"\n \t\u{feff}]{0,80}") {
        if let Ok(table) = Table::parse(&text) {
            prop_assert!(table.names().iter().all(|name| table.values(name).map_or(true, |x| x.len() == table.rows())));
            let time = &table.names()[0];
            let _ = table.suspicions(time, &[], table.names());
        }
    }

    /// Numbers are unchanged after printing and reading.
    #[test]
    fn numbers_are_read_to_the_last_bit(values in prop::collection::vec(prop::num::f64::NORMAL, 2..20)) {
        let rows: Vec<String> = values.iter().enumerate().map(|(k, y)| format!("{k},{y:e}")).collect();
        let table = Table::parse(&format!("t,y\n{}", rows.join("\n"))).unwrap();
        prop_assert_eq!(table.column("y").unwrap(), &values[..]);
    }
}
