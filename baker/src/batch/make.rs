//! One asset of a batch, from its mesh or from a file of the same content key to its place.

use super::job::{Files, Made, Order};
use super::{figures::figures, gates, measure, preview};
use crate::bake::{Step, bake};
use crate::content_key::{ATTRIBUTE, key_of};
use crate::error::Error;
use crate::input::{self, Input};
use crate::provenance::input_settings;
use crate::recipe::Recipe;
use crate::report::{self, page::page, report};
use std::path::{Path, PathBuf};
use std::time::Instant;
use volmap_formats::asset::{self, Asset, Value};
use volmap_runtime::VolumeMap;

/// Makes an asset, its picture and its report. The asset comes last: if it is there, so is the rest.
///
/// # Errors
/// A mesh that can't be read or baked; files that can't be written. What lay in the asset's place stays.
pub fn make(order: &Order, on_step: &mut dyn FnMut(&str)) -> Result<Made, Error> {
    let start = Instant::now();
    let recipe = order.subject.parameters.recipe();
    let mut notes = Vec::new();
    let found = order.candidates.iter().find_map(|path| reuse(path, order, &recipe));
    let (asset, bytes, from) = match found {
        Some(found) => found,
        None => {
            let (asset, bytes) = baked(order, &recipe, on_step)?;
            (asset, bytes, None)
        }
    };
    let figures = figures(&asset);
    let failed_gates = gates::failed(&order.gates, &figures, bytes.len() as u64);
    on_step("drawing");
    publish(&order.files.preview, &preview::preview(&VolumeMap::from_asset(&asset)?))?;
    if let Some(base) = &order.files.report {
        on_step("measuring for the report");
        write_report(base, &asset, order)?;
    }
    on_step("writing");
    notes.extend(keep(&bytes, &order.files));
    place(&bytes, &order.files, failed_gates.is_empty())?;
    Ok(Made {
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

/// What the asset in a file says of the mesh's name is of its own mesh, which may have had another.
fn reuse(path: &Path, order: &Order, recipe: &Recipe) -> Option<(Asset, Vec<u8>, Option<PathBuf>)> {
    let bytes = std::fs::read(path).ok()?;
    let mut asset = asset::from_bytes(bytes.clone()).ok()?;
    if key_of(&asset) != Some(&order.identity.key) {
        return None;
    }
    let name = Value::from(file_name(&order.subject.mesh).as_str());
    let bytes = match asset.source.insert("file".into(), name.clone()) {
        Some(same) if same == name => bytes,
        _ => asset::encode(&asset, recipe.compression).ok()?,
    };
    Some((asset, bytes, Some(path.to_owned())))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn baked(order: &Order, recipe: &Recipe, on_step: &mut dyn FnMut(&str)) -> Result<(Asset, Vec<u8>), Error> {
    on_step("reading");
    let input = load(order, recipe)?;
    let mut settings = recipe.bake.clone();
    settings.map.max_memory = order.max_memory;
    let mut step = |step: Step| on_step(step.name());
    let mut asset = bake(input.clone(), &settings, &mut |_| (), &mut step)?.asset;
    if order.subject.error_points > 0 {
        on_step("measuring the error");
        measure::note_error(&mut asset, &input, order.subject.error_points)?;
    }
    asset.bake.insert(ATTRIBUTE.into(), order.identity.key.as_str().into());
    on_step("compressing");
    let bytes = asset::encode(&asset, recipe.compression)?;
    Ok((asset, bytes))
}

fn load(order: &Order, recipe: &Recipe) -> Result<Input, Error> {
    let mesh = &order.subject.mesh;
    let input = input::load(mesh, &recipe.input)?;
    match input.source.blake3 == order.identity.mesh {
        true => Ok(input),
        false => Err(Error::Import {
            path: mesh.clone(),
            reason: "has changed since the batch began; run the batch again".into(),
        }),
    }
}

/// Into the cache, which may be another machine's and full or gone: then the batch does without.
fn keep(bytes: &[u8], files: &Files) -> Option<String> {
    let cached = files.cached.as_ref()?;
    let same = std::fs::read(cached).is_ok_and(|old| old == bytes);
    let error = (!same).then(|| publish(cached, bytes).err()).flatten()?;
    Some(format!("not kept in the cache: {error}"))
}

fn place(bytes: &[u8], files: &Files, is_good: bool) -> Result<(), Error> {
    let to = if is_good { &files.output } else { &files.rejected };
    publish(to, bytes)?;
    if is_good && files.rejected.exists() {
        // It was refused before and isn't any more.
        let _ = std::fs::remove_file(&files.rejected);
    }
    Ok(())
}

fn write_report(base: &Path, asset: &Asset, order: &Order) -> Result<(), Error> {
    let mesh = input::load(&order.subject.mesh, &input_settings(asset)?)?;
    let settings = report::Settings {
        max_error: order.gates.max_error.map(|part| part.0),
        ..report::Settings::default()
    };
    let found = report(asset, Some(mesh), &settings, &mut |_| ())?;
    let json = serde_json::to_string_pretty(&found.findings).expect("numbers and text") + "\n";
    let html = page(&file_name(&order.files.output), &found.findings, found.pictures()).to_html();
    publish(&with_ending(base, ".json"), json.as_bytes())?;
    publish(&with_ending(base, ".html"), html.as_bytes())
}

/// A path with an ending that may follow a dot in its name.
pub fn with_ending(base: &Path, ending: &str) -> PathBuf {
    let mut name = base.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

fn publish(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(|source| Error::Io { path: folder.to_owned(), source })?;
    Ok(asset::publish(path, bytes)?)
}
