//! The bodies' surfaces, written once: with the poses of the frames they are the bodies at any time.

use crate::error::Error;
use std::path::Path;
use volmap_bake::iso_surface::iso_surface;
use volmap_formats::export::ply;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::VolumeMap;

/// The surface Phi = 0 of a map, for a body whose mesh is not at hand.
///
/// # Errors
/// A surface too large for memory.
pub fn surface_of_map(map: &VolumeMap) -> Result<TriangleMesh, Error> {
    let surface = iso_surface(map, 0.0, None, &Default::default())?;
    Ok(TriangleMesh { vertices: surface.vertices, triangles: surface.triangles })
}

/// Writes a body's mesh into a folder, and returns the file's name, which its number makes unique.
///
/// # Errors
/// A file that can't be written.
pub fn write_mesh(folder: &Path, number: usize, name: &str, mesh: &TriangleMesh) -> Result<String, Error> {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let file = format!("{number:02}_{}.ply", name.chars().take(60).map(plain).collect::<String>());
    let comment = "volmap, a body in its own frame";
    ply::write(&folder.join(&file), &mesh.vertices, &mesh.triangles, comment)?;
    Ok(file)
}
