//! Bytes as letters.

use luenberger_figures::base85::{decode, encode};
use std::collections::BTreeSet;

#[test]
fn every_length_comes_back() {
    for length in 0..=9_usize {
        for first in [0_u8, 1, 84, 127, 254, 255] {
            let bytes: Vec<u8> = (0..length).map(|k| first.wrapping_mul(k as u8 + 1)).collect();
            let text = encode(&bytes);
            assert_eq!(text.len(), bytes.len() / 4 * 5 + [0, 2, 3, 4][bytes.len() % 4]);
            assert_eq!(decode(&text), Some(bytes));
        }
    }
    assert_eq!(encode(&[0xff; 4]).len(), 5);
    assert_eq!(decode(&encode(&[0xff; 7])), Some(vec![0xff; 7]));
}

#[test]
fn no_letter_ends_an_element_and_bad_text_is_refused() {
    // The last letter of the words 0 to 84 is each of the letters.
    let last = |word: u32| encode(&word.to_be_bytes()).chars().last().unwrap();
    let all: BTreeSet<char> = (0..85).map(last).collect();
    assert_eq!(all.len(), 85);
    assert!(['<', '>', '&', '"', '\\'].iter().all(|letter| !all.contains(letter)));
    for bad in ["<!--!", "a", "aaaaaa", "~~~~~", "aé"] {
        assert_eq!(decode(bad), None, "{bad}");
    }
}
