//! Entries of a matrix that rounding errors can account for.

/// How such an entry is printed.
pub const ABOUT_ZERO: &str = "≈0";

/// What that means.
pub const ABOUT_ZERO_MEANS: &str = "not more than the rounding errors of the other entries of its row and its column";

/// For each entry whether it is not zero and below the rounding errors of its row and of its column, whatever the units
/// of both are. Of a vector, below those of its largest entry.
pub fn is_about_zero(rows: &[Vec<f64>]) -> Vec<Vec<bool>> {
    let columns = rows.first().map_or(0, Vec::len);
    let largest = |entries: &mut dyn Iterator<Item = f64>| entries.fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let of_column: Vec<f64> =
        (0..columns).map(|j| largest(&mut rows.iter().filter_map(|row| row.get(j).copied()))).collect();
    let one = |row: &Vec<f64>| {
        let of_row = largest(&mut row.iter().copied());
        let entry = |(x, of_column): (&f64, &f64)| {
            let beside = match (rows.len(), columns) {
                (1, _) => of_row,
                (_, 1) => *of_column,
                _ => of_row.min(*of_column),
            };
            *x != 0.0 && x.abs() <= 8.0 * f64::EPSILON * beside
        };
        row.iter().zip(&of_column).map(entry).collect()
    };
    rows.iter().map(one).collect()
}
