//! SDPA's files as people and programs write them, and as they arrive when something went wrong.

use std::fmt::Write as _;

use luenberger_lmi::sdpa::{ReadError, Settings, read, solve};
use luenberger_proof::Interval;
use luenberger_proof::semidefinite::{Block, Entry, Program};
use proptest::prelude::*;

/// The first example of SDPA's manual (K. Fujisawa and others, SDPA User's Manual), with its comments and separators;
/// its optimum is -41.9.
#[test]
fn the_manuals_own_example() {
    let text = "\"Example 1: mDim = 3, nBLOCK = 1, {2}\"\n   3  =  mDIM\n   1  =  nBLOCK\n   2  = bLOCKsTRUCT\n{48, -8, 20}\n\
        0 1 1 1 -11\n0 1 2 2 23\n1 1 1 1 10\n1 1 1 2 4\n2 1 2 2 -8\n3 1 1 2 -8\n3 1 2 2 -2\n";
    let program = read(text.as_bytes()).expect("the manual's file");
    assert_eq!((program.unknowns(), program.blocks()), (3, &[Block::Dense(2)][..]));
    let found = solve(&program, &Settings::default());
    assert!(found.lower <= -41.9 && -41.9 <= found.upper && found.upper - found.lower < 1e-6, "{found:?}");
}

#[test]
fn announced_sizes_take_no_memory() {
    let range = |text: &str| matches!(read(text.as_bytes()), Err(ReadError::Range { .. } | ReadError::Number { .. }));
    for count in ["1000000000000000000", "99999999999999999999999", "-1", "0", "16777217", "1e18", "nan", "+", "1.5"] {
        assert!(range(&format!("{count}\n1\n2\n")), "{count} unknowns");
        assert!(range(&format!("1\n{count}\n2\n")), "{count} blocks");
        assert!(range(&format!("1\n1\n2\n1\n{count} 1 1 1 1\n")) || count == "0", "matrix {count}");
        assert!(range(&format!("1\n1\n2\n1\n1 {count} 1 1 1\n")), "block {count}");
        assert!(range(&format!("1\n1\n2\n1\n1 1 {count} 1 1\n")), "row {count}");
        assert!(range(&format!("1\n1\n2\n1\n1 1 1 {count} 1\n")), "column {count}");
    }
    // These are within what is taken for meant; the text ends long before they are reached.
    assert!(matches!(read(&b"16777216\n16777216\n1\n"[..]), Err(ReadError::Truncated { line: 3, .. })));
    // A block of this order would take a petabyte; it is not begun.
    let program = read(&b"1\n1\n16777216\n1\n1 1 1 1 1\n"[..]).expect("well-formed");
    let found = solve(&program, &Settings::default());
    assert_eq!(found.runs, 0);
    assert!(found.why.is_some(), "{found:?}");
}

#[test]
fn numbers_that_are_none_or_too_large_are_errors_with_their_line() {
    for value in ["1e999", "-1D+400", "NaN", "inf", "-infinity", "0x10", "1e", "--1", "1,5e999", "½", "1e5e5"] {
        let error = read(format!("1\n1\n2\n1\n1 1 1 1 {value}\n").as_bytes()).expect_err(value);
        assert!(error.to_string().starts_with("line 5: "), "{value}: {error}");
        let error = read(format!("1\n1\n2\n{value}\n1 1 1 1 1\n").as_bytes()).expect_err(value);
        assert!(error.to_string().starts_with("line "), "{value}: {error}");
    }
    // Too small is not too large: an interval around 0.
    let program = read(&b"1\n1\n1\n1\n1 1 1 1 1e-999\n"[..]).expect("a tiny number");
    assert!(program.matrix(1)[0].value.contains(0.0) && program.matrix(1)[0].value.hi() > 0.0);
}

#[test]
fn decimals_are_points_where_binary64_has_them_and_intervals_elsewhere() {
    let cost = |token: &str| read(format!("1\n1\n1\n{token}\n").as_bytes()).map(|program| program.costs()[0]);
    for (token, exact) in [
        ("1", true),
        ("-0.5", true),
        ("+2.50", true),
        ("1e22", true),
        ("1.0D+01", true),
        ("0.1", false),
        ("-0.0", true),
        ("1e23", false),
        (".75", true),
        ("3.", true),
    ] {
        assert_eq!(cost(token).unwrap().is_point(), exact, "{token}");
    }
    assert!(["1e400", "nan", "inf", "x"].iter().all(|token| cost(token).is_err()));
}

