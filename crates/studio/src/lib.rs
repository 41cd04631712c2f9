//! The whole chain in one page: studies are read, run, verified and exported by a WebAssembly module.
//!
//! [`answer`] takes a request and gives the answer, both as a [`Message`]: JSON, and files with their bytes. It does
//! what the commands of `luenberger` do, by the same code, with files in memory; the bytes of its files are those of
//! the commands on the same machine, and in WebAssembly their numbers differ by rounding. Nothing but [`wasm`](self)
//! knows that there is a page.
//!
//! | request `do` | answer beside `error` |
//! |---|---|
//! | `about` | version, schema, kinds, templates and their files |
//! | `check` | mistakes of a study with their places, its outline, its observers, plant and estimated cost |
//! | `run` | results, their summary, and the files of the results folder |
//! | `advise`, `tune` | the same of these commands |
//! | `export` | the code of an observer for its target |
//! | `verify` | whether a certificate holds |
//! | `columns` | the columns of a log, and a table `[log]` for it |
//! | `zip` | all files in one archive |
//!
//! ```
//! use luenberger_studio::{Message, Quiet, answer};
//! use serde_json::json;
//! let text = luenberger_study::template::text("double-integrator").ok_or("a template")?;
//! let request = Message::new(json!({ "do": "check", "study": text, "name": "study.toml" }));
//! let answer = Message::read(&answer(&request.bytes(), &Quiet))?;
//! assert!(answer.json["error"].is_null() && answer.json["diagnostics"] == json!([]));
//! assert_eq!(answer.json["plant"]["states"], json!(["position", "velocity"]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(missing_docs)]

mod about;
mod advise;
mod archive;
mod check;
mod columns;
mod error;
mod export;
mod message;
#[cfg(feature = "page")]
mod page;
mod run;
mod study;
mod tune;
mod verify;
#[cfg(target_arch = "wasm32")]
pub mod wasm;

pub use error::StudioError;
pub use message::{Message, MessageError};
#[cfg(feature = "page")]
pub use page::{packed, page, page_with};

use serde_json::{Value, json};

/// What surrounds the module.
pub trait Host: Sync {
    /// Takes the progress of a request, a JSON object: `{"stage", "what", "done", "of"}`.
    fn progress(&self, json: &str);
}

/// A host that ignores progress.
pub struct Quiet;

impl Host for Quiet {
    fn progress(&self, _json: &str) {}
}

/// The answer to a request, each as the bytes of a [`Message`]. A request that cannot be answered has an answer that
/// says why: `{"error": {"message", "diagnostics"}, "rendered"}`.
///
/// The cost is that of the command of the same name; memory holds the request, the results, and the answer.
pub fn answer(request: &[u8], host: &dyn Host) -> Vec<u8> {
    let answer = Message::read(request).map_err(StudioError::from).and_then(|message| answered(message, host));
    answer.unwrap_or_else(|error| Message::new(error.to_json())).bytes()
}

fn answered(request: Message, host: &dyn Host) -> Result<Message, StudioError> {
    let wanted = request.json.get("do").and_then(Value::as_str).unwrap_or_default().to_owned();
    let answer = match wanted.as_str() {
        "about" => about::about(),
        "check" => check::check(request),
        "run" => run::run(request, host),
        "export" => export::export(request),
        "verify" => verify::verify(request),
        "advise" => advise::advise(request, host),
        "tune" => tune::tune(request, host),
        "columns" => columns::columns(request),
        "zip" => archive::zip(request),
        _ => Err(StudioError::Unknown { wanted }),
    };
    let mut answer = answer?;
    if let Value::Object(members) = &mut answer.json {
        members.entry("error").or_insert(json!(null));
    }
    Ok(answer)
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
