//! Angle-weighted pseudonormals: which side of the surface a point is on.
//!
//! Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted pseudonormal".
//! With the closest point c on a vertex or an edge, the normal of one adjacent face can give the wrong
//! side; the sum of all adjacent unit normals, at a vertex weighted by the face's angle there, never
//! does. This holds for closed, consistently oriented surfaces that don't intersect themselves.

use glam::DVec3;

use crate::mesh::topology::{Neighbour, Topology};
use crate::sdf::closest_point::{Closest, Feature};

/// |cos| of the angle between pseudonormal and offset below which rounding could turn the sign.
const UNSURE_COSINE: f64 = 1e-4;

/// Pseudonormals of all features; edges' are summed when asked for.
#[derive(Clone, Debug)]
pub struct Pseudonormals {
    faces: Vec<DVec3>,
    vertices: Vec<DVec3>,
    /// The face across each of a face's edges.
    neighbours: Vec<[Neighbour; 3]>,
}

impl Pseudonormals {
    /// Normals of a mesh and its topology.
    pub fn new(vertices: &[DVec3], triangles: &[[u32; 3]], topology: &Topology) -> Pseudonormals {
        let mut faces = Vec::with_capacity(triangles.len());
        let mut sums = vec![DVec3::ZERO; vertices.len()];
        for triangle in triangles {
            let corners = triangle.map(|v| vertices[v as usize]);
            let normal = unit_normal(&corners);
            faces.push(normal);
            for (i, &v) in triangle.iter().enumerate() {
                sums[v as usize] += normal * corner_angle(&corners, i);
            }
        }
        Pseudonormals { faces, vertices: sums, neighbours: topology.neighbours().to_vec() }
    }

    /// Pseudonormal of the feature on which `closest` lies; not of unit length.
    pub fn at(&self, closest: &Closest, triangles: &[[u32; 3]]) -> DVec3 {
        let face = closest.triangle as usize;
        match closest.feature {
            Feature::Face => self.faces[face],
            Feature::Edge(i) => match self.neighbours[face][i as usize].face() {
                None => self.faces[face],
                Some(other) => self.faces[face] + self.faces[other],
            },
            Feature::Vertex(i) => self.vertices[triangles[face][i as usize] as usize],
        }
    }

    /// True inside, false outside; none where offset and pseudonormal are so close to perpendicular
    /// that rounding could decide, as at needle-sharp edges and points.
    pub fn inside(&self, p: DVec3, closest: &Closest, triangles: &[[u32; 3]]) -> Option<bool> {
        let normal = self.at(closest, triangles);
        let offset = p - closest.point;
        let cosine = offset.dot(normal) / (offset.length() * normal.length());
        (cosine.abs() > UNSURE_COSINE).then_some(cosine < 0.0)
    }
}

/// Unit normal; zero for a triangle without area.
fn unit_normal(corners: &[DVec3; 3]) -> DVec3 {
    let [a, b, c] = *corners;
    (b - a).cross(c - a).normalize_or_zero()
}

/// Angle of the triangle at corner i.
fn corner_angle(corners: &[DVec3; 3], i: usize) -> f64 {
    let to_next = corners[(i + 1) % 3] - corners[i];
    let to_last = corners[(i + 2) % 3] - corners[i];
    to_next.cross(to_last).length().atan2(to_next.dot(to_last))
}
