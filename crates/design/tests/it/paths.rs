//! The ways through the comparisons of a right-hand side, one by one.

use luenberger_design::enclosure::Undefined;
use luenberger_design::internals::{comparison, explore, explore_ways, follow, note_undefined};

fn open_comparison() -> bool {
    comparison(None)
}

#[test]
fn a_way_is_followed_whatever_the_operands_say() {
    let ways = explore_ways(|| (comparison(Some(false)), comparison(None))).unwrap();
    let [(first, way), (second, _)] = ways.as_slice() else { panic!("{}", ways.len()) };
    assert_eq!((*first, *second), ((false, true), (false, false)));
    assert_eq!(follow(way, || (comparison(Some(true)), comparison(Some(false)))), Some((false, true)));
    // A third question belongs to another way.
    assert_eq!(follow(way, || (0..3).filter(|_| comparison(None)).count()), None);
}

#[test]
fn every_way_is_taken_once() {
    let ways = explore(|| open_comparison().then(open_comparison)).unwrap();
    assert_eq!(ways, [Some(true), Some(false), None]);
}

#[test]
fn explorations_nest() {
    let ways = explore(|| {
        let outer = open_comparison();
        let inner = explore(open_comparison).unwrap();
        assert_eq!(explore(|| note_undefined("ln")), Err(Undefined::Operation("ln")));
        (outer, inner, open_comparison())
    });
    let inner = vec![true, false];
    let expected: Vec<_> =
        [(true, true), (true, false), (false, true), (false, false)].map(|(a, b)| (a, inner.clone(), b)).into();
    assert_eq!(ways.unwrap(), expected);
}

#[test]
fn loops_end() {
    assert_eq!(explore(|| while open_comparison() {}), Err(Undefined::TooManyBranches));
    assert_eq!(explore(|| while !open_comparison() {}), Err(Undefined::TooManyBranches));
    // Seven comparisons in a row have 128 ways.
    let seven = || (0..7).filter(|_| open_comparison()).count();
    assert_eq!(explore(seven), Err(Undefined::TooManyBranches));
}

#[test]
fn a_panic_leaves_nothing_behind() {
    let outer = explore(|| {
        let caught = std::panic::catch_unwind(|| explore(|| -> bool { panic!("in a plant") }));
        assert!(caught.is_err());
        open_comparison()
    });
    assert_eq!(outer.unwrap(), [true, false]);
}
