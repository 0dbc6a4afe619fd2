//! Whether the assets in a folder are those that a manifest wants: keys, checksums and gates, without baking.

use super::assets::Expanded;
use super::gates;
use super::journal::past;
use super::places::Places;
use super::read::read;
use super::state::{Action, Known, decide};
use super::summary::Outcome;
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
    /// How it stands.
    pub standing: Standing,
    /// What is wrong with it; nothing if it is good.
    pub problems: Vec<String>,
}

/// How an asset stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// It is what the manifest wants.
    Good,
    /// It has no solid, or its signs are in doubt.
    Doubtful,
    /// A gate refuses it.
    Rejected,
    /// It is missing, damaged, or follows from something else.
    Outdated,
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
                let (standing, problems) = standing(decide(asset, &known).action);
                Finding { name: asset.name.clone(), standing, problems }
            })
            .collect()
    })
}

fn standing(action: Action) -> (Standing, Vec<String>) {
    let kept = match action {
        Action::Keep(kept) => kept,
        Action::Make(why, _) | Action::Fail(why) => return (Standing::Outdated, vec![why]),
    };
    let problems = gates::texts(&kept.failed_gates);
    match gates::outcome(&kept.failed_gates) {
        None => (Standing::Good, problems),
        Some(Outcome::Doubtful) => (Standing::Doubtful, problems),
        Some(_) => (Standing::Rejected, problems),
    }
}
