//! The manifest of a batch: which meshes, with which parameters, and what makes an asset good enough.

use super::names;
use super::pattern::Pattern;
use crate::error::Error;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use std::fmt;
use std::path::Path;
use volmap_bake::parameters::{ByteSize, Fraction, Parameters};
use volmap_documents::{At, Checked, Kind, Syntax};

/// The version of the format that this program reads.
pub const VERSION: u32 = 1;

/// Points at which an asset's error is measured if nothing else is said.
pub const ERROR_POINTS: u32 = 200;

const MAX_ERROR_POINTS: u32 = 10_000_000;
/// Longer time limits are mistakes, seconds.
const MAX_TIMEOUT: f64 = 1e9;

const MANIFESTS: Kind = Kind {
    singular: "manifest",
    plural: "manifests",
    version: VERSION,
    program: "volmap",
    example: "bake = { support_radius = 0.1 }",
};

/// A manifest for `volmap batch`, version 1. Files are named relative to the manifest's folder, with `/`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "give a table")]
#[schemars(title = "volmap batch manifest")]
pub struct Manifest {
    /// The schema that an editor checks the file by: batch.schema.json.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Version of this format: 1.
    pub version: u32,
    /// What holds for every asset that says nothing else.
    #[serde(default)]
    pub defaults: Rules,
    /// Which meshes, and what holds for them. Every entry that names a mesh applies to it, later ones over earlier
    /// ones: so globs give rules, and exact paths after them exceptions. A mesh becomes one asset, or one for each of
    /// its maps.
    pub assets: Vec<Entry>,
}

/// How assets are made and judged. What is given key by key replaces what holds else.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "give a table")]
pub struct Rules {
    /// Parameters of the bake: the options of `volmap bake`, with `_` for `-`.
    pub bake: Parameters,
    /// What an asset must pass.
    pub gates: Gates,
    /// Seconds after which a bake is ended as failed; its report isn't counted. Default: none.
    pub timeout: Option<f64>,
    /// Seconds after which a report is ended, and its asset failed. Default: none.
    pub report_timeout: Option<f64>,
    /// Points at which the volume's error is measured; 0: not at all. Default: 200.
    #[schemars(range(max = MAX_ERROR_POINTS))]
    pub error_points: Option<u32>,
    /// Write a page with errors and their causes for each asset. Default: false.
    pub report: Option<bool>,
}

/// What an asset must pass. The first two hold unless they are given: what fails them alone is doubtful.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "give a table")]
pub struct Gates {
    /// A node of the map must lie in the solid. Default: true; false for maps that shall have none.
    pub must_have_solid: Option<bool>,
    /// Largest part of the nodes at which the sign may be in doubt, because the mesh isn't closed or its faces don't run
    /// one way round (1% or 0.01). Default: 1%; 100% allows all.
    pub max_sign_disagreements: Option<Fraction>,
    /// Largest error of the volume in the fluid, as a part of the full ball (1% or 0.01).
    pub max_error: Option<Fraction>,
    /// Largest size of the asset's file, bytes, or as 2MB or 500kB.
    pub max_bytes: Option<ByteSize>,
    /// The mesh must have no hole. Default: false.
    pub must_be_closed: Option<bool>,
}

/// Some meshes, and what holds for them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "give a table")]
pub struct Entry {
    /// Mesh files: paths or globs, relative to the manifest's folder. In a glob `*` is any part of a name, `**` any
    /// folders, `?` one character, `{a,b}` one of several. None where `bake.shape` gives a shape: then the entry is one
    /// asset by itself, or one for each of its maps.
    #[serde(default)]
    pub mesh: Texts,
    /// Globs or paths of files that this entry doesn't mean.
    #[serde(default)]
    pub exclude: Texts,
    /// The asset's path in the output folder, without .h5. {path} stands for the mesh's path below the glob's fixed
    /// part, {stem} for its file's name, both without extension, {extension} for that, {parent} for its folder's name,
    /// {map} for the map's name. Of a shape path and stem are what it is called, as `sphere`.
    /// Default: "{path}"; where there are maps, ".{map}" is put behind if {map} isn't in it.
    #[serde(default)]
    pub name: Option<String>,
    /// Words by which assets can be found; those of all entries add up.
    #[serde(default)]
    pub tags: Vec<String>,
    /// Parameters of the bake: the options of `volmap bake`, with `_` for `-`.
    #[serde(default)]
    pub bake: Parameters,
    /// What the assets must pass.
    #[serde(default)]
    pub gates: Gates,
    /// Seconds after which a bake is ended as failed; its report isn't counted.
    #[serde(default)]
    pub timeout: Option<f64>,
    /// Seconds after which a report is ended, and its asset failed.
    #[serde(default)]
    pub report_timeout: Option<f64>,
    /// Points at which the volume's error is measured; 0: not at all.
    #[serde(default)]
    #[schemars(range(max = MAX_ERROR_POINTS))]
    pub error_points: Option<u32>,
    /// Write a page with errors and their causes for each asset.
    #[serde(default)]
    pub report: Option<bool>,
    /// Several assets of each mesh. A later entry's maps replace an earlier one's. What a map says goes over what all
    /// entries say.
    #[serde(default)]
    pub maps: Option<Vec<MapEntry>>,
}

