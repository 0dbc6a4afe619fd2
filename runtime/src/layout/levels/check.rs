//! What the cells of all levels have to be to each other.

use super::error::LevelsError;
use super::rows::{Rows, union};
use glam::UVec3;
use volmap_formats::asset::{CellRun, LevelCells};

/// No cell holds another one. `refined` are the cells of each level that hold finer ones.
pub(super) fn partition(levels: &[LevelCells], refined: &[Vec<CellRun>]) -> Result<(), LevelsError> {
    for (level, (cells, refined)) in levels.iter().zip(refined).enumerate() {
        let refined = Rows::new(refined);
        for run in cells.band.iter().chain(&cells.solid) {
            if let Some(holds) = refined.overlap(run.j, run.k, run.i..run.i + run.len) {
                let cell = UVec3::new(holds.i.max(run.i), run.j, run.k);
                return Err(LevelsError::Nested { level: level as u32, cell });
            }
        }
    }
    Ok(())
}

/// Cells of the band that touch, at a corner even, differ by one level at most.
pub(super) fn balance(resolution: UVec3, levels: &[LevelCells]) -> Result<(), LevelsError> {
    // Cells of a level that touch some of the band two levels finer or more.
    let mut touched: Vec<CellRun> = Vec::new();
    for level in (0..levels.len().saturating_sub(2)).rev() {
        let resolution = (resolution * (1 << level)).to_array();
        let mut of_level = Vec::with_capacity(levels[level + 2].band.len() + touched.len());
        levels[level + 2].band.iter().for_each(|run| add_touched(run, 2, 1, resolution, &mut of_level));
        touched.iter().for_each(|run| add_touched(run, 1, 0, resolution, &mut of_level));
        touched = union(of_level);
        let rows = Rows::new(&touched);
        for run in &levels[level].band {
            if let Some(fine) = rows.overlap(run.j, run.k, run.i..run.i + run.len) {
                let cell = UVec3::new(fine.i.max(run.i), run.j, run.k);
                return Err(LevelsError::Unbalanced { level: level as u32, cell });
            }
        }
    }
    Ok(())
}

/// The cells, `levels` coarser, that hold those of a run and `grown` cells around it.
fn add_touched(run: &CellRun, levels: u32, grown: u32, resolution: [u32; 3], out: &mut Vec<CellRun>) {
    let range = |start: u32, len: u32, axis: usize| {
        let last = (start + len - 1 + grown) >> levels;
        (start.saturating_sub(grown) >> levels, last.min(resolution[axis] - 1))
    };
    let (i, last_i) = range(run.i, run.len, 0);
    let (j, last_j) = range(run.j, 1, 1);
    let (k, last_k) = range(run.k, 1, 2);
    for k in k..=last_k {
        for j in j..=last_j {
            let next = CellRun { i, j, k, len: last_i - i + 1 };
            if out.last() != Some(&next) {
                out.push(next);
            }
        }
    }
}
