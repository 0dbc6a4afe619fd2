//! Signed distance to a mesh: closest point and side.

use glam::DVec3;
use std::sync::OnceLock;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::diagnosis::Diagnosis;
use crate::mesh::parts::corners;
use crate::mesh::topology::Topology;
use crate::sdf::bvh::Bvh;
use crate::sdf::closest_point::Closest;
use crate::sdf::lanes::LANES;
use crate::sdf::packet::Search;
use crate::sdf::pseudonormal::Pseudonormals;
use crate::sdf::sign::{SignChoice, SignMethod, choose_sign};
use crate::sdf::union::{Arrangement, Overlaps, UnionSurface, contacts, tree_of_union};
use crate::sdf::winding::WindingNumbers;

/// A mesh, ready for queries from any number of threads.
#[derive(Clone, Debug)]
pub struct MeshDistance {
    mesh: TriangleMesh,
    /// All triangles: for the side.
    bvh: Bvh,
    /// The surface of the union, where that isn't all triangles: for the distance.
    surface: Option<(UnionSurface, Bvh)>,
    overlaps: Overlaps,
    /// Made when first asked for.
    pseudonormals: OnceLock<Pseudonormals>,
    winding: WindingNumbers,
    choice: SignChoice,
    balanced: bool,
}

/// Points that lie close together, asked together.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    /// Of each point, what is known of it or of one near it.
    pub known: [Option<KnownDistance>; LANES],
    search: Search,
}

impl Neighbours {
    /// So many points at most.
    pub const MAX: usize = LANES;