/// One of several assets of a mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "give a table")]
pub struct MapEntry {
    /// Its name.
    pub name: String,
    /// Words by which the asset can be found, too.
    #[serde(default)]
    pub tags: Vec<String>,
    /// Parameters of the bake: the options of `volmap bake`, with `_` for `-`.
    #[serde(default)]
    pub bake: Parameters,
    /// What the asset must pass.
    #[serde(default)]
    pub gates: Gates,
    /// Seconds after which a bake is ended as failed; its report isn't counted.
    #[serde(default)]
    pub timeout: Option<f64>,
    /// Seconds after which a report is ended, and its asset failed.
    #[serde(default)]
    pub report_timeout: Option<f64>,
    /// Points at which the volume's error is measured; 0: not at all.
    #[serde(default)]
    #[schemars(range(max = MAX_ERROR_POINTS))]
    pub error_points: Option<u32>,
    /// Write a page with errors and their causes for the asset.
    #[serde(default)]
    pub report: Option<bool>,
}

/// One text, or a list of them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Texts(pub Vec<String>);

/// Reads and checks a manifest.
///
/// # Errors
/// A file that can't be read; an unknown key, a wrong type, a value that can't be used, each with line and column.
pub fn load(path: &Path) -> Result<Manifest, Error> {
    Ok(MANIFESTS.load(path, Manifest::check)?)
}

/// A manifest from its text; `name` stands for the file in errors.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, syntax: Syntax, name: &str) -> Result<Manifest, Error> {
    Ok(MANIFESTS.parse(text, syntax, name, Manifest::check)?)
}

/// The manifest of meshes that the command line names.
pub fn from_patterns(patterns: &[String], name: Option<&str>, parameters: &Parameters) -> Manifest {
    Manifest {
        schema: None,
        version: VERSION,
        defaults: Rules { bake: parameters.clone(), ..Rules::default() },
        assets: vec![Entry {
            mesh: Texts(patterns.to_vec()),
            name: name.map(str::to_owned),
            ..Entry::default()
        }],
    }
}

impl Manifest {
    /// The JSON Schema of a manifest, for editors.
    pub fn schema() -> Value {
        let mut schema = schemars::schema_for!(Manifest).to_value();
        remove_empty_defaults(&mut schema);
        schema
    }

    /// Checks all that can be known without looking at files.
    pub(super) fn check(&self) -> Checked {
        let top = At::top();
        top.require("version", self.version == VERSION, || {
            let cure = if self.version > VERSION { "take a newer volmap" } else { "give that" };
            format!("{} is not known; this program reads {VERSION}: {cure}", self.version)
        })?;
        self.defaults.check(&top.key("defaults"))?;
        let shape = self.defaults.bake.shape;
        top.key("defaults").key("bake").require("shape", shape.is_none(), || {
            "belongs to an entry of its own: [[assets]] with `bake.shape` and without `mesh`".into()
        })?;
        top.require("assets", !self.assets.is_empty(), || "there are none; give one at least".into())?;
        let list = top.key("assets");
        self.assets.iter().enumerate().try_for_each(|(i, entry)| entry.check(&list.item(i)))
    }
}

/// A default of nothing, or of tables that hold nothing, tells an editor's user nothing.
fn remove_empty_defaults(schema: &mut Value) {
    fn is_empty(value: &Value) -> bool {
        value.is_null() || value.as_object().is_some_and(|table| table.values().all(is_empty))
    }
    match schema {
        Value::Object(table) => {
            table.retain(|key, value| key != "default" || !is_empty(value));
            table.values_mut().for_each(remove_empty_defaults);
        }
        Value::Array(list) => list.iter_mut().for_each(remove_empty_defaults),
        _ => {}
    }
}

