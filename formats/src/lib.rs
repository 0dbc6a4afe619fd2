//! What volmap has on disk: triangle meshes in, volume-map assets out and in. No algorithms.

#[cfg(feature = "mesh")]
pub mod mesh;
