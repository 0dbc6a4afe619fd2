//! Assets of earlier batches that the manifest has no more.

use super::assets::PlannedAsset;
use super::places;
use crate::content_key::key_of;
use crate::error::Error;
use std::collections::BTreeSet;
use std::path::Path;
use volmap_formats::asset;
use walkdir::WalkDir;

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
pub fn tidy(out: &Path, assets: &[PlannedAsset], leftovers: Leftovers) -> Result<Vec<String>, Error> {
    if leftovers == Leftovers::Ignore {
        return Ok(Vec::new());
    }
    let wanted: BTreeSet<&str> = assets.iter().map(|asset| asset.name.as_str()).collect();
    let left: BTreeSet<String> = names(out)
        .filter(|(name, path)| !wanted.contains(name.as_str()) && is_ours(path))
        .map(|(name, _)| name)
        .collect();
    left.into_iter()
        .map(|name| match leftovers {
            Leftovers::Remove => remove(out, &name),
            _ => Ok(format!("{name}: the manifest has it no more; --prune removes it")),
        })
        .collect()
}

/// Names of all that may be assets, and their files.
fn names(out: &Path) -> impl Iterator<Item = (String, std::path::PathBuf)> {
    let files = WalkDir::new(out).sort_by_file_name().into_iter().filter_map(Result::ok);
    files.filter(|entry| entry.file_type().is_file()).filter_map(move |entry| {
        let path = entry.into_path();
        let parts: Vec<&str> =
            path.strip_prefix(out).ok()?.iter().map(|part| part.to_str()).collect::<Option<_>>()?;
        let parts = parts.strip_prefix(&["rejected"]).unwrap_or(&parts);
        let name = parts.join("/").strip_suffix(".h5")?.to_owned();
        Some((name, path))
    })
}

fn is_ours(path: &Path) -> bool {
    asset::read(path).is_ok_and(|asset| key_of(&asset).is_some())
}

fn remove(out: &Path, name: &str) -> Result<String, Error> {
    let report = places::report(name);
    let json = report.replace(".html", ".json");
    let files = [places::output(name), places::rejected(name), places::preview(name), report, json];
    for file in files.iter().map(|file| out.join(file)).filter(|file| file.exists()) {
        std::fs::remove_file(&file).map_err(|source| Error::Io { path: file.clone(), source })?;
    }
    Ok(format!("{name}: removed, as the manifest has it no more"))
}
