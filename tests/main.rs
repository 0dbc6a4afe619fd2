//! The tests of volmap, in one binary.

#[cfg(feature = "interop")]
mod interop_meshes;
