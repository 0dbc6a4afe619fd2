//! A solid that is filled, and how deep points are in it.

use std::sync::Arc;
use volmap_bake::sdf::{BoundaryDistance, SignedDistance};
use volmap_formats::asset::Exterior;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{DVec3, PosedMap};

/// A solid that is filled.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Its map, placed.
    pub map: PosedMap,
    /// Its mesh in the map's frame, if there is one. It is more exact than the map in the corners of a box, where
    /// particles must fit.
    pub mesh: Option<BoundaryDistance>,
    /// The mesh itself, in the map's frame.
    pub surface: Option<Arc<TriangleMesh>>,
    /// Offset of the map's surface from the mesh, out of the solid, metres.
    pub thickness: f64,
}

impl Solid {
    /// A box around its map's grid, metres.
    pub fn bounds(&self) -> [DVec3; 2] {
        let (middle, half) = self.middle_and_half();
        [middle - half, middle + half]
    }

    /// Its middle and half of its edges, metres.
    pub fn middle_and_half(&self) -> (DVec3, DVec3) {
        let grid = self.map.map.grid();
        let [low, high] = [grid.origin, grid.max_corner()];
        let turned = |axis: DVec3| (self.map.pose.rotation * (axis * (high - low))).abs();
        let half = 0.5 * (turned(DVec3::X) + turned(DVec3::Y) + turned(DVec3::Z));
        (self.map.pose.to_world(0.5 * (low + high)), half)
    }
}

/// How deep a point is in the space that is filled, metres; `distance` is the map's, which is taken where the mesh is
/// farther than 2 rp.
pub(super) fn depth_in(solid: &Solid, point: DVec3, distance: f64, rp: f64) -> f64 {
    let side = if solid.map.map.exterior() == Exterior::Solid { 1.0 } else { -1.0 };
    let depth = side * distance;
    match &solid.mesh {
        Some(mesh) if depth.abs() < 2.0 * rp => {
            // Inside the mesh is the solid, or the hollow of a container: both are filled.
            -mesh.at(solid.map.pose.to_map(point)) - side * solid.thickness
        }
        _ => depth,
    }
}
