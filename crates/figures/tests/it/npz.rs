//! Archives of numbers.

use std::io::{self, Cursor, Read, Seek, SeekFrom, Write};

use luenberger_figures::npz;

/// The files of an archive of these columns.
fn files<const N: usize>(columns: [&[f64]; N]) -> [Vec<u8>; N] {
    let names: [String; N] = std::array::from_fn(|k| format!("x{k}"));
    let mut file = Cursor::new(Vec::new());
    let named = names.iter().map(String::as_str).zip(columns);
    npz::write(&mut file, named, &[("about.txt", "some columns")]).unwrap();
    let mut archive = zip::ZipArchive::new(file).unwrap();
    names.map(|name| {
        let mut npy = Vec::new();
        archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut npy).unwrap();
        npy
    })
}

/// Every bit of a number is kept, that of infinite, signed and subnormal ones too.
#[test]
fn what_is_read_is_what_was_written() {
    let columns: [&[f64]; 3] = [&[0.1 + 0.2, f64::NAN, -0.0], &[f64::INFINITY, -f64::NAN, 5e-324], &[]];
    for (npy, column) in files(columns).iter().zip(columns) {
        let numbers = npz::numbers(npy).unwrap();
        assert!(numbers.iter().map(|x| x.to_bits()).eq(column.iter().map(|x| x.to_bits())), "{numbers:?}");
    }
}

/// A file on a disk with so many bytes left.
struct Full(Cursor<Vec<u8>>, u64);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let left = self.1.saturating_sub(self.0.position()) as usize;
        if left == 0 && !bytes.is_empty() {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.0.write(&bytes[..left.min(bytes.len())])
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Full {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

/// Wherever the disk becomes full, that is the error.
#[test]
fn a_full_disk_is_an_error_of_storage() {
    let write = |size: u64| {
        let mut file = Full(Cursor::new(Vec::new()), size);
        let written = npz::write(&mut file, [("a", &[1.0, 2.0][..]), ("b", &[3.0])], &[("about.txt", "two columns")]);
        written.map(|()| file.0.into_inner())
    };
    let whole = write(u64::MAX).unwrap();
    assert_eq!(write(whole.len() as u64).unwrap(), whole);
    for size in 0..whole.len() as u64 {
        let error = write(size).unwrap_err();
        let zip::result::ZipError::Io(error) = error else { panic!("{size}: {error}") };
        assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{size}");
    }
}

#[test]
fn other_files_are_refused() {
    let [npy] = files([&[1.0, 2.0]]);
    let mut integers = npy.clone();
    let kind = npy.windows(3).position(|bytes| bytes == b"<f8").unwrap();
    integers[kind + 1] = b'i';
    // Cut short, of another length than the header says, of another type, or no file of numbers at all.
    for file in [&npy[..npy.len() - 1], &npy[..npy.len() - 8], &integers, b"PK"] {
        assert_eq!(npz::numbers(file), None, "{file:?}");
    }
}
