//! Fans: the triangles around a vertex, as far as they are connected by edges at it.

use volmap_formats::mesh::TriangleMesh;

use crate::mesh::topology::{DisjointSets, HalfEdge, Topology};

const NO_FAN: u32 = u32::MAX;

/// How many fans there are around each vertex: 1 where the surface is a surface.
pub fn count_fans(mesh: &TriangleMesh, topology: &Topology) -> Vec<u32> {
    let mut fan_at = vec![NO_FAN; 3 * mesh.triangles.len()];
    let mut fans = vec![0u32; mesh.vertices.len()];
    let mut count = 0;
    for (corner, &vertex) in mesh.triangles.iter().flatten().enumerate() {
        if fan_at[corner] != NO_FAN {
            continue;
        }
        fan_at[corner] = count;
        // Both ways round, over the corner's two sides.
        for at_start in [true, false] {
            let mut way = Way { corner, at_start };
            while let Some(next) = way.step(topology)
                && fan_at[next.corner] == NO_FAN
            {
                fan_at[next.corner] = count;
                way = next;
            }
        }
        fans[vertex as usize] += 1;
        count += 1;
    }
    join_at_crowded_edges(topology, &fan_at, count, &mut fans);
    fans
}

/// The way ended at edges with more than two faces, which connect all of their faces.
fn join_at_crowded_edges(topology: &Topology, fan_at: &[u32], count: u32, fans: &mut [u32]) {
    let mut sets: Option<DisjointSets> = None;
    for edge in topology.edges().filter(|edge| edge.sides.len() > 2) {
        let sets = sets.get_or_insert_with(|| DisjointSets::new(count as usize));
        let first = end_corners(edge.sides[0]);
        for &other in &edge.sides[1..] {
            let ends = first.into_iter().zip(end_corners(other)).zip(edge.ends);
            for ((a, b), vertex) in ends {
                fans[vertex as usize] -= u32::from(sets.union(fan_at[a], fan_at[b]));
            }
        }
    }
}

/// Corners of the half-edge's triangle at the edge's lower and upper vertex.
fn end_corners(half: HalfEdge) -> [usize; 2] {
    let (from, to) = (half.corner(), next_corner(half.corner()));
    if half.forward() { [from, to] } else { [to, from] }
}

fn next_corner(corner: usize) -> usize {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

fn last_corner(corner: usize) -> usize {
    if corner.is_multiple_of(3) { corner + 2 } else { corner - 1 }
}

/// A corner, and over which of its sides the way leads on.
struct Way {
    corner: usize,
    /// The side that starts at the corner; or else the one that ends there.
    at_start: bool,
}

impl Way {
    fn step(&self, topology: &Topology) -> Option<Way> {
        let side = if self.at_start { self.corner } else { last_corner(self.corner) };
        let neighbour = topology.neighbours()[side / 3][side % 3];
        let across = neighbour.corner()?;
        // The vertex starts the side across if both run the same way and it starts this one, or if neither.
        // There the way leads on over the corner's other side.
        Some(match neighbour.same_way() == self.at_start {
            true => Way { corner: across, at_start: false },
            false => Way { corner: next_corner(across), at_start: true },
        })
    }
}
