//! Cells of which a map says nothing: SPlisHSPlasH may leave out those far from the surface, on both sides. A connected
//! set of them doesn't touch the surface, so it is what its stored neighbours are.

use super::{Kind, cell_values};
use volmap_formats::export::cdm::{DiscreteGrid, NODES, UNSAMPLED};
use volmap_runtime::layout::serendipity::node;

/// Makes each removed cell fluid or solid; fluid where nothing is stored beside it.
///
/// # Errors
/// Removed cells between fluid and solid.
pub(super) fn fill_removed(grid: &DiscreteGrid, kinds: &mut [Kind]) -> Result<(), String> {
    for start in 0..kinds.len() {
        if kinds[start] != Kind::Removed {
            continue;
        }
        kinds[start] = Kind::Fluid;
        let mut component = vec![start];
        let (mut is_solid, mut is_fluid, mut next) = (false, false, 0);
        while let Some(&cell) = component.get(next) {
            next += 1;
            for (neighbour, axis, side) in neighbours(grid.resolution, cell) {
                if kinds[neighbour] == Kind::Removed {
                    kinds[neighbour] = Kind::Fluid;
                    component.push(neighbour);
                } else {
                    let values = face_values(grid, neighbour, axis, -side);
                    is_solid |= values.iter().any(|d| *d < 0.0);
                    is_fluid |= values.iter().any(|d| *d > 0.0);
                }
            }
        }
        if is_fluid && is_solid {
            return Err(
                "cells that it leaves out lie between fluid and solid: there it has no surface".into()
            );
        }
        if is_solid {
            component.iter().for_each(|&cell| kinds[cell] = Kind::Solid);
        }
    }
    Ok(())
}

/// Cells that share a face with a cell: their number, the axis, and -1 or 1 for the direction to them.
fn neighbours(resolution: [u32; 3], cell: usize) -> impl Iterator<Item = (usize, usize, f64)> {
    let n = resolution.map(|n| n as usize);
    let at = [cell % n[0], cell / n[0] % n[1], cell / (n[0] * n[1])];
    let strides = [1, n[0], n[0] * n[1]];
    (0..3).flat_map(move |axis| {
        let lower = (at[axis] > 0).then(|| (cell - strides[axis], axis, -1.0));
        let upper = (at[axis] + 1 < n[axis]).then(|| (cell + strides[axis], axis, 1.0));
        lower.into_iter().chain(upper)
    })
}

/// The distances on a face of a cell, if it is stored: cells that were removed say nothing.
fn face_values(grid: &DiscreteGrid, cell: usize, axis: usize, side: f64) -> Vec<f64> {
    let values = cell_values(&grid.fields[0], cell).filter(|values| !values.contains(&UNSAMPLED));
    let on_face = |a: &usize| node(*a)[axis] == side;
    values.map_or(Vec::new(), |values| (0..NODES).filter(on_face).map(|a| values[a]).collect())
}
