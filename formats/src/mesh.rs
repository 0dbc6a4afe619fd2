//! Triangle meshes: one type, whatever the file format.

/// A triangle mesh, indexed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Positions, in metres once units are applied.
    pub vertices: Vec<[f64; 3]>,
    /// Indices into `vertices`; counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}
