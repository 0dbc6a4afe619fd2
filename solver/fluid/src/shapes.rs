//! Bodies from meshes made in memory, which are baked as a boundary method needs them.

use crate::bodies::{BodyDescription, ContactMaterial, FluidContact, Motion};
use crate::error::Error;
use std::collections::BTreeMap;
use std::sync::Arc;
use volmap_bake::bake::{Bake, BakeSettings, bake};
use volmap_bake::input::{Input, MeshSource};
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_bake::settings::Tolerances;
use volmap_formats::mesh::{CleanReport, Placement, TriangleMesh};
use volmap_runtime::{ClosureKind, DVec3, MapErrors, Pose, VolumeMap};

/// A mesh and its map.
#[derive(Clone, Debug)]
pub struct Shape {
    /// The mesh; of a container that of its hollow, triangles outwards.
    pub mesh: Arc<TriangleMesh>,
    /// The map.
    pub map: Arc<VolumeMap>,
}

/// A mesh baked for the default closure and a kernel's support radius (metres), as scenes do; of a container the
/// solid is outside.
///
/// # Errors
/// As [`bake`].
pub fn baked(mesh: TriangleMesh, support_radius: f64, container: bool) -> Result<Shape, Error> {
    baked_for(ClosureKind::Mirror, mesh, support_radius, container)
}

/// The same for another closure.
///
/// # Errors
/// As [`bake`].
pub fn baked_for(
    closure: ClosureKind,
    mesh: TriangleMesh,
    support_radius: f64,
    container: bool,
) -> Result<Shape, Error> {
    let (radius, cell_size) = (closure.map_radius(support_radius), closure.cell_size(support_radius));
    baked_finely(mesh, radius, cell_size, container)
}

/// The same with cells of several sizes, as exact as the closure needs: what scenes take for large bodies and those that
/// turn.
///
/// # Errors
/// As [`bake`].
pub fn baked_adaptively(
    closure: ClosureKind,
    mesh: TriangleMesh,
    support_radius: f64,
    container: bool,
) -> Result<Shape, Error> {
    let MapErrors { volume, distance } = closure.map_errors();
    let map = MapSettings {
        support_radius: Some(closure.map_radius(support_radius)),
        grid: GridChoice::Tolerance(Tolerances { volume, distance, normal: None }),
        invert: container,
        ..MapSettings::default()
    };
    baked_by(mesh, map)
}

/// The same with cells of another size, metres, for the map's own support radius.
///
/// # Errors
/// As [`bake`].
pub fn baked_finely(
    mesh: TriangleMesh,
    support_radius: f64,
    cell_size: f64,
    container: bool,
) -> Result<Shape, Error> {
    let map = MapSettings {
        support_radius: Some(support_radius),
        grid: GridChoice::CellSize(cell_size),
        invert: container,
        ..MapSettings::default()
    };
    baked_by(mesh, map)
}

/// The same by any settings of the baker.
///
/// # Errors
/// As [`bake`].
pub fn baked_by(mesh: TriangleMesh, map: MapSettings) -> Result<Shape, Error> {
    let asset = bake_made(mesh.clone(), map)?.asset;
    Ok(Shape { mesh: Arc::new(mesh), map: Arc::new(VolumeMap::from_asset(&asset)?) })
}

/// All that the baker says of a mesh made in memory.
///
/// # Errors
/// As [`bake`].
pub fn bake_made(mesh: TriangleMesh, map: MapSettings) -> Result<Bake, Error> {
    let input = Input {
        mesh,
        source: MeshSource { file: "made".into(), format: "none".into(), blake3: String::new() },
        cleaning: CleanReport::default(),
        placement: Placement::default(),
        weld_tolerance: 0.0,
        coordinate_step: None,
        shape: None,
        placed_shape: None,
    };
    let settings = BakeSettings { map, ..BakeSettings::default() };
    Ok(bake(input, &settings, &Default::default())?)
}

/// A box between two corners.
pub fn cuboid(min: DVec3, max: DVec3) -> TriangleMesh {
    let corner = |n: u32| {
        let side = DVec3::new((n & 1).into(), (n >> 1 & 1).into(), (n >> 2 & 1).into());
        (min + (max - min) * side).to_array()
    };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// A ball around the origin: an octahedron whose triangles are cut in four `levels` times (5: 8,192 triangles).
pub fn ball(radius: f64, levels: u32) -> TriangleMesh {
    let mut points = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let quarters = |&[a, b, c]: &[u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(quarters).collect();
    }
    let vertices = points.iter().map(|&point| (radius * point).to_array()).collect();
    TriangleMesh { vertices, triangles }
}

/// Volume of a closed mesh, m^3.
pub fn volume(mesh: &TriangleMesh) -> f64 {
    let at = |n: u32| DVec3::from(mesh.vertices[n as usize]);
    mesh.triangles.iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c))) / 6.0).sum()
}

impl Shape {
    /// A body of this shape, unturned, with its origin at `at`.
    pub fn body(&self, name: &str, at: DVec3, motion: Motion) -> BodyDescription {
        BodyDescription {
            name: name.into(),
            map: self.map.clone(),
            mesh: Some(self.mesh.clone()),
            pose: Pose { translation: at, ..Pose::default() },
            motion,
            material: ContactMaterial::default(),
            fluid_contact: FluidContact::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_closed_and_face_outwards() {
        let cube = cuboid(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 3.0, 2.5));
        assert!((volume(&cube) - 3.0).abs() < 1e-12);
        let sphere = ball(2.0, 5);
        assert_eq!(sphere.triangles.len(), 8192);
        assert_eq!(sphere.vertices.len(), 4098);
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
        assert!((volume(&sphere) / exact - 1.0).abs() < 2e-3);
    }
}
