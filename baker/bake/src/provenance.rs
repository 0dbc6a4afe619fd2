//! What an asset says of its own bake: how its mesh was placed, and which file it was.

use crate::error::Error;
use crate::input::{self, Input, InputSettings, MeshSource};
use crate::parameters;
use std::path::{Path, PathBuf};
use volmap_formats::asset::{Asset, Value};
use volmap_formats::mesh::read_bytes;

/// How the asset's mesh was read and placed; the default for what the asset doesn't say.
///
/// # Errors
/// Parameters that no bake writes.
pub fn input_settings(asset: &Asset) -> Result<InputSettings, Error> {
    let settings = parameters::restore(&asset.bake).map_err(strange)?;
    Ok(InputSettings { shape: None, ..settings })
}

/// The shape that was baked, placed as the asset says; none if it was a mesh.
///
/// # Errors
/// Parameters that no bake writes.
pub fn shape(asset: &Asset) -> Result<Option<Input>, Error> {
    let settings = parameters::restore(&asset.bake).map_err(strange)?;
    settings.shape.map(|shape| input::from_shape(shape, &settings)).transpose()
}

/// A parameter of the bake that is a number; `default` if the asset doesn't say.
///
/// # Errors
/// A parameter that no bake writes.
pub fn real(asset: &Asset, name: &'static str, default: f64) -> Result<f64, Error> {
    parameters::real(&asset.bake, name).map(|found| found.unwrap_or(default)).map_err(strange)
}

/// A parameter of the bake that is true or false; false if the asset doesn't say.
///
/// # Errors
/// A parameter that no bake writes.
pub fn flag(asset: &Asset, name: &'static str) -> Result<bool, Error> {
    parameters::flag(&asset.bake, name).map(Option::unwrap_or_default).map_err(strange)
}

/// The mesh that was baked, if it lies in one of the folders.
pub fn find_mesh(asset: &Asset, folders: &[&Path]) -> Option<PathBuf> {
    let (Some(Value::Text(name)), Some(Value::Text(hash))) =
        (asset.source.get("file"), asset.source.get("blake3"))
    else {
        return None;
    };
    // A name and no way: the asset may come from anywhere.
    let name = Path::new(name).file_name()?;
    let is_it =
        |path: &PathBuf| read_bytes(path).is_ok_and(|bytes| blake3::hash(&bytes).to_hex().as_str() == hash);
    folders.iter().map(|folder| folder.join(name)).find(is_it)
}

/// A warning, if this isn't the file that was baked.
pub fn other_mesh(asset: &Asset, source: &MeshSource) -> Option<String> {
    let Some(Value::Text(known)) = asset.source.get("blake3") else { return None };
    (*known != source.blake3).then(|| {
        let name = match asset.source.get("file") {
            Some(Value::Text(name)) => name,
            _ => "another file",
        };
        format!("{} is not the mesh that was baked ({name}): their contents differ", source.file)
    })
}

fn strange(name: &'static str) -> Error {
    Error::setting(
        "mesh",
        format!("the asset's parameter {name} is none of a bake; the mesh can't be placed"),
    )
}
