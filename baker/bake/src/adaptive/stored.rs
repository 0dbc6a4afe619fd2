//! An adaptive map as it is stored.

use super::settle::Settled;
use crate::error::Error;
use crate::plan::Plan;
use crate::settings::{MapSettings, Precision};
use crate::storage::{Rounding, quadrature, stored};
use volmap_formats::asset::{Asset, Attributes, Dimension};

/// The asset of an adaptive map, which says nothing of bake and source yet, and what rounding changed.
pub fn adaptive_asset(
    settled: &Settled,
    plan: &Plan,
    settings: &MapSettings,
) -> Result<(Asset, Option<Rounding>), Error> {
    let r = plan.support_radius;
    let quadrature = quadrature(settings.rule, r);
    let (signed_distance, distance) = stored(settled.distance.clone(), r, settings.precision)?;
    let (volume, of_volume) = stored(settled.volume.clone(), quadrature.ball_volume, settings.precision)?;
    let rounding = match settings.precision {
        Precision::Rounded(allowed) => Some(Rounding { allowed, distance, volume: of_volume, density: 0.0 }),
        Precision::F32 | Precision::F64 => None,
    };
    let mut levels = settled.levels.iter().cloned();
    let coarsest = levels.next().unwrap_or_default();
    let asset = Asset {
        dimension: Dimension::Three,
        grid: plan.grid.into(),
        support_radius: r,
        exterior: plan.exterior,
        quadrature,
        band_cells: coarsest.band,
        solid_cells: coarsest.solid,
        finer: levels.collect(),
        signed_distance,
        volume,
        plane_weight: settled.weights.contains(&1).then(|| settled.weights.clone()),
        density: None,
        bake: Attributes::new(),
        source: Attributes::new(),
        diagnosis: Attributes::new(),
    };
    Ok((asset, rounding))
}
