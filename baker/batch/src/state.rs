//! Is an asset what the manifest wants? Its content key tells; nothing else counts, no time of a file and no record.
//! What earlier batches noted only makes the answer quick.

use super::assets::PlannedAsset;
use super::figures::figures;
use super::gates::{self, FailedGate};
use super::job::{AssetFiles, OutputFiles};
use super::journal::Records;
use super::places::Places;
use super::settings::BatchSettings;
use super::summary::{AssetReport, Figures};
use super::threads::in_pool;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use volmap_bake::content_key::{Identity, difference, identify, key_of, parameters};
use volmap_formats::asset::{self, AssetError};

/// An asset, and what is to be done.
pub struct Decision {
    /// What its bytes follow from; none if its mesh can't be read.
    pub identity: Option<Identity>,
    /// What is to be done.
    pub action: Action,
}

/// What is to be done.
pub enum Action {
    /// Nothing.
    Keep(Kept),
    /// To make it, for this reason, perhaps from one of these files.
    Make(String, Vec<PathBuf>),
    /// There is no way.
    Fail(String),
}

/// A file that is what it should be.
pub struct Kept {
    /// Gates that it doesn't pass.
    pub failed_gates: Vec<FailedGate>,
    /// Size, bytes.
    pub bytes: u64,
    /// BLAKE3.
    pub file_blake3: String,
    /// What it is like.
    pub figures: Figures,
    /// It lies with the rejected ones.
    pub is_rejected: bool,
}

/// All that decisions go by.
pub struct Known<'a> {
    /// Where things lie.
    pub places: &'a Places,
    /// What earlier batches noted.
    pub records: &'a Records,
    /// Names of recorded assets by their keys.
    pub by_key: BTreeMap<&'a str, Vec<&'a str>>,
    /// Make everything anew.
    pub rebuild: bool,
    /// Check files by what they hold, whatever is noted of them, and nothing but the assets.
    pub thorough: bool,
}

impl<'a> Known<'a> {
    /// Of what earlier batches noted.
    pub fn new(places: &'a Places, records: &'a Records) -> Known<'a> {
        let mut by_key: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (name, record) in records {
            if let Some(identity) = &record.identity {
                by_key.entry(&identity.key).or_default().push(name);
            }
        }
        Known { places, records, by_key, rebuild: false, thorough: false }
    }
}

/// What is to be done with each asset, in their order.
pub fn decisions(assets: &[&PlannedAsset], settings: &BatchSettings, records: &Records) -> Vec<Decision> {
    let known = Known { rebuild: settings.rebuild, ..Known::new(&settings.places, records) };
    in_pool(settings.threads, || assets.par_iter().map(|asset| decide(asset, &known)).collect())
}

/// Decides what is to be done with an asset.
pub fn decide(asset: &PlannedAsset, known: &Known) -> Decision {
    if let Some(fault) = &asset.fault {
        return Decision { identity: None, action: Action::Fail(fault.clone()) };
    }
    let effective = parameters(&asset.parameters.recipe(), asset.error_points);
    let identity = match identify(&asset.mesh, effective) {
        Ok(identity) => identity,
        Err(error) => return Decision { identity: None, action: Action::Fail(error.to_string()) },
    };
    let files = known.places.files(&asset.name, Some(&identity.key), asset.report);
    let action = match known.rebuild {
        true => Action::Make("rebuild".into(), Vec::new()),
        false => action(asset, &identity, &files, known),
    };
    Decision { identity: Some(identity), action }
}

