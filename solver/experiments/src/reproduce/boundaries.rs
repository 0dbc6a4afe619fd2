//! The boundary methods of the papers, with their names in tables.

use super::methods::Method;
use crate::validation::flow::solver;
use volmap_fluid::Error;
use volmap_fluid::bodies::BodyDescription;
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure, FluidSettings};
use volmap_fluid::shapes::Shape;
use volmap_fluid::simulation::Setup;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::ClosureKind;

/// A boundary method with a name.
#[derive(Clone, Copy, Debug)]
pub struct Named {
    /// Its name in tables.
    pub name: &'static str,
    /// Boundary, closure and pressure.
    pub method: Method,
}

/// Akinci et al. 2012: particles that mirror the fluid's pressure.
pub const PARTICLES: Named =
    Named { name: "particles", method: Method::of(BoundaryMethod::Particles, BoundaryPressure::Mirror) };

/// The same on blue noise, as the authors of Bender et al. 2020 sample surfaces.
pub const BLUE_NOISE: Named =
    Named { name: "particles, blue noise", method: Method::blue_noise(BoundaryPressure::Mirror) };

/// Koschier and Bender 2017.
pub const DENSITY_MAP: Named =
    Named { name: "density map", method: Method::of(BoundaryMethod::DensityMap, BoundaryPressure::Mirror) };

/// Bender et al. 2020, Eq. 14 and 15.
pub const PAPER_MAP: Named = Named {
    name: "volume map, as the paper",
    method: Method::maps(ClosureKind::Paper, BoundaryPressure::Mirror),
};

/// The default of scenes: closure `mirror`, boundary pressure `own`.
pub const VOLUME_MAP: Named =
    Named { name: "volume map", method: Method::maps(ClosureKind::Mirror, BoundaryPressure::Own) };

impl Named {
    /// [`Method::shape`].
    ///
    /// # Errors
    /// As [`Method::shape`].
    pub fn baked(&self, mesh: TriangleMesh, particle_radius: f64, container: bool) -> Result<Shape, Error> {
        self.method.shape(mesh, particle_radius, container)
    }

    /// Inviscid fluid without particles yet, under gravity that falls along -y.
    ///
    /// # Errors
    /// As [`Method::setup`].
    pub fn setup(&self, particle_radius: f64, bodies: Vec<BodyDescription>) -> Result<Setup, Error> {
        let fluid = FluidSettings { viscosity: 0.0, ..FluidSettings::default() };
        self.method.setup(particle_radius, fluid, solver(particle_radius), bodies)
    }
}
