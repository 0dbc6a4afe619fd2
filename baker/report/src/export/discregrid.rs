//! The map for SPlisHSPlasH (`.cdm`; scene key `mapFile`), the distance for Discregrid and Bullet (`.cdf`).
//!
//! What SPlisHSPlasH does with a point decides what is stored (`TimeStep::computeVolumeAndBoundaryX`, version 2.19):
//!
//! | distance there | it takes | stored |
//! | --- | --- | --- |
//! | none, or >= r | no boundary | cells of the fluid beyond the band: removed |
//! | 0 to r | volume and gradient; it finds both by the cell and the nodes of field 0 | the band, bit for bit |
//! | <= 0 | no volume; moves the particle along the gradient | solid cells: distances of `deep.rs` |
//!
//! So both fields have the same cells and nodes, and V is "not sampled" at nodes that belong to solid cells alone; that
//! is how an import knows them.

use super::deep::ClosestPoints;
use super::hexahedra::band_nodes;
use super::values;
use crate::error::Error;
use glam::UVec3;
use volmap_bake::watch::{Cancelled, Watch};
use volmap_formats::asset::{Asset, CellRun};
use volmap_formats::export::cdm::{DiscreteGrid, Field, NODES, REMOVED, UNSAMPLED, local_node};
use volmap_runtime::layout::{CellIndex, Nodes};
use volmap_runtime::{Grid, VolumeMap};

/// A cell that is stored.
struct Stored {
    place: UVec3,
    is_band: bool,
    nodes: [u32; NODES],
}

/// Distance and, `with_volume`, volume.
///
/// # Errors
/// An asset that isn't consistent, or more cells than the format can number; cancelled.
pub fn discregrid(asset: &Asset, with_volume: bool, watch: &Watch) -> Result<DiscreteGrid, Error> {
    watch.step("finding the cells")?;
    let grid = *VolumeMap::from_asset(asset)?.grid();
    let all = grid.resolution.as_u64vec3().element_product();
    let (stored, nodes) = stored(asset).filter(|_| all < u64::from(REMOVED)).ok_or_else(|| {
        Error::setting("output", "Discregrid's maps can't hold that many cells; take larger ones")
    })?;
    let distance = values(&asset.signed_distance);
    let distance = spread(asset, &stored, &distance, nodes)?;
    let mut fields = vec![distances(asset, &grid, &stored, distance, watch)?];
    if with_volume {
        fields.push(spread(asset, &stored, &values(&asset.volume), nodes)?);
    }
    let mut cell_map = vec![REMOVED; all as usize];
    let [nx, ny, _] = grid.resolution.as_usizevec3().to_array();
    for (number, cell) in stored.iter().enumerate() {
        let [i, j, k] = cell.place.as_usizevec3().to_array();
        cell_map[i + nx * (j + ny * k)] = number as u32;
    }
    let local = |cell: &Stored| std::array::from_fn(|b| cell.nodes[local_node(b)]);
    let cells: Vec<[u32; NODES]> = stored.iter().map(local).collect();
    let field = |nodes| Field { nodes, cells: cells.clone(), cell_map: cell_map.clone() };
    Ok(DiscreteGrid {
        min: asset.grid.origin,
        max: grid.max_corner().to_array(),
        resolution: asset.grid.resolution,
        cell_size: asset.grid.cell_size,
        fields: fields.into_iter().map(field).collect(),
    })
}

/// The cells of band and solid by (k, j, i), and the number of their nodes. `None` if they are too many.
fn stored(asset: &Asset) -> Option<(Vec<Stored>, usize)> {
    let mark = |runs: &[CellRun], is_band| runs.iter().map(move |&run| (run, is_band)).collect::<Vec<_>>();
    let mut runs = [mark(&asset.band_cells, true), mark(&asset.solid_cells, false)].concat();
    runs.sort_unstable_by_key(|(run, _)| (run.k, run.j, run.i));
    let plain: Vec<CellRun> = runs.iter().map(|(run, _)| *run).collect();
    let resolution = asset.grid.resolution.into();
    let nodes = Nodes::new(resolution, &plain)?;
    let index = CellIndex::new(resolution, &plain, &[], &nodes);
    let places = runs.iter().flat_map(|&(run, is_band)| {
        (run.i..run.i + run.len).map(move |i| (UVec3::new(i, run.j, run.k), is_band))
    });
    let cell = |((place, is_band), nodes): ((UVec3, bool), volmap_runtime::layout::NodeNumbers)| Stored {
        place,
        is_band,
        nodes: nodes.all(),
    };
    Some((places.zip(index.stored()).map(cell).collect(), nodes.count()))
}

/// The asset's values at the nodes of the band, bit for bit; the others are not sampled.
fn spread(asset: &Asset, stored: &[Stored], field: &[f64], nodes: usize) -> Result<Vec<f64>, Error> {
    let mut out = vec![UNSAMPLED; nodes];
    for (cell, own) in stored.iter().filter(|cell| cell.is_band).zip(band_nodes(asset)?) {
        for (&to, from) in cell.nodes.iter().zip(own) {
            out[to as usize] = field[from as usize];
        }
    }
    Ok(out)
}

/// Fills in the distances of the solid's nodes.
fn distances(
    asset: &Asset,
    grid: &Grid,
    stored: &[Stored],
    mut nodes: Vec<f64>,
    watch: &Watch,
) -> Result<Vec<f64>, Cancelled> {
    watch.step("finding the distances in the solid")?;
    let mut closest = ClosestPoints::new(*grid);
    for cell in stored.iter().filter(|cell| cell.is_band) {
        closest.learn(cell.place, &cell.nodes.map(|node| nodes[node as usize]));
    }
    let solid = || stored.iter().filter(|cell| !cell.is_band);
    solid().for_each(|cell| closest.want(cell.place));
    closest.find(watch)?;
    // At least what the asset says of these cells.
    let least = 2.0 * asset.support_radius;
    for cell in solid() {
        for (a, &node) in cell.nodes.iter().enumerate() {
            let value = &mut nodes[node as usize];
            if *value == UNSAMPLED {
                let distance = closest.distance(cell.place, a);
                *value = if distance.is_finite() { -distance.max(least) } else { -least };
            }
        }
    }
    Ok(nodes)
}
