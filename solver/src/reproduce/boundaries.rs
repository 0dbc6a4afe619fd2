//! The boundary methods of the papers beside each other: the same bodies and the same fluid for each.

use crate::bodies::{Bodies, BodyDescription};
use crate::boundary::density_map;
use crate::error::Error;
use crate::particles::Particles;
use crate::scene::map::cell_size;
use crate::settings::{BoundaryMethod, BoundaryPressure, FluidSettings, World};
use crate::simulation::Setup;
use crate::validation::flow::{GRAVITY, solver};
use crate::validation::shapes::{Shape, baked_by};
use volmap_baker::density_map::DensitySettings;
use volmap_baker::plan::{GridChoice, Settings};
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{ClosureKind, DVec3};

/// A boundary method with the pressure that belongs to it.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// As tables call it.
    pub name: &'static str,
    /// How the fluid sees bodies.
    pub boundary: BoundaryMethod,
    /// Of volume maps.
    pub closure: ClosureKind,
    /// Of the boundary.
    pub pressure: BoundaryPressure,
}

/// Akinci et al. 2012: particles that mirror the fluid's pressure.
pub const PARTICLES: Method = Method {
    name: "particles",
    boundary: BoundaryMethod::Particles,
    closure: ClosureKind::Mirror,
    pressure: BoundaryPressure::Mirror,
};

/// Koschier and Bender 2017.
pub const DENSITY_MAP: Method =
    Method { name: "density map", boundary: BoundaryMethod::DensityMap, ..PARTICLES };

/// Bender et al. 2020, Eq. 14 and 15.
pub const PAPER_MAP: Method = Method {
    name: "volume map, as the paper",
    boundary: BoundaryMethod::VolumeMap,
    closure: ClosureKind::Paper,
    ..PARTICLES
};

/// The default of scenes: closure `mirror`, no pressure of the boundary's own.
pub const VOLUME_MAP: Method =
    Method { name: "volume map", closure: ClosureKind::Mirror, pressure: BoundaryPressure::Own, ..PAPER_MAP };

impl Method {
    /// A world of this method without gravity; the kernel's support radius is 4 rp.
    pub fn world(&self, particle_radius: f64) -> World {
        World {
            particle_radius,
            support_radius: 4.0 * particle_radius,
            boundary: self.boundary,
            closure: self.closure,
            gravity: DVec3::ZERO,
            ..World::default()
        }
    }

    /// A mesh with the map that the method takes, of cells as scenes have them; of a container the solid is outside.
    ///
    /// # Errors
    /// As [`volmap_baker::bake::bake`].
    pub fn baked(&self, mesh: TriangleMesh, particle_radius: f64, container: bool) -> Result<Shape, Error> {
        let world = self.world(particle_radius);
        self.baked_with_cells(mesh, &world, cell_size(world.map_closure(), world.support_radius), container)
    }

    /// The same of cells of another size, metres, for a world of this method.
    ///
    /// # Errors
    /// As [`volmap_baker::bake::bake`].
    pub fn baked_with_cells(
        &self,
        mesh: TriangleMesh,
        world: &World,
        cell_size: f64,
        container: bool,
    ) -> Result<Shape, Error> {
        let density = DensitySettings { extension: density_map::EXTENSION, ..DensitySettings::default() };
        let settings = Settings {
            support_radius: Some(world.map_closure().map_radius(world.support_radius)),
            grid: GridChoice::CellSize(cell_size),
            invert: container,
            density: (self.boundary == BoundaryMethod::DensityMap).then_some(density),
            ..Settings::default()
        };
        baked_by(mesh, settings)
    }

    /// Inviscid fluid without particles yet, under gravity that falls along -y.
    ///
    /// # Errors
    /// As [`Bodies::new`].
    pub fn setup(&self, particle_radius: f64, bodies: Vec<BodyDescription>) -> Result<Setup, Error> {
        let gravity = DVec3::new(0.0, -GRAVITY, 0.0);
        let mut solver = solver(particle_radius);
        solver.boundary_pressure = self.pressure;
        Ok(Setup {
            world: World { gravity, ..self.world(particle_radius) },
            fluid: FluidSettings { viscosity: 0.0, ..FluidSettings::default() },
            solver,
            particles: Particles::default(),
            emitters: Vec::new(),
            bodies: Bodies::new(bodies, gravity)?,
            domain: None,
        })
    }
}
