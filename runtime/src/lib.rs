//! Volume maps at run time: open an asset, validate it once, then ask for distance, normal, closest point and
//! boundary volume at any point, in constant time.
//!
//! ```no_run
//! use volmap_runtime::{DVec3, Sample, VolumeMap};
//! let map = VolumeMap::open("duck.h5".as_ref())?;
//! if let Sample::Near(boundary) = map.sample(DVec3::new(0.1, 0.2, 0.3)) {
//!     println!("{} m from the wall, {} m^3 of it", boundary.distance, boundary.volume);
//! }
//! # Ok::<(), volmap_runtime::Error>(())
//! ```
//!
//! Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*: V is Eq. 12, Phi is Eq. 10, both
//! interpolated by cubic Serendipity elements on a sparse band of cells. Maps may hold the density of Koschier and
//! Bender 2017 too (Eq. 9): [`VolumeMap::density`].
//!
//! Maps in two dimensions ([`Dimension::Two`]) answer the same questions for points (x, y).
//!
//! Guaranteed: after [`VolumeMap::open`] no query fails or panics, whatever the point (NaN is outside); memory is
//! bounded by the file's size (thrice in two dimensions) and 28 bytes a row of the grid's cells, of which there are at most 2^24; answers
//! don't depend on the thread, the batch or the processor, to the bit. A map is `Send + Sync`.
//! Not guaranteed: gradients are continuous inside cells only (C0 elements).

// For what the unit tests share with the others.
#[cfg(test)]
extern crate self as volmap_runtime;

#[cfg(target_arch = "x86_64")]
mod avx2;
mod batch;
mod cells;
mod closure;
mod density;
mod element;
mod error;
mod fields;
mod grid;
mod kernel;
mod lanes;
mod nodes;
mod open;
mod plane;
mod pose;
mod query;
pub mod serendipity;

pub use cells::{Cell, CellIndex, NodeNumbers};
pub use closure::{BoundaryDensity, Closure, ClosureKind};
pub use density::Density;
pub use error::Error;
pub use glam::{DQuat, DVec2, DVec3};
pub use grid::{Grid, Location};
pub use kernel::{Kernel, KernelKind};
pub use nodes::{Family, NodeInterval, Nodes};
pub use pose::{Pose, PosedMap};
pub use query::{Boundary, Sample, Values, VolumeMap};
pub use volmap_formats::asset::Dimension;
