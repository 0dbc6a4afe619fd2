//! The signed distance discretised on a band of cells: Bender et al. 2020, section 5, step 1.

use super::band::BandCells;
use super::boundary_distance::SignedDistance;
use super::mesh_distance::Neighbours;
use super::sides::set_signs;
use crate::rows::{RowCluster, fill_clusters};
use crate::watch::{Cancelled, Work};
use glam::DVec3;
use volmap_formats::asset::Exterior;
use volmap_runtime::Grid;
use volmap_runtime::layout::serendipity::shape;
use volmap_runtime::layout::{Cell, CellIndex, Nodes};

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
        let values = values(&grid, nodes, phi, &Work::default());
        let values = values.unwrap_or_else(|Cancelled| unreachable!("nobody has the request"));
        let cells = CellIndex::new(grid.resolution, &cells.band, &cells.solid, nodes);
        DistanceField { grid, cells, values, exterior }
    }

    /// Puts the values at the nodes of the band's cells in place.
    pub fn new(
        grid: Grid,
        cells: &BandCells,
        nodes: &Nodes,
        exterior: Exterior,
        values: Vec<f64>,
    ) -> DistanceField {
        let cells = CellIndex::new(grid.resolution, &cells.band, &cells.solid, nodes);
        DistanceField { grid, cells, values, exterior }
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

/// Lattice points whose nodes are worked on in turn, at most.
const LONGEST: u32 = 64;

/// Phi at the nodes of a grid, in the order of their numbers; each counts as work. The nodes of a lattice point, and of
/// the edges that begin there, are asked together.
///
/// # Errors
/// [`Cancelled`].
pub fn values(
    grid: &Grid,
    nodes: &Nodes,
    phi: &impl SignedDistance,
    work: &Work,
) -> Result<Vec<f64>, Cancelled> {
    let separate = phi.has_separate_signs();
    let fill = |near: &mut Neighbours, cluster: &mut RowCluster| {
        if work.is_cancelled() {
            return;
        }
        for i in cluster.first..cluster.end {
            let (mut points, mut count) = ([DVec3::ZERO; Neighbours::MAX], 0);
            for (row, _) in cluster.rows.iter().filter(|(row, _)| row.holds(i)) {
                for t in 0..row.family.nodes_per_point() {
                    points[count] = row.position(grid, i, t);
                    count += 1;
                }
            }
            phi.prepare(&points[..count], near, !separate);
            let mut asked = points[..count].iter().zip(&mut near.known);
            for (row, own) in cluster.rows.iter_mut().filter(|(row, _)| row.holds(i)) {
                for (value, (point, known)) in row.nodes_mut(i, own).iter_mut().zip(asked.by_ref()) {
                    *value = match separate {
                        true => phi.size_near(*point, known),
                        false => phi.near(*point, known),
                    };
                }
            }
            work.add(count as u64);
        }
    };
    let mut values = fill_clusters(nodes, LONGEST, Neighbours::default, fill);
    work.check()?;
    if separate {
        set_signs(grid, nodes, &mut values, phi);
    }
    Ok(values)
}