    /// The same is known near all points.
    pub fn know(&mut self, known: Option<KnownDistance>) {
        self.known = [known; LANES];
    }
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
        MeshDistance::with_topology(mesh, &Topology::new(mesh), sign, diagnosis)
    }

    /// The same of a mesh whose edges are known.
    pub fn with_topology(
        mesh: &TriangleMesh,
        topology: &Topology,
        sign: SignMethod,
        diagnosis: &Diagnosis,
    ) -> MeshDistance {
        let corners = corners_of(mesh);
        let mut bvh = Bvh::new(&corners);
        let choice = match sign {
            SignMethod::Auto => choose_sign(diagnosis),
            method => SignChoice { method, reason: "as asked for".to_string() },
        };
        // Each has parts that run on one thread.
        let (winding, contacts) = rayon::join(|| WindingNumbers::new(&bvh), || contacts(&bvh));
        let balanced = diagnosis.balanced;
        let arrangement = Arrangement { topology, corners: &corners, bvh: &bvh, winding: &winding, balanced };
        let (overlaps, surface) = arrangement.union(&contacts, diagnosis.nested_solids.count > 0);
        let with_tree = |surface: UnionSurface| {
            let tree = tree_of_union(&mut bvh, &corners, &surface);
            (surface, tree)
        };
        let surface = surface.map(with_tree);
        MeshDistance {
            mesh: mesh.clone(),
            pseudonormals: OnceLock::new(),
            winding,
            surface,
            overlaps,
            bvh,
            choice,
            balanced,
        }
    }

    /// What overlaps in the mesh.
    pub fn overlaps(&self) -> &Overlaps {
        &self.overlaps
    }

    /// The union's surface, to which the distance is. None if that is all of the mesh.
    pub fn union_surface(&self) -> Option<&UnionSurface> {
        self.surface.as_ref().map(|(surface, _)| surface)
    }

    /// Triangles of the surface to which the distance is, and of which triangle of the mesh each is a part; together
    /// they enclose the solid, if the mesh is balanced.
    pub fn surface_triangles(&self) -> (Vec<[DVec3; 3]>, Vec<u32>) {
        let corners = corners_of(&self.mesh);
        match &self.surface {
            Some((surface, _)) => surface.triangles(&corners).unzip(),
            None => {
                let numbers = (0..corners.len() as u32).collect();
                (corners, numbers)
            }
        }
    }

    /// A mesh of the union's surface, without shared vertices where triangles were cut. None if it is the mesh itself.
    pub fn union_mesh(&self) -> Option<TriangleMesh> {
        self.surface.as_ref().map(|(surface, _)| surface.mesh(&self.mesh))
    }

    /// Volume that the surface encloses, m^3; means nothing where the mesh isn't balanced.
    pub fn volume(&self) -> f64 {
        let (triangles, _) = self.surface_triangles();
        let origin = triangles[0][0];
        let volume = |corners: &[DVec3; 3]| {
            let [a, b, c] = corners.map(|corner| corner - origin);
            a.dot(b.cross(c)) / 6.0
        };
        triangles.iter().map(volume).sum()
    }

    /// Normal of a triangle as its corners run; zero if it has no area.
    pub fn normal(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = corners(&self.mesh, triangle as usize);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// The tree of the triangles to which the distance is.
    fn tree(&self) -> &Bvh {
        self.surface.as_ref().map_or(&self.bvh, |(_, tree)| tree)
    }

    /// The sign in use, and why.
    pub fn sign_choice(&self) -> &SignChoice {
        &self.choice
    }

    /// Closest point of the union's surface; the feature is that of the piece where that is left of a triangle.
    pub fn closest(&self, p: DVec3) -> Closest {
        self.closest_within(p, f64::INFINITY)
    }

    /// `closest`, faster where a distance is known that will not be exceeded.
    pub fn closest_within(&self, p: DVec3, upper_bound: f64) -> Closest {
        self.tree().closest(p, upper_bound)
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

    /// Distance and closest point, faster where they are known at a point not far away. Where the way is shorter than
    /// the distance, there is no surface between the points, so that a mesh with integer winding numbers has one side
    /// there. The result is the same whatever is known.
    pub fn distance_near(&self, p: DVec3, near: Option<&KnownDistance>) -> KnownDistance {
        if let Some(same) = near.filter(|near| near.point == p) {
            return *same;
        }
        let closest = self.closest_within(p, upper_bound(p, near));
        self.known(p, &closest, near)
    }

    /// [`MeshDistance::distance_near`] at up to [`Neighbours::MAX`] points, much faster than one by one where they lie
    /// close together. What is known of them is known then.
    pub fn distances_near(&self, points: &[DVec3], near: &mut Neighbours) {
        let mut bounds = [f64::INFINITY; LANES];
        for ((bound, p), known) in bounds.iter_mut().zip(points).zip(&near.known) {
            *bound = upper_bound(*p, known.as_ref());
        }
        let closest = self.tree().closest_to_each(points, &bounds, &mut near.search);
        for ((p, closest), known) in points.iter().zip(&closest).zip(&mut near.known) {
            *known = Some(self.known(*p, closest, known.as_ref()));
        }
    }

    /// What is known of a point once its closest point is.
    fn known(&self, p: DVec3, closest: &Closest, near: Option<&KnownDistance>) -> KnownDistance {
        let distance = closest.distance_squared.sqrt();
        let mut known = KnownDistance { point: p, distance, surface: closest.point, inside: None };
        match self.choice.method {
            SignMethod::Pseudonormal => known.inside = Some(self.inside_by_pseudonormal(p, closest)),
            _ => near.into_iter().for_each(|near| self.follow_side(&mut known, near)),
        }
        known
    }

    /// Where winding numbers are integers, the side is that of a point near by, if the way there is shorter than one of
    /// the distances: there is no surface on it.
    fn follow_side(&self, known: &mut KnownDistance, near: &KnownDistance) {
        let free_way = || known.point.distance(near.point) < near.distance.max(known.distance) * (1.0 - 1e-9);
        if known.inside.is_none() && near.inside.is_some() && self.has_integer_winding() && free_way() {
            known.inside = near.inside;
        }
    }

    /// Makes the sides of the first `count` points known, whose distances are.
    pub fn sides_near(&self, count: usize, near: &mut Neighbours) {
        for lane in 0..count {
            let (before, rest) = near.known.split_at_mut(lane);
            let Some(known) = &mut rest[0] else { continue };
            before.iter().flatten().for_each(|other| self.follow_side(known, other));
            self.side(known);
        }
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

    /// Side of the surface by the pseudonormal at the closest point of all triangles; by the winding number where that
    /// is too close to call.
    pub fn inside_by_pseudonormal(&self, p: DVec3, closest: &Closest) -> bool {
        let of_all = self.surface.as_ref().map(|_| self.bvh.closest(p, f64::INFINITY));
        let closest = of_all.as_ref().unwrap_or(closest);
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

fn corners_of(mesh: &TriangleMesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangles.len()).map(|triangle| corners(mesh, triangle)).collect()
}

/// The mesh is no further than the point of it that is closest to a neighbour.
fn upper_bound(p: DVec3, near: Option<&KnownDistance>) -> f64 {
    near.map_or(f64::INFINITY, |near| p.distance(near.surface))
}