impl Rules {
    /// What is given here, else what `base` gives.
    pub fn over(&self, base: &Rules) -> Rules {
        Rules {
            bake: self.bake.over(&base.bake),
            gates: self.gates.over(&base.gates),
            timeout: self.timeout.or(base.timeout),
            report_timeout: self.report_timeout.or(base.report_timeout),
            error_points: self.error_points.or(base.error_points),
            report: self.report.or(base.report),
        }
    }

    fn check(&self, at: &At) -> Checked {
        let bake = at.key("bake");
        self.bake.check().map_err(|mistake| bake.problem(mistake.key, mistake.reason))?;
        for (key, limit) in [("timeout", self.timeout), ("report_timeout", self.report_timeout)] {
            let seconds = limit.unwrap_or(1.0);
            at.require(key, seconds > 0.0 && seconds <= MAX_TIMEOUT, || {
                format!("{seconds} is no time; give seconds, above 0")
            })?;
        }
        let points = self.error_points.unwrap_or(0);
        at.require("error_points", points <= MAX_ERROR_POINTS, || {
            format!("{points} are more than {MAX_ERROR_POINTS}")
        })
    }
}

impl Gates {
    /// What is given here, else what `base` gives.
    pub fn over(&self, base: &Gates) -> Gates {
        Gates {
            must_have_solid: self.must_have_solid.or(base.must_have_solid),
            max_sign_disagreements: self.max_sign_disagreements.or(base.max_sign_disagreements),
            max_error: self.max_error.or(base.max_error),
            max_bytes: self.max_bytes.or(base.max_bytes),
            must_be_closed: self.must_be_closed.or(base.must_be_closed),
        }
    }
}

impl Entry {
    /// What it says of making and judging.
    pub fn rules(&self) -> Rules {
        Rules {
            bake: self.bake.clone(),
            gates: self.gates,
            timeout: self.timeout,
            report_timeout: self.report_timeout,
            error_points: self.error_points,
            report: self.report,
        }
    }

    fn check(&self, at: &At) -> Checked {
        match (self.mesh.0.is_empty(), self.bake.shape.is_some()) {
            (true, false) => {
                return Err(at.problem("mesh", "names no file; give one, or a shape by `bake.shape`"));
            }
            (false, true) => {
                return Err(at.key("bake").problem("shape", "goes without `mesh`; give one of them"));
            }
            _ => {}
        }
        for (key, texts) in [("mesh", &self.mesh), ("exclude", &self.exclude)] {
            for text in &texts.0 {
                Pattern::new(text).map_err(|reason| at.problem(key, reason))?;
            }
        }
        if let Some(template) = &self.name {
            names::check_template(template).map_err(|reason| at.problem("name", reason))?;
        }
        check_tags(at, &self.tags)?;
        self.rules().check(at)?;
        let (maps, list) = (self.maps.as_deref().unwrap_or_default(), at.key("maps"));
        for (i, map) in maps.iter().enumerate() {
            let at = list.item(i);
            names::check_part(&map.name).map_err(|reason| at.problem("name", reason))?;
            let twin = |other: &MapEntry| other.name.to_lowercase() == map.name.to_lowercase();
            at.require("name", !maps[..i].iter().any(twin), || {
                format!("two maps are called `{}`", map.name)
            })?;
            check_tags(&at, &map.tags)?;
            at.key("bake").require("shape", map.bake.shape.is_none(), || {
                "is the entry's; its maps differ in what else they give".into()
            })?;
            map.rules().check(&at)?;
        }
        Ok(())
    }
}

impl MapEntry {
    /// What it says of making and judging.
    pub fn rules(&self) -> Rules {
        Rules {
            bake: self.bake.clone(),
            gates: self.gates,
            timeout: self.timeout,
            report_timeout: self.report_timeout,
            error_points: self.error_points,
            report: self.report,
        }
    }
}

fn check_tags(at: &At, tags: &[String]) -> Checked {
    let empty = tags.iter().any(|tag| tag.trim().is_empty());
    at.require("tags", !empty, || "a tag is empty".into())
}

impl<'de> Deserialize<'de> for Texts {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrMore)
    }
}

struct OneOrMore;

impl<'de> Visitor<'de> for OneOrMore {
    type Value = Texts;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a path, a glob, or a list of them")
    }

    fn visit_str<E>(self, text: &str) -> Result<Texts, E> {
        Ok(Texts(vec![text.to_owned()]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Texts, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(list)).map(Texts)
    }
}

impl JsonSchema for Texts {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Texts".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" } }] })
    }
}
