//! Base-85 encoding of bytes for HTML elements: five letters for four bytes.
//!
//! The letters are the printable ASCII characters without space, `"&'<>\`, the backtick, `,` and `;`, in their order.
//! The most significant digit is first; the last 1 to 3 bytes have one letter more than bytes.

/// The printable characters that are no digits.
const EXCLUDED: &[u8] = b"\"&'<>\\`,;";

fn letters() -> impl Iterator<Item = u8> {
    (b'!'..=b'~').filter(|letter| !EXCLUDED.contains(letter))
}

/// The letters of `bytes`.
pub fn encode(bytes: &[u8]) -> String {
    let digits: Vec<char> = letters().map(char::from).collect();
    let mut text = String::with_capacity(bytes.len().div_ceil(4) * 5);
    for group in bytes.chunks(4) {
        let mut word = [0; 4];
        word[..group.len()].copy_from_slice(group);
        let word = u32::from_be_bytes(word);
        let places = (0..=group.len() as u32).map(|place| digits[(word / 85_u32.pow(4 - place) % 85) as usize]);
        text.extend(places);
    }
    text
}

/// The bytes of `text`; none if it has other letters, or a group that stands for no bytes.
pub fn decode(text: &str) -> Option<Vec<u8>> {
    let mut digits = [None; 128];
    for (digit, letter) in letters().enumerate() {
        digits[usize::from(letter)] = Some(digit as u64);
    }
    let mut bytes = Vec::with_capacity(text.len() / 5 * 4 + 3);
    for group in text.as_bytes().chunks(5) {
        let count = group.len().checked_sub(1).filter(|count| *count > 0)?;
        let mut word = 0_u64;
        for place in 0..5 {
            // Missing letters count as the last one, so that the leading bytes are right.
            let digit = group.get(place).map_or(Some(84), |letter| *digits.get(usize::from(*letter))?)?;
            word = 85 * word + digit;
        }
        bytes.extend_from_slice(&u32::try_from(word).ok()?.to_be_bytes()[..count]);
    }
    Some(bytes)
}
