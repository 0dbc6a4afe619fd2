//! Bakes triangle meshes into volume maps.
pub mod rows;
pub mod sdf;
pub mod volume_map;
