//! What a closure computes, whatever its kind.

use crate::kernel::Kernel;
use crate::sample::{Surface, SurfaceWithGradient};
use glam::DVec3;
use std::fmt::Debug;

/// What the boundary adds to the density of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryDensity {
    /// rho_B over the fluid's rest density.
    pub density: f64,
    /// Its gradient at the particle, 1/m; against the normal.
    pub gradient: DVec3,
    /// The sample point x*, metres: where forces on the body act.
    pub point: DVec3,
}

/// What a closure is told of the surface: a [`Surface`], or better a [`SurfaceWithGradient`], with which the gradient
/// of the density is the true one. Both convert into it.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    pub(super) surface: &'a Surface,
    /// m^2.
    pub(super) volume_gradient: Option<DVec3>,
}

impl<'a> From<&'a Surface> for Seen<'a> {
    #[inline]
    fn from(surface: &'a Surface) -> Seen<'a> {
        Seen { surface, volume_gradient: None }
    }
}

impl<'a> From<&'a SurfaceWithGradient> for Seen<'a> {
    #[inline]
    fn from(near: &'a SurfaceWithGradient) -> Seen<'a> {
        Seen { surface: &near.surface, volume_gradient: Some(near.volume_gradient) }
    }
}

/// The distance (metres) at a point of the map.
pub(super) type Probe<'a> = &'a dyn Fn(DVec3) -> f64;

/// A particle for which a density is wanted: it sees some volume, and the surface is nearer than the kernel's support
/// radius.
#[derive(Clone, Copy)]
pub(super) struct Particle<'a> {
    pub seen: Seen<'a>,
    pub position: DVec3,
    pub probe: Option<Probe<'a>>,
}

/// What a closure is made for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setup {
    pub kernel: Kernel,
    /// rp, metres.
    pub particle_radius: f64,
}

/// One kind of closure, with its tables.
pub(super) trait Model: Debug + Send + Sync {
    /// `None` where the boundary adds nothing.
    fn density(&self, particle: Particle) -> Option<BoundaryDensity>;

    /// See [`Closure::volume`](super::Closure::volume).
    fn volume(&self, surface: &Surface) -> f64 {
        surface.volume
    }
}
