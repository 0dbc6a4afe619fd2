//! The signed distance discretised on a band of cells: Bender et al. 2020, section 5, step 1.

use super::band::BandCells;
use super::boundary_distance::SignedDistance;
use crate::rows::fill_rows;
use glam::{DVec3, UVec3};
use volmap_formats::asset::Exterior;
use volmap_runtime::serendipity::shape;
use volmap_runtime::{Cell, CellIndex, Grid, Nodes};

/// Signed distance at the nodes of a band; whole cells of solid or fluid beyond.
#[derive(Clone, Debug)]
pub struct DistanceField {
    /// The lattice of cells.
    pub grid: Grid,
    /// Which cells have values.
    pub cells: CellIndex,
    /// Value of each node, metres, negative inside the solid.
    pub values: Vec<f64>,
    /// What lies outside the grid.
    pub exterior: Exterior,
}

/// Distance as far as the field knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phi {
    /// In the band: metres.
    Value(f64),
    /// Deeper than the band.
    Solid,
    /// Farther than the band.
    Fluid,
}

impl DistanceField {
    /// Samples `phi` at every node of the band's cells.
    pub fn sample(
        grid: Grid,
        cells: &BandCells,
        nodes: &Nodes,
        exterior: Exterior,
        phi: &impl SignedDistance,
    ) -> DistanceField {
        let values = fill_rows(
            nodes,
            || None,
            |last_row, row, out| {
                // A row begins near the beginning of the last.
                let mut known = *last_row;
                for (n, (value, point)) in out.iter_mut().zip(row.positions(&grid)).enumerate() {
                    *value = phi.near(point, &mut known);
                    if n == 0 {
                        *last_row = known;
                    }
                }
            },
        );
        let cells = CellIndex::new(grid.resolution, &cells.band, &cells.solid, nodes);
        DistanceField { grid, cells, values, exterior }
    }

    /// What is known of a cell, which may lie outside the grid.
    pub fn cell(&self, i: i64, j: i64, k: i64) -> Cell {
        let n = self.grid.resolution;
        let inside = |at: i64, n: u32| (0..i64::from(n)).contains(&at);
        match (inside(i, n.x) && inside(j, n.y) && inside(k, n.z), self.exterior) {
            (true, _) => self.cells.find(UVec3::new(i as u32, j as u32, k as u32)),
            (false, Exterior::Solid) => Cell::Solid,
            (false, Exterior::Fluid) => Cell::Fluid,
        }
    }

    /// Interpolated distance at any point.
    pub fn at(&self, point: DVec3) -> Phi {
        let cell = match self.grid.locate(point) {
            Some(location) => (self.cells.find(location.cell), location.xi),
            None if self.exterior == Exterior::Solid => return Phi::Solid,
            None => return Phi::Fluid,
        };
        match cell {
            (Cell::Band(numbers), xi) => {
                let terms = shape(xi).into_iter().zip(numbers.all());
                Phi::Value(terms.map(|(n, number)| n * self.values[number as usize]).sum())
            }
            (Cell::Solid, _) => Phi::Solid,
            (Cell::Fluid, _) => Phi::Fluid,
        }
    }
}
