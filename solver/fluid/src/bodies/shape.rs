//! What bodies touch each other with: the convex hull where that is the body, convex parts for other free
//! bodies (Mamou and Ghorbel 2009, *A Simple and Efficient Approach for 3D Mesh Approximate Convex
//! Decomposition*), the surface itself for those that forces don't move.

use super::description::BodyDescription;
use rapier3d_f64::math::Pose;
use rapier3d_f64::parry::shape::ConvexPolyhedron;
use rapier3d_f64::parry::transformation::vhacd::{VHACD, VHACDParameters};
use rapier3d_f64::prelude::{SharedShape, TriMesh, TriMeshFlags};
use std::collections::HashMap;
use std::sync::Arc;
use volmap_bake::iso_surface::{iso_surface, lattice::LatticeChoice};
use volmap_formats::asset::Exterior;
use volmap_formats::mesh::{TriangleMesh, guard};
use volmap_runtime::{DVec3, Dimension, VolumeMap};

/// A hull that is larger than the body by this part of it is the body.
const CONVEX: f64 = 0.01;
/// Voxels along the longest edge of a body that is split into convex parts.
const VOXELS: u32 = 32;
/// Points of a hull at most; a contact looks through all of them.
const HULL_POINTS: usize = 256;
/// A hull of a map's surface may lack this part of its size anywhere.
const PLAIN: f64 = 5e-4;

/// Shapes that were made already, by the address of their mesh or map: bodies with the same one share it.
#[derive(Default)]
pub(super) struct Shapes {
    made: HashMap<(usize, bool, bool), SharedShape>,
}

impl Shapes {
    /// The shape of a body.
    pub fn get(&mut self, body: &BodyDescription, is_free: bool) -> Result<SharedShape, String> {
        let address = match &body.mesh {
            Some(mesh) => Arc::as_ptr(mesh).addr(),
            None => Arc::as_ptr(&body.map).addr(),
        };
        let key = (address, is_free, body.map.exterior() == Exterior::Solid);
        if let Some(shape) = self.made.get(&key) {
            return Ok(shape.clone());
        }
        let shape = make(body, is_free)?;
        self.made.insert(key, shape.clone());
        Ok(shape)
    }
}

fn make(body: &BodyDescription, is_free: bool) -> Result<SharedShape, String> {
    let hull_of: Hull = if body.mesh.is_some() { hull } else { plain_hull };
    let mut mesh = match &body.mesh {
        // An inverted map's own surface is turned already.
        Some(mesh) if body.map.exterior() == Exterior::Solid => turned(mesh),
        Some(mesh) => (**mesh).clone(),
        None => mesh_of_map(&body.map)?,
    };
    mesh.triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    // Meshes are checked, but what a library does with an odd one is not.
    guard::quietly(|| if is_free { convex_parts(&mesh, hull_of) } else { surface(&mesh) })
        .unwrap_or_else(Err)
        .map_err(|reason| format!("no collision shape can be made of its mesh: {reason}"))
}

fn turned(mesh: &TriangleMesh) -> TriangleMesh {
    let triangles = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    TriangleMesh { vertices: mesh.vertices.clone(), triangles }
}

/// The surface of the map, from the corners of its cells.
fn mesh_of_map(map: &VolumeMap) -> Result<TriangleMesh, String> {
    if map.dimension() == Dimension::Two {
        return Err("its map is in two dimensions; give it a mesh to touch other bodies with".into());
    }
    let resolution = LatticeChoice::Resolution(map.finest_grid(super::MOST_CELLS).resolution.to_array());
    let surface =
        iso_surface(map, 0.0, Some(resolution), &Default::default()).map_err(|error| error.to_string())?;
    match surface.triangles.is_empty() {
        true => Err("its map has no surface".into()),
        false => Ok(TriangleMesh { vertices: surface.vertices, triangles: surface.triangles }),
    }
}

fn points(mesh: &TriangleMesh) -> Vec<DVec3> {
    mesh.vertices.iter().map(|&vertex| vertex.into()).collect()
}

/// The surface, of which only the outside repels.
fn surface(mesh: &TriangleMesh) -> Result<SharedShape, String> {
    let flags = TriMeshFlags::ORIENTED | TriMeshFlags::FIX_INTERNAL_EDGES;
    let made = TriMesh::with_flags(points(mesh), mesh.triangles.clone(), flags);
    made.map(SharedShape::new).map_err(|error| error.to_string())
}

/// A convex hull of points, if they aren't in one plane.
type Hull = fn(&[DVec3]) -> Option<ConvexPolyhedron>;

