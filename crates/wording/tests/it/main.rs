//! Numbers, counts and names in sentences, against what C's `printf` prints and against Unicode's lists.

use luenberger_wording::{
    capital, complex, counted, entry, escape, is_invisible, quoted, rounded, shortest, significant, visible,
};

/// `%.17g` of C reads back as the number; no shorter decimal of these does.
#[test]
fn the_shortest_decimal_reads_back() {
    let expected = [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1"),
        (-0.1, "-0.1"),
        (1e-4, "0.0001"),
        (9.9e-5, "9.9e-5"),
        (-9.9e-5, "-9.9e-5"),
        (9_999_999.5, "9999999.5"),
        (1e7, "1e7"),
        (-1e7, "-1e7"),
        (f64::INFINITY, "inf"),
        (f64::NEG_INFINITY, "-inf"),
        (f64::NAN, "NaN"),
        (0.1 + 0.2, "0.30000000000000004"),
    ];
    for (x, text) in expected {
        assert_eq!(shortest(x), text);
    }
}

/// `printf("%.3g")` and so on; half to even, as the decimal of the double is.
#[test]
fn digits_are_rounded_as_printf_does() {
    let expected = [
        (22.0 / 7.0, 1, "3", 3.0),
        (22.0 / 7.0, 5, "3.1429", 3.1429),
        (-2.0 / 3.0, 3, "-0.667", -0.667),
        (2.5, 1, "2", 2.0),
        (99_950.0, 3, "100000", 1e5),
        (0.000_099_96, 3, "0.0001", 1e-4),
        (0.0, 3, "0", 0.0),
        (7.0, 0, "7", 7.0),
    ];
    for (x, digits, text, value) in expected {
        assert_eq!((significant(x, digits).as_str(), rounded(x, digits)), (text, value));
    }
}

/// The sign stands between the parts; a part that is 0 is left out.
#[test]
fn the_sign_of_an_imaginary_part_is_said() {
    let expected = [
        ([-1.0, 2.0], "-1 + 2i"),
        ([-1.0, -2.0], "-1 - 2i"),
        ([3.0, -0.25], "3 - 0.25i"),
        ([0.0, -2.0], "-2i"),
        ([0.0, 2.0], "2i"),
        ([-3.0, 0.0], "-3"),
        ([-3.0, -0.0], "-3"),
        ([0.0, 0.0], "0"),
        ([1.0 / 3.0, 2.0 / 3.0], "0.333 + 0.667i"),
    ];
    for (number, text) in expected {
        assert_eq!(complex(number, 3), text);
    }
}

#[test]
fn entries_count_from_one_and_nouns_have_their_plural() {
    assert_eq!([entry(0, 0), entry(2, 10)], ["(1, 1)", "(3, 11)"]);
    assert_eq!([counted(0, "row"), counted(1, "row"), counted(2, "row")], ["0 rows", "1 row", "2 rows"]);
    assert_eq!([capital("the end"), capital("\u{e4}hm"), capital("")], ["The end", "\u{c4}hm", ""]);
}

/// RFC 8259 escapes a quote and a backslash by a backslash; XML 1.0 has four entities for these characters.
#[test]
fn names_cannot_end_a_quotation_or_an_element() {
    assert_eq!(quoted("a \"b\" \\ c\n"), "\"a \\\"b\\\" \\\\ c\\u{a}\"");
    assert_eq!(visible("a\tb"), "a\\u{9}b");
    assert_eq!(escape("<a b=\"c\">&amp;"), "&lt;a b=&quot;c&quot;&gt;&amp;amp;");
}

/// Unicode 16: the neighbours of every range of `docs/certificates.md` are visible, its ends are not.
#[test]
fn invisible_are_the_ranges_of_the_list_with_their_ends() {
    let inside = [0x00, 0x1f, 0x7f, 0xa0, 0xad, 0x200f, 0x2000, 0x2028, 0x202f, 0xfeff, 0xe0000, 0xe0fff];
    let outside = [0x20, 0x7e, 0xa1, 0xac, 0xae, 0x1fff, 0x2010, 0x2027, 0x2030, 0xfefe, 0xfe10, 0xe1000];
    assert!(inside.into_iter().filter_map(char::from_u32).all(is_invisible));
    assert!(!outside.into_iter().filter_map(char::from_u32).any(is_invisible));
}
