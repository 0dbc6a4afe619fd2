//! Assets that earlier batches made in a folder that the manifest no longer lists.

use super::assets::PlannedAsset;
use super::places::Places;
use crate::error::Error;
use std::collections::BTreeSet;
use std::path::Path;
use volmap_bake::content_key::key_of;
use volmap_formats::asset;

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

/// What came of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tidied {
    /// In words.
    pub notes: Vec<String>,
    /// Names of those that are still there.
    pub left: Vec<String>,
}

/// Does it with the assets among `known`, the names of all that batches made in this folder: others' files are none of
/// its business, wherever they lie.
///
/// # Errors
/// A file that can't be removed.
pub fn tidy(
    places: &Places,
    assets: &[PlannedAsset],
    known: BTreeSet<String>,
    leftovers: Leftovers,
) -> Result<Tidied, Error> {
    let wanted: BTreeSet<&str> = assets.iter().map(|asset| asset.name.as_str()).collect();
    let mut tidied = Tidied::default();
    for name in known.into_iter().filter(|name| !wanted.contains(name.as_str())) {
        let files = places.files(&name, None, true);
        if !is_ours(&files.good.asset) && !is_ours(&files.rejected.asset) {
            continue;
        }
        if leftovers == Leftovers::Remove {
            for file in files.good.all().into_iter().chain(files.rejected.all()).filter(|file| file.exists())
            {
                std::fs::remove_file(&file).map_err(|source| Error::io(file, source))?;
            }
            tidied.notes.push(format!("{name}: removed, as the manifest no longer lists it"));
            continue;
        }
        if leftovers == Leftovers::Tell {
            tidied.notes.push(format!("{name}: no longer in the manifest; pruning removes it"));
        }
        tidied.left.push(name);
    }
    Ok(tidied)
}

fn is_ours(path: &Path) -> bool {
    asset::read(path).is_ok_and(|asset| key_of(&asset).is_some())
}
