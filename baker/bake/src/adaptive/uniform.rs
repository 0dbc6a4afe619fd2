//! An adaptive map with cells of one size: for programs and formats that know no others.
//!
//! A cell that is as small as the adaptive one it lies in, or smaller, has its polynomial exactly. So of distances and of
//! volumes that are stored plainly nothing changes as long as the cells are the smallest ones.

use crate::error::Error;
use crate::sdf::band::joined;
use glam::{DVec3, UVec3};
use std::collections::BTreeSet;
use volmap_formats::asset::{Array, Asset, CellRun, LevelCells};
use volmap_runtime::layout::serendipity::{NODES, node, shape};
use volmap_runtime::layout::{CellIndex, CornerWeights, FlatWall, Held, LevelCell, Levels, Nodes};
use volmap_runtime::{Grid, layout::Cell};

/// The same map with equal cells: the smallest, or, where that were more than `max_cells`, larger ones. Uniform maps stay
/// as they are.
///
/// # Errors
/// Cells that aren't those of a map.
pub fn uniform(asset: &Asset, max_cells: u64) -> Result<Asset, Error> {
    if !asset.is_adaptive() {
        return Ok(asset.clone());
    }
    let source = Source::new(asset)?;
    let level =
        (0..=asset.finer.len() as u32).rev().find(|&level| source.count(level) <= max_cells).unwrap_or(0);
    source.at(level)
}

struct Source<'a> {
    asset: &'a Asset,
    lists: Vec<LevelCells>,
    levels: Levels,
    cells: Vec<LevelCell>,
    distance: Vec<f64>,
    volume: Vec<f64>,
    weights: Option<(CornerWeights, FlatWall)>,
}

