//! Signed distance to a mesh: closest point and side.

use glam::DVec3;
use std::sync::OnceLock;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::diagnosis::Diagnosis;
use crate::mesh::topology::Topology;
use crate::sdf::bvh::Bvh;
use crate::sdf::closest_point::Closest;
use crate::sdf::pseudonormal::Pseudonormals;
use crate::sdf::sign::{SignChoice, SignMethod, choose_sign};
use crate::sdf::winding::WindingNumbers;

/// A mesh, ready for queries from any number of threads.
#[derive(Clone, Debug)]
pub struct MeshDistance {
    mesh: TriangleMesh,
    bvh: Bvh,
    /// Made when first asked for.
    pseudonormals: OnceLock<Pseudonormals>,
    winding: WindingNumbers,
    choice: SignChoice,
    balanced: bool,
}

/// A point where the distance is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownDistance {
    /// The point.
    pub point: DVec3,
    /// Its distance, 0 or more.
    pub distance: f64,
    /// The point of the mesh that is closest to it.
    pub surface: DVec3,
    /// Its side, if that was asked for or followed.
    pub inside: Option<bool>,
}

impl MeshDistance {
    /// Prepares a mesh of at least one triangle with finite coordinates and valid indices (panics
    /// otherwise), and its diagnosis, which decides where `sign` is `Auto`.
    pub fn new(mesh: &TriangleMesh, sign: SignMethod, diagnosis: &Diagnosis) -> MeshDistance {
        let corner = |v: u32| DVec3::from(mesh.vertices[v as usize]);
        let corners: Vec<[DVec3; 3]> = mesh.triangles.iter().map(|triangle| triangle.map(corner)).collect();
        let bvh = Bvh::new(&corners);
        let choice = match sign {
            SignMethod::Auto => choose_sign(diagnosis),
            method => SignChoice { method, reason: "as asked for".to_string() },
        };
        MeshDistance {
            mesh: mesh.clone(),
            pseudonormals: OnceLock::new(),
            winding: WindingNumbers::new(&bvh),
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
        self.bvh.closest(p, upper_bound)
    }

    /// Distance to the mesh, 0 or more.
    pub fn unsigned_distance(&self, p: DVec3) -> f64 {
        self.closest(p).distance_squared.sqrt()
    }

    /// Distance to the mesh, negative inside.
    pub fn signed_distance(&self, p: DVec3) -> f64 {
        let mut known = self.distance_near(p, None);
        self.side(&mut known) * known.distance
    }

    /// -1 inside, 1 outside.
    pub fn sign(&self, p: DVec3) -> f64 {
        self.side(&mut self.distance_near(p, None))
    }

    /// Distance and closest point, faster where they are known at a point not far away: the mesh is no further than
    /// the point of it that was closest there. Where the way is shorter than the distance, there is no surface between
    /// the points, so that a mesh with integer winding numbers has one side there. The result is the same whatever is
    /// known.
    pub fn distance_near(&self, p: DVec3, near: Option<&KnownDistance>) -> KnownDistance {
        if let Some(same) = near.filter(|near| near.point == p) {
            return *same;
        }
        let bound = near.map_or(f64::INFINITY, |near| p.distance(near.surface));
        let closest = self.closest_within(p, bound);
        let distance = closest.distance_squared.sqrt();
        let carries = self.has_integer_winding();
        let same_side = |near: &KnownDistance| {
            // The larger of the two distances tells.
            p.distance(near.point) < near.distance.max(distance) * (1.0 - 1e-9)
        };
        let inside = match self.choice.method {
            SignMethod::Pseudonormal => Some(self.inside_by_pseudonormal(p, &closest)),
            _ => near.filter(|near| carries && same_side(near)).and_then(|near| near.inside),
        };
        KnownDistance { point: p, distance, surface: closest.point, inside }
    }

    /// Whether the sign is that of winding numbers which are integers everywhere.
    pub fn has_integer_winding(&self) -> bool {
        self.balanced && self.choice.method != SignMethod::Pseudonormal
    }

    /// -1 inside, 1 outside; now known.
    pub fn side(&self, known: &mut KnownDistance) -> f64 {
        let inside = *known.inside.get_or_insert_with(|| self.inside_by_winding(known.point));
        if inside { -1.0 } else { 1.0 }
    }

    /// Side of the surface by the pseudonormal at the closest point; by the winding number where that
    /// is too close to call.
    pub fn inside_by_pseudonormal(&self, p: DVec3, closest: &Closest) -> bool {
        let pseudonormals = self.pseudonormals.get_or_init(|| {
            let vertices: Vec<DVec3> = self.mesh.vertices.iter().map(|&v| DVec3::from(v)).collect();
            Pseudonormals::new(&vertices, &self.mesh.triangles, &Topology::new(&self.mesh))
        });
        let inside = pseudonormals.inside(p, closest, &self.mesh.triangles);
        inside.unwrap_or_else(|| self.inside_by_winding(p))
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
