//! Equally spaced points over a map's domain, its border included.

use crate::error::Error;
use volmap_runtime::{DVec3, Grid, VolumeMap};

/// How dense the points are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LatticeChoice {
    /// This many steps along x, y, z.
    Resolution([u32; 3]),
    /// Steps of this length, metres, or a little less, so that they fill the domain.
    CellSize(f64),
}

/// The points.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Coordinates along x, y, z, metres.
    axes: [Vec<f64>; 3],
}

impl Lattice {
    /// Over the domain of a map; without a choice in `per_cell` steps a cell, of adaptive maps the smallest cells that give
    /// no more points than `most`.
    ///
    /// # Errors
    /// No points, or more than `most`.
    pub fn over(
        map: &VolumeMap,
        choice: Option<LatticeChoice>,
        per_cell: u32,
        most: u64,
    ) -> Result<Lattice, Error> {
        let steps = u64::from(per_cell).pow(3);
        Lattice::new(&map.finest_grid(most / 2 / steps), choice, per_cell, most)
    }

    /// Over the domain of `grid`; without a choice in `per_cell` steps a cell.
    ///
    /// # Errors
    /// No points, or more than `most`.
    pub fn new(
        grid: &Grid,
        choice: Option<LatticeChoice>,
        per_cell: u32,
        most: u64,
    ) -> Result<Lattice, Error> {
        let cells = grid.resolution.as_dvec3();
        let steps = match choice {
            None => cells * f64::from(per_cell),
            Some(LatticeChoice::Resolution(steps)) => DVec3::from(steps.map(f64::from)),
            Some(LatticeChoice::CellSize(edge)) if edge > 0.0 => {
                (cells * grid.cell_size / edge - 1e-9).ceil()
            }
            Some(LatticeChoice::CellSize(edge)) => {
                return Err(Error::setting("cell_size", format!("{edge} m is not a length")));
            }
        };
        let points = (steps.max(DVec3::ZERO) + DVec3::ONE).element_product();
        if steps.min_element() < 1.0 || points > most as f64 {
            let reason = format!(
                "{} x {} x {} steps are {points:.3e} points; take 1 step at least and {most} points at most",
                steps.x, steps.y, steps.z
            );
            return Err(Error::setting("resolution", format!("{reason} (by this or `cell_size`)")));
        }
        Ok(Lattice { axes: [0, 1, 2].map(|axis| coordinates(grid, axis, steps[axis] as u32)) })
    }

    /// Points along x, y, z.
    pub fn points(&self) -> [usize; 3] {
        self.axes.each_ref().map(Vec::len)
    }

    /// Place of a point, metres.
    pub fn point(&self, [i, j, k]: [usize; 3]) -> DVec3 {
        DVec3::new(self.axes[0][i], self.axes[1][j], self.axes[2][k])
    }
}

/// Corners of cells have the bits that the grid gives them; rounding takes no point out of the domain.
fn coordinates(grid: &Grid, axis: usize, steps: u32) -> Vec<f64> {
    let cells = f64::from(grid.resolution[axis]);
    let place =
        |step: u32| grid.origin[axis] + grid.cell_size[axis] * (f64::from(step) * cells / f64::from(steps));
    let mut out: Vec<f64> = (0..=steps).map(place).collect();
    if let Some(last) = out.last_mut() {
        while (*last - grid.origin[axis]) / grid.cell_size[axis] > cells {
            *last = last.next_down();
        }
    }
    out
}
