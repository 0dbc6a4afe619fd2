//! Signed distance to a mesh: closest point and side.

use glam::DVec3;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::diagnosis::Diagnosis;
use crate::mesh::topology::Topology;
use crate::sdf::bvh::Bvh;
use crate::sdf::closest_point::{Closest, closest_point_on_triangle};
use crate::sdf::pseudonormal::Pseudonormals;
use crate::sdf::sign::{SignChoice, SignMethod, choose_sign};
use crate::sdf::winding::WindingNumbers;

/// A mesh, ready for queries from any number of threads.
#[derive(Clone, Debug)]
pub struct MeshDistance {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    bvh: Bvh,
    pseudonormals: Pseudonormals,
    winding: WindingNumbers,
    choice: SignChoice,
    balanced: bool,
}

/// A point where the signed distance is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownDistance {
    /// The point.
    pub point: DVec3,
    /// Its distance, negative inside.
    pub signed_distance: f64,
}

impl MeshDistance {
    /// Prepares a mesh of at least one triangle with finite coordinates and valid indices (panics
    /// otherwise), and its diagnosis, which decides where `sign` is `Auto`.
    pub fn new(mesh: &TriangleMesh, sign: SignMethod, diagnosis: &Diagnosis) -> MeshDistance {
        let vertices: Vec<DVec3> = mesh.vertices.iter().map(|&v| DVec3::from(v)).collect();
        let corners: Vec<[DVec3; 3]> =
            mesh.triangles.iter().map(|triangle| triangle.map(|v| vertices[v as usize])).collect();
        let topology = Topology::new(mesh);
        let bvh = Bvh::new(&corners);
        let choice = match sign {
            SignMethod::Auto => choose_sign(diagnosis),
            method => SignChoice { method, reason: "as asked for".to_string() },
        };
        MeshDistance {
            pseudonormals: Pseudonormals::new(&vertices, &mesh.triangles, &topology),
            winding: WindingNumbers::new(&bvh),
            triangles: mesh.triangles.clone(),
            vertices,
            bvh,
            choice,
            balanced: diagnosis.balanced,
        }
    }

    /// The sign in use, and why.
    pub fn sign_choice(&self) -> &SignChoice {
        &self.choice
    }

    /// Closest point of the mesh.
    pub fn closest(&self, p: DVec3) -> Closest {
        self.closest_within(p, f64::INFINITY)
    }

    /// `closest`, faster where a distance is known that will not be exceeded.
    pub fn closest_within(&self, p: DVec3, upper_bound: f64) -> Closest {
        let triangle = self.bvh.closest_triangle(p, upper_bound).triangle;
        let corners = self.triangles[triangle as usize].map(|v| self.vertices[v as usize]);
        let found = closest_point_on_triangle(p, &corners);
        Closest {
            distance_squared: found.distance_squared,
            point: found.point,
            triangle,
            feature: found.feature,
        }
    }

    /// Distance to the mesh, 0 or more.
    pub fn unsigned_distance(&self, p: DVec3) -> f64 {
        self.closest(p).distance_squared.sqrt()
    }

    /// Distance to the mesh, negative inside.
    pub fn signed_distance(&self, p: DVec3) -> f64 {
        let closest = self.closest(p);
        let distance = closest.distance_squared.sqrt();
        if self.inside(p, &closest) { -distance } else { distance }
    }

    /// `signed_distance`, faster where it is `known` at a point not far away. Distance changes by no more
    /// than the way between the points; and where that is shorter than the distance itself, there is no
    /// surface between them, so that a mesh with integer winding numbers has one side there. The result
    /// is the same whatever is known.
    pub fn signed_distance_near(&self, p: DVec3, known: &KnownDistance) -> f64 {
        let way = p.distance(known.point);
        let known_distance = known.signed_distance.abs();
        let closest = self.closest_within(p, known_distance + way);
        let distance = closest.distance_squared.sqrt();
        let carries = self.balanced && self.choice.method != SignMethod::Pseudonormal;
        let same_side = carries && way < known_distance * (1.0 - 1e-9);
        let inside = if same_side { known.signed_distance < 0.0 } else { self.inside(p, &closest) };
        if inside { -distance } else { distance }
    }

    /// -1 inside, 1 outside.
    pub fn sign(&self, p: DVec3) -> f64 {
        let inside = match self.choice.method {
            SignMethod::Pseudonormal => self.inside_by_pseudonormal(p, &self.closest(p)),
            _ => self.inside_by_winding(p),
        };
        if inside { -1.0 } else { 1.0 }
    }

    fn inside(&self, p: DVec3, closest: &Closest) -> bool {
        match self.choice.method {
            SignMethod::Pseudonormal => self.inside_by_pseudonormal(p, closest),
            _ => self.inside_by_winding(p),
        }
    }

    /// Side of the surface by the pseudonormal at the closest point; by the winding number where that
    /// is too close to call.
    pub fn inside_by_pseudonormal(&self, p: DVec3, closest: &Closest) -> bool {
        self.pseudonormals.inside(p, closest, &self.triangles).unwrap_or_else(|| self.inside_by_winding(p))
    }

    /// Inside where the winding number is above one half.
    pub fn inside_by_winding(&self, p: DVec3) -> bool {
        self.winding.inside(&self.bvh, p, self.balanced)
    }

    /// Winding number around `p`, by all triangles.
    pub fn winding_number(&self, p: DVec3) -> f64 {
        WindingNumbers::exact(&self.bvh, p)
    }
}
