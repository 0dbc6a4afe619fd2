//! Turning all triangles of a mesh the same way round.
//!
//! Both signs of the distance rest on it: a single flipped triangle spoils the pseudonormals around it
//! and the winding number in front of it. Patches, connected by edges with exactly two faces, are
//! made consistent by a flood fill that keeps the direction of the majority; then closed patches that
//! are inside out are turned, with all that lies in them.

use std::collections::VecDeque;

use serde::Serialize;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::nesting::{Nesting, find_nesting};
use crate::mesh::parts::{Parts, corners};
use crate::mesh::topology::{Neighbour, Topology};

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

/// Orients the mesh; linear time.
pub fn orient(mesh: &mut TriangleMesh) -> OrientationRepair {
    let mut topology = Topology::new(mesh);
    orient_with(mesh, &mut topology).0
}

/// `orient`, for who has the topology already; it follows the mesh. Returns the oriented patches and how
/// they are nested too.
pub fn orient_with(mesh: &mut TriangleMesh, topology: &mut Topology) -> (OrientationRepair, Parts, Nesting) {
    let patches = flood(topology.neighbours());
    let mut repair = OrientationRepair::default();
    let mut flipped = vec![false; mesh.triangles.len()];
    if let Some(flip) = consistent_flips(mesh, topology, &patches, &mut repair) {
        apply(&flip, mesh, topology);
        flipped = flip;
    }
    let mut parts = Parts::new(mesh, topology, &patches.label, patches.count);
    let nesting = find_nesting(mesh, &parts);
    let turned = turned_patches(&parts, &nesting, &mut repair);
    if turned.contains(&true) {
        let flip: Vec<bool> = patches.label.iter().map(|&patch| turned[patch as usize]).collect();
        apply(&flip, mesh, topology);
        flipped.iter_mut().zip(&flip).for_each(|(flipped, flip)| *flipped ^= flip);
        parts.turn(&turned);
    }
    repair.flipped_triangles = flipped.into_iter().filter(|&flip| flip).count();
    (repair, parts, nesting)
}

fn apply(flip: &[bool], mesh: &mut TriangleMesh, topology: &mut Topology) {
    for (triangle, _) in mesh.triangles.iter_mut().zip(flip).filter(|(_, flip)| **flip) {
        triangle.swap(1, 2);
    }
    topology.flip(flip);
}

/// Triangles connected by edges with exactly two faces.
struct Patches {
    /// The patch of each triangle, numbered in the order of their first triangles.
    label: Vec<u32>,
    count: usize,
    /// Which triangles to flip to agree with the first of their patch, as far as can be.
    flip: Vec<bool>,
}

fn flood(neighbours: &[[Neighbour; 3]]) -> Patches {
    const NOT_REACHED: u32 = u32::MAX;
    let mut label = vec![NOT_REACHED; neighbours.len()];
    let mut flip = vec![false; neighbours.len()];
    let mut count = 0;
    let mut queue = VecDeque::new();
    for start in 0..neighbours.len() {
        if label[start] != NOT_REACHED {
            continue;
        }
        label[start] = count;
        queue.push_back(start as u32);
        while let Some(face) = queue.pop_front() {
            for neighbour in neighbours[face as usize] {
                if let Some(other) = neighbour.face()
                    && label[other] == NOT_REACHED
                {
                    label[other] = count;
                    flip[other] = flip[face as usize] ^ neighbour.same_way();
                    queue.push_back(other as u32);
                }
            }
        }
        count += 1;
    }
    Patches { label, count: count as usize, flip }
}

/// Which triangles to flip so that each patch is consistent, by flipping as few as possible. `None`: all
/// are.
fn consistent_flips(
    mesh: &TriangleMesh,
    topology: &Topology,
    patches: &Patches,
    repair: &mut OrientationRepair,
) -> Option<Vec<bool>> {
    let Patches { label, count, flip } = patches;
    let inconsistent = inconsistent_edges(topology, patches);
    if inconsistent.before.iter().all(|&edges| edges == 0) {
        return None;
    }
    let mut size = vec![0usize; *count];
    let mut flipped = vec![0usize; *count];
    for (&patch, &flip) in label.iter().zip(flip) {
        size[patch as usize] += 1;
        flipped[patch as usize] += usize::from(flip);
    }
    let flip = label.iter().zip(flip).map(|(&patch, flip)| {
        let patch = patch as usize;
        let no_gain = inconsistent.before[patch] <= inconsistent.after[patch];
        !no_gain && (flip ^ (2 * flipped[patch] > size[patch]))
    });
    count_repairs(mesh, label, &inconsistent, repair);
    Some(flip.collect())
}

/// Patches by their inconsistent edges before and after.
fn count_repairs(
    mesh: &TriangleMesh,
    label: &[u32],
    InconsistentEdges { before, after }: &InconsistentEdges,
    repair: &mut OrientationRepair,
) {
    let mut seen = vec![false; before.len()];
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
}

/// For each patch, the number of edges whose faces disagree: as they are, and after the flips.
struct InconsistentEdges {
    before: Vec<usize>,
    after: Vec<usize>,
}

fn inconsistent_edges(topology: &Topology, patches: &Patches) -> InconsistentEdges {
    let Patches { label, count, flip } = patches;
    let mut before = vec![0; *count];
    let mut after = vec![0; *count];
    for edge in topology.edges() {
        if let [a, b] = edge.sides {
            let patch = label[a.face()] as usize;
            let disagree = a.forward() == b.forward();
            before[patch] += usize::from(disagree);
            after[patch] += usize::from(disagree ^ flip[a.face()] ^ flip[b.face()]);
        }
    }
    InconsistentEdges { before, after }
}

/// Closed patches to turn: those of negative volume that lie in no other, and all that lies in them.
/// What lies inside another keeps its direction relative to it: it may be a hollow or a solid.
fn turned_patches(parts: &Parts, nesting: &Nesting, repair: &mut OrientationRepair) -> Vec<bool> {
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
