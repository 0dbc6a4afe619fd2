//! Bakes distance functions of one's own: no mesh, no triangles.
//!
//! `cargo run --release -p volmap-bake --example bake_distance`

use glam::{DVec2, DVec3};
use std::error::Error;
use std::f64::consts::{PI, TAU};
use volmap_bake::bake::bake_distance;
use volmap_bake::plan::Extent;
use volmap_bake::settings::{GridChoice, MapSettings};
use volmap_bake::watch::Watch;
use volmap_formats::asset::Asset;
use volmap_runtime::VolumeMap;

/// A torus around the z axis, metres: an exact distance.
fn torus(x: DVec3) -> f64 {
    const RING: f64 = 0.4;
    const TUBE: f64 = 0.15;
    DVec2::new(x.truncate().length() - RING, x.z).length() - TUBE
}

/// A gyroid of period 1 m, cut to a ball: no exact distance, but one that nowhere changes faster than the way goes
/// (is 1-Lipschitz), as the bake needs. Its gradient is at most sqrt(3) times TAU long before the division.
fn gyroid_ball(x: DVec3) -> f64 {
    let (p, q) = (TAU * x, TAU * DVec3::new(x.y, x.z, x.x));
    let gyroid = p.x.sin() * q.x.cos() + p.y.sin() * q.y.cos() + p.z.sin() * q.z.cos();
    (gyroid / (3f64.sqrt() * TAU)).max(x.length() - 0.5)
}

fn bake(phi: impl Fn(DVec3) -> f64 + Sync, extent: Extent) -> Result<Asset, Box<dyn Error>> {
    let settings =
        MapSettings { support_radius: Some(0.1), grid: GridChoice::CellSize(0.05), ..MapSettings::default() };
    Ok(bake_distance(&phi, &extent, &settings, &Watch::default())?)
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    // The box must hold the surface. The area serves the estimate of the cost only.
    let half = DVec3::new(0.55, 0.55, 0.15);
    let asset = bake(torus, Extent { min: -half, max: half, area: 4.0 * PI * PI * 0.4 * 0.15 })?;

    // Beside the tube, half a support radius away, a part of the ball around the point is solid.
    let map = VolumeMap::from_asset(&asset)?;
    let place = DVec3::new(0.6, 0.0, 0.0);
    println!("torus: {:.6} m^3 of solid around {place}", map.values(place).volume);

    let asset = bake(gyroid_ball, Extent { min: DVec3::splat(-0.5), max: DVec3::splat(0.5), area: 2.0 })?;
    println!("gyroid: {} nodes", asset.volume.len());
    Ok(())
}
