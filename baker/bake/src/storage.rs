//! Fields as they are stored.

use crate::error::Error;
use crate::maps::Maps;
use crate::plan::Plan;
use crate::settings::{MapSettings, Precision};
use crate::volume_map::quadrature::Rule;
use glam::UVec3;
use volmap_formats::asset::{Array, Asset, Attributes, Dimension, QuadratureSpec, Rounded};

/// Nodes of a grid all of whose cells are stored, each split in two along every axis `level` times.
pub(crate) fn dense_nodes(resolution: UVec3, level: u32) -> u64 {
    let [x, y, z] = resolution.to_array().map(|cells| u128::from(cells) << level);
    let corners = (x + 1) * (y + 1) * (z + 1);
    let edges = x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z;
    u64::try_from(corners + 2 * edges).unwrap_or(u64::MAX)
}

/// How far the stored fields may be, and are, from what was computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounding {
    /// The bound: part of r and of the full ball.
    pub allowed: f64,
    /// Largest change of a distance, part of r.
    pub distance: f64,
    /// Largest change of a volume, part of the full ball.
    pub volume: f64,
    /// Largest change of a density over rest density.
    pub density: f64,
}

/// The asset of the maps, which says nothing of bake and source yet, and what rounding changed.
pub(crate) fn stored_asset(
    maps: Maps,
    plan: &Plan,
    settings: &MapSettings,
) -> Result<(Asset, Option<Rounding>), Error> {
    let (mut asset, mut rounding) = stored_fields(maps.distance, maps.volume, plan, settings)?;
    (asset.band_cells, asset.solid_cells) = (maps.cells.band, maps.cells.solid);
    if let Some((density, values)) = settings.density.zip(maps.density) {
        let (values, change) = stored(values, 1.0, settings.precision)?;
        asset.density = Some(density.field(plan.support_radius, values));
        rounding = rounding.map(|rounding| Rounding { density: change, ..rounding });
    }
    Ok((asset, rounding))
}

/// The same of distance and volume alone, as yet without cells.
pub(crate) fn stored_fields(
    distance: Vec<f64>,
    volume: Vec<f64>,
    plan: &Plan,
    settings: &MapSettings,
) -> Result<(Asset, Option<Rounding>), Error> {
    let r = plan.support_radius;
    let quadrature = quadrature(settings.rule, r);
    let (signed_distance, of_distance) = stored(distance, r, settings.precision)?;
    let (volume, of_volume) = stored(volume, quadrature.ball_volume, settings.precision)?;
    let rounding = match settings.precision {
        Precision::Rounded(allowed) => {
            Some(Rounding { allowed, distance: of_distance, volume: of_volume, density: 0.0 })
        }
        Precision::F32 | Precision::F64 => None,
    };
    let asset = Asset {
        dimension: Dimension::Three,
        grid: plan.grid.into(),
        support_radius: r,
        exterior: plan.exterior,
        quadrature,
        band_cells: Vec::new(),
        solid_cells: Vec::new(),
        finer: Vec::new(),
        signed_distance,
        volume,
        density: None,
        plane_weight: None,
        bake: Attributes::new(),
        source: Attributes::new(),
        diagnosis: Attributes::new(),
    };
    Ok((asset, rounding))
}

fn quadrature(rule: Rule, support_radius: f64) -> QuadratureSpec {
    QuadratureSpec {
        name: rule.to_string(),
        degree: rule.degree(),
        points: rule.points().len() as u64,
        ball_volume: rule.ball_volume(support_radius),
    }
}

/// A field as it is stored, and, where it is rounded to parts of `unit`, the largest change in that unit.
pub(crate) fn stored(values: Vec<f64>, unit: f64, precision: Precision) -> Result<(Array, f64), Error> {
    match precision {
        Precision::F32 => Ok((Array::F32(values.into_iter().map(|x| x as f32).collect()), 0.0)),
        Precision::F64 => Ok((Array::F64(values), 0.0)),
        Precision::Rounded(part) => {
            let rounded = Rounded::new(&values, unit, part);
            let rounded = rounded.map_err(|error| Error::setting("max_rounding", error.to_string()))?;
            let worst = rounded.worst_error(&values);
            Ok((Array::Rounded(rounded), worst / unit))
        }
    }
}
