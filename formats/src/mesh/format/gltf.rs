//! glTF 2.0 (Khronos, ISO/IEC 12113:2022): JSON or GLB, node transforms applied, in metres.
//!
//! Own structs over `serde_json` for the few properties that geometry needs: the `gltf` crate
//! panics on damaged files, keeps transforms in f32, and refuses a file for its materials.

mod accessor;
mod json;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};

use self::accessor::Buffers;
use self::json::{Asset, Node, Primitive, Root};
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

/// Reads the default scene, or all root nodes if there is no scene. Skins and morph targets are not
/// applied. Buffers beside the file are looked up in `folder`.
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
    };
    for (mesh, affine) in instances(&root, &raw)? {
        scene.add_mesh(&mut raw, mesh, &affine)?;
    }
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
    let strange = |name: &&String| !HARMLESS.iter().any(|harmless| name.starts_with(harmless));
    match root.extensions_required.iter().find(strange) {
        Some(name) => Err(MeshError::unsupported(
            format,
            format!("the required extension {}", show(name.as_bytes())),
            "export the model without it (without compression or instancing)",
        )),
        None => Ok(()),
    }
}

/// All meshes of the scene, with their transforms, parents before children.
fn instances(root: &Root, raw: &RawMesh) -> Result<Vec<(usize, DAffine3)>, MeshError> {
    let mut found = Vec::new();
    if root.nodes.is_empty() && root.scenes.is_empty() {
        return Ok((0..root.meshes.len()).map(|mesh| (mesh, DAffine3::IDENTITY)).collect());
    }
    let mut visited = vec![false; root.nodes.len()];
    let mut stack: Vec<(usize, DAffine3)> = Vec::new();
    let tops = top_nodes(root, raw)?;
    stack.extend(tops.into_iter().rev().map(|node| (node, DAffine3::IDENTITY)));
    while let Some((index, parent)) = stack.pop() {
        let place = || format!("node {index}");
        let Some(node) = root.nodes.get(index) else {
            return Err(raw.bad(place(), "there is no such node; export the file again"));
        };
        if std::mem::replace(&mut visited[index], true) {
            return Err(raw.bad(
                place(),
                "the node has two parents or is its own ancestor, which glTF forbids; export the \
                 file again",
            ));
        }
        let affine = parent * local(node, raw, &place)?;
        found.extend(node.mesh.map(|mesh| (mesh, affine)));
        stack.extend(node.children.iter().rev().map(|&child| (child, affine)));
    }
    Ok(found)
}

fn top_nodes(root: &Root, raw: &RawMesh) -> Result<Vec<usize>, MeshError> {
    if root.scenes.is_empty() {
        let mut is_child = vec![false; root.nodes.len()];
        for &child in root.nodes.iter().flat_map(|node| &node.children) {
            if let Some(mark) = is_child.get_mut(child) {
                *mark = true;
            }
        }
        return Ok((0..root.nodes.len()).filter(|&node| !is_child[node]).collect());
    }
    let scene = root.scene.unwrap_or(0);
    let found = root.scenes.get(scene).map(|scene| scene.nodes.clone());
    found.ok_or_else(|| raw.bad(format!("scene {scene}"), "there is no such scene; export again"))
}

/// A matrix (column by column), or translation * rotation * scale.
fn local(node: &Node, raw: &RawMesh, place: &dyn Fn() -> String) -> Result<DAffine3, MeshError> {
    if let Some(m) = &node.matrix {
        return Ok(DAffine3::from_mat4(DMat4::from_cols_array(m)));
    }
    let translation = DVec3::from(node.translation.unwrap_or([0.0; 3]));
    let scale = DVec3::from(node.scale.unwrap_or([1.0; 3]));
    let quaternion = DVec4::from(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let length = quaternion.length();
    if !(length > 0.0 && length.is_finite()) {
        return Err(raw.bad(place(), "the rotation is not a quaternion; export the file again"));
    }
    let rotation = DQuat::from_vec4(quaternion / length);
    Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
}

/// A mesh where a node of the scene puts it.
struct Instance<'a> {
    affine: &'a DAffine3,
    /// Those of each accessor that was read: primitives with different materials often share their vertices.
    vertices: BTreeMap<usize, Vertices>,
}

/// A range of the mesh's vertices.
#[derive(Clone, Copy)]
struct Vertices {
    first: u32,
    count: u32,
}

impl Vertices {
    fn add(raw: &mut RawMesh, positions: Vec<[f64; 3]>, affine: &DAffine3) -> Vertices {
        let narrow = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let added = Vertices { first: narrow(raw.positions.len()), count: narrow(positions.len()) };
        raw.positions.extend(positions.into_iter().map(|p| affine.transform_point3(p.into()).to_array()));
        added
    }
}

struct Scene<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    budget: Budget,
}

impl Scene<'_> {
    fn add_mesh(&mut self, raw: &mut RawMesh, mesh: usize, affine: &DAffine3) -> Result<(), MeshError> {
        let Some(primitives) = self.root.meshes.get(mesh).map(|mesh| &mesh.primitives) else {
            return Err(raw.bad(format!("mesh {mesh}"), "there is no such mesh; export again"));
        };
        raw.objects += 1;
        let mut instance = Instance { affine, vertices: BTreeMap::new() };
        for (k, primitive) in primitives.iter().enumerate() {
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
        let Vertices { first, count } = match instance.vertices.get(&accessor) {
            Some(&known) => known,
            None => {
                let positions = self.buffers.positions(accessor, &mut self.budget)?;
                let added = Vertices::add(raw, positions, instance.affine);
                *instance.vertices.entry(accessor).or_insert(added)
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
        let mirrored = instance.affine.matrix3.determinant() < 0.0;
        add_triangles(raw, primitive.mode, first, &indices, mirrored);
        Ok(())
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
