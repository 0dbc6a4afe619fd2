//! Whether the assets in a folder are those that a manifest wants: keys, checksums and gates, without baking.

use super::assets::Expanded;
use super::journal::past;
use super::places::Places;
use super::read::read;
use super::state::{Action, Known, decide};
use super::threads::in_pool;
use crate::error::Error;
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What was found of an asset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The asset's name.
    pub name: String,
    /// What is wrong with it; nothing if it is good.
    pub problems: Vec<String>,
}

/// The manifest that the summary in a folder names.
///
/// # Errors
/// No summary, or one of a batch without a manifest.
pub fn manifest_of(folder: &Path) -> Result<PathBuf, Error> {
    let path = folder.join("summary.json");
    let summary = read(&path)?;
    let manifest = summary
        .manifest
        .ok_or_else(|| Error::unusable(&path, "names no manifest, as the batch had none; name it"))?;
    Ok(folder.join(manifest))
}

/// Looks at every asset of a manifest in the folder, in the manifest's order. Files are read whole and believed for
/// what they hold alone.
pub fn verify(expanded: &Expanded, out: &Path, threads: usize) -> Vec<Finding> {
    let places = Places { out: out.to_owned(), cache: None };
    // What was written is known to the bit, if a batch noted it.
    let records = past(out, None).records;
    let known = Known { thorough: true, ..Known::new(&places, &records) };
    in_pool(threads, || {
        let assets = expanded.assets.par_iter();
        assets
            .map(|asset| {
                let problems = match decide(asset, &known).action {
                    Action::Keep(kept) if kept.is_rejected => vec!["refused by its gates".to_owned()],
                    Action::Keep(kept) => kept.failed_gates,
                    Action::Make(why, _) | Action::Fail(why) => vec![why],
                };
                Finding { name: asset.name.clone(), problems }
            })
            .collect()
    })
}
