//! Tables of text.

/// Rows of cells, left-aligned in columns.
pub(super) fn table(text: &mut String, rows: &[Vec<String>]) {
    let columns = rows.iter().map(Vec::len).max().unwrap_or_default();
    // A row that ends early holds an error message, which may be long and does not affect the column widths.
    let width = |column: usize| {
        let full = rows.iter().filter(|row| row.len() == columns);
        full.filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or_default()
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    for row in rows {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        text.extend(["  ", cells.join("  ").trim_end(), "\n"]);
    }
}