fn action(asset: &PlannedAsset, identity: &Identity, files: &OutputFiles, known: &Known) -> Action {
    let record = known.records.get(&asset.name);
    let why = match look(&files.good.asset, identity, record, known.thorough) {
        Ok(found) => return keep(asset, found, &files.good, known.thorough),
        Err(Fault::Foreign) => {
            return Action::Fail(format!(
                "{} wasn't made by a batch; move it away, or rebuild everything",
                files.good.asset.display()
            ));
        }
        Err(Fault::Outdated(why)) => why,
    };
    if let Ok(found) = look(&files.rejected.asset, identity, record, known.thorough) {
        if !gates::failed(&asset.gates, &found.figures, found.bytes).is_empty() {
            let found = Kept { is_rejected: true, ..found };
            return keep(asset, found, &files.rejected, known.thorough);
        }
        return Action::Make("passes its gates now".into(), vec![files.rejected.asset.clone()]);
    }
    // The cache's may appear before the job starts: another machine may be at the same work.
    let mut candidates: Vec<PathBuf> = files.cached.iter().cloned().collect();
    for other in known.by_key.get(identity.key.as_str()).into_iter().flatten() {
        let other = known.places.files(other, None, false);
        candidates.extend([other.good.asset, other.rejected.asset].into_iter().filter(|file| file.exists()));
    }
    Action::Make(why, candidates)
}

/// What belongs to an asset is made again if it is gone.
fn keep(asset: &PlannedAsset, mut found: Kept, files: &AssetFiles, alone: bool) -> Action {
    found.failed_gates = gates::failed(&asset.gates, &found.figures, found.bytes);
    let is_gone = |file: &PathBuf| !alone && !file.exists();
    match () {
        () if is_gone(&files.preview) => Action::Make("picture missing".into(), vec![files.asset.clone()]),
        () if files.report.as_ref().is_some_and(is_gone) => {
            Action::Make("report missing".into(), vec![files.asset.clone()])
        }
        () => Action::Keep(found),
    }
}

/// Why a file isn't the wanted asset.
enum Fault {
    /// It is missing, damaged, or follows from something else.
    Outdated(String),
    /// It is somebody else's.
    Foreign,
}

/// The file, if it is the wanted asset.
fn look(
    path: &Path,
    identity: &Identity,
    record: Option<&AssetReport>,
    thorough: bool,
) -> Result<Kept, Fault> {
    let outdated = |why: String| Err(Fault::Outdated(why));
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return outdated(if record.is_some() || thorough { "file missing" } else { "new" }.into());
        }
        Err(error) => return outdated(format!("file can't be read: {error}")),
    };
    let (size, hash) = (bytes.len() as u64, blake3::hash(&bytes).to_hex().to_string());
    let recorded = record.filter(|record| record.file_blake3.as_ref() == Some(&hash));
    let same_key =
        |record: &&AssetReport| record.identity.as_ref().is_some_and(|old| old.key == identity.key);
    if recorded.is_none() && record.is_some_and(|record| same_key(&record) && record.output_is(path)) {
        return outdated("file damaged: it isn't what the batch wrote".into());
    }
    let kept = |figures| Kept {
        failed_gates: Vec::new(),
        bytes: size,
        file_blake3: hash.clone(),
        figures,
        is_rejected: false,
    };
    if let (Some(figures), false) =
        (recorded.filter(same_key).and_then(|record| record.figures.clone()), thorough)
    {
        return Ok(kept(figures));
    }
    let asset = match asset::from_bytes(bytes) {
        Ok(asset) => asset,
        Err(error) if record.is_none() && is_foreign(&error) => return Err(Fault::Foreign),
        Err(error) => return outdated(format!("file damaged: {error}")),
    };
    match key_of(&asset) {
        Some(key) if key == identity.key => Ok(kept(figures(&asset))),
        Some(_) => {
            let old = recorded.and_then(|record| record.identity.as_ref());
            let why = old.and_then(|old| difference(old, identity));
            outdated(why.unwrap_or_else(|| "mesh, parameters or program changed".into()))
        }
        None => Err(Fault::Foreign),
    }
}

/// Whether it is rather another kind of file, or a newer program's, than a damaged asset.
fn is_foreign(error: &AssetError) -> bool {
    matches!(error, AssetError::NotHdf5 | AssetError::NotAnAsset | AssetError::Version { .. })
}
