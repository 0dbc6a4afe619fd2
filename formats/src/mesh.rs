//! Triangle meshes: one type, whatever the file format.
//!
//! ```text
//! bytes -> RawMesh (polygons as the file has them) -> clean -> TriangleMesh -> Placement
//! ```
//!
//! In two dimensions the surface is an [`Outline`]: lines of an OBJ.
//!
//! Guarantees: what is returned as `Ok` has finite coordinates of at most [`MAX_COORDINATE`] and
//! indices in range; bad input ends in a [`MeshError`], never in a panic, and allocates at most a
//! fixed multiple of the file's real size (see [`budget`]).
//!
//! Not guaranteed: that the mesh is closed, consistently oriented or free of self-intersections.
//! What a reader leaves out is named in [`RawMesh::notes`] and [`RawMesh::skipped`].

use std::fs;
use std::path::{Path, PathBuf};

mod binary;
pub mod budget;
mod clean;
mod error;
mod format;
pub mod guard;
mod outline;
mod raw;
mod skipped;
mod text;
mod transform;

pub use clean::{CleanReport, CleanSettings, clean};
pub use error::MeshError;
pub use format::MeshFormat;
pub use outline::{Outline, parse_outline};
pub use raw::{Faces, MAX_COORDINATE, RawMesh};
pub use skipped::Skipped;
pub use transform::{Placement, Rotation, UpAxis};

/// A triangle mesh, indexed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Positions, in metres once units are applied.
    pub vertices: Vec<[f64; 3]>,
    /// Indices into `vertices`; counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads a mesh file and cleans it: [`read_mesh`], then [`clean`].
///
/// # Errors
/// A [`MeshError`] that names the file.
pub fn load(path: &Path, settings: &CleanSettings) -> Result<(TriangleMesh, CleanReport), MeshError> {
    clean(read_mesh(path)?, settings).map_err(|error| error.in_file(path))
}

/// Reads a mesh file as it is: polygons, duplicates and all.
///
/// The format is the one that the content shows, or else the one that the extension names.
///
/// # Errors
/// A [`MeshError`] that names the file.
pub fn read_mesh(path: &Path) -> Result<RawMesh, MeshError> {
    read_file(path).map_err(|error| error.in_file(path))
}

fn read_file(path: &Path) -> Result<RawMesh, MeshError> {
    parse_file(path, &file_bytes(path)?)
}

/// The bytes of a mesh file, for [`parse_mesh`].
///
/// # Errors
/// [`MeshError::Io`] if it can't be read or isn't a regular file, with the file's name.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, MeshError> {
    file_bytes(path).map_err(|error| error.in_file(path))
}

/// [`read_mesh`], for who has the file's bytes already.
///
/// # Errors
/// A [`MeshError`] that names the file.
pub fn parse_mesh(path: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    parse_file(path, bytes).map_err(|error| error.in_file(path))
}

/// Other files that a mesh file's geometry is in, relative to its folder: the buffers of a glTF. They need not exist.
pub fn references(format: MeshFormat, bytes: &[u8]) -> Vec<PathBuf> {
    guard::contain(format.name(), || Ok(format.references(bytes))).unwrap_or_default()
}

fn file_bytes(path: &Path) -> Result<Vec<u8>, MeshError> {
    let io = |error| MeshError::Io { what: "cannot read the file".into(), error };
    // A FIFO or a device has no size, so nothing would bound what is read.
    if !fs::metadata(path).map_err(io)?.is_file() {
        return Err(MeshError::Io {
            what: "cannot read a mesh here".into(),
            error: std::io::Error::other("not a regular file"),
        });
    }
    fs::read(path).map_err(io)
}

fn parse_file(path: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let format = MeshFormat::detect(path, bytes)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    read(bytes, format, Some(folder))
}

/// Reads a mesh from memory. A glTF file's buffers must be inside it (GLB, or `data:` URIs).
///
/// # Errors
/// A [`MeshError`] that names the place inside the file.
pub fn read_mesh_bytes(bytes: &[u8], format: MeshFormat) -> Result<RawMesh, MeshError> {
    read(bytes, format, None)
}

fn read(bytes: &[u8], format: MeshFormat, folder: Option<&Path>) -> Result<RawMesh, MeshError> {
    let raw = guard::contain(format.name(), || format.read(bytes, folder))?;
    raw.check()?;
    raw.check_not_empty()?;
    Ok(raw)
}
