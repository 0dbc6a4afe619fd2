//! Walls, gaps and rods thinner than a cell, found in the distances at the nodes: along an edge of a cell, the distance
//! then rises and falls again within less than a cell, or falls and rises. That is seen at no cost; `width` tells whether
//! it is a wall, a gap, or only an edge of the surface, `rod` whether that is a rod's.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use volmap_runtime::Grid;
use volmap_runtime::layout::{Family, Nodes};

use super::boundary_distance::BoundaryDistance;
use super::cell_edges::{CellEdge, FAMILIES, for_each_edge};
use super::closest_point::{Closest, Feature};
use super::rod::rod_width;
use super::width::touching_ball;

/// Slopes of the distance on both sides of a fold, at least: a plane has 0.577 along one of the axes.
const SLOPE: f64 = 0.5;
/// Folds are no deeper than that, in cells.
const DEPTH: f64 = 0.5;
/// The same beside a rod, which lines may pass at half a cell, with no node nearer than a sixth of a cell along them,
/// and whose side may be flat for nearly a cell.
const ROD_SLOPE: f64 = 0.1;
const ROD_DEPTH: f64 = 0.6;
/// Folds that are measured, at most; of more, as many spread evenly.
const MEASURED: usize = 512;
/// Folds at which rods are looked for, at most.
const PROBED: usize = 256;
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
    /// Rods of the solid, thin in two directions.
    pub rods: Thin,
}

/// Walls, gaps or rods.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Thin {
    /// How often a line of the grid goes through one, or passes a rod, about.
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
        let Folds { sharp, dips } = folds(grid, nodes, distances);
        let (stride, measured) = spread(&sharp, MEASURED, |fold| measure(fold, phi, cell));
        let of_measured = |width: fn(&Measured) -> Option<f64>| {
            let found = measured.iter().filter_map(|measured| Some((width(measured)?, measured.place)));
            thin(stride, found.collect())
        };
        let (walls, gaps) = (of_measured(|m| m.wall), of_measured(|m| m.gap));
        let (stride, rods) = spread(&dips, PROBED, |fold| rod(fold, phi, cell));
        ThinPlaces { cell, walls, gaps, rods: thin(stride, rods) }
    }
}

/// What is found at folds, of which so many are looked at, spread evenly; and how many each stands for.
fn spread<T: Send>(
    folds: &[Fold],
    most: usize,
    find: impl Fn(&Fold) -> Option<T> + Sync + Send,
) -> (usize, Vec<T>) {
    let stride = folds.len().div_ceil(most).max(1);
    (stride, folds.par_iter().step_by(stride).filter_map(find).collect())
}

/// Of widths and places, each of which stands for `stride`.
fn thin(stride: usize, mut found: Vec<(f64, DVec3)>) -> Thin {
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Thin {
        count: found.len() * stride,
        width: found.first().map_or(0.0, |(width, _)| *width),
        places: found.iter().take(PLACES).map(|(_, place)| place.to_array()).collect(),
    }
}

/// Widths below a cell at a point of the surface.
struct Measured {
    place: DVec3,
    wall: Option<f64>,
    gap: Option<f64>,
}

fn measure(fold: &Fold, phi: &BoundaryDistance, cell: f64) -> Option<Measured> {
    let closest = fold.closest(phi);
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

/// Width and place of a rod.
fn rod(fold: &Fold, phi: &BoundaryDistance, cell: f64) -> Option<(f64, DVec3)> {
    let surface = fold.closest(phi).point;
    Some((rod_width(phi, fold.place, surface, cell)?, surface))
}

/// A node at a fold of the distance.
#[derive(Clone, Copy)]
struct Fold {
    place: DVec3,
    distance: f64,
}

impl Fold {
    fn closest(&self, phi: &BoundaryDistance) -> Closest {
        // Moved by the thickness, and by rounding at most.
        let bound = (self.distance.abs() + phi.thickness.abs()) * (1.0 + 1e-9);
        phi.mesh.closest_within(self.place, bound)
    }
}

/// Nodes at folds near the surface.
#[derive(Default)]
struct Folds {
    /// Where both slopes are steep: walls and gaps.
    sharp: Vec<Fold>,
    /// Where the distance falls and rises again: rods.
    dips: Vec<Fold>,
}

fn folds(grid: &Grid, nodes: &Nodes, distances: &[f64]) -> Folds {
    let along = |(family, axis): (Family, usize)| {
        // By the lower end of each edge, the first of its two inner nodes.
        let mut thirds = vec![NONE; nodes.count_of(Family::Corner)];
        for_each_edge(nodes, family, axis, |edge| thirds[edge.lower as usize] = edge.third);
        let line = Line { grid, axis, distances };
        let mut found = Folds::default();
        for_each_edge(nodes, family, axis, |edge| line.find(&edge, thirds[edge.upper as usize], &mut found));
        found
    };
    // In the order of the axes, whatever is done first.
    let mut all = Folds::default();
    for Folds { sharp, dips } in FAMILIES.into_par_iter().map(along).collect::<Vec<_>>() {
        all.sharp.extend(sharp);
        all.dips.extend(dips);
    }
    all
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
    /// The first folds that begin in an edge, after which the inner nodes from `next` on follow, if there are any. Each
    /// fold once: between nodes 1 and 2, 2 and 3, or 3 and 4 of the line.
    fn find(&self, edge: &CellEdge, next: u32, found: &mut Folds) {
        let cell = self.grid.cell_size;
        let (third, longest) = (cell[self.axis] / 3.0, cell.max_element());
        let (count, after) = if next == NONE { (1, [edge.upper; 2]) } else { (3, [next, next + 1]) };
        let line = [edge.lower, edge.third, edge.third + 1, edge.upper, after[0], after[1]];
        let values = line.map(|number| self.distances[number as usize]);
        let (mut has_sharp, mut has_dip) = (false, false);
        for (first, values) in values.windows(4).take(count).enumerate() {
            let (rise, fall) = (values[1] - values[0], values[3] - values[2]);
            let depth = values[1].abs().min(values[2].abs());
            if rise * fall >= 0.0 || depth > ROD_DEPTH * longest {
                continue;
            }
            let slope = rise.abs().min(fall.abs());
            if slope >= SLOPE * third && depth <= DEPTH * longest && !has_sharp {
                has_sharp = true;
                found.sharp.push(self.fold(edge, first, values));
            }
            if slope >= ROD_SLOPE * third && rise < 0.0 && !has_dip {
                has_dip = true;
                found.dips.push(self.fold(edge, first, values));
            }
        }
    }

    /// The fold between the inner two of four values, of which the first is a node of the edge: at the smaller one.
    fn fold(&self, edge: &CellEdge, first: usize, values: &[f64]) -> Fold {
        let inner = if values[1].abs() <= values[2].abs() { 1 } else { 2 };
        let mut place = self.grid.origin + DVec3::from(edge.corner.map(f64::from)) * self.grid.cell_size;
        place[self.axis] += (first + inner) as f64 / 3.0 * self.grid.cell_size[self.axis];
        Fold { place, distance: values[inner] }
    }
}
