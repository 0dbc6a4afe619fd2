//! glTF 2.0 (Khronos, ISO/IEC 12113:2022): JSON or GLB, node transforms applied, in metres.
//!
//! Own structs over `serde_json` for the few properties that geometry needs: the `gltf` crate
//! panics on damaged files, keeps transforms in f32, and refuses a file for its materials.

mod accessor;
mod deform;
mod json;
mod nodes;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};

use self::accessor::Buffers;
use self::deform::{Joints, add_targets, joint_sets};
use self::json::{Asset, Primitive, Root};
use self::nodes::{Placed, placed_meshes, transform};
use crate::mesh::binary::{Endian, Scalar};
use crate::mesh::budget::Budget;
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::text::{show, without_bom};

pub const NAME: &str = "glTF";
pub const BINARY_NAME: &str = "GLB";

/// Required extensions that leave positions and indices as they are, by their beginnings.
/// Quantized positions are read; lights, materials and textures don't matter.
const HARMLESS: [&str; 10] = [
    "KHR_mesh_quantization",
    "KHR_materials_",
    "KHR_technique",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_xmp",
    "KHR_animation_pointer",
];

/// Looked for wherever a node has it: writers often leave it out of the list of required extensions, and of the other.
const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Reads the default scene, or all root nodes if there is no scene. Skins and morph targets are applied as the file has
/// them at rest. Buffers beside the file are looked up in `folder`.
pub fn read(bytes: &[u8], folder: Option<&Path>) -> Result<RawMesh, MeshError> {
    let is_binary = bytes.starts_with(b"glTF");
    let format = if is_binary { BINARY_NAME } else { NAME };
    let (text, chunk) = if is_binary { glb(bytes)? } else { (without_bom(bytes), None) };
    check_asset(text, format)?;
    let root: Root = serde_json::from_slice(text).map_err(|error| json_error(format, &error))?;
    check_extensions(&root, format)?;
    let mut raw = RawMesh::new(format);
    raw.unit = Some(1.0);
    let mut scene = Scene {
        root: &root,
        buffers: Buffers::new(&root, format, chunk, folder),
        budget: Budget::new(bytes.len()),
        skinned: BTreeSet::new(),
        morphed: BTreeSet::new(),
    };
    for placed in placed_meshes(&root, &mut raw)? {
        scene.add(&mut raw, &placed)?;
    }
    scene.note(&mut raw);
    note_extensions(&root, &mut raw);
    Ok(raw)
}

/// Files in the model's folder that hold its buffers, in the file's order, each once.
/// None of a file that can't be read.
pub fn buffer_files(bytes: &[u8]) -> Vec<PathBuf> {
    let json = match bytes.starts_with(b"glTF") {
        true => glb(bytes).map_or(&[][..], |(json, _)| json),
        false => without_bom(bytes),
    };
    let root: Root = serde_json::from_slice(json).unwrap_or_default();
    let mut files = Vec::new();
    for uri in root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref()) {
        let file = if uri.starts_with("data:") { None } else { accessor::local_path(uri) };
        files.extend(file.filter(|file| !files.contains(file)));
    }
    files
}

/// The JSON chunk and the binary one.
fn glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), MeshError> {
    let bad = |at: usize, problem: &str| MeshError::malformed(BINARY_NAME, format!("byte {at}"), problem);
    let word = |at: usize| {
        let word = bytes.get(at..at + 4);
        word.map(|w| Scalar::U32.read(w, Endian::Little) as usize)
            .ok_or_else(|| bad(at, "the file ends in a header; it was cut: export it again"))
    };
    if word(4)? != 2 {
        return Err(MeshError::unsupported(
            BINARY_NAME,
            format!("version {}", word(4)?),
            "export the model as glTF 2.0",
        ));
    }
    let mut chunks = Vec::new();
    let mut at = 12;
    while at < bytes.len() && chunks.len() < 2 {
        let (length, kind) = (word(at)?, word(at + 4)?);
        let chunk = bytes.get(at + 8..(at + 8).saturating_add(length));
        let chunk = chunk.ok_or_else(|| {
            bad(at, "a chunk is longer than the file; it was cut: export or download it again")
        })?;
        chunks.push((kind, chunk));
        at += 8 + length;
    }
    match chunks.as_slice() {
        [(0x4E4F_534A, json), rest @ ..] => {
            let chunk = rest.first().filter(|(kind, _)| *kind == 0x004E_4942);
            Ok((json, chunk.map(|(_, chunk)| *chunk)))
        }
        _ => Err(bad(12, "the first chunk is not JSON; the file is damaged: export it again")),
    }
}

