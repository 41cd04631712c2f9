//! LZMA for WebAssembly: the page passes compressed bytes in a buffer of [`allocate`] and gets those of [`unpack`].

use std::io::Read;

use lzma_rust2::LzmaReader;

/// Kilobytes of memory at most, for the dictionary that the bytes ask for.
const MEMORY: u32 = 1 << 17;

/// A buffer of `length` bytes, which [`unpack`] frees.
#[unsafe(no_mangle)]
pub extern "C" fn allocate(length: usize) -> *mut u8 {
    Box::into_raw(vec![0_u8; length].into_boxed_slice()).cast()
}

/// The address of the length (four bytes, the least significant first) and the bytes of a `.lzma` file, which stay; 0
/// if they are damaged.
///
/// # Safety
/// `packed` and `length` are those of a call of [`allocate`], whose buffer was not passed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn unpack(packed: *mut u8, length: usize) -> *const u8 {
    // SAFETY: the caller passes a whole buffer of `allocate`.
    let packed = unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(packed, length)) };
    let mut bytes = vec![0; 4];
    let read = LzmaReader::new_mem_limit(&packed[..], MEMORY, None).and_then(|mut reader| reader.read_to_end(&mut bytes));
    let Ok(Ok(length)) = read.map(u32::try_from) else { return std::ptr::null() };
    bytes[..4].copy_from_slice(&length.to_le_bytes());
    bytes.leak().as_ptr()
}
