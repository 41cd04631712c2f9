//! Tables of numbers as CSV and npz.

use luenberger_figures::Table;
use luenberger_figures::table::TableError;
use std::io::Read;

fn csv(table: &Table) -> Result<String, TableError> {
    let mut bytes = Vec::new();
    table.write_csv(&mut bytes).map(|()| String::from_utf8(bytes).unwrap())
}

#[test]
fn what_is_read_back_is_what_was_written() {
    let values = vec![0.1 + 0.2, -1.0 / 3.0, f64::MIN_POSITIVE, 5e-324, f64::MAX, -0.0, 1e21, 4.0];
    let text = csv(&Table::new().column("t", values.clone()).column("e2_cubic", values.clone())).unwrap();
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    assert_eq!(reader.headers().unwrap(), vec!["t", "e2_cubic"]);
    let read: Vec<f64> = reader.records().map(|r| r.unwrap()[1].parse().unwrap()).collect();
    assert_eq!(read.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), values.map_bits());
}

trait Bits {
    fn map_bits(&self) -> Vec<u64>;
}

impl Bits for Vec<f64> {
    fn map_bits(&self) -> Vec<u64> {
        self.iter().map(|x| x.to_bits()).collect()
    }
}

#[test]
fn a_table_that_makes_no_sense_is_refused() {
    let t = || Table::new().column("t", [0.0, 1.0]);
    assert!(matches!(csv(&Table::new()), Err(TableError::Empty)));
    assert!(matches!(csv(&Table::new().column("t", [])), Err(TableError::Empty)));
    assert!(matches!(csv(&t().column("x", [1.0])), Err(TableError::Length { found: 1, expected: 2, .. })));
    assert!(matches!(csv(&t().column("t", [1.0, 2.0])), Err(TableError::Duplicate { .. })));
    assert!(matches!(csv(&t().column("x", [1.0, f64::NAN])), Err(TableError::NotFinite { row: 2, .. })));
}

fn npz(table: &Table) -> Result<Vec<u8>, TableError> {
    let mut file = std::io::Cursor::new(Vec::new());
    table.write_npz(&mut file).map(|()| file.into_inner())
}

#[test]
fn the_archive_has_the_bits_of_every_column_under_its_name() {
    let values = vec![0.1 + 0.2, f64::MIN_POSITIVE, 5e-324, -0.0, f64::MAX];
    let table = Table::new().column("t", [1.0, 2.0, 3.0, 4.0, 5.0]).column("cubic: x\u{302}1 - x1", values.clone());
    let bytes = npz(&table).unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
    assert_eq!(archive.len(), 2);
    let mut entry = archive.by_name("cubic: x\u{302}1 - x1.npy").unwrap();
    let mut array = Vec::new();
    entry.read_to_end(&mut array).unwrap();
    // As numpy 2.4 writes it.
    let header = format!("\u{1}\0\u{76}\0{:117}\n", "{'descr': '<f8', 'fortran_order': False, 'shape': (5,), }");
    assert_eq!(array[..128], [b"\x93NUMPY", header.as_bytes()].concat());
    let read: Vec<f64> = array[128..].chunks(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect();
    assert_eq!(read.map_bits(), values.map_bits());
    assert_eq!(npz(&table).unwrap(), bytes, "the same table, the same bytes");
}

#[test]
fn what_csv_refuses_npz_refuses() {
    let t = || Table::new().column("t", [0.0, 1.0]);
    assert!(matches!(npz(&Table::new()), Err(TableError::Empty)));
    assert!(matches!(npz(&t().column("x", [1.0])), Err(TableError::Length { found: 1, expected: 2, .. })));
    assert!(matches!(npz(&t().column("t", [1.0, 2.0])), Err(TableError::Duplicate { .. })));
    assert!(matches!(npz(&t().column("x", [1.0, f64::INFINITY])), Err(TableError::NotFinite { row: 2, .. })));
}