fn json_error(format: &'static str, error: &serde_json::Error) -> MeshError {
    MeshError::malformed(
        format,
        format!("line {}, column {}", error.line(), error.column()),
        format!("invalid JSON: {error}; the file was cut or is damaged: export it again"),
    )
}

fn check_asset(text: &[u8], format: &'static str) -> Result<(), MeshError> {
    let head: Asset = serde_json::from_slice(text).map_err(|error| json_error(format, &error))?;
    let version = head.asset.map(|asset| match asset.version {
        serde_json::Value::String(text) => text,
        // glTF 1.0 files of old exporters have a number here.
        other => other.to_string(),
    });
    match version {
        Some(version) if version.starts_with("2.") => Ok(()),
        Some(version) => Err(MeshError::unsupported(
            format,
            format!("version {}", show(version.as_bytes())),
            "export the model as glTF 2.0",
        )),
        None => Err(MeshError::malformed(format, "line 1", "there is no `asset`: it isn't a glTF 2.0 file")),
    }
}

fn check_extensions(root: &Root, format: &'static str) -> Result<(), MeshError> {
    let read = [INSTANCING, "KHR_node_visibility"];
    let strange = |name: &&String| !read.iter().chain(&HARMLESS).any(|known| name.starts_with(known));
    match root.extensions_required.iter().find(strange) {
        Some(name) => Err(MeshError::unsupported(
            format,
            format!("the required extension {}", show(name.as_bytes())),
            "export the model without it (without compression)",
        )),
        None => Ok(()),
    }
}

/// Extensions of nodes, meshes and primitives that are read, or that leave the surface as it is.
fn is_known(name: &str) -> bool {
    const KNOWN: [&str; 8] = [
        INSTANCING,
        "KHR_node_",
        "KHR_draco_mesh_compression",
        "EXT_mesh_features",
        "EXT_mesh_manifold",
        "EXT_structural_metadata",
        "CESIUM_primitive_outline",
        "MSFT_lod",
    ];
    KNOWN.iter().chain(&HARMLESS).any(|known| name.starts_with(known))
}

/// The names of extensions that may change the surface, and aren't read.
fn note_extensions(root: &Root, raw: &mut RawMesh) {
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let names = (root.nodes.iter().flat_map(|node| node.extensions.keys()))
        .chain(root.meshes.iter().flat_map(|mesh| mesh.extensions.keys()))
        .chain(primitives.flat_map(|primitive| primitive.extensions.keys()));
    let unknown: BTreeSet<&String> = names.filter(|name| !is_known(name)).collect();
    if !unknown.is_empty() {
        let names: Vec<String> = unknown.into_iter().map(|name| show(name.as_bytes())).collect();
        raw.notes.push(format!("extensions that are not read: {}", names.join(", ")));
    }
}

/// A mesh as one node of the scene draws it.
struct Instance<'a> {
    affine: DAffine3,
    /// Of the morph targets.
    weights: &'a [f64],
    joints: Option<Joints>,
    /// Those that were read, by their accessors: primitives with different materials often share their vertices.
    vertices: BTreeMap<Vec<usize>, Vertices>,
}

/// A range of the mesh's vertices.
#[derive(Clone, Copy)]
struct Vertices {
    first: u32,
    count: u32,
    mirrored: bool,
}

impl Vertices {
    fn add(raw: &mut RawMesh, positions: Vec<[f64; 3]>, mirrored: bool) -> Vertices {
        let narrow = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let added = Vertices { first: narrow(raw.positions.len()), count: narrow(positions.len()), mirrored };
        raw.positions.extend(positions);
        added
    }
}

struct Scene<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    budget: Budget,
    /// Meshes with a skin or with weights of morph targets, for a note.
    skinned: BTreeSet<usize>,
    morphed: BTreeSet<usize>,
}

