//! Fluids in two dimensions, as Fig. 11 of Bender et al. 2020 has one: all that is other there.
//!
//! The kernel in the plane is the one in space times a length,
//! [`KernelKind::plane_thickness`](volmap_runtime::KernelKind::plane_thickness) r. So a particle of area A is, to all
//! sums of the solver, one in space of volume A times that length, in a plane z = 0 that nothing leaves: particles
//! begin there and no force has a z. Forces, masses and energies are those of a metre along z.

use crate::bodies::{Bodies, FluidContact};
use crate::error::Error;
use crate::settings::{BoundaryMethod, FluidSettings, World};
use crate::setup::Setup;
use volmap_runtime::{ClosureKind, Dimension, Kernel};

impl World {
    /// The kernel, normalised in as many dimensions as there are.
    pub fn kernel_of_size(&self) -> Kernel {
        match self.dimension {
            Dimension::Two => Kernel::in_plane(self.kernel, self.support_radius),
            Dimension::Three => Kernel::new(self.kernel, self.support_radius),
        }
    }

    /// (2 rp)^d, m^d.
    pub fn particle_cube(&self) -> f64 {
        (2.0 * self.particle_radius).powi(self.dimension.count() as i32)
    }

    /// Volume V of a particle, m^3; in two dimensions area, m^2.
    pub fn particle_volume(&self, fluid: &FluidSettings) -> f64 {
        fluid.volume_factor * self.particle_cube()
    }

    /// From a particle's m^d to the m^3 that sums with kernels in space weigh it by.
    pub fn volume_in_sums(&self) -> f64 {
        match self.dimension {
            Dimension::Two => self.kernel.plane_thickness() * self.support_radius,
            Dimension::Three => 1.0,
        }
    }
}

/// Checks that everything has as many dimensions as the world, and that the world has what it asks for.
///
/// # Errors
/// [`Error::Setup`] with the place.
pub(crate) fn check(setup: &Setup) -> Result<(), Error> {
    check_maps(setup.world.dimension, &setup.bodies)?;
    if setup.world.dimension == Dimension::Three {
        return Ok(());
    }
    let refuse = |place: &str, reason: &str| {
        Err(Error::Setup { place: place.to_owned(), reason: format!("in two dimensions {reason}") })
    };
    let out_of_plane = |x: &f64| *x != 0.0;
    if setup.particles.positions.iter().map(|x| x.z).any(|z| out_of_plane(&z)) {
        return refuse("particles", "all are at z = 0");
    }
    if setup.particles.velocities.iter().any(|[_, _, z]| *z != 0.0) || out_of_plane(&setup.world.gravity.z) {
        return refuse("velocities and gravity", "nothing moves along z");
    }
    if !setup.emitters.is_empty() {
        return refuse("emitters", "there are none: they emit layers of particles along z");
    }
    if setup.solver.boundary_pressure.is_extrapolated() {
        return refuse("boundary_pressure", "it is `own` or `mirror`");
    }
    let World { boundary, closure, .. } = setup.world;
    match (boundary, closure) {
        (BoundaryMethod::DensityMap, _) => Ok(()),
        (BoundaryMethod::VolumeMap, closure) if closure.is_in_plane() => Ok(()),
        (BoundaryMethod::VolumeMap, _) => {
            let known: Vec<String> = ClosureKind::ALL
                .iter()
                .filter(|kind| kind.is_in_plane())
                .map(|kind| format!("`{kind}`"))
                .collect();
            refuse("closure", &format!("there are {}", known.join(", ")))
        }
        _ => refuse("boundary", "there are volume maps and density maps"),
    }
}

fn check_maps(dimension: Dimension, bodies: &Bodies) -> Result<(), Error> {
    for (body, posed) in bodies.posed().iter().enumerate() {
        let place = || format!("body `{}`", bodies.name(body));
        let [has, needs] = [posed.map.dimension().count(), dimension.count()];
        if has != needs {
            let reason = format!("its map is in {has} dimensions, the fluid in {needs}; bake it in {needs}");
            return Err(Error::Setup { place: place(), reason });
        }
        if dimension == Dimension::Two && bodies.is_free(body) {
            let reason =
                "it moves by forces, which isn't known in two dimensions; let it stand or follow a path";
            return Err(Error::Setup { place: place(), reason: reason.into() });
        }
        if dimension == Dimension::Two && bodies.fluid_contact(body) != FluidContact::default() {
            let reason = "its surface has a drag, which isn't known in two dimensions; leave it out";
            return Err(Error::Setup { place: place(), reason: reason.into() });
        }
    }
    Ok(())
}
