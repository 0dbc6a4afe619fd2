//! From a manifest to the assets that it asks for, each with all that holds for it.

use super::left_out::{LeftOut, by_format};
use super::manifest::{ERROR_POINTS, Entry, Gates, Manifest, MapEntry, Rules};
use super::names::{self, Mesh};
use super::pattern::{Files, Pattern};
use crate::error::Error;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use volmap_bake::parameters::Parameters;

/// The assets of a manifest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expanded {
    /// In the order of the entries that name their meshes first, and of the meshes' paths.
    pub assets: Vec<PlannedAsset>,
    /// What a careful person would look at: globs without a mesh, parameters without effect.
    pub notes: Vec<String>,
    /// Files that patterns meet and that aren't read.
    pub left_out: Vec<LeftOut>,
    /// Folders that couldn't be looked into: there may be more assets.
    pub unreadable: Vec<String>,
}

/// An asset that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedAsset {
    /// Its path in the output folder, without .h5, with `/`.
    pub name: String,
    /// The mesh's file.
    pub mesh: PathBuf,
    /// The same, as the manifest's folder sees it, with `/`.
    pub mesh_name: String,
    /// The manifest's tags, each once.
    pub tags: Vec<String>,
    /// All that is given for its bake.
    pub parameters: Parameters,
    /// What it must pass.
    pub gates: Gates,
    /// Seconds that its bake may take.
    pub timeout: Option<f64>,
    /// Seconds that its report may take.
    pub report_timeout: Option<f64>,
    /// Points at which its error is measured; 0: not.
    pub error_points: u32,
    /// Whether it gets a page with errors.
    pub report: bool,
    /// Why it can't be made whatever its mesh holds.
    pub fault: Option<String>,
}

impl Expanded {
    /// BLAKE3 of what is asked for, but for what the meshes hold.
    pub fn fingerprint(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for asset in &self.assets {
            let PlannedAsset { name, mesh_name, tags, parameters, gates, error_points, report, .. } = asset;
            let said = serde_json::to_vec(&(name, mesh_name, tags, parameters, gates, error_points, report));
            hasher.update(&said.expect("plain data"));
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// An entry that is ready to match.
struct Matcher<'a> {
    entry: &'a Entry,
    patterns: Vec<Pattern>,
    exclude: Vec<Pattern>,
}

/// All that the entries say of a mesh.
struct Said<'a> {
    rules: Rules,
    tags: Vec<&'a str>,
    template: &'a str,
    fixed_part: &'a str,
    maps: &'a [MapEntry],
}

/// Finds the meshes of a manifest, and what holds for each. `folder` is the manifest's.
///
/// # Errors
/// Names that can't be files' or that two assets would share; a manifest made in Rust that [`super::manifest::load`]
/// would refuse.
pub fn expand(manifest: &Manifest, folder: &Path) -> Result<Expanded, Error> {
    manifest.check().map_err(|problem| refuse(problem.key(), problem.reason))?;
    let matchers: Vec<Matcher> = manifest
        .assets
        .iter()
        .enumerate()
        .map(|(i, entry)| Matcher::new(entry, i, folder))
        .collect::<Result<_, _>>()?;
    let mut found = Expanded::default();
    let meshes = meshes(&matchers, folder, &mut found);
    let mut assets = Vec::new();
    for mesh in &meshes {
        let said = say(&manifest.defaults, &matchers, mesh);
        if said.maps.is_empty() {
            assets.push(asset(&said, mesh, folder, None)?);
        }
        for map in said.maps {
            assets.push(asset(&said, mesh, folder, Some(map))?);
        }
    }
    for entry in manifest.assets.iter().filter(|entry| entry.mesh.0.is_empty()) {
        let Some(shape) = entry.bake.shape else { continue };
        let said = of_shape(&manifest.defaults, entry);
        let maps = said.maps.iter().map(Some);
        let alone = said.maps.is_empty().then_some(None);
        for map in maps.chain(alone) {
            assets.push(asset(&said, shape.name(), folder, map)?);
        }
    }
    check_names(&assets)?;
    without_density(&assets, &mut found.notes);
    Ok(Expanded { assets, ..found })
}

fn refuse(place: impl Into<String>, reason: impl Into<String>) -> Error {
    volmap_documents::Error::Content { place: place.into(), reason: reason.into() }.into()
}

impl Matcher<'_> {
    fn new<'a>(entry: &'a Entry, index: usize, folder: &Path) -> Result<Matcher<'a>, Error> {
        let read = |key: &str, texts: &[String]| {
            let one = |text: &String| Pattern::in_folder(text, folder);
            let patterns: Result<Vec<_>, _> = texts.iter().map(one).collect();
            patterns.map_err(|reason| refuse(format!("assets[{index}].{key}"), reason))
        };
        Ok(Matcher {
            entry,
            patterns: read("mesh", &entry.mesh.0)?,
            exclude: read("exclude", &entry.exclude.0)?,
        })
    }

    /// The pattern that means this mesh.
    fn pattern(&self, mesh: &str) -> Option<&Pattern> {
        let pattern = self.patterns.iter().find(|pattern| pattern.matches(mesh))?;
        (!self.exclude.iter().any(|pattern| pattern.matches(mesh))).then_some(pattern)
    }
}