impl<'a> Scene<'a> {
    fn add(&mut self, raw: &mut RawMesh, placed: &Placed) -> Result<(), MeshError> {
        let Some(mesh) = self.root.meshes.get(placed.mesh) else {
            return Err(raw.bad(format!("mesh {}", placed.mesh), "there is no such mesh; export again"));
        };
        let node = placed.node.map(|node| &self.root.nodes[node]);
        let weights = node.and_then(|node| node.weights.as_ref()).unwrap_or(&mesh.weights);
        if weights.iter().any(|weight| *weight != 0.0) {
            self.morphed.insert(placed.mesh);
        }
        let skin = node.and_then(|node| node.skin);
        let mut affines = vec![placed.affine];
        if let Some(instancing) = node.and_then(|node| node.extensions.get(INSTANCING)) {
            let place = format!("node {}", placed.node.unwrap_or(0));
            affines = self.instances(instancing, placed.affine, &place)?;
        }
        for affine in affines {
            let (buffers, budget) = (&mut self.buffers, &mut self.budget);
            let joints =
                skin.map(|skin| Joints::of_skin(skin, self.root, raw, buffers, budget)).transpose()?;
            if joints.is_some() {
                self.skinned.insert(placed.mesh);
            }
            // Joints alone place what hangs on them.
            let affine = if joints.is_some() { DAffine3::IDENTITY } else { affine };
            let instance = Instance { affine, weights, joints, vertices: BTreeMap::new() };
            self.add_mesh(raw, placed.mesh, instance)?;
        }
        Ok(())
    }

    /// The transforms of EXT_mesh_gpu_instancing: translations, rotations and scales as accessors.
    fn instances(
        &mut self,
        extension: &serde_json::Value,
        node: DAffine3,
        place: &str,
    ) -> Result<Vec<DAffine3>, MeshError> {
        let mut read = |name: &str, shape: &str| -> Result<Option<Vec<f64>>, MeshError> {
            let accessor = extension.get("attributes").and_then(|attributes| attributes.get(name));
            let accessor = accessor.and_then(serde_json::Value::as_u64).map(|accessor| accessor as usize);
            accessor.map(|accessor| self.buffers.numbers(accessor, shape, &mut self.budget)).transpose()
        };
        let translations = read("TRANSLATION", "VEC3")?;
        let rotations = read("ROTATION", "VEC4")?;
        let scales = read("SCALE", "VEC3")?;
        let lengths = [(&translations, 3), (&rotations, 4), (&scales, 3)];
        let counts: Vec<usize> =
            lengths.iter().filter_map(|(values, width)| Some(values.as_ref()?.len() / width)).collect();
        let bad = |problem: &str| {
            self.buffers.bad(place, format!("{INSTANCING}: {problem}; export the file again"))
        };
        let Some(&count) = counts.first().filter(|&first| counts.iter().all(|count| count == first)) else {
            return Err(bad("its attributes are missing or of different lengths"));
        };
        self.budget.take(count, 128, "the scene")?;
        let instance = |k: usize| {
            let three = |values: &Option<Vec<f64>>, other: f64| {
                values.as_ref().map_or([other; 3], |v| [v[3 * k], v[3 * k + 1], v[3 * k + 2]])
            };
            let rotation = rotations
                .as_ref()
                .map_or([0.0, 0.0, 0.0, 1.0], |r| [r[4 * k], r[4 * k + 1], r[4 * k + 2], r[4 * k + 3]]);
            Some(node * transform(three(&translations, 0.0), rotation, three(&scales, 1.0))?)
        };
        let found: Option<Vec<DAffine3>> = (0..count).map(instance).collect();
        found.ok_or_else(|| bad("a rotation is not a quaternion"))
    }

