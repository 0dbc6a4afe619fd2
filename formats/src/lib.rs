//! What volmap has on disk: triangle meshes in, volume-map assets out and in. No algorithms.
//!
//! - [`mesh`] (feature `mesh`): mesh files of eleven formats into one [`mesh::TriangleMesh`];
//! - [`asset`]: the volume-map asset, an HDF5 file described in `SPEC.md`; [`asset::read()`] is always there,
//!   `asset::write` needs the feature `write`;
//! - `export` (feature `export`): files for other programs: VTK, PLY, and Discregrid's, which is read, too;
//! - [`text`]: numbers for people, and text from files that is safe to print.
//!
//! Guaranteed: no panic on any input, memory bounded by the size of the input, a damaged asset is an error
//! and never another number. Not guaranteed: that a mesh is closed or oriented; the baker diagnoses that.

pub mod asset;
#[cfg(feature = "export")]
pub mod export;
#[cfg(feature = "mesh")]
pub mod mesh;
pub mod text;
