//! What a density map costs beside a volume map of the same solid: Bender et al. 2020, section 6, after Fig. 10.
//!
//! There the unit cube's density map needs 60^3 cells for a smooth force and its volume map 10^3: 580 times the time
//! (175 s, 0.3 s) and 200 times the memory (78.2 MB, 392 KB). [`paper_bytes`] gives these sizes.

use super::{DensitySettings, compute_density};
use crate::clock::Clock;
use crate::error::Error;
use crate::input::bounds;
use crate::maps::compute_maps;
use crate::mesh::{Prepared, prepare};
use crate::plan::{Extent, plan};
use crate::sdf::{BoundaryDistance, MeshDistance, SignMethod};
use crate::settings::{GridChoice, MapSettings};
use crate::stage::Stage;
use crate::volume_map::quadrature::Rule;
use crate::watch::Watch;
use volmap_formats::mesh::TriangleMesh;

/// What one kind of map costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Finding the cells, sampling the distance, integrating: wall time.
    pub seconds: f64,
    /// Bytes of the distance and of the kind's field as we hold them: the band's nodes in the settings' precision.
    pub bytes: u64,
    /// Bytes of the same as the paper's program holds them.
    pub paper_bytes: u64,
}

/// Costs of both kinds of map on the same grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// Distance and volume.
    pub volume: Cost,
    /// Distance and density.
    pub density: Cost,
}

/// The settings of the paper's comparison: the volume by 4,096 points, the density by 17,576, before those outside
/// the ball are left out.
pub fn paper_settings(resolution: u32) -> MapSettings {
    let density = DensitySettings { rule: Rule::GaussLegendre(50), ..DensitySettings::default() };
    MapSettings {
        support_radius: Some(0.1),
        grid: GridChoice::Resolution([resolution; 3]),
        rule: Rule::GaussLegendre(30),
        density: Some(density),
        ..MapSettings::default()
    }
}

/// The cube [-1/2, 1/2]^3, metres.
pub fn unit_cube() -> TriangleMesh {
    let corner = |n: u32| [0, 1, 2].map(|axis| f64::from(n >> axis & 1) - 0.5);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    TriangleMesh { vertices: (0..8).map(corner).collect(), triangles: triangles.collect() }
}

/// Computes both kinds of map of a mesh on one grid, and what each costs; a density must be in the settings.
///
/// # Errors
/// As [`plan`] and [`compute_maps`]; cancelled; no density in the settings.
pub fn measure(mesh: &TriangleMesh, settings: &MapSettings, watch: &Watch) -> Result<Costs, Error> {
    let no_density = || Error::setting("density", "is needed for its cost");
    let density = settings.density.as_ref().ok_or_else(no_density)?;
    let mut mesh = mesh.clone();
    let Prepared { diagnosis, .. } = prepare(&mut mesh, false);
    let [min, max] = bounds(&mesh);
    let plan = plan(&Extent { min, max, area: diagnosis.area }, settings)?;
    let phi = BoundaryDistance {
        shape: None,
        mesh: MeshDistance::new(&mesh, SignMethod::Auto, &diagnosis),
        invert: settings.invert,
        thickness: settings.thickness,
    };
    let clock = Clock::default();
    let watch = &clock.beside(watch);
    let maps = compute_maps(&plan, settings.rule, &phi, watch)?;
    compute_density(&plan, density, &phi, &maps, watch)?;
    clock.stop();
    let seconds = |stages: &[Stage]| stages.iter().map(|stage| clock.seconds_of(*stage)).sum::<f64>();
    let distance = seconds(&[Stage::Band, Stage::Distance]);
    let bytes = 2 * settings.precision.bytes() * maps.nodes.count() as u64;
    let cost = |own: f64| Cost {
        seconds: distance + own,
        bytes,
        paper_bytes: paper_bytes(plan.grid.resolution.to_array()),
    };
    Ok(Costs { volume: cost(seconds(&[Stage::Volume])), density: cost(seconds(&[Stage::Density])) })
}

/// Bytes of a map of two fields in the paper's program, every cell stored: per field 8 a node, 32 numbers of 4 a cell
/// for its nodes, and 4 a cell for its place.
pub fn paper_bytes(resolution: [u32; 3]) -> u64 {
    let [x, y, z] = resolution.map(u64::from);
    let corners = (x + 1) * (y + 1) * (z + 1);
    let edges = x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z;
    2 * (8 * (corners + 2 * edges) + (32 * 4 + 4) * x * y * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_paper() {
        // "78.2 MB" and "392 KB", both in binary units.
        let mib = paper_bytes([60; 3]) as f64 / 1024.0 / 1024.0;
        let kib = paper_bytes([10; 3]) as f64 / 1024.0;
        assert!((mib - 78.2).abs() < 0.2 && (kib - 392.0).abs() < 1.0, "{mib} MiB {kib} KiB");
    }

    #[test]
    fn both_kinds_are_computed_on_the_unit_cube() {
        let settings = MapSettings { rule: Rule::Chord(4), ..paper_settings(10) };
        let costs = measure(&unit_cube(), &settings, &Watch::default()).unwrap();
        assert_eq!(costs.volume.bytes, costs.density.bytes);
        assert!(costs.volume.bytes > 0 && costs.volume.bytes < costs.volume.paper_bytes);
        let error =
            measure(&unit_cube(), &MapSettings { density: None, ..settings }, &Watch::default()).unwrap_err();
        assert!(error.to_string().contains("density"), "{error}");
    }
}
