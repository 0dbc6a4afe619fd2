//! From a mesh file to the mesh that is baked: read, clean, place.

use crate::coordinates::coordinate_step;
use crate::error::Error;
use crate::primitive::{PlacedPrimitive, Primitive};
use glam::DVec3;
use serde::Serialize;
use std::path::Path;
use volmap_formats::mesh::{
    self, CleanReport, CleanSettings, Faces, MeshError, Placement, RawMesh, TriangleMesh,
};

/// How a mesh file becomes a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputSettings {
    /// Metres per unit of the file; by default what the file says, or 1.
    pub unit: Option<f64>,
    /// Up axis, scale, rotation and translation; its unit is not used.
    pub placement: Placement,
    /// Vertices this close are one, in the file's unit.
    pub weld_tolerance: f64,
    /// A shape that is baked instead of a file.
    pub shape: Option<Primitive>,
}

/// A mesh, and where it comes from.
#[derive(Clone, Debug)]
pub struct Input {
    /// The mesh, in metres.
    pub mesh: TriangleMesh,
    /// Its file.
    pub source: MeshSource,
    /// What cleaning did.
    pub cleaning: CleanReport,
    /// The placement with its unit.
    pub placement: Placement,
    /// Vertices this close are one, in the file's unit.
    pub weld_tolerance: f64,
    /// Step of the file's numbers, metres, where they look rounded.
    pub coordinate_step: Option<f64>,
    /// The shape that the mesh stands for, as it was given; its distance is what is baked then.
    pub shape: Option<Primitive>,
    /// The same, placed.
    pub placed_shape: Option<PlacedPrimitive>,
}

/// Where a mesh comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshSource {
    /// Name of the file, without folders.
    pub file: String,
    /// Format of the file.
    pub format: String,
    /// BLAKE3 of the file's bytes.
    pub blake3: String,
}

/// Reads, cleans and places a mesh; or makes the shape that the settings give, and reads no file.
///
/// # Errors
/// A file that can't be read or used; a placement that can't be.
pub fn load(path: &Path, settings: &InputSettings) -> Result<Input, Error> {
    if let Some(shape) = settings.shape {
        return from_shape(shape, settings);
    }
    from_bytes(path, mesh::read_bytes(path)?, settings)
}

/// The same from a file's bytes; `path` tells the format and is named in errors.
///
/// # Errors
/// Bytes that are no mesh; a placement that can't be.
pub fn from_bytes(
    path: &Path,
    bytes: impl AsRef<[u8]> + Sync,
    settings: &InputSettings,
) -> Result<Input, Error> {
    let (raw, hash) = rayon::join(|| mesh::parse_mesh(path, bytes.as_ref()), || blake3::hash(bytes.as_ref()));
    drop(bytes);
    let raw = raw?;
    let source = MeshSource {
        file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        format: raw.format.to_string(),
        blake3: hash.to_hex().to_string(),
    };
    let in_file = |error| Error::MeshFile { path: path.to_owned(), source: error };
    cleaned(raw, source, settings).map_err(in_file)
}

/// The same from arrays: places of the vertices, and triangles by the numbers of their vertices, which run
/// counterclockwise seen from outside. `name` stands in the asset instead of a file's.
///
/// # Errors
/// A number of a vertex that isn't there, a coordinate that isn't finite, no triangle; a placement that can't be used.
pub fn from_arrays(
    name: &str,
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    settings: &InputSettings,
) -> Result<Input, Error> {
    let mut faces = Faces::default();
    triangles.iter().for_each(|corners| faces.push(corners));
    let mut hasher = blake3::Hasher::new();
    vertices.iter().flatten().for_each(|x| _ = hasher.update(&x.to_le_bytes()));
    triangles.iter().flatten().for_each(|vertex| _ = hasher.update(&vertex.to_le_bytes()));
    let source = MeshSource {
        file: name.into(),
        format: ARRAYS.into(),
        blake3: hasher.finalize().to_hex().to_string(),
    };
    let raw = RawMesh { positions: vertices.to_vec(), faces, ..RawMesh::new(ARRAYS) };
    Ok(cleaned(raw, source, settings)?)
}

/// The same of a shape, whose closed form is what is baked. Up axis, scale, rotation and translation place it as a
/// mesh.
///
/// # Errors
/// A shape that there isn't, or that isn't one of its kind once it is placed.
pub fn from_shape(shape: Primitive, settings: &InputSettings) -> Result<Input, Error> {
    let placement = Placement { unit: settings.unit.unwrap_or(1.0), ..settings.placement };
    let placed = PlacedPrimitive::new(shape, &placement)?;
    let source = MeshSource {
        file: shape.name().into(),
        format: SHAPE.into(),
        blake3: blake3::hash(shape.to_string().as_bytes()).to_hex().to_string(),
    };
    Ok(Input {
        mesh: placed.mesh()?,
        source,
        cleaning: CleanReport::default(),
        placement,
        weld_tolerance: settings.weld_tolerance,
        coordinate_step: None,
        shape: Some(shape),
        placed_shape: Some(placed),
    })
}

/// The format of a mesh that comes from no file.
const ARRAYS: &str = "arrays";
/// The format of what is no mesh.
pub(crate) const SHAPE: &str = "shape";

fn cleaned(raw: RawMesh, source: MeshSource, settings: &InputSettings) -> Result<Input, MeshError> {
    let unit = settings.unit.or(raw.unit).unwrap_or(1.0);
    let placement = Placement { unit, ..settings.placement };
    let step = coordinate_step(&raw.positions);
    let clean_settings = CleanSettings { weld_tolerance: settings.weld_tolerance };
    let (mut mesh, cleaning) = mesh::clean(raw, &clean_settings)?;
    placement.apply(&mut mesh)?;
    let weld_tolerance = settings.weld_tolerance;
    let scale = placement.scale.into_iter().fold(0.0, |most: f64, scale| most.max(scale.abs()));
    let coordinate_step = step.map(|step| step * unit * scale);
    Ok(Input {
        mesh,
        source,
        cleaning,
        placement,
        weld_tolerance,
        coordinate_step,
        shape: None,
        placed_shape: None,
    })
}

/// Lowest and highest corner of a mesh's box, metres.
pub fn bounds(mesh: &TriangleMesh) -> [DVec3; 2] {
    let points = || mesh.vertices.iter().map(|&v| DVec3::from(v));
    [points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max)]
}
