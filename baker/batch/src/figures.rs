//! What an asset is like, as it says itself.

use super::summary::Figures;
use volmap_bake::describe::{SIGN_DOUBT, VOLUME_ERROR_MAX, VOLUME_ERROR_POINTS, VOLUME_ERROR_RMS};
use volmap_bake::doubt::has_solid;
use volmap_formats::asset::{Asset, Attributes, Value};

/// The figures of an asset.
pub fn figures(asset: &Asset) -> Figures {
    let warnings = match asset.diagnosis.get("warnings") {
        Some(Value::Text(lines)) => lines.lines().map(str::to_owned).collect(),
        _ => Vec::new(),
    };
    Figures {
        triangles: integer(&asset.source, "triangles").unwrap_or(0),
        closed: integer(&asset.diagnosis, "closed") == Some(1),
        support_radius: asset.support_radius,
        cell_size: asset.grid.cell_size.into_iter().fold(0.0, f64::max),
        band_cells: asset.band_count(),
        nodes: asset.volume.len() as u64,
        volume_error_max: real(&asset.bake, VOLUME_ERROR_MAX),
        volume_error_rms: real(&asset.bake, VOLUME_ERROR_RMS),
        volume_error_points: integer(&asset.bake, VOLUME_ERROR_POINTS).unwrap_or(0),
        has_solid: has_solid(asset.signed_distance.to_f64().into_iter(), asset.support_radius),
        sign_doubt: real(&asset.diagnosis, SIGN_DOUBT).unwrap_or(0.0),
        warnings,
    }
}

fn integer(attributes: &Attributes, name: &str) -> Option<u64> {
    match attributes.get(name) {
        Some(Value::Integer(list)) => list.first().copied(),
        _ => None,
    }
}

fn real(attributes: &Attributes, name: &str) -> Option<f64> {
    match attributes.get(name) {
        Some(Value::Real(list)) => list.first().copied(),
        _ => None,
    }
}
