//! Symbols and stack frames of a program for a 32-bit target, little-endian.

use crate::step::Failure;
use std::fs;
use std::path::Path;

/// The functions of a program, and the frames of those that were compiled with `-Zemit-stack-sizes`.
pub(super) struct Image {
    /// Name, address, bytes.
    functions: Vec<(String, u64, u64)>,
    /// Address, bytes.
    frames: Vec<(u64, u64)>,
    /// Bytes of constants.
    pub(super) constants: u64,
}

/// A symbol of a function.
const FUNCTION: u8 = 2;

impl Image {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = fs::read(path).map_err(|source| Failure::io(path, source))?;
        Self::parse(&bytes).ok_or_else(|| Failure::Firmware(format!("{} is no ELF file of 32 bits", path.display())))
    }

    fn parse(bytes: &[u8]) -> Option<Self> {
        bytes.starts_with(b"\x7fELF\x01\x01").then_some(())?;
        let (table, size, count, names) = (word(bytes, 32)?, half(bytes, 46)?, half(bytes, 48)?, half(bytes, 50)?);
        let section = |k: usize| -> Option<(&[u8], usize, usize)> {
            let at = table + k * size;
            let (start, length) = (word(bytes, at + 16)?, word(bytes, at + 20)?);
            // A section without content has an offset all the same.
            let content = if word(bytes, at + 4)? == 8 { &[][..] } else { bytes.get(start..start + length)? };
            Some((content, word(bytes, at)?, word(bytes, at + 24)?))
        };
        let section_names = section(names)?.0;
        let (mut functions, mut frames, mut constants) = (Vec::new(), Vec::new(), 0);
        for k in 0..count {
            let (content, name, link) = section(k)?;
            match text(section_names, name)? {
                ".symtab" => {
                    let names = section(link)?.0;
                    for symbol in content.chunks_exact(16).filter(|symbol| symbol[12] & 15 == FUNCTION) {
                        let name = text(names, word(symbol, 0)?)?.to_owned();
                        // The lowest bit of a Thumb function is its instruction set.
                        functions.push((name, (word(symbol, 4)? & !1) as u64, word(symbol, 8)? as u64));
                    }
                }
                ".stack_sizes" => {
                    let mut rest = content;
                    while rest.len() > 4 {
                        let address = (word(rest, 0)? & !1) as u64;
                        let (frame, length) = unsigned(&rest[4..])?;
                        frames.push((address, frame));
                        rest = &rest[4 + length..];
                    }
                }
                section if section.starts_with(".rodata") => constants += content.len() as u64,
                _ => {}
            }
        }
        Some(Self { functions, frames, constants })
    }

    /// Bytes of the functions with these names.
    pub(super) fn code(&self, is_wanted: impl Fn(&str) -> bool) -> u64 {
        self.functions.iter().filter(|(name, ..)| is_wanted(name)).map(|(.., size)| size).sum()
    }

    /// Whether there is such a function.
    pub(super) fn has(&self, is_wanted: impl Fn(&str) -> bool) -> bool {
        self.functions.iter().any(|(name, ..)| is_wanted(name))
    }

    /// Bytes of the stack frame of a function.
    pub(super) fn frame(&self, name: &str) -> Option<u64> {
        let (_, address, _) = self.functions.iter().find(|(other, ..)| other == name)?;
        self.frames.iter().find(|(other, _)| other == address).map(|(_, frame)| *frame)
    }
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize)
}

fn half(bytes: &[u8], at: usize) -> Option<usize> {
    Some(usize::from(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?)))
}

/// Text that ends with a zero.
fn text(bytes: &[u8], at: usize) -> Option<&str> {
    let rest = bytes.get(at..)?;
    std::str::from_utf8(&rest[..rest.iter().position(|byte| *byte == 0)?]).ok()
}

/// A number of seven bits per byte, and its length.
fn unsigned(bytes: &[u8]) -> Option<(u64, usize)> {
    let length = 1 + bytes.iter().position(|byte| byte & 0x80 == 0)?;
    let digits = bytes[..length].iter().rev();
    Some((digits.fold(0, |number, byte| (number << 7) | u64::from(byte & 0x7f)), length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_seven_bits_per_byte() {
        assert_eq!(unsigned(&[8]), Some((8, 1)));
        assert_eq!(unsigned(&[0xe5, 0x8e, 0x26, 1]), Some((624_485, 3)));
        assert_eq!(unsigned(&[0x80]), None);
        assert!(Image::parse(b"\x7fELF\x02\x01").is_none());
        assert!(Image::parse(b"").is_none());
    }
}