/// The hull, or several of parts.
fn convex_parts(mesh: &TriangleMesh, hull_of: Hull) -> Result<SharedShape, String> {
    let points = points(mesh);
    let volume = volume(&points, &mesh.triangles);
    let hull = hull_of(&points).ok_or("it is flat")?;
    if hull_volume(&hull) <= (1.0 + CONVEX) * volume {
        return Ok(SharedShape::new(hull));
    }
    let parameters = VHACDParameters { resolution: VOXELS, ..VHACDParameters::default() };
    let split = VHACD::decompose(&parameters, &points, &mesh.triangles, true);
    let parts = split.compute_exact_convex_hulls(&points, &mesh.triangles);
    let parts: Vec<_> = parts.iter().filter_map(|(points, _)| hull_of(points)).collect();
    match parts.is_empty() {
        true => Err("it has no convex parts".into()),
        false => Ok(SharedShape::compound(
            parts.into_iter().map(|part| (Pose::IDENTITY, SharedShape::new(part))).collect(),
        )),
    }
}

/// The convex hull, of no more than [`HULL_POINTS`] points: those that are farthest in equally spread
/// directions.
fn hull(points: &[DVec3]) -> Option<ConvexPolyhedron> {
    let hull = ConvexPolyhedron::from_convex_hull(points)?;
    if hull.points().len() <= HULL_POINTS {
        return Some(hull);
    }
    let mut is_kept = vec![false; hull.points().len()];
    for direction in directions() {
        let far = |at: &usize| hull.points()[*at].dot(direction);
        let farthest = (0..is_kept.len()).max_by(|a, b| far(a).total_cmp(&far(b)))?;
        is_kept[farthest] = true;
    }
    let kept: Vec<DVec3> = hull.points().iter().zip(is_kept).filter(|(_, k)| *k).map(|(p, _)| *p).collect();
    ConvexPolyhedron::from_convex_hull(&kept)
}

/// The convex hull but for [`PLAIN`], of as few points as do: those that are farthest out of the hull so far. A surface
/// of a map has points all over its faces and edges, and rapier lets a body stand on four corners of a face at most.
fn plain_hull(points: &[DVec3]) -> Option<ConvexPolyhedron> {
    let all = ConvexPolyhedron::from_convex_hull(points)?;
    let points = all.points();
    let farthest = |direction: DVec3| {
        points.iter().copied().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
    };
    let corner = |n: u32| DVec3::new((n & 1).into(), (n >> 1 & 1).into(), (n >> 2 & 1).into()) - 0.5;
    let mut kept: Vec<DVec3> = Vec::new();
    for point in (0..8).filter_map(|n| farthest(corner(n))) {
        if !kept.contains(&point) {
            kept.push(point);
        }
    }
    let size = points.iter().map(|point| point.distance(points[0])).fold(0.0, f64::max);
    loop {
        // Flat so far, where the corners of a box around it see one face.
        let Some(hull) = ConvexPolyhedron::from_convex_hull(&kept) else { return Some(all) };
        let planes = planes(&hull);
        let outside = |point: &DVec3| {
            planes.iter().map(|(normal, on)| normal.dot(*point - *on)).fold(f64::NEG_INFINITY, f64::max)
        };
        let next = points.iter().map(|point| (outside(point), *point)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        if next.0 <= PLAIN * size || kept.len() == HULL_POINTS || kept.contains(&next.1) {
            return Some(hull);
        }
        kept.push(next.1);
    }
}

/// The planes of a hull's triangles: normals outwards, of length 1, and a point each.
fn planes(hull: &ConvexPolyhedron) -> Vec<(DVec3, DVec3)> {
    let (points, triangles) = hull.to_trimesh();
    let plane = |&[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|v| points[v as usize]);
        Some(((b - a).cross(c - a).try_normalize()?, a))
    };
    triangles.iter().filter_map(plane).collect()
}

/// The axes, then Fibonacci's lattice on the sphere: Swinbank and Purser 2006.
fn directions() -> impl Iterator<Item = DVec3> {
    let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let count = HULL_POINTS - 6;
    axes.chain((0..count).map(move |n| {
        let z = 1.0 - (2.0 * n as f64 + 1.0) / count as f64;
        let turn = DVec3::new(1.0, 0.0, 0.0).rotate_z(n as f64 * GOLDEN_ANGLE);
        turn * (1.0 - z * z).sqrt() + DVec3::Z * z
    }))
}

/// Radians.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

fn volume(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let at = |v: u32| points[v as usize] - points[0];
    triangles.iter().map(|&[a, b, c]| at(a).cross(at(b)).dot(at(c)) / 6.0).sum()
}

