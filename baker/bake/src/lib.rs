//! Bakes triangle meshes into volume maps: Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*.
//!
//! ```text
//! TriangleMesh -> mesh (diagnosis, orientation) -> sdf (distance, sign, band, field) -> volume_map -> Asset
//! ```
//! In two dimensions: Outline -> [`area_map`] -> Asset.
//!
//! [`bake::bake`] is the whole way; [`maps::compute_maps`] the part that any signed distance can take.

pub mod area_map;
pub mod bake;
pub mod content_key;
pub mod density_map;
pub mod describe;
pub mod error;
pub mod input;
pub mod iso_surface;
pub mod maps;
pub mod mesh;
pub mod parameters;
pub mod plan;
pub mod provenance;
pub mod random;
pub mod recipe;
pub mod rows;
pub mod sdf;
pub mod summary;
pub mod tolerance;
pub mod volume_map;
pub mod watch;
pub mod work;

pub use error::Error;
