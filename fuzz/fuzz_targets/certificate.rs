//! Any bytes are a certificate or an error that names a line: no panic, no unbounded memory or time; and what is read
//! is written and read again as the same.
//!
//! `cargo +nightly fuzz run certificate`. A good corpus: what `cargo run --example certificate` prints, and the files
//! of the tests.
#![no_main]

use libfuzzer_sys::fuzz_target;
use luenberger_proof::certificate::{CertificateFile, Rejection};

fuzz_target!(|bytes: &[u8]| {
    let file = match CertificateFile::read(bytes) {
        Ok(file) => file,
        Err(error) => {
            assert!(error.line >= 1 && !error.to_string().is_empty());
            return;
        }
    };
    let again = CertificateFile::read(file.to_json().as_bytes()).expect("what was read can be written");
    assert_eq!((again.theorem(), again.claims()), (file.theorem(), file.claims()));
    // The digest would stop most mutations: the mathematics is to see them too.
    let sealed = again.with_claims(again.claims()).expect("what was read can be written");
    match sealed.check() {
        Ok(proved) => assert!(proved.facts.iter().all(|fact| fact.verdict.is_proved())),
        Err(Rejection::Digest { .. }) => panic!("just sealed"),
        Err(why) => assert!(!why.to_string().is_empty()),
    }
});
