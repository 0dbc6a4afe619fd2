//! The numbering of an adaptive map's nodes: cells of several levels, each of half the size of those before.
//!
//! Level 0 is the map's grid; level l has the same origin, cells of `cell_size / 2^l` and its own lattice of nodes,
//! numbered as in a uniform map ([`Nodes`](super::Nodes)), level by level. A node that lies in the closed box of a band
//! cell of the level before is *constrained*: it has the values of that cell's polynomial. The others are *free*, and
//! theirs are the values that an asset stores.

mod check;
mod constrain;
mod error;
mod number;
mod rows;
mod tree;

pub use error::LevelsError;
pub(crate) use tree::{Tree, TreeHint};

use super::cells::{Found, Starts};
use super::nodes::Family;
use super::serendipity::NODES;
use crate::grid::Grid;
use constrain::Constrained;
use glam::{DVec3, UVec3};
use number::LevelNodes;
use rows::Rows;
use std::collections::HashMap;
use tree::{LeafRun, MOST};
use volmap_formats::asset::{CellRun, LevelCells};

/// The cells and nodes of an adaptive map.
pub struct Levels {
    grid: Grid,
    tree: Tree,
    levels: Vec<Level>,
    /// Cells of the band.
    cells: u32,
    free_count: usize,
}

struct Level {
    band: Vec<CellRun>,
    /// Number of the first run among those of all levels.
    first_run: u32,
    nodes: LevelNodes,
    /// Ascending.
    constrained: Vec<Constrained>,
}

/// A cell of the band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelCell {
    /// Its level.
    pub level: u32,
    /// Its index on the level's lattice.
    pub index: UVec3,
    /// Its number among all cells: level by level, by (k, j, i).
    pub number: usize,
    /// The numbers of its nodes among all, in the order of [`serendipity`](super::serendipity).
    pub nodes: [u32; NODES],
}

/// What holds a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    /// A cell of the band.
    Band {
        /// Its number.
        number: usize,
        /// Its level.
        level: u32,
        /// Coordinates in the reference cell [-1, 1]^3.
        xi: DVec3,
    },
    /// Deeper in the solid than the band.
    Solid,
    /// Farther from the solid than the band.
    Fluid,
    /// No cell of the domain.
    Outside,
}

/// Weights at the corners of all cells.
#[derive(Clone, Debug, PartialEq)]
pub struct CornerWeights {
    /// The different ones, in the order of the element's corners.
    pub palette: Vec<[f64; 8]>,
    /// Per cell, by its number, the place in the palette.
    pub of_cell: Vec<u32>,
}

impl CornerWeights {
    /// Those of a cell, by its number.
    pub fn of(&self, cell: usize) -> [f64; 8] {
        self.palette[self.of_cell[cell] as usize]
    }
}

impl Levels {
    /// Numbers the nodes. `grid` is that of level 0, `levels[0]` are its cells; the lists are as
    /// [`Asset::check`](volmap_formats::asset::Asset::check) wants them.
    ///
    /// # Errors
    /// A cell within another one; cells that touch and differ by two levels or more; too many nodes.
    pub fn new(grid: Grid, levels: &[LevelCells]) -> Result<Levels, LevelsError> {
        Levels::for_values(grid, levels, usize::MAX)
    }

    /// As [`Levels::new`], for so many values at free nodes. The memory that it takes is in proportion to them and to
    /// the runs.
    pub(crate) fn for_values(
        grid: Grid,
        levels: &[LevelCells],
        values: usize,
    ) -> Result<Levels, LevelsError> {
        let refined = checked(grid.resolution, levels, values as u64)?;
        let numbered = number(levels)?;
        Ok(Levels::assemble(grid, levels, &refined, numbered))
    }

    /// What queries need of it.
    pub(crate) fn into_tree(self) -> Tree {
        self.tree
    }

    fn assemble(grid: Grid, cells: &[LevelCells], refined: &[Vec<CellRun>], levels: Vec<Level>) -> Levels {
        let mut runs = Vec::new();
        let mut count = 0;
        for (level, of_level) in levels.iter().enumerate() {
            for (run, &bases) in of_level.band.iter().zip(&of_level.nodes.bases) {
                runs.push(LeafRun { first: run.i, level: level as u32, cell: count, bases });
                count += run.len;
            }
        }
        let constrained: usize = levels.iter().map(|level| level.constrained.len()).sum();
        let free_count = levels.last().map_or(0, |level| level.nodes.end as usize) - constrained;
        let tree = Tree::new(grid.resolution, cells, refined, runs);
        Levels { grid, tree, levels, cells: count, free_count }
    }

    /// Number of all nodes, the constrained ones included.
    pub fn count(&self) -> usize {
        self.levels.last().map_or(0, |level| level.nodes.end as usize)
    }

    /// Number of the free nodes: those whose values are stored.
    pub fn free_count(&self) -> usize {
        self.free_count
    }

    /// Number of the band's cells.
    pub fn cell_count(&self) -> usize {
        self.cells as usize
    }

    /// The lattice of a level.
    pub fn grid(&self, level: u32) -> Grid {
        self.grid.refined(level)
    }

