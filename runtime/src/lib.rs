//! Volume maps at run time: open an asset, validate it once, then ask for distance, normal, closest point and
//! boundary volume at any point, in constant time.
//!
//! TODO tour

// For what the unit tests share with the others.
#[cfg(test)]
extern crate self as volmap_runtime;

#[cfg(target_arch = "x86_64")]
mod avx2;
mod batch;
mod closure;
mod element;
mod error;
mod grid;
mod kernel;
mod lanes;
pub mod layout;
mod map;
mod open;
mod plane;
mod pose;
mod posed;
mod quadrature;
mod query;
mod sample;
mod storage;

pub use closure::{BoundaryDensity, Closure, ClosureError, ClosureKind, Seen};
pub use error::Error;
pub use glam::{DQuat, DVec2, DVec3, UVec3};
pub use grid::{Grid, Location};
pub use kernel::{Kernel, KernelKind};
pub use map::VolumeMap;
pub use pose::Pose;
pub use posed::PosedMap;
pub use query::Answer;
pub use sample::{MapDensity, Sample, Surface, SurfaceWithGradient, Values};
pub use volmap_formats::asset::{Asset, AssetError, Dimension, Exterior, QuadratureSpec};
