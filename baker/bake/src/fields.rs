//! The fields of a map as they were computed: on cells of one size, or of several.

use crate::adaptive::{Adapted, AdaptiveMap};
use crate::error::Error;
use crate::maps::Maps;
use crate::plan::Plan;
use crate::rows::positions;
use crate::sdf::BoundaryDistance;
use crate::sdf::leaks::leaks;
use crate::sdf::thin::ThinPlaces;
use crate::settings::MapSettings;
use crate::storage::{Rounding, dense_nodes, stored_asset};
use crate::summary::CellCounts;
use glam::DVec3;
use volmap_formats::asset::Asset;

/// What a bake computed.
pub(crate) enum Fields {
    /// Cells of one size.
    Uniform(Box<Maps>),
    /// Cells of several.
    Adaptive(Box<AdaptiveMap>),
}

impl Fields {
    /// Signed distance at the nodes that are stored, metres.
    pub fn distance(&self) -> &[f64] {
        match self {
            Fields::Uniform(maps) => &maps.distance,
            Fields::Adaptive(map) => &map.settled.distance,
        }
    }

    /// Where these nodes are.
    pub fn places<'a>(&'a self, plan: &'a Plan) -> Box<dyn Iterator<Item = DVec3> + 'a> {
        match self {
            Fields::Uniform(maps) => Box::new(positions(&maps.nodes, &plan.grid)),
            Fields::Adaptive(map) => Box::new(map.settled.free_positions()),
        }
    }

    /// How the cells of several sizes were found.
    pub fn adapted(&self) -> Option<&Adapted> {
        match self {
            Fields::Uniform(_) => None,
            Fields::Adaptive(map) => Some(&map.found),
        }
    }

    /// How many cells there are.
    pub fn cells(&self, plan: &Plan) -> CellCounts {
        let grid = plan.grid.resolution.as_u64vec3().element_product();
        match self {
            Fields::Uniform(maps) => {
                CellCounts { grid, band: maps.cells.band_count(), solid: maps.cells.solid_count() }
            }
            // Of the grid, if all were as small as the smallest.
            Fields::Adaptive(map) => CellCounts {
                grid: grid << (3 * map.finest_level()),
                band: map.asset.band_count(),
                solid: map.asset.solid_count(),
            },
        }
    }

    /// Bytes of all fields if every cell of the grid were stored, and of what is.
    pub fn bytes(&self, plan: &Plan, settings: &MapSettings) -> [u64; 2] {
        let fields = 2 + u64::from(settings.density.is_some());
        let level = match self {
            Fields::Uniform(_) => 0,
            Fields::Adaptive(map) => map.finest_level(),
        };
        let dense = dense_nodes(plan.grid.resolution, level);
        [dense, self.distance().len() as u64]
            .map(|nodes| nodes.saturating_mul(fields * settings.precision.bytes()))
    }

    /// Faces between inside and outside without a surface. Adaptive cells are split there, and told as too wrong.
    pub fn leaks(&self, plan: &Plan) -> u64 {
        match self {
            Fields::Uniform(maps) => leaks(plan.grid.resolution, &maps.cells),
            Fields::Adaptive(_) => 0,
        }
    }

    /// Walls and gaps thinner than a cell. Adaptive cells are split there, and told as too wrong.
    pub fn thin(&self, plan: &Plan, phi: &BoundaryDistance) -> ThinPlaces {
        match self {
            Fields::Uniform(maps) => ThinPlaces::find(&plan.grid, &maps.nodes, &maps.distance, phi),
            Fields::Adaptive(map) => {
                let finest = plan.grid.refined(map.finest_level());
                ThinPlaces { cell: finest.cell_size.max_element(), ..ThinPlaces::default() }
            }
        }
    }

    /// The asset, which says nothing of bake and source yet, and what rounding changed.
    pub fn into_asset(self, plan: &Plan, settings: &MapSettings) -> Result<(Asset, Option<Rounding>), Error> {
        match self {
            Fields::Uniform(maps) => stored_asset(*maps, plan, settings),
            Fields::Adaptive(map) => Ok((map.asset, map.rounding)),
        }
    }
}