#[test]
fn every_mistake_names_its_line() {
    let cases = [
        ("", "line 1: the text ends where the number of unknowns is expected"),
        ("x\n", "line 1: \"x\" stands where the number of unknowns is expected"),
        ("\"c\n0\n", "line 2: the number of unknowns is 0; it must be between 1 and 16777216"),
        ("1\n1\n2\n", "line 3: the text ends where a cost is expected"),
        ("1\n1\n0\n", "line 3: the order of a block is 0; it must be between 1 and 16777216"),
        ("1\n1\n2\n1e999\n", "line 4: \"1e999\" stands where a cost is expected"),
        ("1\n1\n2\n1\n2 1 1 1 1\n", "line 5: the number of a matrix is 2; it must be between 0 and 1"),
        ("1\n1\n-2\n1\n1 1 1 2 1\n", "line 5: the column in a diagonal block is 2; it must be between 1 and 1"),
        ("1\n1\n2\n1\n1 1 1\n", "line 5: the text ends where the column is expected"),
    ];
    for (text, message) in cases {
        assert_eq!(read(text.as_bytes()).unwrap_err().to_string(), message);
    }
    let error = read(&b"1\n1\n2\n1\n1 1 1 \xff 1\n"[..]).unwrap_err();
    assert_eq!(error, ReadError::NotText { line: 5, byte: 7 });
}

#[test]
fn punctuation_comments_and_repeated_entries() {
    let text = "* a comment\n\"another\n 1 = m\n 2 = blocks\n(2, -1)\n{1.0}\n1 1 2 1 1.5\n1 1 1 2 0.5\n0 2 1 1 0\n";
    let program = read(text.as_bytes()).unwrap();
    assert_eq!(program.blocks(), [Block::Dense(2), Block::Diagonal(1)]);
    assert_eq!(program.matrix(1).len(), 1);
    assert_eq!(program.matrix(1)[0].value, Interval::of(2.0));
    assert!(program.matrix(0).is_empty());
}

/// A program of small decimals, and how it is written.
#[derive(Debug, Clone)]
struct Written {
    blocks: Vec<i64>,
    /// In tenths.
    costs: Vec<i32>,
    /// Matrix, block, row, column (some outside the block: brought inside), value in tenths.
    entries: Vec<(usize, usize, usize, usize, i32)>,
    /// Choices of the writer, used in turn.
    style: Vec<u8>,
}

fn written() -> impl Strategy<Value = Written> {
    let block = prop_oneof![1_i64..=4, -4_i64..=-1];
    (prop::collection::vec(block, 1..=3), prop::collection::vec(-99_i32..=99, 1..=4)).prop_flat_map(
        |(blocks, costs)| {
            let (count, unknowns) = (blocks.len(), costs.len());
            let entry = (0..=unknowns, 1..=count, 1_usize..=4, 1_usize..=4, -99_i32..=99);
            (prop::collection::vec(entry, 0..24), prop::collection::vec(any::<u8>(), 64)).prop_map(
                move |(entries, style)| Written { blocks: blocks.clone(), costs: costs.clone(), entries, style },
            )
        },
    )
}

impl Written {
    fn placed(&self) -> impl Iterator<Item = (usize, usize, usize, usize, i32)> {
        self.entries.iter().map(|&(k, block, i, j, value)| {
            let order = self.blocks[block - 1].unsigned_abs() as usize;
            let (i, j) = ((i - 1) % order + 1, (j - 1) % order + 1);
            (k, block, i, if self.blocks[block - 1] < 0 { i } else { j }, value)
        })
    }

    fn text(&self) -> String {
        let mut style = self.style.iter().cycle().copied();
        let mut choose = move |n: u8| style.next().unwrap_or_default() % n;
        let mut text = String::new();
        for _ in 0..choose(3) {
            text.push_str(["\"1 2 3\n", "* a comment\n", "\n", "  \" indented\r\n"][usize::from(choose(4))]);
        }
        let words = ["\n", " = m\n", "\r\n", "   anything 3 4 5\n"];
        let _ = write!(text, "{}{}", self.costs.len(), words[usize::from(choose(4))]);
        let _ = write!(text, "{}{}", self.blocks.len(), words[usize::from(choose(4))]);
        let separators = [" ", ", ", "\t", "  ", ",", "\n", "{ ", " } ", "(", " ) "];
        let number = |tenths: i32, choice: u8| {
            let sign = if tenths < 0 { "-" } else { ["", "+"][usize::from(choice / 8 % 2)] };
            let (whole, tenth) = (tenths.unsigned_abs() / 10, tenths.unsigned_abs() % 10);
            let size = tenths.unsigned_abs();
            match choice % 5 {
                0 => format!("{sign}{whole}.{tenth}"),
                1 => format!("{sign}{size}E-1"),
                2 => format!("{sign}{size}.0D-01"),
                3 => format!("{sign}0.{whole:02}{tenth}00d+2"),
                _ => format!("{sign}{whole}.{tenth}00000000000000000000000"),
            }
        };
        text.push_str(["", "(", "{"][usize::from(choose(3))]);
        for (k, order) in self.blocks.iter().enumerate() {
            let before = if k == 0 { "" } else { separators[usize::from(choose(10))] };
            let plus = if *order > 0 && choose(4) == 0 { "+" } else { "" };
            let _ = write!(text, "{before}{plus}{order}");
        }
        text.push_str(["\n", ")\n", "} = orders\n"][usize::from(choose(3))]);
        for (k, cost) in self.costs.iter().enumerate() {
            let before = if k == 0 { "" } else { separators[usize::from(choose(10))] };
            let _ = write!(text, "{before}{}", number(*cost, choose(255)));
        }
        text.push_str(["\n", "}\n", " words\n"][usize::from(choose(3))]);
        for (k, block, i, j, value) in self.placed() {
            let value = number(value, choose(255));
            for field in [k.to_string(), block.to_string(), i.to_string(), j.to_string(), value] {
                let _ = write!(text, "{field}{}", separators[usize::from(choose(10))]);
            }
            text.push('\n');
        }
        text
    }

