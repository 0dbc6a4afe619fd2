//! Why a closure doesn't fit a map.

use super::kind::{ClosureKind, names};

/// Why there is no such closure for a map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClosureError {
    /// The map was baked for another support radius.
    #[error(
        "closure `{kind}` with a kernel of support radius {kernel_radius} m needs a map of support radius {needed} m; \
         this map's is {found} m"
    )]
    MapRadius {
        /// The closure.
        kind: ClosureKind,
        /// Support radius of the kernel, metres.
        kernel_radius: f64,
        /// That of the maps that go with it.
        needed: f64,
        /// That of this map.
        found: f64,
    },
    /// The kernel's integral is 1 in another number of dimensions than the map has.
    #[error("the map is in {map} dimensions and needs a kernel in as many; this one is in {kernel}")]
    Dimension {
        /// Dimensions of the map.
        map: u64,
        /// Dimensions of the kernel.
        kernel: u64,
    },
    /// Not known in two dimensions.
    #[error("closure `{kind}` isn't known in two dimensions; take {}", names(ClosureKind::is_in_plane))]
    NotInPlane {
        /// The closure.
        kind: ClosureKind,
    },
    /// The particle radius is no length.
    #[error("the particle radius is {found} m; it must be positive and finite")]
    ParticleRadius {
        /// What was given, metres.
        found: f64,
    },
}
