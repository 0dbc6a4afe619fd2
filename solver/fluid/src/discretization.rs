//! What the sums over neighbours are made with.

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
    /// In how many dimensions: of the Laplacian.
    pub dimension: Dimension,
}
