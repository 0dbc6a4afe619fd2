//! Cells as they are stored: runs of 4 numbers, in version 5 of 5, the level first.

use super::MAX_LEVELS;
#[cfg(feature = "write")]
use super::attributes;
#[cfg(feature = "write")]
use crate::asset::Asset;
use crate::asset::error::AssetError;
#[cfg(feature = "write")]
use crate::asset::tree::Dataset;
use crate::asset::tree::{Array, Tree};
use crate::asset::{CellRun, LevelCells};

const BAND: &str = "/cells/band";
const SOLID: &str = "/cells/solid";

/// Both tables.
#[cfg(feature = "write")]
pub(super) fn datasets(asset: &Asset) -> [(&'static str, Dataset); 2] {
    let finer = |cells: fn(&LevelCells) -> &[CellRun]| asset.finer.iter().map(cells);
    let band = std::iter::once(asset.band_cells.as_slice()).chain(finer(|cells| &cells.band));
    let solid = std::iter::once(asset.solid_cells.as_slice()).chain(finer(|cells| &cells.solid));
    let levels = asset.is_adaptive();
    [
        (BAND, table(band, levels, "cells that are stored")),
        (SOLID, table(solid, levels, "cells deeper in the solid than the band")),
    ]
}

#[cfg(feature = "write")]
fn table<'a>(by_level: impl Iterator<Item = &'a [CellRun]>, levels: bool, description: &str) -> Dataset {
    let (mut numbers, mut runs) = (Vec::new(), 0);
    for (level, cells) in by_level.enumerate() {
        runs += cells.len();
        for run in cells {
            numbers.extend(levels.then_some(level as u32));
            numbers.extend([run.i, run.j, run.k, run.len]);
        }
    }
    let (columns, text) = match levels {
        true => (5, "level, i, j, k, length: cells (i .. i+length, j, k) of the level"),
        false => (4, "i, j, k, length: cells (i .. i+length, j, k)"),
    };
    Dataset {
        array: Array::U32(numbers),
        shape: vec![runs, columns],
        attributes: attributes([("columns", text.into()), ("description", description.into())]),
    }
}

/// The cells of each level, one at least.
pub(super) fn from_tree(tree: &Tree, with_levels: bool) -> Result<Vec<LevelCells>, AssetError> {
    let mut levels = vec![LevelCells::default()];
    if with_levels {
        put(tree, BAND, &mut levels, |cells| &mut cells.band)?;
        put(tree, SOLID, &mut levels, |cells| &mut cells.solid)?;
    } else {
        let run = |n: &[u32]| CellRun { i: n[0], j: n[1], k: n[2], len: n[3] };
        levels[0].band = numbers(tree, BAND, 4)?.chunks_exact(4).map(run).collect();
        levels[0].solid = numbers(tree, SOLID, 4)?.chunks_exact(4).map(run).collect();
    }
    Ok(levels)
}

fn put(
    tree: &Tree,
    path: &str,
    levels: &mut Vec<LevelCells>,
    list: fn(&mut LevelCells) -> &mut Vec<CellRun>,
) -> Result<(), AssetError> {
    let mut last = 0;
    for (row, n) in numbers(tree, path, 5)?.chunks_exact(5).enumerate() {
        let level = n[0] as usize;
        if level < last {
            return Err(AssetError::invalid(path, format!("row {row} is out of order")));
        }
        if level >= MAX_LEVELS {
            return Err(AssetError::invalid(path, format!("has more than {MAX_LEVELS} levels")));
        }
        last = level;
        levels.resize_with(levels.len().max(level + 1), LevelCells::default);
        list(&mut levels[level]).push(CellRun { i: n[1], j: n[2], k: n[3], len: n[4] });
    }
    Ok(())
}

fn numbers<'a>(tree: &'a Tree, path: &str, columns: usize) -> Result<&'a [u32], AssetError> {
    let dataset = tree.datasets.get(path).ok_or_else(|| AssetError::Missing(path.into()))?;
    match (&dataset.array, dataset.shape.as_slice()) {
        (Array::U32(numbers), &[_, width]) if width == columns => Ok(numbers),
        _ => Err(AssetError::invalid(path, format!("isn't a table of u32 with {columns} columns"))),
    }
}