    /// Where all nodes are, metres, in the order of their numbers.
    pub fn positions(&self) -> Vec<DVec3> {
        let mut out = Vec::with_capacity(self.count());
        for (level, of_level) in self.levels.iter().enumerate() {
            let grid = self.grid(level as u32);
            for (family, rows) in Family::ALL.into_iter().zip(&of_level.nodes.families) {
                for row in rows {
                    let points = row.intervals.iter().flat_map(|interval| interval.first..interval.end);
                    for corner in points.map(|i| DVec3::new(i.into(), row.j.into(), row.k.into())) {
                        let place = |t| grid.origin + grid.cell_size * (corner + family.offset(t));
                        out.extend((0..family.nodes_per_point()).map(place));
                    }
                }
            }
        }
        out
    }

    /// The numbers of the free nodes among all, ascending: the order of the stored values.
    pub fn free(&self) -> impl Iterator<Item = u32> + '_ {
        self.levels.iter().zip(self.starts()).flat_map(|(level, start)| level.free(start..level.nodes.end))
    }

    /// The numbers of the free corner nodes among all, ascending: the order of the stored weights.
    pub fn free_corners(&self) -> impl Iterator<Item = u32> + '_ {
        let levels = self.levels.iter().zip(self.starts());
        levels.flat_map(|(level, start)| level.free(start..level.nodes.corners_end))
    }

    /// Number of the free corner nodes.
    pub fn free_corner_count(&self) -> usize {
        self.free_corners().count()
    }

    /// Number of the first node of each level.
    fn starts(&self) -> impl Iterator<Item = u32> + '_ {
        std::iter::once(0).chain(self.levels.iter().map(|level| level.nodes.end))
    }

    /// The values at all nodes, from those at the free ones. Panics if they are fewer.
    pub fn complete(&self, free: &[f64]) -> Vec<f64> {
        let mut all = Vec::new();
        self.complete_into(free, &mut all);
        all
    }

    /// The same in memory that is there already.
    pub fn complete_into(&self, free: &[f64], all: &mut Vec<f64>) {
        let free = free[..self.free_count].iter().copied();
        self.fill(free, all, |all, parts| parts.map(|(node, part)| part * all[node]).sum());
    }

    /// The same of several fields at once, which are computed in double precision.
    pub(crate) fn complete_all<T: Copy + Default, const N: usize>(
        &self,
        free: impl Iterator<Item = [T; N]>,
        wide: fn(T) -> f64,
        narrow: fn(f64) -> T,
    ) -> Vec<[T; N]>
    where
        [T; N]: Default,
    {
        let mut all = Vec::new();
        self.fill(free, &mut all, |all, parts| {
            let mut sum = [0.0; N];
            for (node, part) in parts {
                let values: [T; N] = all[node];
                sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += part * wide(value));
            }
            sum.map(narrow)
        });
        all
    }

    /// Values at the free nodes, and at constrained ones what follows from the nodes and parts that they depend on.
    fn fill<T: Copy + Default>(
        &self,
        free: impl Iterator<Item = T>,
        all: &mut Vec<T>,
        follows: impl Fn(&[T], &mut dyn Iterator<Item = (usize, f64)>) -> T,
    ) {
        all.resize(self.count(), T::default());
        for (number, value) in self.free().zip(free) {
            all[number as usize] = value;
        }
        self.constrain(|node, at, numbers| {
            let parts = constrain::SHAPES.parts(at.sixths);
            all[node] = follows(all, &mut parts.map(|(a, part)| (numbers[a] as usize, part)));
        });
    }

    /// The transposed of [`Levels::complete`]: numbers at all nodes, those at constrained ones shared out to the nodes that
    /// they follow from, at the free ones. What a fit of the free values needs. The numbers given are used up.
    pub fn share_out(&self, all: &mut [f64]) -> Vec<f64> {
        let shapes = &*constrain::SHAPES;
        for pair in self.levels.windows(2).rev() {
            let (coarse, level) = (&pair[0], &pair[1]);
            for at in &level.constrained {
                let numbers = Starts::advanced(coarse.nodes.bases[at.run as usize], at.steps).all();
                let value = all[at.node as usize];
                shapes.parts(at.sixths).for_each(|(a, part)| all[numbers[a] as usize] += part * value);
            }
        }
        self.free().map(|node| all[node as usize]).collect()
    }

    /// The weights at the corners of all cells, from those at the free corner nodes. Panics if they are fewer.
    pub fn complete_weights(&self, free: &[u32]) -> CornerWeights {
        // The same everywhere, as a rule.
        if let [first, rest @ ..] = free
            && rest.iter().all(|weight| weight == first)
        {
            return CornerWeights {
                palette: vec![[f64::from(*first); 8]],
                of_cell: vec![0; self.cell_count()],
            };
        }
        let mut all = vec![0.0; self.count()];
        for (place, number) in self.free_corners().enumerate() {
            all[number as usize] = f64::from(free[place]);
        }
        let corners = |all: &[f64], numbers: &[u32; NODES]| -> [f64; 8] {
            std::array::from_fn(|a| all[numbers[a] as usize])
        };
        self.constrain(|node, at, numbers| {
            if at.sixths.iter().all(|sixths| sixths % 3 == 0) {
                all[node] = constrain::trilinear(at.sixths, &corners(&all, numbers));
            }
        });
        let mut places = HashMap::new();
        let mut weights =
            CornerWeights { palette: Vec::new(), of_cell: Vec::with_capacity(self.cell_count()) };
        for cell in self.cells() {
            let of_cell = corners(&all, &cell.nodes);
            let place = *places.entry(of_cell.map(f64::to_bits)).or_insert_with(|| {
                weights.palette.push(of_cell);
                weights.palette.len() as u32 - 1
            });
            weights.of_cell.push(place);
        }
        weights
    }

    /// Every constrained node, from coarse levels to fine ones, with the numbers of its cell's nodes.
    fn constrain(&self, mut each: impl FnMut(usize, &Constrained, &[u32; NODES])) {
        for pair in self.levels.windows(2) {
            let (coarse, level) = (&pair[0], &pair[1]);
            for at in &level.constrained {
                let numbers = Starts::advanced(coarse.nodes.bases[at.run as usize], at.steps).all();
                each(at.node as usize, at, &numbers);
            }
        }
    }

    /// Every cell of the band, by its number.
    pub fn cells(&self) -> impl Iterator<Item = LevelCell> + '_ {
        let of_level = move |(level, of_level): (usize, &'_ Level)| {
            let first = of_level.first_run as usize;
            let runs = &self.tree.runs()[first..first + of_level.band.len()];
            let runs: Vec<(CellRun, LeafRun)> =
                of_level.band.iter().copied().zip(runs.iter().copied()).collect();
            runs.into_iter().flat_map(move |(cells, run)| {
                (0..cells.len).map(move |steps| LevelCell {
                    level: level as u32,
                    index: UVec3::new(cells.i + steps, cells.j, cells.k),
                    number: (run.cell + steps) as usize,
                    nodes: Starts::advanced(run.bases, steps).all(),
                })
            })
        };
        self.levels.iter().enumerate().flat_map(of_level)
    }

    /// What holds a point; a point on a face between two cells is in the upper one, on the domain's upper faces in the
    /// last one.
    pub fn find(&self, point: DVec3) -> Held {
        let Some((cell, mut f)) = self.grid.cell_and_place(point) else { return Held::Outside };
        match self.tree.place(cell, &mut f, &mut { TreeHint::NONE }) {
            Found::Solid => Held::Solid,
            Found::Fluid => Held::Fluid,
            Found::Band(place) => Held::Band {
                number: self.tree.cell(place),
                level: self.tree.level(place),
                xi: f * 2.0 - DVec3::ONE,
            },
        }
    }
}

