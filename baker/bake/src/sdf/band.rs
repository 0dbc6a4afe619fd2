//! Which cells are stored: those with a point of |Phi| <= 2 r (Bender et al. 2020, section 5, step 3), found
//! without visiting the others one by one.
//!
//! Phi is 1-Lipschitz: in a block of cells with half diagonal R it stays within R of its value at the centre. Blocks
//! that this decides are left whole, the others are split, so the work grows with the band and not with the box.

use super::boundary_distance::SignedDistance;
use super::mesh_distance::{KnownDistance, Neighbours};
use crate::watch::{Cancelled, Work};
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
        count(&self.band)
    }

    /// Number of cells beyond it in the solid.
    pub fn solid_count(&self) -> u64 {
        count(&self.solid)
    }
}

fn count(runs: &[CellRun]) -> u64 {
    runs.iter().map(|run| u64::from(run.len)).sum()
}

/// Blocks of more cells along an axis are split by several threads.
const TASK_CELLS: u32 = 16;
/// How often a cell on the edge of the band is split; undecided parts count as in the band.
const REFINEMENTS: u32 = 2;

/// Finds the band of half width `width` (metres) of the signed distance `phi`, which must be 1-Lipschitz where it
/// doesn't change its sign. Cells that are decided count as work.
///
/// # Errors
/// [`Cancelled`].
pub fn find_band(
    grid: &Grid,
    width: f64,
    phi: &impl SignedDistance,
    work: &Work,
) -> Result<BandCells, Cancelled> {
    let search = Search { grid, width, phi, work };
    let whole = Block { low: UVec3::ZERO, high: grid.resolution };
    let found = search.block(whole, None, &mut Neighbours::default());
    work.check()?;
    Ok(BandCells { band: joined(found.band), solid: joined(found.solid) })
}

/// Cells from `low` to before `high`.
#[derive(Clone, Copy)]
struct Block {
    low: UVec3,
    high: UVec3,
}

/// A box in space, metres.
#[derive(Clone, Copy)]
struct Span {
    center: DVec3,
    half: DVec3,
}

struct Search<'a, D> {
    grid: &'a Grid,
    width: f64,
    phi: &'a D,
    work: &'a Work,
}

impl<D: SignedDistance> Search<'_, D> {
    fn block(&self, block: Block, mut known: Option<KnownDistance>, near: &mut Neighbours) -> BandCells {
        let mut cells = BandCells::default();
        let span = self.span(block);
        let size = self.phi.size_near(span.center, &mut known);
        let reach = span.reach();
        let is_cell = block.high - block.low == UVec3::ONE;
        let beyond = size - reach > self.width;
        if beyond || is_cell && !self.touches(span, size, known, REFINEMENTS, near) {
            self.work.add(block.count());
            if self.phi.near(span.center, &mut known) < 0.0 {
                block.push_to(&mut cells.solid);
            }
        } else if is_cell || size + reach <= self.width {
            self.work.add(block.count());
            block.push_to(&mut cells.band);
        } else if !self.work.is_cancelled() {
            for part in self.parts(block, known, near) {
                cells.band.extend(part.band);
                cells.solid.extend(part.solid);
            }
        }
        cells
    }

    /// The cells of the blocks that a block is split into, whose centres are asked together.
    fn parts(&self, block: Block, known: Option<KnownDistance>, near: &mut Neighbours) -> Vec<BandCells> {
        let parts = block.octants();
        let centers: Vec<DVec3> = parts.iter().map(|&part| self.span(part).center).collect();
        near.know(known);
        self.phi.prepare(&centers, near, false);
        let parts: Vec<_> = parts.into_iter().zip(near.known).collect();
        match (block.high - block.low).max_element() > TASK_CELLS {
            true => {
                let parts = parts.into_par_iter();
                parts
                    .map_init(Neighbours::default, |near, (part, known)| self.block(part, known, near))
                    .collect()
            }
            false => parts.into_iter().map(|(part, known)| self.block(part, known, near)).collect(),
        }
    }

    fn span(&self, block: Block) -> Span {
        let [low, high] = [block.low, block.high].map(|corner| self.grid.cell_corner(corner));
        Span { center: 0.5 * (low + high), half: 0.5 * (high - low) }
    }

    /// Whether a box has a point in the band; `size` is |Phi| at its centre.
    fn touches(
        &self,
        span: Span,
        size: f64,
        known: Option<KnownDistance>,
        refinements: u32,
        near: &mut Neighbours,
    ) -> bool {
        let reaches = |known| self.phi.reaches(known, span.center, span.half, self.width);
        if size <= self.width || known.as_ref().is_some_and(reaches) {
            return true;
        }
        if size - span.reach() > self.width {
            return false;
        }
        if refinements == 0 {
            return true;
        }
        let parts = [0, 1, 2, 3, 4, 5, 6, 7].map(|octant| span.octant(octant));
        near.know(known);
        self.phi.prepare(&parts.map(|part| part.center), near, false);
        parts.into_iter().zip(near.known).any(|(part, mut known)| {
            let size = self.phi.size_near(part.center, &mut known);
            self.touches(part, size, known, refinements - 1, near)
        })
    }
}

impl Span {
    /// From the centre to the corners, and a little more: rounding of the corners must not hide a touching cell.
    fn reach(&self) -> f64 {
        self.half.length() * (1.0 + 1e-9)
    }

    fn octant(&self, octant: usize) -> Span {
        let side = |axis: u32| if octant >> axis & 1 == 0 { -0.5 } else { 0.5 };
        let center = self.center + self.half * DVec3::new(side(0), side(1), side(2));
        Span { center, half: 0.5 * self.half }
    }
}

impl Block {
    fn count(self) -> u64 {
        (self.high - self.low).as_u64vec3().element_product()
    }

    /// The halves along every axis that has more than one cell.
    fn octants(self) -> Vec<Block> {
        let middle = self.low + (self.high - self.low + 1) / 2;
        let mut parts = vec![self];
        for axis in (0..3).filter(|&axis| self.high[axis] - self.low[axis] > 1) {
            let halves = |part: Block| {
                let (mut lower, mut upper) = (part, part);
                lower.high[axis] = middle[axis];
                upper.low[axis] = middle[axis];
                [lower, upper]
            };
            parts = parts.into_iter().flat_map(halves).collect();
        }
        parts
    }

    fn push_to(self, runs: &mut Vec<CellRun>) {
        for k in self.low.z..self.high.z {
            for j in self.low.y..self.high.y {
                runs.push(CellRun { i: self.low.x, j, k, len: self.high.x - self.low.x });
            }
        }
    }
}

/// Sorts by (k, j, i) and joins runs that touch.
pub(crate) fn joined(mut runs: Vec<CellRun>) -> Vec<CellRun> {
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
