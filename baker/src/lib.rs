//! Bakes triangle meshes into volume maps.

pub mod mesh;
pub mod sdf;