impl Source<'_> {
    fn new(asset: &Asset) -> Result<Source<'_>, Error> {
        let lists = asset.levels();
        let wrong = |error: String| Error::setting("asset", error);
        let levels = Levels::new(Grid::from(asset.grid), &lists).map_err(|error| wrong(error.to_string()))?;
        let complete = |field: &Array| match field.len() == levels.free_count() {
            true => Ok(levels.complete(&field.to_f64())),
            false => Err(wrong("has other values than nodes".into())),
        };
        let (distance, volume) = (complete(&asset.signed_distance)?, complete(&asset.volume)?);
        let weights = asset.plane_weight.as_ref().filter(|free| free.len() == levels.free_corner_count());
        let wall = FlatWall::new(asset.support_radius, asset.quadrature.ball_volume);
        let weights = weights.map(|free| (levels.complete_weights(free), wall));
        let cells = levels.cells().collect();
        Ok(Source { asset, lists, levels, cells, distance, volume, weights })
    }

    /// Cells of the band, about, if all were of this level.
    fn count(&self, level: u32) -> u64 {
        let of_level = |(own, cells): (u32, u64)| match own > level {
            true => cells >> (3 * (own - level)).min(63),
            false => cells << (3 * (level - own)).min(40),
        };
        (0..).zip(self.asset.cells_by_level()).map(of_level).sum()
    }

    /// The map on the cells of a level.
    fn at(&self, level: u32) -> Result<Asset, Error> {
        let band = self.runs(level, |cells| &cells.band);
        let solid = without(self.runs(level, |cells| &cells.solid), &band);
        let grid = self.levels.grid(level);
        let too_many = || Error::setting("asset", "has too many cells for one size");
        let nodes = Nodes::new(grid.resolution, &band).ok_or_else(too_many)?;
        let index = CellIndex::new(grid.resolution, &band, &solid, &nodes);
        let mut values = [vec![0.0; nodes.count()], vec![0.0; nodes.count()]];
        for run in &band {
            for at in (run.i..run.i + run.len).map(|i| UVec3::new(i, run.j, run.k)) {
                let Cell::Band(numbers) = index.find(at) else { continue };
                let low = grid.cell_corner(at);
                for (a, number) in numbers.all().into_iter().enumerate() {
                    let place = low + grid.cell_size * (0.5 * (node(a) + DVec3::ONE));
                    let [distance, volume] = self.values(place, low + 0.5 * grid.cell_size);
                    values[0][number as usize] = distance;
                    values[1][number as usize] = volume;
                }
            }
        }
        let [distance, volume] = values.map(Array::F64);
        Ok(Asset {
            grid: grid.into(),
            band_cells: band,
            solid_cells: solid,
            finer: Vec::new(),
            plane_weight: None,
            signed_distance: distance,
            volume,
            ..self.asset.clone()
        })
    }

    /// Phi and V at a place, by the cell that holds a point near it, or one that touches that.
    fn values(&self, place: DVec3, within: DVec3) -> [f64; 2] {
        let held = [within, place].into_iter().find_map(|point| match self.levels.find(point) {
            Held::Band { number, level, .. } => Some((number, level)),
            _ => None,
        });
        let Some((number, level)) = held else { return self.beyond(within) };
        let (cell, grid) = (&self.cells[number], self.levels.grid(level));
        let xi = (place - grid.cell_corner(cell.index)) / grid.cell_size * 2.0 - DVec3::ONE;
        let parts: [f64; NODES] = shape(xi);
        let sum = |values: &[f64]| -> f64 {
            parts.iter().zip(&cell.nodes).map(|(n, node)| n * values[*node as usize]).sum()
        };
        let (distance, mut volume) = (sum(&self.distance), sum(&self.volume));
        if let Some((weights, wall)) = &self.weights {
            volume += part_of(&trilinear(xi), &weights.of(number)) * wall.volume(distance);
        }
        // A fit overshoots by a part of its tolerance; a volume is none then.
        [distance, volume.clamp(0.0, self.asset.quadrature.ball_volume)]
    }

    /// Where no cell is stored: as far as the band is wide.
    fn beyond(&self, point: DVec3) -> [f64; 2] {
        let width = 2.0 * self.asset.support_radius;
        match self.levels.find(point) {
            Held::Solid => [-width, self.asset.quadrature.ball_volume],
            _ => [width, 0.0],
        }
    }

    /// The cells of a level that larger ones hold, or that hold smaller ones.
    fn runs(&self, level: u32, of: impl Fn(&LevelCells) -> &Vec<CellRun>) -> Vec<CellRun> {
        let mut rows = BTreeSet::new();
        for (own, cells) in self.lists.iter().enumerate() {
            let own = own as u32;
            for run in of(cells) {
                if own <= level {
                    let times = 1 << (level - own);
                    for (dk, dj) in (0..times).flat_map(|dk| (0..times).map(move |dj| (dk, dj))) {
                        rows.insert((run.k * times + dk, run.j * times + dj, run.i * times, run.len * times));
                    }
                } else {
                    let down = own - level;
                    let (first, last) = (run.i >> down, (run.i + run.len - 1) >> down);
                    (first..=last).for_each(|i| _ = rows.insert((run.k >> down, run.j >> down, i, 1)));
                }
            }
        }
        joined(rows.into_iter().map(|(k, j, i, len)| CellRun { i, j, k, len }).collect())
    }
}

/// The runs without the cells that lie in others.
fn without(runs: Vec<CellRun>, others: &[CellRun]) -> Vec<CellRun> {
    let is_free = |i: u32, run: &CellRun| {
        let at = others.partition_point(|other| (other.k, other.j, other.i + other.len) <= (run.k, run.j, i));
        others.get(at).is_none_or(|other| (other.k, other.j) != (run.k, run.j) || other.i > i)
    };
    let single = |run: CellRun| {
        let free = (run.i..run.i + run.len).filter(move |&i| is_free(i, &run));
        free.map(move |i| CellRun { i, len: 1, ..run }).collect::<Vec<_>>()
    };
    joined(runs.into_iter().flat_map(single).collect())
}

/// The trilinear value of these corners.
fn part_of(parts: &[f64; 8], corners: &[f64; 8]) -> f64 {
    parts.iter().zip(corners).map(|(n, w)| n * w).sum()
}

/// The parts that the corners' values have in the trilinear value at a place in [-1, 1]^3.
fn trilinear(xi: DVec3) -> [f64; 8] {
    std::array::from_fn(|corner| {
        let side = |axis: usize| 0.5 * (1.0 + xi[axis] * (2.0 * (corner >> axis & 1) as f64 - 1.0));
        side(0) * side(1) * side(2)
    })
}
