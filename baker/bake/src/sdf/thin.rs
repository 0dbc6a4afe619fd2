//! Walls and gaps thinner than a cell, found in the distances at the nodes: along an edge of a cell, the distance then
//! rises and falls again within less than a cell, or falls and rises. That is seen at no cost; `width` tells whether
//! it is a wall, a gap, or only an edge of the surface.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use volmap_runtime::Grid;
use volmap_runtime::layout::{Family, Nodes};

use super::boundary_distance::BoundaryDistance;
use super::closest_point::Feature;
use super::width::touching_ball;

/// Slopes of the distance on both sides of a fold, at least: a plane has 0.577 along one of the axes.
const SLOPE: f64 = 0.5;
/// Folds that are measured, at most; of more, as many spread evenly.
const MEASURED: usize = 512;
/// Places that are kept.
const PLACES: usize = 64;

/// What is thinner than a cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ThinPlaces {
    /// Longest edge of the cells, metres.
    pub cell: f64,
    /// Walls of the solid.
    pub walls: Thin,
    /// Gaps of the fluid.
    pub gaps: Thin,
}

/// Walls or gaps.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Thin {
    /// How often a line of the grid goes through one, about.
    pub count: usize,
    /// Width of the thinnest that was measured, metres.
    pub width: f64,
    /// Points of the surface there, the thinnest first.
    pub places: Vec<[f64; 3]>,
}

impl ThinPlaces {
    /// Looks at the distances at a map's nodes, metres.
    pub fn find(grid: &Grid, nodes: &Nodes, distances: &[f64], phi: &BoundaryDistance) -> ThinPlaces {
        let cell = grid.cell_size.max_element();
        let folds = folds(grid, nodes, distances);
        let stride = folds.len().div_ceil(MEASURED).max(1);
        let measured: Vec<Measured> =
            folds.par_iter().step_by(stride).filter_map(|fold| measure(*fold, phi, cell)).collect();
        let thin = |width: fn(&Measured) -> Option<f64>| {
            let mut found: Vec<(f64, DVec3)> =
                measured.iter().filter_map(|measured| Some((width(measured)?, measured.place))).collect();
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            Thin {
                count: found.len() * stride,
                width: found.first().map_or(0.0, |(width, _)| *width),
                places: found.iter().take(PLACES).map(|(_, place)| place.to_array()).collect(),
            }
        };
        ThinPlaces { cell, walls: thin(|m| m.wall), gaps: thin(|m| m.gap) }
    }
}

/// Widths below a cell at a point of the surface.
struct Measured {
    place: DVec3,
    wall: Option<f64>,
    gap: Option<f64>,
}

fn measure(point: DVec3, phi: &BoundaryDistance, cell: f64) -> Option<Measured> {
    let closest = phi.mesh.closest(point);
    // On an edge of the surface every ball is small.
    if closest.feature != Feature::Face {
        return None;
    }
    let out = phi.mesh.normal(closest.triangle) * if phi.invert { -1.0 } else { 1.0 };
    // The surface moves out of the solid by the thickness: on both sides of a wall.
    let width = |direction: DVec3, grown: f64| {
        let width = touching_ball(&phi.mesh, closest.point, direction, cell - grown)? + grown;
        (width > 0.0 && width < cell).then_some(width)
    };
    let (wall, gap) = (width(-out, 2.0 * phi.thickness), width(out, -2.0 * phi.thickness));
    (wall.is_some() || gap.is_some()).then_some(Measured { place: closest.point, wall, gap })
}

/// Nodes at folds of the distance that are no deeper than half a cell.
fn folds(grid: &Grid, nodes: &Nodes, distances: &[f64]) -> Vec<DVec3> {
    let mut found = Vec::new();
    let depth = 0.5 * grid.cell_size.max_element();
    for (family, axis) in [(Family::EdgeX, 0), (Family::EdgeY, 1), (Family::EdgeZ, 2)] {
        let edges = edges(nodes, family, axis);
        let steep = SLOPE * grid.cell_size[axis] / 3.0;
        for edge in edges.iter().flatten() {
            let next = edges[edge.upper as usize].as_ref();
            let line = [edge.lower, edge.third, edge.third + 1, edge.upper];
            let further = next.map(|next| [next.third, next.third + 1]);
            let value = |at: usize| {
                let number = if at < 4 { line[at] } else { further.map_or(line[3], |next| next[at - 4]) };
                distances[number as usize]
            };
            // Each fold once: between nodes 1 and 2, 2 and 3, or 3 and 4 of the line.
            for first in 0..if further.is_some() { 3 } else { 1 } {
                let [a, b, c, d] = [0, 1, 2, 3].map(|i| value(first + i));
                let (rise, fall) = (b - a, d - c);
                let is_fold = rise * fall < 0.0 && rise.abs() >= steep && fall.abs() >= steep;
                if is_fold && b.abs().min(c.abs()) <= depth {
                    let at = first + if b.abs() <= c.abs() { 1 } else { 2 };
                    let mut place = grid.origin + edge.corner * grid.cell_size;
                    place[axis] += at as f64 / 3.0 * grid.cell_size[axis];
                    found.push(place);
                    break;
                }
            }
        }
    }
    found
}

/// A cell's edge by its nodes.
#[derive(Clone, Copy)]
struct Edge {
    /// Lattice point of its lower end.
    corner: DVec3,
    lower: u32,
    /// The first of its two inner nodes.
    third: u32,
    upper: u32,
}

/// Edges along an axis by their lower end.
fn edges(nodes: &Nodes, family: Family, axis: usize) -> Vec<Option<Edge>> {
    let mut edges = vec![None; nodes.count_of(Family::Corner)];
    let step = [(1, 0, 0), (0, 1, 0), (0, 0, 1)][axis];
    for (j, k, interval) in nodes.intervals(family) {
        let lower = nodes.number(Family::Corner, interval.first, j, k);
        let upper = nodes.number(Family::Corner, interval.first + step.0, j + step.1, k + step.2);
        for i in 0..interval.end - interval.first {
            let corner = DVec3::new(f64::from(interval.first + i), f64::from(j), f64::from(k));
            let third = interval.start + 2 * i;
            edges[(lower + i) as usize] = Some(Edge { corner, lower: lower + i, third, upper: upper + i });
        }
    }
    edges
}
