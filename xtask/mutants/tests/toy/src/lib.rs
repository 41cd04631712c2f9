//! Functions whose mutants are known by sight.

/// n (n + 1) / 2, by a loop.
pub fn triangle(n: u32) -> u32 {
    let (mut i, mut sum) = (0, 0);
    while i < n {
        i += 1;
        sum += i;
    }
    sum
}

pub fn larger(a: i32, b: i32) -> i32 {
    if a > b { a } else { b }
}

pub fn joined(a: String, b: &str) -> String {
    a + b
}

pub const fn bits(bytes: u32) -> u32 {
    bytes * 8
}

pub fn word(n: u32) -> &'static str {
    match n {
        0 => "none",
        1 => "one",
        many if many > 9 && many % 2 == 0 => "many",
        _ => "some",
    }
}

#[derive(Debug, PartialEq)]
pub struct Size {
    pub rows: usize,
    pub columns: usize,
}

pub fn row(columns: usize) -> Size {
    Size { columns, ..Size { rows: 1, columns: 1 } }
}

pub fn unreached(x: i32) -> i32 {
    -x
}

pub fn evens(n: u32) -> impl Iterator<Item = u32> {
    (0..n).map(|k| 2 * k)
}
