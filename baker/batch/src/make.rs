//! One asset of a batch, from its mesh or from a file of the same content key to its place.

use super::job::{MakeResult, MakeTask, REPORT_STEP};
use super::{figures::figures, gates, measure, preview};
use crate::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;
use volmap_bake::bake::bake;
use volmap_bake::content_key::{self, ATTRIBUTE, key_of};
use volmap_bake::recipe::Recipe;
use volmap_bake::watch::Watch;
use volmap_formats::asset::{self, Asset, Value};
use volmap_report::report::{ReportSettings, page::page, report};
use volmap_runtime::VolumeMap;

/// Makes an asset, its picture and its report. The asset comes last: if it is there, so is the rest.
///
/// # Errors
/// A mesh that can't be read or baked; files that can't be written; cancelled. What lay in the asset's place stays.
pub fn make(task: &MakeTask, watch: &Watch) -> Result<MakeResult, Error> {
    let start = Instant::now();
    let recipe = task.input.parameters.recipe();
    let mut notes = Vec::new();
    let found = task.candidates.iter().find_map(|path| reuse(path, task, &recipe));
    let (asset, bytes, from) = match found {
        Some(found) => found,
        None => {
            let (asset, bytes) = baked(task, &recipe, watch)?;
            (asset, bytes, None)
        }
    };
    let figures = figures(&asset);
    let failed_gates = gates::failed(&task.gates, &figures, bytes.len() as u64);
    let files = if failed_gates.is_empty() { &task.files.good } else { &task.files.rejected };
    watch.step("drawing")?;
    let preview = preview::preview(&VolumeMap::from_asset(&asset)?);
    let report = match &files.report {
        Some(page) => Some((page, report_of(&asset, task, watch)?)),
        None => None,
    };
    // Last of all, so that nothing is left of what is stopped before.
    watch.step("writing")?;
    publish(&files.preview, &preview)?;
    if let Some((page, report)) = &report {
        publish(&page.with_extension("json"), report.json.as_bytes())?;
        publish(page, report.html.as_bytes())?;
    }
    if from.is_none() || from != task.files.cached {
        notes.extend(keep(&bytes, task));
    }
    publish(&files.asset, &bytes)?;
    if failed_gates.is_empty() {
        // It may have been refused before, and isn't any more.
        task.files.rejected.forget();
    }
    Ok(MakeResult {
        from,
        failed_gates,
        figures,
        bytes: bytes.len() as u64,
        file_blake3: blake3::hash(&bytes).to_hex().to_string(),
        seconds: start.elapsed().as_secs_f64(),
        peak_memory: None,
        notes,
    })
}

/// What an asset says of its mesh's name and of the program are those of another day; with today's it is what a bake
/// would give.
fn reuse(path: &Path, task: &MakeTask, recipe: &Recipe) -> Option<(Asset, Vec<u8>, Option<PathBuf>)> {
    let (mut asset, mut bytes) = read_same(path, &task.identity.key)?;
    let names =
        [("file", file_name(&task.input.mesh)), ("program_version", env!("CARGO_PKG_VERSION").into())];
    let mut is_same = true;
    for (attribute, name) in names {
        let name = Value::from(name.as_str());
        is_same &= asset.source.insert(attribute.into(), name.clone()) == Some(name);
    }
    if !is_same {
        bytes = asset::encode(&asset, recipe.compression).ok()?;
    }
    Some((asset, bytes, Some(path.to_owned())))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn baked(task: &MakeTask, recipe: &Recipe, watch: &Watch) -> Result<(Asset, Vec<u8>), Error> {
    watch.step("reading")?;
    let input = content_key::load(&task.input.mesh, recipe, &task.identity)?;
    let mut settings = recipe.bake.clone();
    settings.map.max_memory = task.max_memory;
    let baked = bake(input.clone(), &settings, watch);
    let mut asset = baked.map_err(|error| task.input.parameters.explain(error))?.asset;
    measure::note_error(&mut asset, &input, task.input.error_points, watch)?;
    asset.bake.insert(ATTRIBUTE.into(), task.identity.key.as_str().into());
    watch.step("compressing")?;
    let bytes = asset::encode(&asset, recipe.compression)?;
    Ok((asset, bytes))
}

/// Into the cache, which may be another machine's and full or gone: then the batch does without.
fn keep(bytes: &[u8], task: &MakeTask) -> Option<String> {
    let cached = task.files.cached.as_ref()?;
    if read_same(cached, &task.identity.key).is_some() {
        return None;
    }
    if let Some(folder) = cached.parent() {
        // What killed writers left there is nobody else's to clear. A folder that isn't there has nothing left.
        let _ = asset::clear_leftovers(folder);
    }
    let error = publish(cached, bytes).err()?;
    Some(format!("not kept in the cache: {error}"))
}

/// The asset in a file and its bytes, if it has this key.
fn read_same(path: &Path, key: &str) -> Option<(Asset, Vec<u8>)> {
    let bytes = std::fs::read(path).ok()?;
    let asset = asset::from_bytes(bytes.clone()).ok()?;
    (key_of(&asset) == Some(key)).then_some((asset, bytes))
}

/// A report as it is written.
struct WrittenReport {
    json: String,
    html: String,
}

/// Its limit is that of the gate; if that changes, the page stays.
fn report_of(asset: &Asset, task: &MakeTask, watch: &Watch) -> Result<WrittenReport, Error> {
    watch.step(REPORT_STEP)?;
    let mesh = content_key::load(&task.input.mesh, &task.input.parameters.recipe(), &task.identity)?;
    let settings =
        ReportSettings { max_error: task.gates.max_error.map(|most| most.0), ..ReportSettings::default() };
    let found = report(asset, Some(mesh), &settings, &watch.silent())?;
    let json = serde_json::to_string_pretty(&found.findings).expect("numbers and text") + "\n";
    let html = page(&file_name(&task.files.good.asset), &found.findings, found.pictures()).to_html();
    Ok(WrittenReport { json, html })
}

fn publish(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(|source| Error::io(folder, source))?;
    Ok(asset::publish(path, bytes)?)
}
