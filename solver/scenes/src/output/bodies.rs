//! The bodies' surfaces, written once. With the poses of the frames they give the bodies at any time.

use crate::error::Error;
use std::path::Path;
use std::sync::Arc;
use volmap_bake::iso_surface::iso_surface;
use volmap_formats::export::ply;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::VolumeMap;

/// A body's surface.
#[derive(Clone, Debug)]
pub struct BodyMesh {
    /// The body's name.
    pub name: String,
    /// Its mesh in its own frame, metres.
    pub mesh: Arc<TriangleMesh>,
}

/// The surface Phi = 0 of a map, for a body that was given as a map.
///
/// # Errors
/// A surface too large for memory.
pub fn surface_of_map(map: &VolumeMap) -> Result<TriangleMesh, Error> {
    let surface = iso_surface(map, 0.0, None, &Default::default())?;
    Ok(TriangleMesh { vertices: surface.vertices, triangles: surface.triangles })
}

/// Writes a body's mesh into a folder, and returns the file's name. The number makes it unique.
///
/// # Errors
/// A file that can't be written.
pub fn write_mesh(folder: &Path, number: usize, body: &BodyMesh) -> Result<String, Error> {
    let BodyMesh { name, mesh } = body;
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let file = format!("{number:02}_{}.ply", name.chars().take(60).map(plain).collect::<String>());
    let comment = "volmap, a body in its own frame";
    ply::write(&folder.join(&file), &mesh.vertices, &mesh.triangles, comment)?;
    Ok(file)
}
