//! A box to be baked inverted, as the container of a dam break (Bender et al. 2020, Fig. 15).

use glam::DVec3;

use crate::mesh::Mesh;

/// Edge length, m.
pub const SIZE: f64 = 3.1;

/// A cube of 12 triangles that face outwards, standing on y = 0, centred in x and z.
pub fn tank() -> Mesh {
    let mut mesh = Mesh::default();
    for corner in 0..8_u8 {
        let bit = |axis: u8| f64::from(corner >> axis & 1);
        mesh.push(DVec3::new(bit(0) - 0.5, bit(1), bit(2) - 0.5) * SIZE);
    }
    for quad in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
        mesh.push_quad(quad);
    }
    mesh
}
