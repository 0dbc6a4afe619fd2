//! Fields as they are stored.

use crate::error::Error;
use crate::maps::Maps;
use crate::plan::Plan;
use crate::settings::{MapSettings, Precision};
use crate::summary::Rounding;
use crate::volume_map::quadrature::Rule;
use volmap_formats::asset::{Array, Asset, Attributes, Dimension, QuadratureSpec, Rounded};

/// Bytes of all fields if every cell of the grid were stored, and for the band alone.
pub(crate) fn field_bytes(plan: &Plan, maps: &Maps, settings: &MapSettings) -> [u64; 2] {
    let [x, y, z] = plan.grid.resolution.to_array().map(u64::from);
    let corners = (x + 1) * (y + 1) * (z + 1);
    let edges = x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z;
    let fields = 2 + u64::from(settings.density.is_some());
    [corners + 2 * edges, maps.nodes.count() as u64].map(|nodes| fields * settings.precision.bytes() * nodes)
}

/// The asset of the maps, which says nothing of bake and source yet, and what rounding changed.
pub(crate) fn stored_asset(
    maps: Maps,
    plan: &Plan,
    settings: &MapSettings,
) -> Result<(Asset, Option<Rounding>), Error> {
    let r = plan.support_radius;
    let quadrature = quadrature(settings.rule, r);
    let (signed_distance, distance_change) = stored(maps.distance, r, settings.precision)?;
    let (volume, volume_change) = stored(maps.volume, quadrature.ball_volume, settings.precision)?;
    let density = maps.density.map(|values| stored(values, 1.0, settings.precision)).transpose()?;
    let (density, density_change) = density.unzip();
    let rounding = match settings.precision {
        Precision::Rounded(allowed) => Some(Rounding {
            allowed,
            distance: distance_change,
            volume: volume_change,
            density: density_change.unwrap_or(0.0),
        }),
        Precision::F32 | Precision::F64 => None,
    };
    let asset = Asset {
        dimension: Dimension::Three,
        grid: plan.grid.into(),
        support_radius: r,
        exterior: plan.exterior,
        quadrature,
        band_cells: maps.cells.band,
        solid_cells: maps.cells.solid,
        finer: Vec::new(),
        signed_distance,
        volume,
        density: settings.density.zip(density).map(|(density, values)| density.field(r, values)),
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