    fn add_mesh(&mut self, raw: &mut RawMesh, mesh: usize, mut instance: Instance) -> Result<(), MeshError> {
        raw.objects += 1;
        for (k, primitive) in self.root.meshes[mesh].primitives.iter().enumerate() {
            let place = format!("mesh {mesh}, primitive {k}");
            match primitive.mode {
                0 => raw.skipped.points += 1,
                1..=3 => raw.skipped.lines += 1,
                4..=6 => self.add_primitive(raw, primitive, &mut instance, &place)?,
                mode => return Err(raw.bad(place, format!("there is no primitive mode {mode}"))),
            }
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        raw: &mut RawMesh,
        primitive: &Primitive,
        instance: &mut Instance,
        place: &str,
    ) -> Result<(), MeshError> {
        let Some(&accessor) = primitive.attributes.get("POSITION") else {
            raw.skipped.other += 1;
            return Ok(());
        };
        let targets =
            primitive.targets.iter().map(|target| target.get("POSITION").copied().unwrap_or(usize::MAX));
        let joints = joint_sets(primitive).into_iter().flatten();
        let key: Vec<usize> =
            [accessor, primitive.targets.len()].into_iter().chain(targets).chain(joints).collect();
        let Vertices { first, count, mirrored } = match instance.vertices.get(&key) {
            Some(&known) => known,
            None => {
                let added = self.read_vertices(raw, accessor, primitive, instance, place)?;
                *instance.vertices.entry(key).or_insert(added)
            }
        };
        let indices = match primitive.indices {
            Some(accessor) => self.buffers.indices(accessor, &mut self.budget)?,
            None => {
                self.budget.take(count as usize, 4, "the scene")?;
                (0..count).collect()
            }
        };
        if let Some(index) = indices.iter().find(|&&index| index >= count) {
            return Err(raw.bad(
                place,
                format!(
                    "refers to vertex {index} (counted from 0), but there are only {count}; the \
                     file is damaged: export it again"
                ),
            ));
        }
        if first.checked_add(count).is_none_or(|end| end == u32::MAX) {
            return Err(MeshError::TooLarge { problem: "the scene has too many vertices; split it".into() });
        }
        self.budget.take(3 * indices.len(), 20, "the scene")?;
        add_triangles(raw, primitive.mode, first, &indices, mirrored);
        Ok(())
    }

    fn read_vertices(
        &mut self,
        raw: &mut RawMesh,
        accessor: usize,
        primitive: &Primitive,
        instance: &Instance,
        place: &str,
    ) -> Result<Vertices, MeshError> {
        let (buffers, budget) = (&mut self.buffers, &mut self.budget);
        let mut positions = buffers.positions(accessor, budget)?;
        add_targets(&mut positions, primitive, instance.weights, buffers, budget, place)?;
        let mut mirrored = instance.affine.matrix3.determinant() < 0.0;
        if let Some(joints) = &instance.joints {
            match joints.apply(&mut positions, primitive, buffers, budget, place)? {
                Some(by_joints) => mirrored = by_joints,
                None => {
                    raw.notes.push(format!(
                        "{place} has a skin, but no joints and weights: its node does not move it"
                    ));
                }
            }
        }
        positions.iter_mut().for_each(|p| *p = instance.affine.transform_point3(DVec3::from(*p)).to_array());
        Ok(Vertices::add(raw, positions, mirrored))
    }

    /// What is taken otherwise than as the vertices stand in the file.
    fn note(&self, raw: &mut RawMesh) {
        let list =
            |meshes: &BTreeSet<usize>| meshes.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        if !self.morphed.is_empty() {
            let meshes = list(&self.morphed);
            raw.notes
                .push(format!("morph targets are applied by the file's default weights to mesh {meshes}"));
        }
        if !self.skinned.is_empty() {
            let meshes = list(&self.skinned);
            raw.notes
                .push(format!("skins are applied in the pose that the file's nodes have to mesh {meshes}"));
        }
    }
}

/// Triangles, strip or fan (section 3.7.2.1). A mirroring node turns the winding.
fn add_triangles(raw: &mut RawMesh, mode: u32, first: u32, indices: &[u32], mirrored: bool) {
    let mut add = |a: u32, b: u32, c: u32| {
        let (b, c) = if mirrored { (c, b) } else { (b, c) };
        raw.faces.push(&[first + a, first + b, first + c]);
    };
    match mode {
        4 => indices.chunks_exact(3).for_each(|t| add(t[0], t[1], t[2])),
        5 => {
            for (k, t) in indices.windows(3).enumerate() {
                let (b, c) = if k % 2 == 0 { (t[1], t[2]) } else { (t[2], t[1]) };
                if t[0] != b && b != c && c != t[0] {
                    add(t[0], b, c);
                }
            }
        }
        _ => {
            for t in indices.get(1..).unwrap_or_default().windows(2) {
                add(indices[0], t[0], t[1]);
            }
        }
    }
    let complete = if mode == 4 { indices.len().is_multiple_of(3) } else { indices.len() > 2 };
    raw.skipped.other += usize::from(!complete);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffer_files_are_named_once_and_stay_in_the_folder() {
        let text = br#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 1, "uri": "a%20b.bin"},
            {"byteLength": 1, "uri": "data:,x"}, {"byteLength": 1, "uri": "a%20b.bin"}, {"byteLength": 1},
            {"byteLength": 1, "uri": "../up.bin"}, {"byteLength": 1, "uri": "sub/c.bin"}]}"#;
        assert_eq!(buffer_files(text), [PathBuf::from("a b.bin"), PathBuf::from("sub/c.bin")]);
        assert!(buffer_files(b"{").is_empty() && buffer_files(b"glTF").is_empty());
    }
}
