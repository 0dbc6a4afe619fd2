//! Summaries from their files.

use super::places::of_part;
use super::summary::{SUMMARY_VERSION, Shard, Summary};
use crate::error::Error;
use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};

/// What every version's file has.
#[derive(Deserialize)]
struct Head {
    version: u32,
}

/// The summary in a file.
///
/// # Errors
/// A file that can't be read, is no summary, or is of a later version of the program.
pub fn read(path: &Path) -> Result<Summary, Error> {
    let refuse = |reason: String| Error::unusable(path, reason);
    let text = fs::read(path).map_err(|source| Error::io(path, source))?;
    let broken = |error: serde_json::Error| {
        refuse(format!("is no summary of a batch: {error}; run the batch again to make it anew"))
    };
    // The version first: what else a later one holds is unknown.
    let Head { version } = serde_json::from_slice(&text).map_err(broken)?;
    if version != SUMMARY_VERSION {
        return Err(refuse(format!(
            "has version {version}, and this program reads version {SUMMARY_VERSION}; use the program that wrote it, \
             or run the batch again"
        )));
    }
    serde_json::from_slice(&text).map_err(broken)
}

/// Name of the summary of a part of a batch.
pub fn file_of(shard: Shard) -> String {
    of_part("summary", "json", Some(shard), &[])
}

/// The summaries of parts in a folder, in the order of the parts.
///
/// # Errors
/// A folder that can't be read or has none.
pub fn find_parts(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let unreadable = |source| Error::io(folder, source);
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        if let Some(shard) = entry.file_name().to_str().and_then(shard_of) {
            found.push(((shard.count, shard.index), entry.path()));
        }
    }
    if found.is_empty() {
        let reason = "has no summary.I-of-N.json; run the batch in shards into this folder first";
        return Err(Error::unusable(folder, reason));
    }
    found.sort();
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

/// The part whose summary has this name.
fn shard_of(name: &str) -> Option<Shard> {
    let (index, count) = name.strip_prefix("summary.")?.strip_suffix(".json")?.split_once("-of-")?;
    let shard = Shard { index: index.parse().ok()?, count: count.parse().ok()? };
    // Not `summary.+1-of-02.json`.
    (file_of(shard) == name).then_some(shard)
}

#[cfg(test)]
mod tests {
    use super::super::fixture::mixed;
    use super::*;

    fn folder() -> tempfile::TempDir {
        tempfile::tempdir().unwrap()
    }

    #[test]
    fn a_summary_comes_back() {
        let folder = folder();
        let path = folder.path().join("summary.json");
        fs::write(&path, serde_json::to_vec_pretty(&mixed()).unwrap()).unwrap();
        assert_eq!(read(&path).unwrap(), mixed());
    }

    #[test]
    fn what_is_no_summary_is_refused() {
        let folder = folder();
        let path = folder.path().join("summary.json");
        let refused = |text: &str| {
            fs::write(&path, text).unwrap();
            let message = read(&path).unwrap_err().to_string();
            assert!(
                message.contains("summary.json: ") && message.contains("run the batch again"),
                "{message}"
            );
            message
        };
        assert!(
            refused("{\"version\": 3, \"new\": 1}")
                .contains("has version 3, and this program reads version 2")
        );
        assert!(refused("{\"version\": 2}").contains("missing field `program_version`"));
        assert!(refused("").contains("EOF"));
        let text = serde_json::to_string_pretty(&mixed()).unwrap();
        assert!(refused(&text[..text.len() / 2]).contains("line "));
        assert!(refused(&text.replacen("\"jobs\"", "\"job\"", 1)).contains("unknown field `job`"));
        fs::remove_file(&path).unwrap();
        assert!(matches!(read(&path), Err(Error::Bake(volmap_bake::Error::Io { .. }))));
    }

    #[test]
    fn parts_are_found_in_order() {
        let folder = folder();
        let none = find_parts(folder.path()).unwrap_err().to_string();
        assert!(none.contains("shards"), "{none}");
        let others = ["summary.json", "summary.1-of-.json", "summary.01-of-12.json", "summary.+1-of-12.json"];
        let parts = ["summary.2-of-12.json", "summary.10-of-12.json", "summary.1-of-12.json"];
        for name in others.into_iter().chain(parts) {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let found = find_parts(folder.path()).unwrap();
        let names: Vec<_> = found.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["summary.1-of-12.json", "summary.2-of-12.json", "summary.10-of-12.json"]);
        assert!(matches!(
            find_parts(&folder.path().join("none")),
            Err(Error::Bake(volmap_bake::Error::Io { .. }))
        ));
    }
}
