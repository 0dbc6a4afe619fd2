//! Which cells are stored: those with a point of |Phi| <= 2 r (Bender et al. 2020, section 5, step 3), found
//! without visiting the others one by one.
//!
//! Phi is 1-Lipschitz: in a block of cells with half diagonal R it stays within R of its value at the centre. Blocks
//! that this decides are left whole, the others are split, so the work grows with the band and not with the box.

use super::boundary_distance::SignedDistance;
use super::mesh_distance::{KnownDistance, Neighbours};
use crate::work::Work;
use glam::{DVec3, UVec3};
use rayon::prelude::*;
use volmap_formats::asset::CellRun;
use volmap_runtime::Grid;

/// The cells of a grid by what is known of them; the rest is fluid. Both sorted by (k, j, i), adjacent ones joined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandCells {
    /// Cells with a point of |Phi| <= width.
    pub band: Vec<CellRun>,
    /// Cells with Phi < -width everywhere.
    pub solid: Vec<CellRun>,
}

impl BandCells {
    /// Number of cells in the band.
    pub fn band_count(&self) -> u64 {
        self.band.iter().map(|run| u64::from(run.len)).sum()
    }
}

/// Blocks of more cells along an axis are split by several threads.
const TASK_CELLS: u32 = 16;
/// How often a cell on the edge of the band is split; undecided parts count as in the band.
const REFINEMENTS: u32 = 2;

/// Finds the band of half width `width` (metres) of the signed distance `phi`, which must be 1-Lipschitz where it
/// doesn't change its sign. Cells that are decided count as work.
pub fn find_band(grid: &Grid, width: f64, phi: &impl SignedDistance, work: &Work) -> BandCells {
    let search = Search { grid, width, phi, work };
    let found = search.block((UVec3::ZERO, grid.resolution), None, &mut Neighbours::default());
    BandCells { band: joined(found.band), solid: joined(found.solid) }
}

struct Search<'a, D> {
    grid: &'a Grid,
    width: f64,
    phi: &'a D,
    work: &'a Work,
}

impl<D: SignedDistance> Search<'_, D> {
    fn block(
        &self,
        (low, high): (UVec3, UVec3),
        mut known: Option<KnownDistance>,
        near: &mut Neighbours,
    ) -> BandCells {
        let mut cells = BandCells::default();
        let half = 0.5 * (self.grid.cell_corner(high) - self.grid.cell_corner(low));
        let center = self.center(low, high);
        let size = self.phi.size_near(center, &mut known);
        // Rounding of the corners must not hide a touching cell.
        let reach = half.length() * (1.0 + 1e-9);
        let is_cell = high - low == UVec3::ONE;
        let beyond = size - reach > self.width;
        if beyond || is_cell && !self.touches((center, half), (size, known), REFINEMENTS, near) {
            self.work.add((high - low).as_u64vec3().element_product());
            if self.phi.near(center, &mut known) < 0.0 {
                push_box(low, high, &mut cells.solid);
            }
        } else if is_cell || size + reach <= self.width {
            self.work.add((high - low).as_u64vec3().element_product());
            push_box(low, high, &mut cells.band);
        } else {
            for part in self.parts((low, high), known, near) {
                cells.band.extend(part.band);
                cells.solid.extend(part.solid);
            }
        }
        cells
    }

    /// The cells of the blocks that a block is split into, whose centres are asked together.
    fn parts(
        &self,
        (low, high): (UVec3, UVec3),
        known: Option<KnownDistance>,
        near: &mut Neighbours,
    ) -> Vec<BandCells> {
        let parts = octants(low, high);
        let centers: Vec<DVec3> = parts.iter().map(|&(low, high)| self.center(low, high)).collect();
        near.know(known);
        self.phi.prepare(&centers, near, false);
        let parts: Vec<_> = parts.into_iter().zip(near.known).collect();
        match (high - low).max_element() > TASK_CELLS {
            true => {
                let parts = parts.into_par_iter();
                parts
                    .map_init(Neighbours::default, |near, (part, known)| self.block(part, known, near))
                    .collect()
            }
            false => parts.into_iter().map(|(part, known)| self.block(part, known, near)).collect(),
        }
    }

    fn center(&self, low: UVec3, high: UVec3) -> DVec3 {
        0.5 * (self.grid.cell_corner(low) + self.grid.cell_corner(high))
    }

    /// Whether a box (centre, half size) has a point in the band; `size` is |Phi| at the centre.
    fn touches(
        &self,
        (center, half): (DVec3, DVec3),
        (size, known): (f64, Option<KnownDistance>),
        refinements: u32,
        near: &mut Neighbours,
    ) -> bool {
        let reaches = |known| self.phi.reaches(known, center, half, self.width);
        if size <= self.width || known.as_ref().is_some_and(reaches) {
            return true;
        }
        if size - half.length() * (1.0 + 1e-9) > self.width {
            return false;
        }
        if refinements == 0 {
            return true;
        }
        let part = |octant: usize| {
            let side = |axis: u32| if octant >> axis & 1 == 0 { -0.5 } else { 0.5 };
            center + half * DVec3::new(side(0), side(1), side(2))
        };
        let parts = [0, 1, 2, 3, 4, 5, 6, 7].map(part);
        near.know(known);
        self.phi.prepare(&parts, near, false);
        parts.into_iter().zip(near.known).any(|(part, mut known)| {
            let size = self.phi.size_near(part, &mut known);
            self.touches((part, 0.5 * half), (size, known), refinements - 1, near)
        })
    }
}

/// The halves of a block along every axis that has more than one cell.
fn octants(low: UVec3, high: UVec3) -> Vec<(UVec3, UVec3)> {
    let middle = low + (high - low + 1) / 2;
    let mut parts = vec![(low, high)];
    for axis in (0..3).filter(|&axis| high[axis] - low[axis] > 1) {
        let halves = |(low, high): (UVec3, UVec3)| {
            let (mut upper_low, mut lower_high) = (low, high);
            upper_low[axis] = middle[axis];
            lower_high[axis] = middle[axis];
            [(low, lower_high), (upper_low, high)]
        };
        parts = parts.into_iter().flat_map(halves).collect();
    }
    parts
}

fn push_box(low: UVec3, high: UVec3, runs: &mut Vec<CellRun>) {
    for k in low.z..high.z {
        for j in low.y..high.y {
            runs.push(CellRun { i: low.x, j, k, len: high.x - low.x });
        }
    }
}

/// Sorts by (k, j, i) and joins runs that touch.
fn joined(mut runs: Vec<CellRun>) -> Vec<CellRun> {
    runs.sort_unstable_by_key(|run| (run.k, run.j, run.i));
    runs.dedup_by(|next, run| {
        let touches = (next.k, next.j, next.i) == (run.k, run.j, run.i + run.len);
        if touches {
            run.len += next.len;
        }
        touches
    });
    runs
}

/// The part of the runs in the box `low .. high`, in the box's own indices.
pub fn cropped(runs: &[CellRun], low: UVec3, high: UVec3) -> Vec<CellRun> {
    let crop = |run: &CellRun| {
        let begin = run.i.max(low.x);
        let end = (run.i + run.len).min(high.x);
        let inside = begin < end && (low.y..high.y).contains(&run.j) && (low.z..high.z).contains(&run.k);
        let moved = || CellRun { i: begin - low.x, j: run.j - low.y, k: run.k - low.z, len: end - begin };
        inside.then(moved)
    };
    runs.iter().filter_map(crop).collect()
}
