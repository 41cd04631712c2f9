//! Messages between the page and the module: JSON and the bytes of files.
//!
//! The length of the JSON as four bytes, the least significant first; the JSON in UTF-8; the bytes of the files one
//! after the other. The member `files` of the JSON has their names and lengths in this order:
//! `[{"name": "log.csv", "bytes": 1234}]`.

use serde_json::{Value, json};

/// A request or an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// The JSON, an object; its member `files` is that of the bytes, and not in here.
    pub json: Value,
    /// The files: names with `/` between their parts, and bytes.
    pub files: Vec<(String, Vec<u8>)>,
}

/// Why bytes are no message.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MessageError {
    /// It ends too early.
    #[error("the message is cut: {found} bytes of {needed} are there")]
    Cut {
        /// Its bytes.
        found: usize,
        /// How many it says it has, at least.
        needed: usize,
    },
    /// It does not end where it should.
    #[error("the message goes on for {more} bytes behind its files")]
    Longer {
        /// Bytes too many.
        more: usize,
    },
    /// Its JSON cannot be read.
    #[error("the JSON of the message cannot be read: {why}")]
    Json {
        /// Why.
        why: String,
    },
    /// Its JSON is not an object with a list of files.
    #[error("the JSON of the message is not an object, or its files are not a list of names and bytes")]
    Form,
    /// A name that is not that of a file beside the study.
    #[error("{name:?} is not a name of a file: expected parts with / between them, none of them empty, . or ..")]
    Name {
        /// The name.
        name: String,
    },
    /// Two files have one name.
    #[error("two files are named {name:?}")]
    Twice {
        /// The name.
        name: String,
    },
}

/// Bytes of the length in front.
const HEAD: usize = 4;

impl Message {
    /// A message without files.
    pub fn new(json: Value) -> Self {
        Self { json, files: Vec::new() }
    }

    /// The same with these files.
    #[must_use]
    pub fn with(mut self, files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Self {
        self.files.extend(files);
        self
    }

    /// The message in some bytes.
    ///
    /// # Errors
    /// [`MessageError`].
    pub fn read(bytes: &[u8]) -> Result<Self, MessageError> {
        let found = bytes.len();
        let cut = |needed: usize| MessageError::Cut { found, needed };
        let (length, rest) = bytes.split_first_chunk::<HEAD>().ok_or(cut(HEAD))?;
        let length = u32::from_le_bytes(*length) as usize;
        let (json, mut rest) = rest.split_at_checked(length).ok_or(cut(length.saturating_add(HEAD)))?;
        let unreadable = |error: serde_json::Error| MessageError::Json { why: error.to_string() };
        let mut json: Value = serde_json::from_slice(json).map_err(unreadable)?;
        let listed = json.as_object_mut().ok_or(MessageError::Form)?.remove("files");
        let mut files: Vec<(String, Vec<u8>)> = Vec::new();
        for file in listed.as_ref().map_or(Some(&Vec::new()), Value::as_array).ok_or(MessageError::Form)? {
            let name = file.get("name").and_then(Value::as_str).ok_or(MessageError::Form)?;
            let bytes = file.get("bytes").and_then(Value::as_u64).ok_or(MessageError::Form)?;
            if !is_name(name) {
                return Err(MessageError::Name { name: name.to_owned() });
            }
            if files.iter().any(|(other, _)| other == name) {
                return Err(MessageError::Twice { name: name.to_owned() });
            }
            let bytes = usize::try_from(bytes).unwrap_or(usize::MAX);
            let needed = (found - rest.len()).saturating_add(bytes);
            let content;
            (content, rest) = rest.split_at_checked(bytes).ok_or(cut(needed))?;
            files.push((name.to_owned(), content.to_vec()));
        }
        if rest.is_empty() { Ok(Self { json, files }) } else { Err(MessageError::Longer { more: rest.len() }) }
    }

    /// The bytes of the message. A message whose JSON is longer than 4 GiB, which nothing makes, is cut.
    pub fn bytes(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if let Value::Object(members) = &mut json {
            let listed = self.files.iter().map(|(name, bytes)| json!({ "name": name, "bytes": bytes.len() }));
            members.insert("files".to_owned(), listed.collect());
        }
        let json = json.to_string().into_bytes();
        let sum: usize = self.files.iter().map(|(_, bytes)| bytes.len()).sum();
        let mut bytes = Vec::with_capacity(HEAD + json.len() + sum);
        bytes.extend((json.len() as u32).to_le_bytes());
        bytes.extend(json);
        for (_, content) in &self.files {
            bytes.extend(content);
        }
        bytes
    }
}

/// Whether a name is that of a file in a folder or below it.
fn is_name(name: &str) -> bool {
    !name.contains(['\\', '\0']) && name.split('/').all(|part| !["", ".", ".."].contains(&part))
}