    /// The program as it is meant. Tenths that binary64 does not have are no single number, so that positions with
    /// several entries are compared by what they contain.
    fn contains(&self, program: &Program) -> bool {
        let blocks: Vec<Block> = self
            .blocks
            .iter()
            .map(|&n| if n > 0 { Block::Dense(n as usize) } else { Block::Diagonal(n.unsigned_abs() as usize) })
            .collect();
        let holds = |interval: &Interval, tenths: i32| {
            // 10 lo <= tenths <= 10 hi, with a unit of the product's rounding to spare on either side.
            let (lo, hi, value) = (10.0 * interval.lo(), 10.0 * interval.hi(), f64::from(tenths));
            lo.next_down() <= value && value <= hi.next_up() && hi - lo <= 1e-12 * (1.0 + value.abs()) * 24.0
        };
        let mut sums = std::collections::BTreeMap::new();
        for (k, block, i, j, value) in self.placed() {
            *sums.entry((k, block - 1, i.min(j) - 1, i.max(j) - 1)).or_insert(0) += value;
        }
        let entry = |k: usize, e: &Entry| {
            sums.get(&(k, e.block, e.row, e.column)).is_some_and(|tenths| holds(&e.value, *tenths))
        };
        let missing = |&(k, block, row, column): &(usize, usize, usize, usize)| {
            !program.matrix(k).iter().any(|e| (e.block, e.row, e.column) == (block, row, column))
        };
        program.blocks() == blocks
            && program.unknowns() == self.costs.len()
            && program.costs().iter().zip(&self.costs).all(|(c, tenths)| holds(c, *tenths))
            && (0..=self.costs.len()).all(|k| program.matrix(k).iter().all(|e| entry(k, e)))
            && sums.iter().all(|(at, tenths)| *tenths == 0 || !missing(at))
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// However it is written, it is the same program.
    #[test]
    fn separators_signs_exponents_and_mirror_images_change_nothing(case in written()) {
        let text = case.text();
        match read(text.as_bytes()) {
            Ok(program) => prop_assert!(case.contains(&program), "{text}\n{program:?}"),
            Err(error) => prop_assert!(false, "{error}\n{text}"),
        }
    }

    /// Cut, overwritten or torn, it is a program or an error that names a line of the text, and what is read can be
    /// solved or not, but ends.
    #[test]
    fn damage_is_an_error_or_another_program(
        case in written(), cut in 0_usize..600, at in 0_usize..600, bytes in prop::collection::vec(any::<u8>(), 0..6), digits in "[0-9eE.+ -]{0,6}",
    ) {
        let text = case.text().into_bytes();
        for patch in [&bytes[..], digits.as_bytes()] {
            let mut damaged = text.clone();
            damaged.truncate(cut);
            let at = at.min(damaged.len());
            let end = (at + patch.len() / 2).min(damaged.len());
            damaged.splice(at..end, patch.iter().copied());
            let lines = damaged.split(|b| *b == b'\n').count();
            match read(&damaged[..]) {
                Ok(program) => {
                    let found = solve(&program, &Settings { iterations: 40, memory: 1 << 22, ..Settings::default() });
                    prop_assert!(found.lower <= found.upper || found.lower == f64::INFINITY);
                }
                Err(ReadError::NotText { line, .. } | ReadError::Truncated { line, .. } | ReadError::Number { line, .. }
                    | ReadError::Range { line, .. }) => prop_assert!(line <= lines),
                Err(ReadError::Program(_)) => {}
                Err(other) => prop_assert!(false, "{other}"),
            }
        }
    }
}