impl Level {
    /// The free ones among some nodes.
    fn free(&self, nodes: std::ops::Range<u32>) -> impl Iterator<Item = u32> + '_ {
        let mut constrained = self.constrained.iter().map(|at| at.node).peekable();
        nodes.filter(move |&node| constrained.next_if_eq(&node).is_none())
    }
}

/// The cells of each level that hold finer ones.
fn checked(resolution: UVec3, levels: &[LevelCells], values: u64) -> Result<Vec<Vec<CellRun>>, LevelsError> {
    // A cell of a finer level has a free node in the middle of its parent, which eight share at most, and 12 on the
    // edges that end there; one of level 0 has 32 that it shares. So there are more free nodes than cells.
    let enough = |cells: u64, spare: u64| match cells > values.saturating_add(spare) {
        true => Err(LevelsError::TooFewValues { cells, values }),
        false => Ok(()),
    };
    let count = |runs: &mut dyn Iterator<Item = &CellRun>| runs.map(|run| u64::from(run.len)).sum::<u64>();
    enough(count(&mut levels.iter().flat_map(|level| &level.band)), 0)?;
    let refined = tree::refined(levels);
    let blocks = count(&mut refined.iter().flatten());
    enough(blocks, 1 << 16)?;
    let runs: usize = levels.iter().map(|level| level.band.len()).sum();
    if runs >= MOST || blocks >= MOST as u64 {
        return Err(LevelsError::TooMany);
    }
    check::partition(levels, &refined)?;
    check::balance(resolution, levels)?;
    Ok(refined)
}

fn number(levels: &[LevelCells]) -> Result<Vec<Level>, LevelsError> {
    let (mut end, mut first_run) = (0, 0);
    let mut out: Vec<Level> = Vec::with_capacity(levels.len());
    for cells in levels {
        let rows = Rows::new(&cells.band);
        let nodes = LevelNodes::new(&rows, end).ok_or(LevelsError::TooMany)?;
        let before = out.last().map(|level| Rows::new(&level.band));
        let constrained = before.map_or_else(Vec::new, |coarse| constrain::constrained(&nodes, &coarse));
        end = nodes.end;
        out.push(Level { band: cells.band.clone(), first_run, nodes, constrained });
        first_run += cells.band.len() as u32;
    }
    Ok(out)
}
