//! Makes the triangles of a smooth closed surface well shaped: edge flips towards the Delaunay condition and
//! tangential smoothing, with every vertex kept on the implicit surface.
//!
//! Botsch and Kobbelt, *A Remeshing Approach to Multiresolution Modeling*, SGP 2004, section 4, without its
//! edge splits and collapses, since surface nets give even edges to begin with. Flips: Fisher, Springborn,
//! Schroeder and Bobenko, *An Algorithm for the Construction of Intrinsic Delaunay Triangulations*, 2006.

use std::collections::BTreeSet;

use glam::DVec3;

use crate::mesh::Mesh;
use crate::surface::{Field, gradient, project};

/// Repeats flips and smoothing; `mesh` must be closed and manifold, with vertices on the surface.
pub fn improve(mesh: &mut Mesh, field: Field, rounds: usize) {
    for _ in 0..rounds {
        flip_edges(mesh);
        smooth(mesh, field);
    }
    // Some ten sweeps settle it; on a curved surface nothing proves that flips end.
    for _ in 0..100 {
        if flip_edges(mesh) == 0 {
            break;
        }
    }
}

/// A directed edge of a triangle; sorted by its undirected edge, the two sides of an edge are neighbours.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    edge: [u32; 2],
    triangle: usize,
    corner: usize,
}

fn sides(mesh: &Mesh) -> Vec<Side> {
    let mut sides = Vec::with_capacity(3 * mesh.triangles.len());
    for (triangle, t) in mesh.triangles.iter().enumerate() {
        for corner in 0..3 {
            let (a, b) = (t[corner], t[(corner + 1) % 3]);
            sides.push(Side { edge: [a.min(b), a.max(b)], triangle, corner });
        }
    }
    sides.sort_unstable();
    sides
}

/// One sweep over all edges; a triangle takes part in one flip at most. Returns the number of flips.
fn flip_edges(mesh: &mut Mesh) -> usize {
    let sides = sides(mesh);
    let mut touched = vec![false; mesh.triangles.len()];
    let mut added = BTreeSet::new();
    for pair in sides.chunks_exact(2) {
        let [s, t] = [pair[0], pair[1]];
        let [a, b] = [0, 1].map(|k| mesh.triangles[s.triangle][(s.corner + k) % 3]);
        let c = mesh.triangles[s.triangle][(s.corner + 2) % 3];
        let d = mesh.triangles[t.triangle][(t.corner + 2) % 3];
        let edge = [c.min(d), c.max(d)];
        let free = !touched[s.triangle] && !touched[t.triangle];
        if !free || added.contains(&edge) || sides.binary_search_by_key(&edge, |side| side.edge).is_ok() {
            continue;
        }
        if flip_helps([a, b, c, d].map(|v| mesh.vertices[v as usize])) {
            mesh.triangles[s.triangle] = [a, d, c];
            mesh.triangles[t.triangle] = [d, b, c];
            (touched[s.triangle], touched[t.triangle]) = (true, true);
            added.insert(edge);
        }
    }
    added.len()
}

/// Whether the angles opposite the edge a-b sum to more than 180 degrees, in a place that is flat enough.
fn flip_helps([a, b, c, d]: [DVec3; 4]) -> bool {
    let normal = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p);
    let (before_c, before_d) = (normal(a, b, c), normal(b, a, d));
    let cotangent = |apex: DVec3, area2: f64| (a - apex).dot(b - apex) / area2;
    if cotangent(c, before_c.length()) + cotangent(d, before_d.length()) > -1e-9 {
        return false;
    }
    let (after_a, after_b) = (normal(a, d, c), normal(d, b, c));
    let flat = |m: DVec3, n: DVec3| m.dot(n) > 0.7 * m.length() * n.length();
    let sum = before_c + before_d;
    flat(after_a, after_b) && flat(after_a, sum) && flat(after_b, sum)
}

/// Moves each vertex towards the mean of its neighbours within the tangent plane, then back onto the surface.
fn smooth(mesh: &mut Mesh, field: Field) {
    let mut sums = vec![(DVec3::ZERO, 0.0); mesh.vertices.len()];
    for &t in &mesh.triangles {
        for corner in 0..3 {
            // In a closed mesh, every neighbour of a vertex follows it in exactly one triangle.
            let (sum, count) = &mut sums[t[corner] as usize];
            *sum += mesh.vertices[t[(corner + 1) % 3] as usize];
            *count += 1.0;
        }
    }
    for (v, (sum, count)) in mesh.vertices.iter_mut().zip(sums) {
        let normal = gradient(field, *v).normalize();
        let step = sum / count - *v;
        *v = project(field, *v + (step - normal * normal.dot(step)) * 0.5);
    }
}
