//! Archives of numbers.

use std::io::{Cursor, Read};

use luenberger_figures::npz;

/// Every bit of a number is kept, that of infinite, signed and subnormal ones too.
#[test]
fn what_is_read_is_what_was_written() {
    let columns = [[0.1 + 0.2, f64::NAN, -0.0], [f64::INFINITY, -f64::NAN, 5e-324]];
    let mut file = Cursor::new(Vec::new());
    let named = ["x", "y"].into_iter().zip(columns.iter().map(<[f64; 3]>::as_slice));
    npz::write(&mut file, named, &[("about.txt", "two columns")]).unwrap();
    let mut archive = zip::ZipArchive::new(file).unwrap();
    for (name, column) in ["x.npy", "y.npy"].into_iter().zip(columns) {
        let mut npy = Vec::new();
        archive.by_name(name).unwrap().read_to_end(&mut npy).unwrap();
        let numbers = npz::numbers(&npy).unwrap();
        assert_eq!(numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), column.map(f64::to_bits));
        // Of another length, or of no file of numbers at all.
        assert_eq!((npz::numbers(&npy[..npy.len() - 8]), npz::numbers(b"PK")), (None, None));
    }
}
