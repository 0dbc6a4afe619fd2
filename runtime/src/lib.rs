//! Volume maps at run time: open an asset, validate it once, then ask for distance, normal, closest point and
//! boundary volume at any point, in constant time.
//!
//! Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*: V is Eq. 12, Phi is Eq. 10, both interpolated
//! by cubic Serendipity elements on a sparse band of cells. All lengths are metres, in the map's frame.
//!
//! # Open and sample
//!
//! ```
//! # mod ball { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/ball/mod.rs")); }
//! use volmap_runtime::{Sample, VolumeMap};
//! # let path = std::env::temp_dir().join(format!("volmap-tour-{}.h5", std::process::id()));
//! # volmap_formats::asset::write(&path, &ball::asset(0.1), Default::default())?;
//!
//! let map = VolumeMap::open(&path)?; // what `volmap bake` wrote: here a ball of 0.2 m
//! match map.sample([0.25, 0.0, 0.0]) {
//!     Sample::Near(at) => {
//!         assert!((at.distance - 0.05).abs() < 1e-4); // negative inside the solid
//!         println!("{} m^3 of solid within {} m", at.volume, map.support_radius());
//!         println!("closest point {}, normal {}", at.closest_point, at.normal);
//!     }
//!     Sample::Outside => println!("no surface within 2 r"),
//!     Sample::DeepInside => println!("more than 2 r deep in the solid"),
//! }
//! # std::fs::remove_file(&path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Points are `[f64; 3]` or glam's [`DVec3`]. [`VolumeMap::from_bytes`] opens what is in memory,
//! [`VolumeMap::from_asset`] what was just computed.
//!
//! # Many points
//!
//! A batch is two to four times as fast as single samples and gives the same bits; sort particles by place. What is
//! asked for is the type of the answers: [`Sample`], [`Sample<SurfaceWithGradient>`](SurfaceWithGradient), [`Values`]
//! (distance and volume alone, the cheapest), or `Option<`[`MapDensity`]`>`.
//!
//! ```
//! # mod ball { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/ball/mod.rs")); }
//! use volmap_runtime::{DVec3, Values, VolumeMap};
//!
//! # let map = VolumeMap::from_asset(&ball::asset(0.1))?;
//! let points: Vec<DVec3> = (0..1000).map(|n| DVec3::new(0.001 * f64::from(n) + 0.0005, 0.0, 0.0)).collect();
//! let mut values: Vec<Values> = Vec::new(); // reused from step to step
//! map.sample_batch(&points, &mut values);
//! assert_eq!(values.iter().filter(|at| at.distance < 0.0).count(), 200);
//! # Ok::<(), volmap_runtime::Error>(())
//! ```
//!
//! # Moving bodies
//!
//! Any number of bodies share one map. Each has a rigid [`Pose`], which may change at any time; scaling is not
//! possible, for V depends on the support radius.
//!
//! ```
//! # mod ball { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/ball/mod.rs")); }
//! use std::sync::Arc;
//! use volmap_runtime::{DQuat, DVec3, Pose, PosedMap, VolumeMap};
//!
//! # let map = Arc::new(VolumeMap::from_asset(&ball::asset(0.1))?);
//! let pose = Pose { rotation: DQuat::from_rotation_y(0.3), translation: DVec3::new(1.0, 0.0, 0.0) };
//! let body = PosedMap { map: map.clone(), pose };
//! assert!(body.inside([1.0, 0.1, 0.0]) && !body.inside([0.0; 3]));
//! # Ok::<(), volmap_runtime::Error>(())
//! ```
//!
//! # From volume to density
//!
//! A [`Closure`] makes the boundary's density of its volume, for one kernel. A map makes it and says so if it doesn't
//! fit:
//!
//! ```
//! # mod ball { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/ball/mod.rs")); }
//! use volmap_runtime::{ClosureKind, Kernel, KernelKind, VolumeMap};
//!
//! # let map = VolumeMap::from_asset(&ball::asset(0.1))?;
//! let kernel = Kernel::new(KernelKind::CubicSpline, 0.1);
//! let closure = map.closure(ClosureKind::Calibrated, kernel, 0.025)?; // particle radius
//! let x = [0.225, 0.0, 0.0];
//! if let Some(near) = map.sample_with_gradient(x).near() {
//!     let at = closure.density(&near, x).expect("near enough");
//!     println!("{} kg/m^3, force at {}", 1000.0 * at.density, at.point);
//!     assert!(at.gradient.x < 0.0);
//! }
//! let error = map.closure(ClosureKind::Mirror, kernel, 0.025).unwrap_err();
//! assert!(error.to_string().contains("needs a map of support radius 0.025 m; this map's is 0.1 m"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Maps may hold the density of Koschier and Bender 2017 too (Eq. 9): [`VolumeMap::density`].
//!
//! # Two dimensions
//!
//! Maps in two dimensions ([`Dimension::Two`]) answer the same questions for points (x, y): z plays no part, volumes
//! are areas, directions have no z. [`Kernel::in_plane`] is for them.
//!
//! # Guaranteed
//!
//! - After [`VolumeMap::open`] no query fails or panics, whatever the point; NaN is outside.
//! - A damaged, foreign or newer file is an error that names the file and the cure, never a wrong number.
//!   `volmap-formats` checks the file and whether its parts fit each other ([`Asset::check`]); this crate checks that
//!   the values are as many as the nodes.
//! - Memory is bounded by the file's size (thrice in two dimensions) and 28 bytes a row of the grid's cells, of which
//!   there are at most 2^24.
//! - Answers don't depend on the thread, the batch, the order or the processor, to the bit.
//! - A map is `Send + Sync`, and a query takes no lock and allocates nothing.
//!
//! # Not guaranteed
//!
//! - Gradients are continuous inside cells only (C0 elements).
//! - What is in [`layout`] may change with the format; the rest keeps to semantic versions.
//!
//! # Dependencies in the interface
//!
//! glam's vectors, and a few types of `volmap-formats`; all that signatures need is re-exported here.

// For what the unit tests share with the others.
#[cfg(test)]
extern crate self as volmap_runtime;

mod adaptive;
#[cfg(target_arch = "x86_64")]
mod avx2;
mod batch;
mod closure;
mod element;
mod error;
mod finder;
mod flat_wall;
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

pub use closure::{BoundaryDensity, Closure, ClosureError, ClosureKind, MapErrors, Seen};
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
