//! Closures: from the volume of the boundary to its density and density gradient at a particle, which the map leaves
//! open. Bender et al. 2020, section 4.3, and what makes it exact at a flat wall. Each is a file:
//!
//! - [`paper`]: Eq. 14 and 15;
//! - [`offset`]: as SPlisHSPlasH computes it;
//! - [`calibrated`]: with the half space's density R(d), its volume V_plane(d) and beta(d) ([`plane`], [`wall`])
//!   ```text
//!   rho_B      = rho_0 R(Phi)  (V / V_plane(Phi))^beta(Phi)
//!   grad rho_B = rho_0 R'(Phi) (V / V_plane(Phi))^beta(Phi) n
//!   ```
//!   the integral itself at a flat wall, and to first order in curvature on bowls and balls;
//! - [`wedge`]: the same, but where V < V_plane the exponent grows with the deficit up to what a convex edge of 90
//!   degrees needs; a second look at the map, into the solid, tells edges from balls ([`Closure::density_probing`]);
//! - [`lattice`]: as `calibrated`, R being what a half space of particles on a lattice adds instead of a continuum, so
//!   that a fluid's layers rest at rp, 3 rp, ..;
//! - [`image`] (`mirror`): what the fluid's mirror image adds ([`mirror`]), as a function of the volume alone, of a map
//!   with a quarter of the kernel's support radius: value, slope and mirrored pressure belong together, so that a fluid
//!   comes to rest, at rp from walls and calmly, in edges and corners too.
//!
//! The gradient of these is that along the normal, at constant V / V_plane; with the gradient of V, which the map gives
//! too, it is the true one ([`SurfaceWithGradient`]).
//!
//! Tables are computed when a [`Closure`] is made, which takes milliseconds, and only read afterwards.
//!
//! Inside the solid (Phi < 0) every closure's density grows with depth and its gradient keeps its direction, so that
//! pressure pushes a particle out.

mod calibrated;
mod error;
mod image;
mod kind;
mod lattice;
mod mirror;
mod model;
mod offset;
mod paper;
mod plane;
mod table;
mod wall;
mod wedge;

use crate::kernel::Kernel;
use crate::map::VolumeMap;
use crate::sample::Surface;
use glam::DVec3;
use model::{Model, Particle, Setup};
use std::sync::Arc;

#[cfg(doc)]
use crate::sample::SurfaceWithGradient;
pub use error::ClosureError;
pub use kind::{ClosureKind, MapErrors};
pub use model::{BoundaryDensity, Seen};

/// Part by which a map's support radius may differ from the one that is needed: other programs store it in single
/// precision.
const SAME_RADIUS: f64 = 1e-6;

/// How the volume of a map becomes a density, for one kernel and particle size. Made by [`VolumeMap::closure`]; copies
/// share their tables.
#[derive(Clone, Debug)]
pub struct Closure {
    kind: ClosureKind,
    setup: Setup,
    model: Arc<dyn Model>,
}

impl VolumeMap {
    /// A closure for this map, and particles of radius rp = `particle_radius` (metres; half of their spacing). It may
    /// serve other maps too: [`Closure::check`].
    ///
    /// # Errors
    /// A map of another support radius than the kind needs for this kernel ([`ClosureKind::map_radius`]), or of other
    /// dimensions than the kernel; a kind that isn't known in the map's dimensions; a particle radius that isn't
    /// positive and finite.
    pub fn closure(
        &self,
        kind: ClosureKind,
        kernel: Kernel,
        particle_radius: f64,
    ) -> Result<Closure, ClosureError> {
        fits(self, kind, &kernel)?;
        if !(particle_radius > 0.0 && particle_radius.is_finite()) {
            return Err(ClosureError::ParticleRadius { found: particle_radius });
        }
        Ok(Closure::new(kind, kernel, particle_radius))
    }
}

fn fits(map: &VolumeMap, kind: ClosureKind, kernel: &Kernel) -> Result<(), ClosureError> {
    let [of_map, of_kernel] = [map.dimension().count(), kernel.dimension().count()];
    if of_map != of_kernel {
        return Err(ClosureError::Dimension { map: of_map, kernel: of_kernel });
    }
    if of_map == 2 && !kind.is_in_plane() {
        return Err(ClosureError::NotInPlane { kind });
    }
    let kernel_radius = kernel.support_radius();
    let (needed, found) = (kind.map_radius(kernel_radius), map.support_radius());
    // Not so of NaN either.
    match (found - needed).abs() <= SAME_RADIUS * needed {
        true => Ok(()),
        false => Err(ClosureError::MapRadius { kind, kernel_radius, needed, found }),
    }
}

impl Closure {
    pub(crate) fn new(kind: ClosureKind, kernel: Kernel, particle_radius: f64) -> Closure {
        let setup = Setup { kernel, particle_radius };
        Closure { kind, setup, model: kind.model(&setup) }
    }

    /// Whether it fits another map than the one that made it.
    ///
    /// # Errors
    /// As [`VolumeMap::closure`].
    pub fn check(&self, map: &VolumeMap) -> Result<(), ClosureError> {
        fits(map, self.kind, &self.setup.kernel)
    }

    /// Which one it is.
    pub fn kind(&self) -> ClosureKind {
        self.kind
    }

    /// The kernel it was made for.
    pub fn kernel(&self) -> &Kernel {
        &self.setup.kernel
    }

    /// The particle radius it was made for, metres.
    pub fn particle_radius(&self) -> f64 {
        self.setup.particle_radius
    }

    /// Density, gradient and sample point for a particle at `position` (metres) that sees a surface; `None` where the
    /// boundary adds nothing. With a [`SurfaceWithGradient`] the gradient is the true one. `wedge` takes what bends
    /// away from the particle for an edge.
    #[inline]
    pub fn density<'a>(
        &self,
        seen: impl Into<Seen<'a>>,
        position: impl Into<DVec3>,
    ) -> Option<BoundaryDensity> {
        self.answer(Particle { seen: seen.into(), position: position.into(), probe: None })
    }

    /// As [`Closure::density`], where `wedge` asks for the distance (metres) at a second point below the surface, for
    /// particles that see much less volume than a flat wall's: `|x| map.values(x).distance`. The other closures don't
    /// ask.
    #[inline]
    pub fn density_probing<'a>(
        &self,
        seen: impl Into<Seen<'a>>,
        position: impl Into<DVec3>,
        distance: impl Fn(DVec3) -> f64,
    ) -> Option<BoundaryDensity> {
        self.answer(Particle { seen: seen.into(), position: position.into(), probe: Some(&distance) })
    }

    /// The solid's volume (m^3) in the ball of the kernel's support radius r, for what else than density weighs a
    /// boundary by it. A map of a smaller radius doesn't know it: it is then that of a flat wall, led to zero between
    /// r/4 and r/2, where the map ends.
    pub fn volume(&self, surface: &Surface) -> f64 {
        self.model.volume(surface)
    }

    #[inline]
    fn answer(&self, particle: Particle) -> Option<BoundaryDensity> {
        let surface = particle.seen.surface;
        if !(surface.volume > 0.0 && surface.distance < self.setup.kernel.support_radius()) {
            return None;
        }
        self.model.density(particle)
    }
}

#[cfg(test)]
mod tests;