fn hull_volume(hull: &ConvexPolyhedron) -> f64 {
    let (points, triangles) = hull.to_trimesh();
    volume(&points, &triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use volmap_bake::input::{InputSettings, load};

    fn mesh(vertices: &[DVec3]) -> TriangleMesh {
        let (points, triangles) = ConvexPolyhedron::from_convex_hull(vertices).unwrap().to_trimesh();
        TriangleMesh { vertices: points.iter().map(|p| p.to_array()).collect(), triangles }
    }

    fn block(size: DVec3, at: DVec3) -> TriangleMesh {
        let corner = |n: u32| DVec3::new((n & 1).into(), (n >> 1 & 1).into(), (n >> 2 & 1).into());
        mesh(&(0..8).map(|n| at + size * (corner(n) - 0.5)).collect::<Vec<_>>())
    }

    /// Volumes of a shape's convex parts.
    fn volumes(shape: &SharedShape) -> Vec<f64> {
        let parts = match shape.as_compound() {
            Some(compound) => compound.shapes().iter().map(|(_, part)| part.clone()).collect(),
            None => vec![shape.clone()],
        };
        parts.iter().map(|part| hull_volume(part.as_convex_polyhedron().unwrap())).collect()
    }

    #[test]
    fn convex_bodies_are_their_hull() {
        let size = DVec3::new(0.3, 1.0, 2.0);
        let shape = convex_parts(&block(size, DVec3::ONE), hull).unwrap();
        let [volume] = volumes(&shape)[..] else { panic!("more than one part") };
        assert!((volume - 0.6).abs() < 1e-12);
    }

    #[test]
    fn hulls_of_many_points_keep_the_axes_ends() {
        let golden = |n: f64| {
            let z = (2.0 * n + 1.0) / 4000.0 - 1.0;
            DVec3::X.rotate_z(n * GOLDEN_ANGLE) * (1.0 - z * z).sqrt() + DVec3::Z * z
        };
        let mut points: Vec<_> = (0..4000).map(|n| golden(f64::from(n))).collect();
        points.extend(DVec3::AXES);
        let hull = hull(&points).unwrap();
        assert!(hull.points().len() <= HULL_POINTS);
        assert!(hull_volume(&hull) > 0.96 * volume(&points, &mesh(&points).triangles));
        assert!(DVec3::AXES.iter().all(|axis| hull.points().contains(axis)));
    }

    /// A cube with points all over its faces and edges: its corners alone. A ball: near its radius everywhere.
    #[test]
    fn plain_hulls_have_few_points() {
        let steps = (0..9 * 9 * 9).map(|n| [n % 9, n / 9 % 9, n / 81].map(|n| f64::from(n) / 8.0 - 0.5));
        let noise = |n: f64| 1e-9 * (1e4 * n).sin();
        let points: Vec<DVec3> = steps.map(|at| DVec3::from(at.map(|x| x + noise(x + at[1])))).collect();
        let cube = plain_hull(&points).unwrap();
        assert_eq!(cube.points().len(), 8);
        assert!((hull_volume(&cube) - 1.0).abs() < 1e-7);
        let on_ball = |n: f64| {
            let z = (2.0 * n + 1.0) / 4000.0 - 1.0;
            DVec3::X.rotate_z(n * GOLDEN_ANGLE) * (1.0 - z * z).sqrt() + DVec3::Z * z
        };
        let points: Vec<DVec3> = (0..4000).map(|n| on_ball(f64::from(n))).collect();
        let ball = plain_hull(&points).unwrap();
        assert!(ball.points().len() <= HULL_POINTS);
        let planes = planes(&ball);
        let nearest = planes.iter().map(|(normal, on)| normal.dot(*on)).fold(f64::INFINITY, f64::min);
        assert!(nearest > 0.97, "{nearest}");
    }

    #[test]
    fn hollows_stay_open() {
        // An L of three cubes.
        let mut l = block(DVec3::new(2.0, 1.0, 1.0), DVec3::new(1.0, 0.5, 0.5));
        let arm = block(DVec3::ONE, DVec3::new(0.5, 1.5, 0.5));
        let count = l.vertices.len() as u32;
        l.triangles.extend(arm.triangles.iter().map(|t| t.map(|v| v + count)));
        l.vertices.extend(arm.vertices);
        let shape = convex_parts(&l, hull).unwrap();
        assert!(volumes(&shape).len() > 1);
        let hollow = rapier3d_f64::prelude::Ball::new(0.3);
        let at = Pose::from_translation(DVec3::new(1.6, 1.6, 0.5));
        let touch =
            rapier3d_f64::parry::query::intersection_test(&Pose::IDENTITY, &*shape.0, &at, &hollow).unwrap();
        assert!(!touch.intersecting, "the hollow is filled");
    }

    #[test]
    fn parts_of_a_duck_fill_it() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/duck.obj");
        let duck = load(&path, &InputSettings::default()).unwrap().mesh;
        let shape = convex_parts(&duck, hull).unwrap();
        let volumes = volumes(&shape);
        assert!((2..40).contains(&volumes.len()), "{} parts", volumes.len());
        let filled = volumes.iter().sum::<f64>() / 0.8309;
        assert!((0.95..1.10).contains(&filled), "{filled} of its volume");
        let largest = volumes.iter().fold(0.0f64, |a, &b| a.max(b));
        assert!(largest < 0.8, "{largest}");
    }
}
