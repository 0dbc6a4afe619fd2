//! All ways in which the fluid sees bodies, with all pressures of the boundary, and maps for them.

use volmap_bake::density_map::DensitySettings;
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_fluid::boundary::density_map;
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure, World};
use volmap_fluid::shapes::{Shape, baked_by};
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::ClosureKind;

/// How bodies are seen.
pub type View = (BoundaryMethod, ClosureKind);

pub const PRESSURES: [BoundaryPressure; 4] =
    [BoundaryPressure::Own, BoundaryPressure::Mirror, BoundaryPressure::Sph, BoundaryPressure::Mls];

/// Volume maps with each closure, and the other methods.
pub fn views() -> Vec<View> {
    let closures = ClosureKind::ALL.iter().map(|&closure| (BoundaryMethod::VolumeMap, closure));
    let others = [BoundaryMethod::DensityMap, BoundaryMethod::TubeMap, BoundaryMethod::Particles];
    closures.chain(others.map(|boundary| (boundary, ClosureKind::Mirror))).collect()
}

/// A world that sees bodies so.
pub fn world((boundary, closure): View) -> World {
    World { boundary, closure, ..World::default() }
}

/// A mesh with the map that a world takes, as scenes bake it.
pub fn shape(mesh: TriangleMesh, world: &World, container: bool) -> Shape {
    let closure = world.map_closure();
    let density = DensitySettings { extension: density_map::EXTENSION, ..DensitySettings::default() };
    let settings = MapSettings {
        support_radius: Some(closure.map_radius(world.support_radius)),
        grid: GridChoice::CellSize(closure.cell_size(world.support_radius)),
        invert: container,
        density: (world.boundary == BoundaryMethod::DensityMap).then_some(density),
        ..MapSettings::default()
    };
    baked_by(mesh, settings).unwrap()
}
