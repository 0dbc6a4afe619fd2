//! The map's values at equally spaced points of its domain, the cells that are not stored included.
//!
//! There Phi is known to be beyond 2 r, so the distance is given as Phi limited to [-2 r, 2 r], in the band and outside
//! alike: that is right everywhere, and has no step at the band's edge. V is 0 in the fluid, the full ball in the
//! solid.

use super::{ExportField, ExportSettings};
use crate::error::Error;
use rayon::prelude::*;
use volmap_bake::iso_surface::lattice::Lattice;
use volmap_bake::watch::Watch;
use volmap_formats::asset::{Array, Asset};
use volmap_formats::export::vti::{Image, Numbers};
use volmap_runtime::{DVec3, Values, VolumeMap};

/// Of 17 bytes each.
const MAX_POINTS: u64 = 1 << 28;

/// Distance and volume, or one of them, and the array `region`: 0 in the fluid, 1 in the band, 2 deep in the solid. In
/// the precision of the asset; 16-bit fields become single precision.
///
/// # Errors
/// An asset that isn't consistent, or too many points; cancelled.
pub fn image(asset: &Asset, settings: &ExportSettings, watch: &Watch) -> Result<Image, Error> {
    let map = VolumeMap::from_asset(asset)?;
    let lattice = Lattice::over(&map, settings.lattice, 1, MAX_POINTS)?;
    let [nx, ny, nz] = lattice.points();
    let work = watch.begin("asking the map at points", (ny * nz) as u64)?;
    let mut values = vec![Values::default(); nx * ny * nz];
    values.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
        if work.is_cancelled() {
            return;
        }
        let points: Vec<DVec3> = (0..nx).map(|i| lattice.point([i, row % ny, row / ny])).collect();
        let mut answers: Vec<Values> = Vec::new();
        map.sample_batch(&points, &mut answers);
        out.copy_from_slice(&answers);
        work.add(1);
    });
    work.check()?;
    let limit = 2.0 * map.support_radius();
    let double = matches!(asset.signed_distance, Array::F64(_));
    let numbers = |of: &(dyn Fn(&Values) -> f64 + Sync)| match double {
        true => Numbers::F64(values.iter().map(of).collect()),
        false => Numbers::F32(values.iter().map(|v| of(v) as f32).collect()),
    };
    let mut arrays = Vec::new();
    if settings.field != Some(ExportField::Volume) {
        arrays.push(("signed_distance", numbers(&|v| v.distance.clamp(-limit, limit))));
    }
    if settings.field != Some(ExportField::Distance) {
        arrays.push(("volume", numbers(&|v| v.volume)));
    }
    arrays.push(("region", Numbers::U8(values.iter().map(region).collect())));
    let steps = DVec3::new((nx - 1) as f64, (ny - 1) as f64, (nz - 1) as f64);
    let (low, high) = (map.grid().origin, map.grid().max_corner());
    let spacing = ((high - low) / steps).to_array();
    Ok(Image { origin: low.to_array(), spacing, points: [nx, ny, nz].map(|n| n as u32), arrays })
}

fn region(values: &Values) -> u8 {
    match values.distance {
        f64::INFINITY => 0,
        f64::NEG_INFINITY => 2,
        _ => 1,
    }
}
