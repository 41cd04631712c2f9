//! The page, and the module in it.

use std::io::Read;

use luenberger_studio::{packed, page, page_with};
use lzma_rust2::LzmaReader;
use sha2::{Digest, Sha256};

/// A number in LEB128, and what follows it.
fn number(bytes: &[u8]) -> (usize, &[u8]) {
    let end = bytes.iter().position(|byte| byte & 128 == 0).unwrap();
    let number = bytes[..=end].iter().rev().fold(0, |number, byte| number << 7 | usize::from(byte & 127));
    (number, &bytes[end + 1..])
}

fn text(bytes: &[u8]) -> (&str, &[u8]) {
    let (length, rest) = number(bytes);
    (std::str::from_utf8(&rest[..length]).unwrap(), &rest[length..])
}

/// The module is the one that the page beside it names, and asks the page for three functions and nothing else.
#[test]
fn the_module_is_the_one_that_is_named() {
    let mut module = Vec::new();
    let packed = packed();
    LzmaReader::new_mem_limit(&packed[..], u32::MAX, None).unwrap().read_to_end(&mut module).unwrap();
    assert!(module.starts_with(b"\0asm"));
    let digits = format!("{:x}", Sha256::digest(&module));
    assert!(include_str!("../../assets/README.md").contains(&digits), "{digits}");
    let (mut rest, mut imports) = (&module[8..], Vec::new());
    while let Some((section, after)) = rest.split_first() {
        let (length, content) = number(after);
        rest = &content[length..];
        if *section == 2 {
            let (count, mut entries) = number(content);
            for _ in 0..count {
                let (from, after) = text(entries);
                let (name, after) = text(after);
                assert_eq!(after[0], 0, "{name} is no function");
                imports.push(format!("{from}.{name}"));
                entries = number(&after[1..]).1;
            }
        }
    }
    imports.sort();
    assert_eq!(imports, ["luenberger.now", "luenberger.panicked", "luenberger.progress"]);
}

/// A double click opens it from the disk: one file, of a size that a mail takes, with a policy against every
/// connection.
#[test]
fn the_page_is_one_file_that_loads_nothing() {
    let page = page();
    assert!(page.len() < 6_000_000, "{} bytes", page.len());
    assert!(page.contains("connect-src 'none'"));
    for place in
        ["/*STYLE*/", "/*EDITOR*/", "/*WORKER*/", "/*STUDIO*/", "<!--UNPACK-->", "<!--MODULE-->", "<!--VERSION-->"]
    {
        assert!(!page.contains(place), "{place}");
    }
    // Each element ends where the skeleton ends it.
    let skeleton = include_str!("../../assets/page.html");
    assert_eq!(page.matches("</script>").count(), skeleton.matches("</script>").count());
    for tag in ["<link rel=\"stylesheet\"", "<script src", "<img src=\"http", "@import", "url(http"] {
        assert!(!page.contains(tag), "{tag}");
    }
}

/// The letters of the module are those of an element: base 85, without a quote or a bracket.
#[test]
fn any_module_can_be_packed() {
    let page = page_with(&[0x5d, 0, 0, 1, 0]);
    let (_, rest) = page.split_once("id=\"module\">").unwrap();
    let (letters, _) = rest.split_once("</script>").unwrap();
    assert_eq!(luenberger_figures::base85::decode(letters).unwrap(), [0x5d, 0, 0, 1, 0]);
}
