//! Bakes triangle meshes, or any signed distance, into volume maps: Bender et al. 2020, *Implicit Frictional Boundary
//! Handling for SPH*. A library: no command line, no progress bars, no signals.
//!
//! # A mesh
//!
//! ```
//! use volmap_bake::bake::{BakeSettings, bake};
//! use volmap_bake::input::{InputSettings, from_arrays};
//! use volmap_bake::settings::{GridChoice, MapSettings};
//! use volmap_bake::watch::Watch;
//!
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let input = from_arrays("tetrahedron", &corners, &faces, &InputSettings::default())?;
//!
//! let map = MapSettings { support_radius: Some(0.2), grid: GridChoice::CellSize(0.2), ..MapSettings::default() };
//! let baked = bake(input, &BakeSettings { map, ..BakeSettings::default() }, &Watch::default())?;
//! assert!(baked.summary.diagnosis.closed);
//! assert_eq!(baked.asset.volume.len(), baked.summary.nodes);
//! # Ok::<(), volmap_bake::Error>(())
//! ```
//! [`input::load`] reads a file instead. The asset is written by `volmap_formats::asset::write` and asked by
//! `volmap_runtime::VolumeMap`. [`bake::plan_bake`] stops before the work: it gives the grid and what it will cost.
//!
//! Boxes, spheres, cylinders, capsules and planes need no mesh: [`input::from_shape`] makes the same of a
//! [`primitive::Primitive`], whose closed form is baked then.
//!
//! # A distance of one's own
//!
//! ```
//! use volmap_bake::bake::bake_distance;
//! use volmap_bake::plan::Extent;
//! use volmap_bake::settings::{GridChoice, MapSettings};
//! use volmap_bake::watch::Watch;
//! use volmap_runtime::{DVec3, VolumeMap};
//!
//! let sphere = |x: DVec3| x.length() - 0.3;
//! let extent = Extent { min: DVec3::splat(-0.3), max: DVec3::splat(0.3), area: 1.13 };
//! let settings =
//!     MapSettings { support_radius: Some(0.1), grid: GridChoice::CellSize(0.1), ..MapSettings::default() };
//! let asset = bake_distance(&sphere, &extent, &settings, &Watch::default())?;
//!
//! let map = VolumeMap::from_asset(&asset)?;
//! assert!(map.values(DVec3::new(0.3, 0.0, 0.0)).distance.abs() < 0.01);
//! # Ok::<(), volmap_bake::Error>(())
//! ```
//! Any `Fn(DVec3) -> f64 + Sync` is a distance. One that can be asked faster at neighbouring points implements
//! [`sdf::SignedDistance`]. In two dimensions: [`area_map::bake`].
//!
//! # Watching and stopping
//!
//! Long work takes a [`watch::Watch`], which hears of each step and may stop it from another thread. Stopped work
//! returns [`Error::Cancelled`] and leaves nothing behind. `examples/watch_and_stop.rs` shows it.
//!
//! # What is guaranteed
//!
//! - The same input and settings give the same bits, whatever the number of threads and whoever watches.
//! - The cells that are stored hold every point with |Phi| <= 2 r.
//! - Memory is estimated before it is taken; a bake over [`settings::MapSettings::max_memory`] is refused.
//! - Input is checked: a mesh or a setting that can't be used is an error with the cure, not a panic.
//!
//! # What is not
//!
//! - A distance of one's own must be 1-Lipschitz and negative inside; that is not checked. One that is not may lose
//!   cells of the band.
//! - Meshes with holes get a sign by the winding number, which is a guess there. [`summary::Summary::warnings`] says
//!   so.
//! - The estimates of memory and time are right to a factor of 2 for smooth surfaces.
//! - Examining a mesh and building its tree, seconds for millions of triangles, aren't interrupted in their middle.
//!
//! # The way
//!
//! ```text
//! TriangleMesh -> mesh (diagnosis, orientation) -> plan -> sdf (distance, sign, band, field) -> volume_map -> Asset
//! ```

pub mod adaptive;
pub mod area_map;
pub mod bake;
pub mod cache;
mod clock;
pub mod content_key;
mod coordinates;
pub mod density_map;
pub mod describe;
pub mod doubt;
pub mod error;
mod fields;
pub mod input;
pub mod iso_surface;
pub mod maps;
pub mod mesh;
pub mod parameters;
pub mod plan;
pub mod primitive;
pub mod provenance;
pub mod random;
pub mod recipe;
pub mod rows;
pub mod sdf;
pub mod settings;
mod sized;
pub mod stage;
mod storage;
pub mod summary;
pub mod tolerance;
pub mod units;
pub mod volume_map;
pub mod warnings;
pub mod watch;

pub use error::Error;
