//! What an asset says of its own bake: how its mesh was placed, and which file it was.

use crate::error::Error;
use crate::input::{InputSettings, Source};
use std::path::{Path, PathBuf};
use volmap_formats::asset::{Asset, Attributes, Value};
use volmap_formats::mesh::{Placement, Rotation, UpAxis, read_bytes};

/// How the asset's mesh was read and placed; the default for what the asset doesn't say.
///
/// # Errors
/// Parameters that no bake writes.
pub fn input_settings(asset: &Asset) -> Result<InputSettings, Error> {
    let bake = &asset.bake;
    let default = Placement::default();
    let up_axis = match bake.get("up_axis") {
        None => default.up_axis,
        Some(Value::Text(name)) if name == "x" => UpAxis::X,
        Some(Value::Text(name)) if name == "y" => UpAxis::Y,
        Some(Value::Text(name)) if name == "z" => UpAxis::Z,
        Some(_) => return Err(strange("up_axis")),
    };
    let [unit, degrees, weld_tolerance] = [
        reals(bake, "unit", [f64::NAN])?,
        reals(bake, "rotation_degrees", [default.rotation.degrees])?,
        reals(bake, "weld_tolerance", [0.0])?,
    ]
    .map(|[x]| x);
    let placement = Placement {
        unit: default.unit,
        up_axis,
        scale: reals(bake, "scale", default.scale)?,
        rotation: Rotation { axis: reals(bake, "rotation_axis", default.rotation.axis)?, degrees },
        translation: reals(bake, "translation", default.translation)?,
    };
    Ok(InputSettings { unit: (!unit.is_nan()).then_some(unit), placement, weld_tolerance })
}

/// A parameter of the bake that is a number; `default` if the asset doesn't say.
///
/// # Errors
/// A parameter that no bake writes.
pub fn real(asset: &Asset, name: &'static str, default: f64) -> Result<f64, Error> {
    reals(&asset.bake, name, [default]).map(|[x]| x)
}

/// A parameter of the bake that is yes or no; no if the asset doesn't say.
///
/// # Errors
/// A parameter that no bake writes.
pub fn flag(asset: &Asset, name: &'static str) -> Result<bool, Error> {
    match asset.bake.get(name) {
        None => Ok(false),
        Some(Value::Integer(list)) => match list.as_slice() {
            [0] => Ok(false),
            [1] => Ok(true),
            _ => Err(strange(name)),
        },
        Some(_) => Err(strange(name)),
    }
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
pub fn other_mesh(asset: &Asset, source: &Source) -> Option<String> {
    let Some(Value::Text(known)) = asset.source.get("blake3") else { return None };
    (*known != source.blake3).then(|| {
        let name = match asset.source.get("file") {
            Some(Value::Text(name)) => name,
            _ => "another file",
        };
        format!("{} is not the mesh that was baked ({name}): their contents differ", source.file)
    })
}

fn reals<const N: usize>(
    bake: &Attributes,
    name: &'static str,
    default: [f64; N],
) -> Result<[f64; N], Error> {
    match bake.get(name) {
        None => Ok(default),
        Some(Value::Real(list)) => list.as_slice().try_into().map_err(|_| strange(name)),
        Some(_) => Err(strange(name)),
    }
}

fn strange(name: &'static str) -> Error {
    Error::setting(
        "--mesh",
        format!("the asset's parameter {name} is none of a bake; the mesh can't be placed"),
    )
}
