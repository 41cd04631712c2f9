use toy::*;

#[test]
fn triangles() {
    assert_eq!(triangle(4), 10);
}

#[test]
fn the_larger_one() {
    assert_eq!((larger(3, 1), larger(1, 3)), (3, 3));
}

#[test]
fn words() {
    assert_eq!(joined("a".to_owned(), "b"), "ab");
    assert_eq!((word(0), word(1), word(5), word(10), word(11)), ("none", "one", "some", "many", "some"));
}

#[test]
fn sizes() {
    assert_eq!(row(3), Size { rows: 1, columns: 3 });
    assert_eq!(bits(2), 16);
    assert_eq!(evens(3).collect::<Vec<_>>(), [0, 2, 4]);
}

#[test]
#[ignore = "ignored tests are not run"]
fn ignored() {
    assert_eq!(unreached(1), -1);
}
