//! What the sums over neighbours are made with.

use crate::settings::{FluidSettings, World};
use volmap_runtime::{Dimension, KernelKind};

/// Kernel and volume of the sums over neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Discretization {
    /// The kernel.
    pub kernel: KernelKind,
    /// Its support radius r, metres.
    pub support_radius: f64,
    /// Volume V of a particle, m^3; in two dimensions as
    /// [`World::volume_in_sums`](crate::settings::World::volume_in_sums) has it.
    pub volume: f64,
    /// What the sum of V W is on the fluid's lattice at rest, by which densities and their gradients are divided:
    /// [`World::rest_sum`](crate::settings::World::rest_sum). 1 leaves them.
    pub rest_sum: f64,
    /// What gradients are multiplied by besides: [`World::gradient_scale`](crate::settings::World::gradient_scale).
    pub gradient_scale: f64,
    /// In how many dimensions: of the Laplacian.
    pub dimension: Dimension,
}

impl Discretization {
    /// That of a fluid.
    pub fn new(world: &World, fluid: &FluidSettings) -> Discretization {
        Discretization {
            kernel: world.kernel,
            support_radius: world.support_radius,
            volume: world.particle_volume(fluid) * world.volume_in_sums(),
            rest_sum: world.rest_sum(fluid),
            gradient_scale: world.gradient_scale(fluid),
            dimension: world.dimension,
        }
    }
}
