//! What an asset's bytes follow from, as one hash that stands in the asset: the mesh's bytes and those of the files
//! that it refers to, every parameter, the version of the algorithm. Names and times of files are no part of it.

use crate::error::Error;
use crate::input::{self, Input};
use crate::recipe::Recipe;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use volmap_formats::asset::{Asset, Value};
use volmap_formats::mesh::{self, MeshFormat};

/// Raised whenever the same mesh and parameters give other values than before, or the file another form. A test pins
/// values to it.
pub const ALGORITHM_VERSION: u32 = 2;

/// The asset's attribute (of `bake`) that holds the key.
pub const ATTRIBUTE: &str = "content_key";

/// The parameter that a file decides.
const FORMAT: &str = "format";

/// What a file's hash is where there is no file.
const MISSING: &str = "missing";

/// What an asset's bytes follow from. The content key is a hash of all of it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// The content key: BLAKE3 of the rest, which stands in the asset too.
    pub key: String,
    /// BLAKE3 of the mesh file.
    pub mesh: String,
    /// BLAKE3 of the files that the mesh file refers to, by the names that it gives them.
    pub references: BTreeMap<String, String>,
    /// Every parameter, given or by default.
    pub parameters: BTreeMap<String, String>,
    /// Version of the algorithm.
    pub algorithm: u32,
}

/// Hashes what the asset of a mesh file follows from; of a shape, which the parameters give, no file is read.
///
/// # Errors
/// A mesh file that can't be read or is of no known format.
pub fn identify(path: &Path, parameters: BTreeMap<String, String>) -> Result<Identity, Error> {
    if let Some(shape) = parameters.get(input::SHAPE) {
        let mesh = hash(shape.as_bytes());
        let mut identity = Identity { mesh, parameters, algorithm: ALGORITHM_VERSION, ..Identity::default() };
        identity.key = key(&identity);
        return Ok(identity);
    }
    let bytes = mesh::read_bytes(path)?;
    let format = MeshFormat::detect(path, &bytes)
        .map_err(|source| Error::MeshFile { path: path.to_owned(), source })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut references = BTreeMap::new();
    for file in mesh::references(format, &bytes) {
        let hash = match mesh::read_bytes(&folder.join(&file)) {
            Ok(bytes) => hash(&bytes),
            Err(_) => MISSING.to_owned(),
        };
        references.insert(file.to_string_lossy().into_owned(), hash);
    }
    let mut identity = Identity {
        key: String::new(),
        mesh: hash(&bytes),
        references,
        parameters,
        algorithm: ALGORITHM_VERSION,
    };
    // The same bytes can be read in another way under another extension.
    identity.parameters.insert(FORMAT.into(), format.to_string());
    identity.key = key(&identity);
    Ok(identity)
}

impl Identity {
    /// That of the same mesh with other parameters.
    pub fn with_parameters(&self, mut parameters: BTreeMap<String, String>) -> Identity {
        parameters.extend(
            self.parameters.get_key_value(FORMAT).map(|(name, format)| (name.clone(), format.clone())),
        );
        let mut identity = Identity { parameters, ..self.clone() };
        identity.key = key(&identity);
        identity
    }
}

/// The files that a mesh file refers to; none if it can't be read.
pub fn references(path: &Path) -> Vec<PathBuf> {
    let Ok(bytes) = mesh::read_bytes(path) else { return Vec::new() };
    let Ok(format) = MeshFormat::detect(path, &bytes) else { return Vec::new() };
    let folder = path.parent().unwrap_or(Path::new(""));
    mesh::references(format, &bytes).iter().map(|file| folder.join(file)).collect()
}

/// Reads a mesh that must be the one that was identified, with all that it refers to.
///
/// # Errors
/// A mesh that can't be read, or that has changed since.
pub fn load(path: &Path, recipe: &Recipe, identity: &Identity) -> Result<Input, Error> {
    let input = input::load(path, &recipe.input)?;
    let mut parameters = identity.parameters.clone();
    parameters.remove(FORMAT);
    match identify(path, parameters)?.key == identity.key {
        true => Ok(input),
        false => Err(Error::Unusable {
            path: path.to_owned(),
            reason:
                "has changed, or a file that it refers to, or the program, since it was looked at; try again"
                    .into(),
        }),
    }
}

