//! Documents that people and small programs write, in TOML or JSON: every mistake has a line and a column, and the
//! word that was probably meant.
//!
//! - here: from a file or a text to a value of any type that serde reads;
//! - `explain`: serde's messages in an author's words;
//! - [`check`]: checks of values, whose problems know the way to their key;
//! - `place`: from such a way to line and column.

pub mod check;
pub mod error;
mod explain;
mod place;

pub use check::{At, Checked, PathStep, Problem};
pub use error::Error;

use explain::explain;
use place::{line_and_column, locate};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Documents are written by people and small programs; more is another kind of file.
const MAX_BYTES: u64 = 16 << 20;

/// How a document is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Syntax {
    /// .toml
    Toml,
    /// .json
    Json,
}

/// A kind of documents. They have a key `version`.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// What one is called.
    pub singular: &'static str,
    /// What several are called.
    pub plural: &'static str,
    /// The latest version that can be read.
    pub version: u32,
    /// The program that reads them.
    pub program: &'static str,
    /// How a word is written that needs a table.
    pub example: &'static str,
}

impl Syntax {
    /// By the file's name, if that tells.
    pub fn of(path: &Path) -> Option<Syntax> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match extension.as_str() {
            "toml" => Some(Syntax::Toml),
            "json" => Some(Syntax::Json),
            _ => None,
        }
    }
}

impl Kind {
    /// Reads a document and checks it.
    ///
    /// # Errors
    /// A file that can't be read; an unknown key, a wrong type, a value that fails the check, each with line and
    /// column.
    pub fn load<T: DeserializeOwned>(
        &self,
        path: &Path,
        check: impl FnOnce(&T) -> Checked,
    ) -> Result<T, Error> {
        let refuse = |reason| Error::Content { place: path.display().to_string(), reason };
        let syntax = Syntax::of(path)
            .ok_or_else(|| refuse(format!("{} are files that end in .toml or .json", self.plural)))?;
        let io = |source| Error::Io { path: path.to_owned(), source };
        let size = std::fs::metadata(path).map_err(io)?.len();
        if size > MAX_BYTES {
            return Err(refuse(format!("has {size} bytes; a {} has at most {MAX_BYTES}", self.singular)));
        }
        let text = std::fs::read_to_string(path).map_err(io)?;
        // Editors on Windows put a mark before the text.
        self.parse(text.strip_prefix('\u{FEFF}').unwrap_or(&text), syntax, &path.display().to_string(), check)
    }

    /// The same from a document's text; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`Kind::load`].
    pub fn parse<T: DeserializeOwned>(
        &self,
        text: &str,
        syntax: Syntax,
        name: &str,
        check: impl FnOnce(&T) -> Checked,
    ) -> Result<T, Error> {
        let fail = |offset: usize, reason: String| {
            let (line, column) = line_and_column(text, offset);
            Error::Content { place: format!("{name}:{line}:{column}"), reason }
        };
        let value: T = deserialize(text, syntax).map_err(|fault| match self.later_version(text, syntax) {
            Some(reason) => fail(0, reason),
            None => fail(fault.offset, explain(&fault.message, self.example)),
        })?;
        check(&value).map_err(|problem| {
            fail(locate(text, syntax, &problem.path), format!("{}: {}", problem.key(), problem.reason))
        })?;
        Ok(value)
    }

    fn later_version(&self, text: &str, syntax: Syntax) -> Option<String> {
        let Version { version } = deserialize(text, syntax).ok()?;
        let reads = self.version;
        let cure = format!("take a newer {}", self.program);
        (version > reads).then(|| format!("is of version {version}; this program reads {reads}: {cure}"))
    }
}

#[derive(Deserialize)]
struct Version {
    version: u32,
}

struct Fault {
    offset: usize,
    message: String,
}

fn deserialize<'de, T: Deserialize<'de>>(text: &'de str, syntax: Syntax) -> Result<T, Fault> {
    match syntax {
        Syntax::Toml => toml::from_str(text).map_err(|error| Fault {
            offset: error.span().map_or(0, |span| span.start),
            message: error.message().trim().to_owned(),
        }),
        Syntax::Json => serde_json::from_str(text).map_err(|error| {
            let end = byte_of(text, error.line(), error.column());
            let message = error.to_string();
            let place = format!(" at line {} column {}", error.line(), error.column());
            let message = message.strip_suffix(&place).unwrap_or(&message).to_owned();
            Fault { offset: start_of(text, end, &message), message }
        }),
    }
}

/// The byte of a line and a column, which serde_json counts in bytes.
fn byte_of(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (start + column.saturating_sub(1)).min(text.len())
}

/// serde_json points behind what it didn't like; an unknown word begins before.
fn start_of(text: &str, end: usize, message: &str) -> usize {
    let unknown = message.starts_with("unknown ").then(|| message.split('`').nth(1)).flatten();
    let before = |word: &str| text.get(..(end + 1).min(text.len()))?.rfind(&format!("\"{word}\""));
    unknown.and_then(before).unwrap_or(end)
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
