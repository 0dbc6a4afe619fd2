//! Bakes triangle meshes into volume maps: Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*.
//!
//! ```text
//! TriangleMesh -> mesh (diagnosis, orientation) -> sdf (distance, sign, band, field) -> volume_map -> Asset
//! ```
//! [`bake::bake_file`] is the whole way; [`maps::compute_maps`] the part that any signed distance can take.

pub mod error;
pub mod maps;
pub mod plan;
pub mod rows;
pub mod sdf;
pub mod volume_map;

pub use error::Error;
