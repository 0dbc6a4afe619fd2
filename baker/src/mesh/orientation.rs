//! Turning all triangles of a mesh the same way round.
//!
//! Both signs of the distance rest on it: a single flipped triangle spoils the pseudonormals around it
//! and the winding number in front of it. Patches, connected by edges with exactly two faces, are
//! made consistent by a flood fill that keeps the direction of the majority; then closed patches that
//! are inside out are turned, with all that lies in them.

use std::collections::VecDeque;

use serde::Serialize;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::nesting::find_nesting;
use crate::mesh::parts::{Parts, corners, surplus};
use crate::mesh::topology::{DisjointSets, NO_FACE, Topology};

const MAX_PLACES: usize = 8;

/// What `orient` did.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OrientationRepair {
    /// Triangles that run the other way round now.
    pub flipped_triangles: usize,
    /// Patches in which some triangles ran against the majority, and no longer do.
    pub repaired_patches: usize,
    /// Closed patches that were inside out and are turned now.
    pub turned_patches: usize,
    /// Closed patches that were turned because the patch around them was.
    pub turned_along: usize,
    /// Patches that cannot be consistent, as a Moebius strip cannot. They have as few edges with
    /// faces of opposite direction as came, or as the flood fill left.
    pub non_orientable_patches: usize,
    /// A point of each of the first few of those.
    pub non_orientable_places: Vec<[f64; 3]>,
}

/// Orients the mesh; O(n log n).
pub fn orient(mesh: &mut TriangleMesh) -> OrientationRepair {
    let topology = Topology::new(&mesh.triangles);
    let (label, count) = patches(&topology, mesh.triangles.len());
    let mut repair = OrientationRepair::default();
    let mut flip = consistent_flips(mesh, &topology, (&label, count), &mut repair);
    for (triangle, _) in mesh.triangles.iter_mut().zip(&flip).filter(|(_, flip)| **flip) {
        triangle.swap(1, 2);
    }
    let topology = Topology::new(&mesh.triangles);
    let parts = Parts::new(mesh, &topology, &label, count);
    for (part, turned) in turned_patches(mesh, &parts, &mut repair).into_iter().enumerate() {
        for &triangle in parts.triangles(part).iter().filter(|_| turned) {
            mesh.triangles[triangle as usize].swap(1, 2);
            flip[triangle as usize] ^= true;
        }
    }
    repair.flipped_triangles = flip.into_iter().filter(|&flip| flip).count();
    repair
}

/// Patches: triangles connected by edges with exactly two faces.
fn patches(topology: &Topology, triangles: usize) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(triangles);
    for edge in topology.edges() {
        if let [a, b] = edge {
            sets.union(a.face() as u32, b.face() as u32);
        }
    }
    sets.numbered()
}

/// Which triangles to flip so that each patch is consistent, by flipping as few as possible.
fn consistent_flips(
    mesh: &TriangleMesh,
    topology: &Topology,
    (label, count): (&[u32], usize),
    repair: &mut OrientationRepair,
) -> Vec<bool> {
    let mut flip = flood(topology, mesh.triangles.len());
    let mut size = vec![0usize; count];
    let mut flipped = vec![0usize; count];
    for (&patch, &flip) in label.iter().zip(&flip) {
        size[patch as usize] += 1;
        flipped[patch as usize] += usize::from(flip);
    }
    let (before, after) = inconsistent_edges(topology, (label, count), &flip);
    for (&patch, flip) in label.iter().zip(&mut flip) {
        let patch = patch as usize;
        let no_gain = before[patch] <= after[patch];
        *flip = !no_gain && (*flip ^ (2 * flipped[patch] > size[patch]));
    }
    let mut seen = vec![false; count];
    for (triangle, &patch) in label.iter().enumerate() {
        let patch = patch as usize;
        if std::mem::replace(&mut seen[patch], true) {
            continue;
        }
        repair.repaired_patches += usize::from(before[patch] > 0 && after[patch] == 0);
        if after[patch] > 0 {
            repair.non_orientable_patches += 1;
            if repair.non_orientable_places.len() < MAX_PLACES {
                let place = corners(mesh, triangle)[0];
                repair.non_orientable_places.push(place.to_array());
            }
        }
    }
    flip
}

/// Flips that agree with the first triangle of each patch, as far as can be.
fn flood(topology: &Topology, triangles: usize) -> Vec<bool> {
    let neighbours = topology.neighbours();
    let against = directions_against(topology, triangles);
    let mut flip = vec![false; triangles];
    let mut reached = vec![false; triangles];
    let mut queue = VecDeque::new();
    for start in 0..triangles {
        if std::mem::replace(&mut reached[start], true) {
            continue;
        }
        queue.push_back(start);
        while let Some(face) = queue.pop_front() {
            for side in 0..3 {
                let other = neighbours[face][side];
                if other != NO_FACE && !std::mem::replace(&mut reached[other as usize], true) {
                    flip[other as usize] = flip[face] ^ against[face][side];
                    queue.push_back(other as usize);
                }
            }
        }
    }
    flip
}

/// For each side of each triangle, whether the neighbour there runs through the edge the same way.
fn directions_against(topology: &Topology, triangles: usize) -> Vec<[bool; 3]> {
    let mut against = vec![[false; 3]; triangles];
    for edge in topology.edges() {
        if let [a, b] = edge
            && a.forward() == b.forward()
        {
            against[a.face()][a.side()] = true;
            against[b.face()][b.side()] = true;
        }
    }
    against
}

/// For each patch, the edges whose faces disagree: as they are, and after the flips.
fn inconsistent_edges(
    topology: &Topology,
    (label, count): (&[u32], usize),
    flip: &[bool],
) -> (Vec<usize>, Vec<usize>) {
    let mut before = vec![0; count];
    let mut after = vec![0; count];
    for edge in topology.edges() {
        if let [a, b] = edge {
            let patch = label[a.face()] as usize;
            let disagree = surplus(edge.iter()) != 0;
            before[patch] += usize::from(disagree);
            after[patch] += usize::from(disagree ^ flip[a.face()] ^ flip[b.face()]);
        }
    }
    (before, after)
}

/// Closed patches to turn: those of negative volume that lie in no other, and all that lies in them.
/// What lies inside another keeps its direction relative to it: it may be a hollow or a solid.
fn turned_patches(mesh: &TriangleMesh, parts: &Parts, repair: &mut OrientationRepair) -> Vec<bool> {
    let nesting = find_nesting(mesh, parts);
    let is_outermost = |i: usize| nesting.containers[i].is_empty();
    let inside_out = |i: usize| parts.list[i].balanced && parts.list[i].volume < 0.0;
    (0..parts.list.len())
        .map(|i| {
            let outermost =
                nesting.containers[i].iter().map(|&outer| outer as usize).find(|&outer| is_outermost(outer));
            let turned = inside_out(outermost.unwrap_or(i)) && (is_outermost(i) || outermost.is_some());
            repair.turned_patches += usize::from(turned && outermost.is_none());
            repair.turned_along += usize::from(turned && outermost.is_some());
            turned
        })
        .collect()
}
