//! A volume map in memory, and what is known of it as a whole.

use crate::adaptive::AdaptiveCells;
use crate::grid::Grid;
use crate::kernel::KernelKind;
use crate::layout::CellIndex;
use crate::storage::{Pairs, RealPairs, Singles};
use glam::DVec3;
use volmap_formats::asset::{Dimension, Exterior, QuadratureSpec};

/// A volume map, ready to be sampled. Made by [`VolumeMap::open`].
#[derive(Clone, Debug)]
pub struct VolumeMap {
    pub(crate) dimension: Dimension,
    pub(crate) grid: Grid,
    /// 1 / cell_size, for gradients only.
    pub(crate) per_cell: DVec3,
    pub(crate) support_radius: f64,
    pub(crate) exterior: Exterior,
    pub(crate) quadrature: QuadratureSpec,
    pub(crate) content: Content,
    pub(crate) density: Option<DensityNodes>,
}

/// The stored cells, and distance and volume of each node.
#[derive(Clone, Debug)]
pub(crate) enum Content {
    Uniform(CellIndex, Pairs),
    Adaptive(AdaptiveCells, RealPairs),
}

/// The density of a map.
#[derive(Clone, Debug)]
pub(crate) struct DensityNodes {
    pub kernel: KernelKind,
    pub numbers: Singles,
}

impl VolumeMap {
    /// In how many dimensions the map is. In two, z plays no part: volumes are areas (m^2), their gradients are in m,
    /// and directions lie in the plane.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// The lattice of cells; its box is the domain of the map. In two dimensions the cells are endless along z. In
    /// adaptive maps it is that of level 0: the largest cells, of which some are divided.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Levels of cells: 1 in uniform maps; each has cells of half the size of those before.
    pub fn levels(&self) -> u32 {
        match &self.content {
            Content::Uniform(..) => 1,
            Content::Adaptive(cells, _) => cells.tree.levels(),
        }
    }

    /// Edge lengths of the smallest cells, metres: those of [`VolumeMap::grid`] in uniform maps.
    pub fn finest_cell_size(&self) -> DVec3 {
        self.grid.cell_size / f64::from(1u32 << (self.levels() - 1))
    }

    /// The lattice in the smallest cells that are no more than `most`, or the map's own.
    pub fn finest_grid(&self, most: u64) -> Grid {
        let grids = (0..self.levels()).rev().map(|level| self.grid.refined(level));
        let cells = |grid: &Grid| grid.resolution.as_u64vec3().element_product();
        grids.into_iter().find(|grid| cells(grid) <= most).unwrap_or(self.grid)
    }

    /// Whether the volume is stored as its difference from a flat wall's, somewhere at least.
    pub fn has_plane_weights(&self) -> bool {
        matches!(&self.content, Content::Adaptive(cells, _) if cells.walls.is_some())
    }

    /// Radius r of the balls whose solid part is the map's volume, metres: the support radius of the kernels that it
    /// was baked for, or a quarter of it ([`ClosureKind::map_radius`](crate::ClosureKind::map_radius)).
    pub fn support_radius(&self) -> f64 {
        self.support_radius
    }

    /// What lies outside the domain.
    pub fn exterior(&self) -> Exterior {
        self.exterior
    }

    /// The rule that integrated the volume.
    pub fn quadrature(&self) -> &QuadratureSpec {
        &self.quadrature
    }

    /// The SPH kernel whose density the map holds; `None` if it holds none.
    pub fn density_kernel(&self) -> Option<KernelKind> {
        self.density.as_ref().map(|density| density.kernel)
    }

    /// Bytes that the map holds in memory.
    pub fn memory_bytes(&self) -> usize {
        let density = self.density.as_ref().map_or(0, |density| density.numbers.memory_bytes());
        let content = match &self.content {
            Content::Uniform(cells, fields) => cells.memory_bytes() + fields.memory_bytes(),
            Content::Adaptive(cells, fields) => cells.memory_bytes() + fields.memory_bytes(),
        };
        content + density
    }
}
