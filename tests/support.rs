//! What the tests share.

use std::path::{Path, PathBuf};
use volmap_bake::density_map::compute_density;
use volmap_bake::maps::{Maps, compute_maps};
use volmap_bake::plan::{Extent, GridChoice, MapSettings, Plan, plan};
use volmap_bake::watch::Watch;
use volmap_formats::asset::{Array, Asset, Attributes, Dimension, QuadratureSpec};
use volmap_runtime::{DVec3, VolumeMap};

pub use volmap_bake::random::Random;

/// A solid with a closed form of its signed distance.
pub struct Solid {
    /// For messages.
    pub name: &'static str,
    /// Box and area.
    pub extent: Extent,
    /// Signed distance, metres.
    pub phi: fn(DVec3) -> f64,
}

/// A sphere of radius 0.5.
pub const SPHERE: Solid = Solid {
    name: "sphere",
    extent: Extent { min: DVec3::splat(-0.5), max: DVec3::splat(0.5), area: std::f64::consts::PI },
    phi: |x| x.length() - 0.5,
};

/// A torus around y, radii 0.5 and 0.25.
pub const TORUS: Solid = Solid {
    name: "torus",
    extent: Extent { min: DVec3::new(-0.75, -0.25, -0.75), max: DVec3::new(0.75, 0.25, 0.75), area: 4.93 },
    phi: |x| DVec3::new((x.x * x.x + x.z * x.z).sqrt() - 0.5, x.y, 0.0).length() - 0.25,
};

/// Plan and fields of a solid at N^3 cells.
pub fn compute(solid: &Solid, resolution: u32, settings: &MapSettings) -> (Plan, Maps) {
    let settings = MapSettings { grid: GridChoice::Resolution([resolution; 3]), ..settings.clone() };
    let plan = plan(&solid.extent, &settings).unwrap();
    let mut maps = compute_maps(&plan, settings.rule, &solid.phi, &Watch::default()).unwrap();
    if let Some(density) = &settings.density {
        maps.density = Some(compute_density(&plan, density, &solid.phi, &maps, &Watch::default()).unwrap());
    }
    (plan, maps)
}

/// An asset with fields of double precision.
pub fn asset_of(plan: &Plan, settings: &MapSettings, maps: Maps) -> Asset {
    Asset {
        dimension: Dimension::Three,
        grid: plan.grid.into(),
        support_radius: plan.support_radius,
        exterior: plan.exterior,
        quadrature: QuadratureSpec {
            name: settings.rule.to_string(),
            degree: settings.rule.degree(),
            points: settings.rule.points().len() as u64,
            ball_volume: settings.rule.ball_volume(plan.support_radius),
        },
        band_cells: maps.cells.band,
        solid_cells: maps.cells.solid,
        finer: Vec::new(),
        signed_distance: Array::F64(maps.distance),
        volume: Array::F64(maps.volume),
        density: settings
            .density
            .zip(maps.density)
            .map(|(density, values)| density.field(plan.support_radius, Array::F64(values))),
        plane_weight: None,
        bake: Attributes::new(),
        source: Attributes::new(),
        diagnosis: Attributes::new(),
    }
}

/// The map of a solid at N^3 cells.
pub fn map_of(solid: &Solid, resolution: u32, settings: &MapSettings) -> VolumeMap {
    let (plan, maps) = compute(solid, resolution, settings);
    VolumeMap::from_asset(&asset_of(&plan, settings, maps)).unwrap()
}

/// The Python of the interop tests: `$VOLMAP_PYTHON`, or that of the environment that `.ci/run` makes.
pub fn python() -> PathBuf {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../.venv/bin/python");
    std::env::var_os("VOLMAP_PYTHON").map_or(default, Into::into)
}
