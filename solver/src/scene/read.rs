//! From a file to a scene: TOML or JSON, every mistake with its line.

use super::place::{line_and_column, locate};
use super::{Scene, VERSION};
use crate::error::Error;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Scenes are written by people and small programs; more is another kind of file.
const MAX_BYTES: u64 = 16 << 20;

/// How a scene is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Syntax {
    /// .toml
    Toml,
    /// .json
    Json,
}

impl Syntax {
    /// By the file's name.
    fn of(path: &Path) -> Result<Syntax, Error> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match extension.as_str() {
            "toml" => Ok(Syntax::Toml),
            "json" => Ok(Syntax::Json),
            _ => Err(Error::Scene {
                place: path.display().to_string(),
                reason: "scenes are files that end in .toml or .json".into(),
            }),
        }
    }
}

/// Reads and checks a scene. Its paths become relative to the working folder, or absolute if `path` is.
///
/// # Errors
/// A file that can't be read; an unknown key, a wrong type, a value out of range, each with line and column.
pub fn load(path: &Path) -> Result<Scene, Error> {
    let syntax = Syntax::of(path)?;
    let io = |source| Error::Io { path: path.to_owned(), source };
    let size = std::fs::metadata(path).map_err(io)?.len();
    if size > MAX_BYTES {
        let reason = format!("has {size} bytes; a scene has at most {MAX_BYTES}");
        return Err(Error::Scene { place: path.display().to_string(), reason });
    }
    let text = std::fs::read_to_string(path).map_err(io)?;
    let mut scene = parse(&text, syntax, &path.display().to_string())?;
    resolve(&mut scene, path.parent().unwrap_or(Path::new("")));
    Ok(scene)
}

/// A scene from its text; `name` stands for the file in errors. Paths stay as they are.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, syntax: Syntax, name: &str) -> Result<Scene, Error> {
    let fail = |offset: usize, reason: String| {
        let (line, column) = line_and_column(text, offset);
        Error::Scene { place: format!("{name}:{line}:{column}"), reason }
    };
    let scene: Scene = deserialize(text, syntax).map_err(|fault| match later_version(text, syntax) {
        Some(version) => {
            fail(0, format!("is of version {version}; this program reads {VERSION}: take a newer volmap-sim"))
        }
        None => fail(fault.offset, explain(&fault.message)),
    })?;
    scene.check().map_err(|problem| {
        fail(locate(text, syntax, &problem.path), format!("{}: {}", problem.key(), problem.reason))
    })?;
    Ok(scene)
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

#[derive(Deserialize)]
struct Version {
    version: u32,
}

fn later_version(text: &str, syntax: Syntax) -> Option<u32> {
    let version = deserialize::<Version>(text, syntax).ok()?.version;
    (version > VERSION).then_some(version)
}

/// serde's message in the words of a scene's author, with what was probably meant.
fn explain(message: &str) -> String {
    for (kind, word) in [("unknown field `", "key"), ("unknown variant `", "value")] {
        let Some((name, known)) = message.strip_prefix(kind).and_then(|rest| rest.split_once("`, ")) else {
            continue;
        };
        let known: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
        let meant = nearest(name, &known);
        return match (known.is_empty(), meant.is_empty()) {
            (true, _) => format!("unknown {word} `{name}`; none is known here"),
            (_, false) => format!("unknown {word} `{name}`; did you mean `{}`?", meant.join("` or `")),
            _ => format!("unknown {word} `{name}`; known here: {}", known.join(", ")),
        };
    }
    if let Some(name) = message.strip_prefix("missing field ") {
        return format!("the key {name} is missing");
    }
    if message.contains("expected newtype variant") || message.contains("expected struct variant") {
        return "this one needs a table with its settings, as motion = { free = { density = 500.0 } }".into();
    }
    message.replace('\n', "; ")
}

/// The known words that were probably meant: the closest, or those that hold the name or a part of it.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Vec<&'a str> {
    let plain = |word: &str| word.to_lowercase().replace('-', "_");
    let name = plain(name);
    let distance = |word: &&&str| strsim::damerau_levenshtein(&name, &plain(word));
    let closest = known.iter().min_by_key(distance);
    if let Some(closest) = closest.filter(|word| 3 * distance(word) <= name.len().max(word.len())) {
        return vec![closest];
    }
    let related =
        |word: &&str| name.len() > 3 && (plain(word).contains(&name) || name.contains(&plain(word)));
    known.iter().copied().filter(related).collect()
}

fn resolve(scene: &mut Scene, folder: &Path) {
    let join = |path: &mut PathBuf| *path = folder.join(&*path);
    scene.cache.iter_mut().for_each(join);
    scene.paths_mut().for_each(join);
}
