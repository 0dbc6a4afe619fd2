//! Distances deep in the solid, where an asset has none: SPlisHSPlasH pushes a particle that got there back along the
//! gradient. Each corner of a solid cell gets the closest point of the surface that a neighbour knows, from the band
//! inwards: Danielsson 1980, *Euclidean Distance Mapping*. The points stand about a cell apart, so the distance is a
//! little too large: by up to 0.11 cells in a sphere and a torus at 40^3 cells.

use glam::UVec3;
use volmap_bake::watch::{Cancelled, Watch};
use volmap_runtime::layout::serendipity::{THIRDS, node, shape_and_gradient};
use volmap_runtime::{DVec3, Grid};

/// Rounds of sweeps; a second one is needed around bends only.
const ROUNDS: usize = 3;

/// Closest points of the surface by corner of the grid.
pub struct ClosestPoints {
    grid: Grid,
    /// NaN where none is known.
    points: Vec<DVec3>,
    is_wanted: Vec<bool>,
}

impl ClosestPoints {
    /// Knows none.
    pub fn new(grid: Grid) -> ClosestPoints {
        let corners = (grid.resolution + UVec3::ONE).as_usizevec3().element_product();
        ClosestPoints { grid, points: vec![DVec3::NAN; corners], is_wanted: vec![false; corners] }
    }

    fn index(&self, corner: UVec3) -> usize {
        let n = self.grid.resolution.as_usizevec3() + 1;
        let at = corner.as_usizevec3();
        at.x + n.x * (at.y + n.y * at.z)
    }

    /// Of the corners of a cell of the band, from its 32 distances: x - Phi n.
    pub fn learn(&mut self, cell: UVec3, distances: &[f64; 32]) {
        for a in 0..8 {
            let (_, gradients) = shape_and_gradient(node(a));
            let gradient: DVec3 = gradients.iter().zip(distances).map(|(g, d)| *g * *d).sum();
            let normal = (gradient / self.grid.cell_size).normalize_or_zero();
            if normal != DVec3::ZERO {
                let corner = corner(cell, a);
                let index = self.index(corner);
                self.points[index] = self.grid.cell_corner(corner) - distances[a] * normal;
            }
        }
    }

    /// The corners of a solid cell are to be found.
    pub fn want(&mut self, cell: UVec3) {
        for a in 0..8 {
            let index = self.index(corner(cell, a));
            self.is_wanted[index] = self.points[index].is_nan();
        }
    }

    /// Finds what is wanted, after all is learnt.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn find(&mut self, watch: &Watch) -> Result<(), Cancelled> {
        for _ in 0..ROUNDS {
            let mut changed = false;
            for direction in 0..8 {
                watch.check()?;
                changed |= self.sweep(direction);
            }
            if !changed {
                break;
            }
        }
        Ok(())
    }

    /// Goes through the corners with each axis upwards or, if its bit is set, downwards; whether any got closer.
    fn sweep(&mut self, direction: usize) -> bool {
        let n = self.grid.resolution + UVec3::ONE;
        let along = |axis: usize, step: u32| match direction >> axis & 1 {
            0 => step,
            _ => n[axis] - 1 - step,
        };
        let mut changed = false;
        for z in 0..n.z {
            for y in 0..n.y {
                for x in 0..n.x {
                    let steps = UVec3::new(x, y, z);
                    let at = UVec3::new(along(0, x), along(1, y), along(2, z));
                    if !self.is_wanted[self.index(at)] {
                        continue;
                    }
                    for mask in 1..8 {
                        let back = UVec3::new(mask & 1, mask >> 1 & 1, mask >> 2 & 1);
                        if steps.cmpge(back).all() {
                            let from = steps - back;
                            let from = UVec3::new(along(0, from.x), along(1, from.y), along(2, from.z));
                            changed |= self.offer(at, self.points[self.index(from)]);
                        }
                    }
                }
            }
        }
        changed
    }

    /// Takes a point if it is closer than the one known.
    fn offer(&mut self, corner: UVec3, point: DVec3) -> bool {
        let (index, place) = (self.index(corner), self.grid.cell_corner(corner));
        let known = self.points[index];
        let is_closer = point.distance_squared(place) < known.distance_squared(place);
        if is_closer || known.is_nan() && !point.is_nan() {
            self.points[index] = point;
            return true;
        }
        false
    }

    /// Distance (not negative) of node `a` of a cell to the closest point of the corners at its ends; infinite if there
    /// is none.
    pub fn distance(&self, cell: UVec3, a: usize) -> f64 {
        let xi = node(a);
        let place = self.grid.origin + self.grid.cell_size * (cell.as_dvec3() + 0.5 * (xi + DVec3::ONE));
        let is_end = |c: &usize| (node(*c) - xi).abs().cmplt(DVec3::splat(1.5)).all();
        let points = (0..8).filter(is_end).map(|c| self.points[self.index(corner(cell, c))]);
        points.map(|point| point.distance(place)).fold(f64::INFINITY, f64::min)
    }
}

fn corner(cell: UVec3, a: usize) -> UVec3 {
    cell + UVec3::from(THIRDS[a].map(|third| u32::from(third / 3)))
}