/// The meshes, each once.
fn meshes(matchers: &[Matcher], folder: &Path, found: &mut Expanded) -> Vec<String> {
    let (mut seen, mut meshes, mut foreign) = (HashSet::new(), Vec::new(), Vec::new());
    for matcher in matchers {
        for (pattern, text) in matcher.patterns.iter().zip(&matcher.entry.mesh.0) {
            let files: Files = pattern.files(folder);
            found.notes.extend(files.notes);
            found.unreadable.extend(files.unreadable);
            let is_wanted = |path: &String| !matcher.exclude.iter().any(|pattern| pattern.covers(path));
            foreign.extend(files.foreign.into_iter().filter(is_wanted));
            let kept: Vec<String> =
                files.paths.into_iter().filter(|path| matcher.pattern(path).is_some()).collect();
            if kept.is_empty() {
                found.notes.push(format!("no mesh matches `{text}`"));
            }
            meshes.extend(kept.into_iter().filter(|path| seen.insert(path.clone())));
        }
    }
    found.left_out = by_format(foreign);
    meshes
}

/// Goes through the entries, later ones over earlier ones.
fn say<'a>(defaults: &Rules, matchers: &'a [Matcher<'a>], mesh: &str) -> Said<'a> {
    let mut said =
        Said { rules: defaults.clone(), tags: Vec::new(), template: "{path}", fixed_part: "", maps: &[] };
    let mut first = true;
    for matcher in matchers {
        let Some(pattern) = matcher.pattern(mesh) else { continue };
        let entry = matcher.entry;
        said.rules = entry.rules().over(&said.rules);
        said.tags.extend(entry.tags.iter().map(String::as_str));
        if first || entry.name.is_some() {
            said.fixed_part = pattern.fixed_part();
        }
        said.template = entry.name.as_deref().unwrap_or(said.template);
        said.maps = entry.maps.as_deref().unwrap_or(said.maps);
        first = false;
    }
    said
}

/// What an entry says of its shape; others have no say in that.
fn of_shape<'a>(defaults: &Rules, entry: &'a Entry) -> Said<'a> {
    Said {
        rules: entry.rules().over(defaults),
        tags: entry.tags.iter().map(String::as_str).collect(),
        template: entry.name.as_deref().unwrap_or("{path}"),
        fixed_part: "",
        maps: entry.maps.as_deref().unwrap_or_default(),
    }
}

fn asset(said: &Said, mesh: &str, folder: &Path, map: Option<&MapEntry>) -> Result<PlannedAsset, Error> {
    let rules = map.map_or_else(|| said.rules.clone(), |map| map.rules().over(&said.rules));
    let path = folder.join(mesh);
    let parent = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
    let parts = Mesh { path: mesh, fixed_part: said.fixed_part, parent: &parent };
    let name = names::fill(said.template, &parts, map.map(|map| map.name.as_str()));
    let name = name.and_then(|name| names::check(&name).map(|()| name));
    // A file's name is its own fault alone; it is told of by that.
    let (name, fault) = match name {
        Ok(name) => (name, None),
        Err(reason) => {
            let behind = map.map_or(String::new(), |map| format!(".{}", map.name));
            let fault =
                format!("{mesh}: can't name its asset: {reason}; rename the mesh, or give it a `name`");
            (format!("{mesh}{behind}"), Some(fault))
        }
    };
    let error_points = rules.error_points.unwrap_or(ERROR_POINTS);
    if rules.gates.max_error.is_some() && error_points == 0 {
        let reason = "max_error needs points at which the error is measured; error_points is 0";
        return Err(refuse(mesh, reason));
    }
    let mut tags: Vec<String> = Vec::new();
    let of_map = map.into_iter().flat_map(|map| map.tags.iter().map(String::as_str));
    for tag in said.tags.iter().copied().chain(of_map) {
        if !tags.iter().any(|known| known == tag) {
            tags.push(tag.to_owned());
        }
    }
    Ok(PlannedAsset {
        name,
        mesh: path,
        mesh_name: mesh.to_owned(),
        tags,
        parameters: rules.bake,
        gates: rules.gates,
        timeout: rules.timeout,
        report_timeout: rules.report_timeout,
        error_points,
        report: rules.report.unwrap_or(false),
        fault,
    })
}

/// Some systems don't tell large letters from small ones.
fn check_names(assets: &[PlannedAsset]) -> Result<(), Error> {
    let mut seen: HashMap<String, &PlannedAsset> = HashMap::new();
    for asset in assets {
        if let Some(other) = seen.insert(asset.name.to_lowercase(), asset) {
            let case = if other.name == asset.name { "" } else { ", but for large and small letters" };
            let reason = format!(
                "its asset would have the name of that of {}, {}.h5{case}; tell them apart with `name`, as \
                 name = \"{{path}}_{{extension}}\" (or a template of names, without a manifest)",
                other.mesh_name, asset.name
            );
            return Err(refuse(&asset.mesh_name, reason));
        }
    }
    Ok(())
}

/// Settings of densities where there is none are most likely forgotten ones.
fn without_density(assets: &[PlannedAsset], notes: &mut Vec<String>) {
    if assets.iter().any(|asset| asset.parameters.density == Some(true)) {
        return;
    }
    let kernel = assets.iter().any(|asset| asset.parameters.kernel.is_some());
    let rule = assets.iter().any(|asset| asset.parameters.density_quadrature.is_some());
    for (given, key) in [(kernel, "kernel"), (rule, "density_quadrature")] {
        if given {
            notes.push(format!("`{key}` has no effect: no asset has density = true"));
        }
    }
}
