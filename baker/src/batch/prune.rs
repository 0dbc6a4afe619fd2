//! Assets of earlier batches that the manifest has no more.

use super::assets::PlannedAsset;
use super::journal::JOURNAL;
use super::places::Places;
use crate::content_key::key_of;
use crate::error::Error;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use volmap_formats::asset;
use walkdir::{DirEntry, WalkDir};

/// What is done with them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leftovers {
    /// They are told of.
    #[default]
    Tell,
    /// They are removed, with what belongs to them.
    Remove,
    /// Nothing, as only a part of the manifest is looked at.
    Ignore,
}

/// Does it, and says which. Files without a content key are somebody else's.
///
/// # Errors
/// A file that can't be removed.
pub fn tidy(places: &Places, assets: &[PlannedAsset], leftovers: Leftovers) -> Result<Vec<String>, Error> {
    if leftovers == Leftovers::Ignore {
        return Ok(Vec::new());
    }
    let wanted: BTreeSet<&str> = assets.iter().map(|asset| asset.name.as_str()).collect();
    let left: BTreeSet<String> = names(places)
        .filter(|(name, path)| !wanted.contains(name.as_str()) && is_ours(path))
        .map(|(name, _)| name)
        .collect();
    left.into_iter()
        .map(|name| match leftovers {
            Leftovers::Remove => remove(places, &name),
            _ => Ok(format!("{name}: the manifest has it no more; --prune removes it")),
        })
        .collect()
}

/// Names of all that may be assets, and their files. The cache isn't looked into, nor another batch's output folder.
fn names(places: &Places) -> impl Iterator<Item = (String, PathBuf)> {
    let out = &places.out;
    let cache = places.cache.as_ref().and_then(|cache| cache.canonicalize().ok());
    let is_own = move |entry: &DirEntry| {
        let is_folder = entry.depth() > 0 && entry.file_type().is_dir();
        !is_folder || entry.path().canonicalize().ok() != cache && !has_journal(entry.path())
    };
    let files = WalkDir::new(out).sort_by_file_name().into_iter().filter_entry(is_own).filter_map(Result::ok);
    files.filter(|entry| entry.file_type().is_file()).filter_map(move |entry| {
        let path = entry.into_path();
        let parts: Option<Vec<&str>> =
            path.strip_prefix(out).ok()?.iter().map(|part| part.to_str()).collect();
        let parts = parts?;
        let parts = parts.strip_prefix(&["rejected"]).unwrap_or(&parts);
        let name = parts.join("/").strip_suffix(".h5")?.to_owned();
        Some((name, path))
    })
}

fn has_journal(folder: &Path) -> bool {
    let files = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let mut names = files.filter_map(|file| file.file_name().into_string().ok());
    names.any(|name| name.starts_with(JOURNAL))
}

fn is_ours(path: &Path) -> bool {
    asset::read(path).is_ok_and(|asset| key_of(&asset).is_some())
}

fn remove(places: &Places, name: &str) -> Result<String, Error> {
    let files = Places { cache: None, ..places.clone() }.files(name, "", true);
    for file in files.good.all().into_iter().chain(files.rejected.all()).filter(|file| file.exists()) {
        std::fs::remove_file(&file).map_err(|source| Error::Io { path: file.clone(), source })?;
    }
    Ok(format!("{name}: removed, as the manifest has it no more"))
}
