//! The lattice of cells: where a point lies, where a node lies.

use glam::{DVec3, UVec3};
use volmap_formats::asset::GridSpec;

/// A box of `resolution` cells of size `cell_size` whose lowest corner is `origin`; metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Lowest corner.
    pub origin: DVec3,
    /// Edge lengths of a cell.
    pub cell_size: DVec3,
    /// Cells along each axis.
    pub resolution: UVec3,
}

/// A cell and the place in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// Index of the cell.
    pub cell: UVec3,
    /// Coordinates in the reference cell [-1, 1]^3.
    pub xi: DVec3,
}

impl Grid {
    /// Highest corner of the domain.
    pub fn max_corner(&self) -> DVec3 {
        self.origin + self.cell_size * self.resolution.as_dvec3()
    }

    /// The same box in cells of half the size, as often as `level` says.
    pub fn refined(&self, level: u32) -> Grid {
        let factor = 1 << level;
        Grid {
            origin: self.origin,
            cell_size: self.cell_size / f64::from(factor),
            resolution: self.resolution * factor,
        }
    }

    /// Lowest corner of a cell.
    pub fn cell_corner(&self, cell: UVec3) -> DVec3 {
        self.origin + self.cell_size * cell.as_dvec3()
    }

    /// Cell and reference coordinates of a point; `None` outside the (closed) domain and for NaN.
    pub fn locate(&self, point: DVec3) -> Option<Location> {
        let (cell, f) = self.cell_and_place(point)?;
        Some(Location { cell, xi: f * 2.0 - DVec3::ONE })
    }

    /// As [`Grid::locate`], with the place in the cell from 0 to 1 along each axis.
    #[inline(always)]
    pub(crate) fn cell_and_place(&self, point: DVec3) -> Option<(UVec3, DVec3)> {
        // No -0: the sum makes it 0, so that all ways to find the cell have the same bits.
        let u = (point - self.origin) / self.cell_size + DVec3::ZERO;
        let n = self.resolution.as_dvec3();
        if !(u.cmpge(DVec3::ZERO).all() && u.cmple(n).all()) {
            return None;
        }
        let cell = u.as_uvec3().min(self.resolution - UVec3::ONE);
        Some((cell, u - cell.as_dvec3()))
    }
}

impl From<GridSpec> for Grid {
    fn from(spec: GridSpec) -> Grid {
        Grid {
            origin: spec.origin.into(),
            cell_size: spec.cell_size.into(),
            resolution: spec.resolution.into(),
        }
    }
}

impl From<Grid> for GridSpec {
    fn from(grid: Grid) -> GridSpec {
        GridSpec {
            origin: grid.origin.into(),
            cell_size: grid.cell_size.into(),
            resolution: grid.resolution.into(),
        }
    }
}
