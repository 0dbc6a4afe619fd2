//! On which side of the surface the nodes of a band are.
//!
//! Two points that are closer to each other than one of them is to the surface have no surface between them: where
//! winding numbers are integers they have one side. So the sides of nodes are followed along the cells' edges, third by
//! third, and only one node of each part that is connected so is asked for its winding number: of the many nodes of the
//! fluid, of the solid, and of the few that lie alone near the surface.

use super::boundary_distance::SignedDistance;
use super::cell_edges::{FAMILIES, for_each_edge};
use crate::mesh::topology::DisjointSets;
use crate::rows::positions;
use glam::DVec3;
use rayon::prelude::*;
use volmap_runtime::Grid;
use volmap_runtime::layout::Nodes;

/// Gives the distances at the nodes, 0 or more, their signs.
pub fn set_signs(grid: &Grid, nodes: &Nodes, distances: &mut [f64], phi: &impl SignedDistance) {
    let (part, count) = connected(grid, nodes, distances).numbered();
    // The node of a part that is farthest from the surface is the cheapest to ask.
    let mut farthest = vec![u32::MAX; count];
    for (node, &part) in part.iter().enumerate() {
        let best = &mut farthest[part as usize];
        if *best == u32::MAX || distances[node] > distances[*best as usize] {
            *best = node as u32;
        }
    }
    let is_asked = |(node, _): &(usize, DVec3)| farthest[part[*node] as usize] as usize == *node;
    let asked: Vec<(usize, DVec3)> = positions(nodes, grid).enumerate().filter(is_asked).collect();
    let solid: Vec<bool> = asked.par_iter().map(|(_, point)| phi.at(*point) < 0.0).collect();
    let mut is_solid = vec![false; count];
    asked.iter().zip(solid).for_each(|((node, _), solid)| is_solid[part[*node] as usize] = solid);
    for (distance, part) in distances.iter_mut().zip(part) {
        if is_solid[part as usize] {
            *distance = -*distance;
        }
    }
}

/// Nodes joined to their neighbours on the edges of the cells where no surface can lie between.
fn connected(grid: &Grid, nodes: &Nodes, distances: &[f64]) -> DisjointSets {
    let mut sets = DisjointSets::new(distances.len());
    let farthest = grid.origin.abs().max(grid.max_corner().abs());
    for (family, axis) in FAMILIES {
        // As far as the rounded places of two neighbours can be from each other.
        let way = grid.cell_size[axis] / 3.0 * (1.0 + 1e-9) + 8.0 * f64::EPSILON * farthest[axis];
        let mut join = |a: u32, b: u32| {
            if way < distances[a as usize].max(distances[b as usize]) {
                sets.union(a, b);
            }
        };
        for_each_edge(nodes, family, axis, |edge| {
            join(edge.lower, edge.third);
            join(edge.third, edge.third + 1);
            join(edge.third + 1, edge.upper);
        });
    }
    sets
}
