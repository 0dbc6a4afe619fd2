//! A triangle mesh as binary PLY, coordinates in double precision.
//! Turk 1994, *The PLY Polygon File Format*.

use super::{ExportError, publish_to};
use std::path::Path;

/// Writes a mesh. The comment, of one line, goes into the header.
///
/// # Errors
/// A file that can't be written.
pub fn write(
    path: &Path,
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    comment: &str,
) -> Result<(), ExportError> {
    publish_to(path, &to_bytes(vertices, triangles, comment))
}

fn to_bytes(vertices: &[[f64; 3]], triangles: &[[u32; 3]], comment: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {comment}\nelement vertex {}\nproperty double x\n\
         property double y\nproperty double z\nelement face {}\nproperty list uchar uint vertex_indices\n\
         end_header\n",
        vertices.len(),
        triangles.len()
    );
    let mut bytes = Vec::with_capacity(header.len() + 24 * vertices.len() + 13 * triangles.len());
    bytes.extend(header.as_bytes());
    bytes.extend(vertices.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    for triangle in triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    bytes
}

#[cfg(all(test, feature = "mesh"))]
mod tests {
    use super::*;
    use crate::mesh::{MeshFormat, read_mesh_bytes};

    #[test]
    fn what_is_written_is_read() {
        let vertices = [[0.1, 0.2, 0.3], [1e-9, 2.0, 0.0], [3.0, -0.0, 1.0], [1.0, 1.0, 1.0]];
        let triangles = [[0, 1, 2], [2, 1, 3]];
        let mesh = read_mesh_bytes(&to_bytes(&vertices, &triangles, "a comment"), MeshFormat::Ply).unwrap();
        assert_eq!(mesh.positions, vertices);
        let faces: Vec<&[u32]> = mesh.faces.iter().collect();
        assert_eq!(faces, triangles.each_ref().map(|t| t.as_slice()));
    }
}
