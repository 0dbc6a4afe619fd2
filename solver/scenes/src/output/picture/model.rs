//! A body's mesh, ready to be drawn: normals at the corners, smooth but for creases, and its sharp edges.

use glam::Vec3;
use std::collections::BTreeMap;
use volmap_figures::raster::{self, Faces, Sides, Triangle, View};
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{DVec3, Pose};

/// Faces that meet at less than this angle, 35 degrees, are one smooth surface; its cosine.
const CREASE: f32 = 0.82;

/// A mesh in its own frame.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// What places are relative to, metres: not zero if they are far from it, as in coordinates of a country.
    pub origin: DVec3,
    /// Places, metres.
    pub vertices: Vec<Vec3>,
    /// Corners of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Normals at them.
    pub normals: Vec<[Vec3; 3]>,
    /// Sharp edges and borders.
    pub edges: Vec<Edge>,
}

/// An edge and the triangles at it.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Ends.
    pub ends: [u32; 2],
    /// Normals of the triangles at it; twice the same at a border.
    pub normals: [Vec3; 2],
}

impl Model {
    /// The model of a mesh. Triangles with corners that don't exist are left out.
    pub fn new(mesh: &TriangleMesh) -> Model {
        let origin = origin(mesh);
        let vertices: Vec<Vec3> =
            mesh.vertices.iter().map(|&p| (DVec3::from(p) - origin).as_vec3()).collect();
        let exists = |t: &&[u32; 3]| t.iter().all(|&corner| (corner as usize) < vertices.len());
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter(exists).copied().collect();
        let areas: Vec<Vec3> = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|corner| vertices[corner as usize]);
                (b - a).cross(c - a)
            })
            .collect();
        let normals = corner_normals(&triangles, &areas, vertices.len());
        let edges = sharp_edges(&triangles, &areas);
        Model { origin, vertices, triangles, normals, edges }
    }

    /// Its triangles that may be seen, at a pose of its [origin](Model::origin); all with this number of a material.
    pub(super) fn project(&self, view: &View, pose: &Pose, sides: Sides, material: u32) -> Vec<Triangle> {
        let place = |&vertex: &Vec3| pose.to_world(vertex.as_dvec3()).as_vec3();
        let places: Vec<Vec3> = self.vertices.iter().map(place).collect();
        let (triangles, normals) = (&self.triangles, &self.normals);
        let faces = Faces { places: &places, triangles, normals, rotation: pose.rotation.as_quat() };
        raster::project(view, &faces, sides, |_| material)
    }
}

/// A mesh so many times its size away from zero has an origin of its own.
const FAR: f64 = 1000.0;

fn origin(mesh: &TriangleMesh) -> DVec3 {
    let places = mesh.vertices.iter().map(|&place| DVec3::from(place)).filter(|place| place.is_finite());
    let around = |[low, high]: [DVec3; 2], place: DVec3| [low.min(place), high.max(place)];
    let [low, high] = places.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], around);
    let middle = 0.5 * (low + high);
    if middle.length() > FAR * (high - low).length() { middle } else { DVec3::ZERO }
}

/// At each corner the mean of the faces around the vertex that aren't beyond a crease.
fn corner_normals(triangles: &[[u32; 3]], areas: &[Vec3], vertices: usize) -> Vec<[Vec3; 3]> {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); vertices];
    for (face, corners) in triangles.iter().enumerate() {
        corners.iter().for_each(|&corner| around[corner as usize].push(face as u32));
    }
    let unit: Vec<Vec3> = areas.iter().map(|area| area.normalize_or_zero()).collect();
    let normal = |face: usize, corner: u32| {
        let smooth = |other: &&u32| unit[**other as usize].dot(unit[face]) > CREASE;
        let sum: Vec3 =
            around[corner as usize].iter().filter(smooth).map(|&other| areas[other as usize]).sum();
        sum.try_normalize().unwrap_or(unit[face])
    };
    triangles.iter().enumerate().map(|(face, corners)| corners.map(|corner| normal(face, corner))).collect()
}

fn sharp_edges(triangles: &[[u32; 3]], areas: &[Vec3]) -> Vec<Edge> {
    let mut faces: BTreeMap<[u32; 2], Vec<Vec3>> = BTreeMap::new();
    for (corners, area) in triangles.iter().zip(areas) {
        for side in 0..3 {
            let mut ends = [corners[side], corners[(side + 1) % 3]];
            ends.sort_unstable();
            faces.entry(ends).or_default().push(area.normalize_or_zero());
        }
    }
    let sharp = |(ends, normals): ([u32; 2], Vec<Vec3>)| match normals[..] {
        [a, b] if a.dot(b) > CREASE => None,
        [a] => Some(Edge { ends, normals: [a, a] }),
        _ => Some(Edge { ends, normals: [normals[0], normals[1]] }),
    };
    faces.into_iter().filter_map(sharp).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubes_have_twelve_edges() {
        let corner = |n: u32| [n & 1, n >> 1 & 1, n >> 2 & 1].map(f64::from);
        let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mut mesh = TriangleMesh { vertices: (0..8).map(corner).collect(), triangles: Vec::new() };
        for [a, b, c, d] in squares {
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        mesh.triangles.push([0, 1, 99]);
        let model = Model::new(&mesh);
        assert_eq!((model.triangles.len(), model.edges.len()), (12, 12));
        for (corners, normals) in model.triangles.iter().zip(&model.normals) {
            let centre: Vec3 = corners.iter().map(|&c| model.vertices[c as usize] - 0.5).sum();
            assert!(
                normals.iter().all(|n| n.dot(centre) > 0.9 && n.max_element().max(-n.min_element()) == 1.0)
            );
        }
    }
}
