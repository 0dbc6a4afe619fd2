//! From a file to a scene: TOML or JSON, every mistake with its line.

use super::defaults::{self, Given};
use super::{Scene, VERSION};
use crate::error::Error;
use std::path::{Path, PathBuf};
use volmap_documents::{Kind, Syntax};

const SCENES: Kind = Kind {
    singular: "scene",
    plural: "scenes",
    version: VERSION,
    program: "volmap-sim",
    example: "motion = { free = { density = 500.0 } }",
};

/// Reads and checks a scene. Its paths become relative to the working folder, or absolute if `path` is. What it
/// leaves open is adapted to what it gives.
///
/// # Errors
/// A file that can't be read; an unknown key, a wrong type, a value out of range, each with line and column.
pub fn load(path: &Path) -> Result<Scene, Error> {
    let given: Given = SCENES.load(path, |_| Ok(())).unwrap_or_default();
    let mut scene = SCENES.load(path, |scene| adapted(scene, &given).check()).map_err(of_scene)?;
    defaults::adapt(&mut scene, &given);
    resolve(&mut scene, path.parent().unwrap_or(Path::new("")));
    Ok(scene)
}

/// A scene from its text; `name` stands for the file in errors. Paths stay as they are.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, syntax: Syntax, name: &str) -> Result<Scene, Error> {
    let given: Given = SCENES.parse(text, syntax, name, |_| Ok(())).unwrap_or_default();
    let checked = SCENES.parse(text, syntax, name, |scene| adapted(scene, &given).check());
    let mut scene = checked.map_err(of_scene)?;
    defaults::adapt(&mut scene, &given);
    Ok(scene)
}

fn adapted(scene: &Scene, given: &Given) -> Scene {
    let mut scene = scene.clone();
    defaults::adapt(&mut scene, given);
    scene
}

fn of_scene(error: volmap_documents::Error) -> Error {
    match error {
        volmap_documents::Error::Content { place, reason } => Error::Scene { place, reason },
        volmap_documents::Error::Io { path, source } => Error::Io { path, source },
    }
}

fn resolve(scene: &mut Scene, folder: &Path) {
    let join = |path: &mut PathBuf| *path = folder.join(&*path);
    scene.cache.iter_mut().for_each(join);
    scene.paths_mut().for_each(join);
}