/// Every parameter that an asset's bytes follow from.
pub fn parameters(recipe: &Recipe, error_points: u32) -> BTreeMap<String, String> {
    let mut out = recipe.effective();
    out.insert("error_points".into(), error_points.to_string());
    out
}

/// The key that stands in an asset.
pub fn key_of(asset: &Asset) -> Option<&str> {
    match asset.bake.get(ATTRIBUTE) {
        Some(Value::Text(key)) => Some(key),
        _ => None,
    }
}

/// Why assets of these identities differ, in words; none if they don't.
pub fn difference(old: &Identity, new: &Identity) -> Option<String> {
    let mut out = Vec::new();
    if old.mesh != new.mesh {
        out.push("the mesh has changed".to_owned());
    }
    let changed = changes(&old.references, &new.references);
    out.extend(changed.iter().map(|(name, ..)| format!("{name} has changed, to which the mesh refers")));
    for (name, from, to) in changes(&old.parameters, &new.parameters) {
        out.push(format!("{name}: {} -> {}", from.unwrap_or("none"), to.unwrap_or("none")));
    }
    if old.algorithm != new.algorithm {
        out.push("this version of volmap computes or stores it in another way".to_owned());
    }
    (!out.is_empty()).then(|| out.join("; "))
}

type Change<'a> = (&'a str, Option<&'a str>, Option<&'a str>);

fn changes<'a>(old: &'a BTreeMap<String, String>, new: &'a BTreeMap<String, String>) -> Vec<Change<'a>> {
    let names = old.keys().chain(new.keys().filter(|name| !old.contains_key(*name)));
    let values = names
        .map(|name| (name.as_str(), old.get(name).map(String::as_str), new.get(name).map(String::as_str)));
    values.filter(|(_, from, to)| from != to).collect()
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// Names and values, each with its length before it, so that no two lists run together to the same bytes.
fn key(identity: &Identity) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut add = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    };
    add(&identity.algorithm.to_string());
    add(&identity.mesh);
    for list in [&identity.references, &identity.parameters] {
        add(&list.len().to_string());
        list.iter().for_each(|(name, value)| {
            add(name);
            add(value);
        });
    }
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
        pairs.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect()
    }

    #[test]
    fn keys_depend_on_content_and_not_on_names_or_times() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        std::fs::write(at("a.obj"), mesh).unwrap();
        std::fs::write(at("b.obj"), mesh).unwrap();
        std::fs::write(at("c.obj"), mesh.replace("0 1 0", "0 2 0")).unwrap();
        let identity = |name: &str, value: &str| identify(&at(name), list(&[("r", value)])).unwrap();
        let first = identity("a.obj", "1");
        assert_eq!(first.key.len(), 64);
        assert_eq!(first, identity("b.obj", "1"));
        for (other, why) in
            [(identity("c.obj", "1"), "the mesh has changed"), (identity("a.obj", "2"), "r: 1 -> 2")]
        {
            assert_ne!(first.key, other.key);
            assert_eq!(difference(&first, &other).unwrap(), why);
        }
        assert_eq!(difference(&first, &first), None);
        let missing = identify(&at("none.obj"), list(&[])).unwrap_err().to_string();
        assert!(missing.contains("none.obj"), "{missing}");
    }

    #[test]
    fn buffers_beside_the_mesh_count() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        let text = r#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 1, "uri": "a.bin"}]}"#;
        std::fs::write(&path, text).unwrap();
        let identity = || identify(&path, list(&[])).unwrap();
        let without = identity();
        assert_eq!(without.references, list(&[("a.bin", MISSING)]));
        std::fs::write(folder.path().join("a.bin"), "x").unwrap();
        let with = identity();
        assert_ne!(without.key, with.key);
        assert_eq!(difference(&without, &with).unwrap(), "a.bin has changed, to which the mesh refers");
    }

    #[test]
    fn names_and_values_do_not_run_together() {
        let of = |pairs: &[(&str, &str)]| key(&Identity { parameters: list(pairs), ..Identity::default() });
        let keys = [of(&[("a", "bc")]), of(&[("ab", "c")]), of(&[("a", "b"), ("c", "")]), of(&[])];
        assert!((0..4).all(|i| (0..i).all(|j| keys[i] != keys[j])));
    }
}
