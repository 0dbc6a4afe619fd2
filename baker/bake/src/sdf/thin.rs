//! Walls and gaps thinner than a cell, found in the distances at the nodes: along an edge of a cell, the distance then
//! rises and falls again within less than a cell, or falls and rises. That is seen at no cost; `width` tells whether
//! it is a wall, a gap, or only an edge of the surface.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use volmap_runtime::Grid;
use volmap_runtime::layout::{Family, Nodes};

use super::boundary_distance::BoundaryDistance;
use super::cell_edges::{CellEdge, FAMILIES, for_each_edge};
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

fn measure(fold: Fold, phi: &BoundaryDistance, cell: f64) -> Option<Measured> {
    // Moved by the thickness, and by rounding at most.
    let bound = (fold.distance.abs() + phi.thickness.abs()) * (1.0 + 1e-9);
    let closest = phi.mesh.closest_within(fold.place, bound);
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

/// A node at a fold of the distance.
#[derive(Clone, Copy)]
struct Fold {
    place: DVec3,
    distance: f64,
}

/// Nodes at folds that are no deeper than half a cell.
fn folds(grid: &Grid, nodes: &Nodes, distances: &[f64]) -> Vec<Fold> {
    let along = |(family, axis): (Family, usize)| {
        // By the lower end of each edge, the first of its two inner nodes.
        let mut thirds = vec![NONE; nodes.count_of(Family::Corner)];
        for_each_edge(nodes, family, axis, |edge| thirds[edge.lower as usize] = edge.third);
        let line = Line { grid, axis, distances };
        let mut found = Vec::new();
        for_each_edge(nodes, family, axis, |edge| {
            found.extend(line.fold(&edge, thirds[edge.upper as usize]))
        });
        found
    };
    // In the order of the axes, whatever is done first.
    FAMILIES.into_par_iter().map(along).collect::<Vec<_>>().concat()
}

/// No node.
const NONE: u32 = u32::MAX;

/// Lines of nodes along an axis.
struct Line<'a> {
    grid: &'a Grid,
    axis: usize,
    distances: &'a [f64],
}

impl Line<'_> {
    /// The node at a fold that begins in an edge, after which the inner nodes from `next` on follow, if there are any.
    /// Each fold once: between nodes 1 and 2, 2 and 3, or 3 and 4 of the line.
    fn fold(&self, edge: &CellEdge, next: u32) -> Option<Fold> {
        let cell = self.grid.cell_size;
        let (steep, depth) = (SLOPE * cell[self.axis] / 3.0, 0.5 * cell.max_element());
        let (count, after) = if next == NONE { (1, [edge.upper; 2]) } else { (3, [next, next + 1]) };
        let line = [edge.lower, edge.third, edge.third + 1, edge.upper, after[0], after[1]];
        let values = line.map(|number| self.distances[number as usize]);
        let first = values.windows(4).take(count).position(|values| {
            let (rise, fall) = (values[1] - values[0], values[3] - values[2]);
            let is_fold = rise * fall < 0.0 && rise.abs() >= steep && fall.abs() >= steep;
            is_fold && values[1].abs().min(values[2].abs()) <= depth
        })?;
        let at = first + if values[first + 1].abs() <= values[first + 2].abs() { 1 } else { 2 };
        let mut place = self.grid.origin + DVec3::from(edge.corner.map(f64::from)) * cell;
        place[self.axis] += at as f64 / 3.0 * cell[self.axis];
        Some(Fold { place, distance: values[at] })
    }
}
