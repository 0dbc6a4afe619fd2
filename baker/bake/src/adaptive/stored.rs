//! An adaptive map as it is stored.

use super::in_place::Settled;
use crate::error::Error;
use crate::plan::Plan;
use crate::settings::MapSettings;
use crate::storage::{Rounding, stored_fields};
use volmap_formats::asset::Asset;

/// The asset of an adaptive map, which says nothing of bake and source yet, and what rounding changed.
pub fn adaptive_asset(
    settled: &Settled,
    plan: &Plan,
    settings: &MapSettings,
) -> Result<(Asset, Option<Rounding>), Error> {
    let (distance, volume) = (settled.distance.clone(), settled.volume.clone());
    let (asset, rounding) = stored_fields(distance, volume, plan, settings)?;
    let mut levels = settled.levels.iter().cloned();
    let coarsest = levels.next().unwrap_or_default();
    let asset = Asset {
        band_cells: coarsest.band,
        solid_cells: coarsest.solid,
        finer: levels.collect(),
        plane_weight: plane_weight(settled),
        ..asset
    };
    Ok((asset, rounding))
}

/// w at the free corners, where it isn't 0.
fn plane_weight(settled: &Settled) -> Option<Vec<u32>> {
    let weight = settled.form.weight();
    (weight != 0).then(|| vec![weight; settled.layout.free_corner_count()])
}
