//! Tests of the committed module.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::GzDecoder;
use sha2::{Digest, Sha256};

/// The embedded module is the one that its README names.
#[test]
fn the_module_is_the_one_that_is_named() {
    let letters = include_str!("../../assets/luenberger-live.wasm.gz.base64").replace('\n', "");
    let packed = STANDARD.decode(letters).unwrap();
    let mut module = Vec::new();
    GzDecoder::new(packed.as_slice()).read_to_end(&mut module).unwrap();
    assert!(module.starts_with(b"\0asm"));
    let digits = format!("{:x}", Sha256::digest(&module));
    assert!(include_str!("../../assets/README.md").contains(&digits), "{digits}");
    // It asks the page for nothing: a plain instantiation runs it. Section 2 would be the imports.
    let mut at = 8;
    while at < module.len() {
        let section = module[at];
        let (mut length, mut shift) = (0_usize, 0);
        loop {
            at += 1;
            length |= usize::from(module[at] & 127) << shift;
            shift += 7;
            if module[at] < 128 {
                break;
            }
        }
        assert_ne!(section, 2, "the module has imports");
        at += 1 + length;
    }
}
